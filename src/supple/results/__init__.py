"""What a simulation tells: recovery, error measures, stress."""

from supple.body import node_displacements
from supple.results.error_measures import (
    MotionError,
    motion_error,
    relative_error,
    rms_error,
)
from supple.results.node_motion import (
    NodeMotion,
    node_motion,
)
from supple.results.recovery import (
    displacement_from_axes,
    node_positions,
)
from supple.results.stress_history import (
    von_mises_history,
    von_mises_strain_history,
)
from supple.results.stress_modes import (
    StrainModes,
    StressModes,
    strain_modes,
    stress_modes,
)

__all__ = [
    "MotionError",
    "NodeMotion",
    "StrainModes",
    "StressModes",
    "displacement_from_axes",
    "motion_error",
    "node_displacements",
    "node_motion",
    "node_positions",
    "relative_error",
    "rms_error",
    "strain_modes",
    "stress_modes",
    "von_mises_history",
    "von_mises_strain_history",
]
