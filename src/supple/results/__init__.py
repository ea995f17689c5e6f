"""What a simulation leaves behind: recovery, energies, error measures, storage."""

from supple.results.error_measures import MotionError, motion_error, relative_error, rms_error
from supple.results.json_report import write_json
from supple.results.recovery import (
    ElasticBody,
    displacement_from_axes,
    node_displacements,
    node_positions,
)
from supple.results.result_reader import ResultHeader, read_header, read_last_instant, read_solution
from supple.results.storage import ResultFile, write_solution

__all__ = [
    "ElasticBody",
    "MotionError",
    "ResultFile",
    "ResultHeader",
    "displacement_from_axes",
    "motion_error",
    "node_displacements",
    "node_positions",
    "read_header",
    "read_last_instant",
    "read_solution",
    "relative_error",
    "rms_error",
    "write_json",
    "write_solution",
]
