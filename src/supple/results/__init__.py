"""What a simulation tells: recovery, tracked motion, joint loads, error measures, stress."""

from supple.body import node_displacements
from supple.results.error_measures import (
    MotionError,
    motion_error,
    relative_error,
    rms_error,
)
from supple.results.joint_loads import (
    joint_loads,
    joint_meanings,
)
from supple.results.recovery import (
    displacement_from_axes,
    node_positions,
)
from supple.results.round_off import without_noise
from supple.results.run_summary import (
    body_numbers,
    stress_numbers,
    summarize,
    unit_names,
)
from supple.results.stress_history import (
    LargestStress,
    TensorBlock,
    largest_stress,
    strain_blocks,
    strain_history,
    stress_blocks,
    stress_history,
    von_mises_history,
    von_mises_strain_history,
)
from supple.results.stress_modes import (
    StrainModes,
    StressModes,
    strain_modes,
    stress_modes,
)
from supple.results.tracked_motion import (
    Observer,
    TrackedMotion,
    deflections,
    observer,
    observer_of,
    tracked_motion,
    tracked_places,
)

__all__ = [
    "LargestStress",
    "MotionError",
    "Observer",
    "StrainModes",
    "StressModes",
    "TensorBlock",
    "TrackedMotion",
    "body_numbers",
    "deflections",
    "displacement_from_axes",
    "joint_loads",
    "joint_meanings",
    "largest_stress",
    "motion_error",
    "node_displacements",
    "node_positions",
    "observer",
    "observer_of",
    "relative_error",
    "rms_error",
    "strain_blocks",
    "strain_history",
    "strain_modes",
    "stress_blocks",
    "stress_history",
    "stress_modes",
    "stress_numbers",
    "summarize",
    "tracked_motion",
    "tracked_places",
    "unit_names",
    "von_mises_history",
    "von_mises_strain_history",
    "without_noise",
]
