"""What a simulation leaves behind: recovery, energies, error measures, storage."""

from supple.results.correction_folder import CorrectionFolder
from supple.results.error_measures import MotionError, motion_error, relative_error, rms_error
from supple.results.json_report import write_json
from supple.results.node_motion import NodeMotion, node_motion
from supple.results.recorded_run import begin_recorded, continue_recorded, simulate_recorded
from supple.results.recovery import (
    ElasticBody,
    displacement_from_axes,
    node_displacements,
    node_positions,
)
from supple.results.result_reader import ResultHeader, read_header, read_last_instant, read_solution
from supple.results.storage import ResultFile, write_solution
from supple.results.stress_history import von_mises_history, von_mises_strain_history
from supple.results.stress_modes import StrainModes, StressModes, strain_modes, stress_modes

__all__ = [
    "CorrectionFolder",
    "ElasticBody",
    "MotionError",
    "NodeMotion",
    "ResultFile",
    "ResultHeader",
    "StrainModes",
    "StressModes",
    "begin_recorded",
    "continue_recorded",
    "displacement_from_axes",
    "motion_error",
    "node_displacements",
    "node_motion",
    "node_positions",
    "read_header",
    "read_last_instant",
    "read_solution",
    "relative_error",
    "rms_error",
    "simulate_recorded",
    "strain_modes",
    "stress_modes",
    "von_mises_history",
    "von_mises_strain_history",
    "write_json",
    "write_solution",
]
