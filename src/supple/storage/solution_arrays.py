"""A solution as a flat table of arrays, one row per output time, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, fields
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from supple.integrate.solution import FloatingMotion, Solution, Statistics

Array = NDArray[np.float64]

MOTION_FIELDS = tuple(field.name for field in fields(FloatingMotion))
_COUNTS = tuple(field.name for field in fields(Statistics) if "seconds" not in field.name)


def to_arrays(solution: Solution) -> dict[str, Array]:
    """Arrays by path: times, bodies/<name>/<field>, joint_forces/<name>."""
    arrays = {"times": solution.times}
    for name, motion in solution.bodies.items():
        arrays |= {f"bodies/{_quoted(name)}/{field}": getattr(motion, field) for field in MOTION_FIELDS}
    arrays |= {f"joint_forces/{_quoted(name)}": force for name, force in solution.joint_forces.items()}
    return {path: np.asarray(array, dtype=np.float64) for path, array in arrays.items()}


def from_arrays(arrays: Mapping[str, Array], statistics: Statistics) -> Solution:
    """The solution that `to_arrays` took apart; its arrays are read-only."""
    motions: dict[str, dict[str, Array]] = {}
    joint_forces: dict[str, Array] = {}
    for path, array in arrays.items():
        array.setflags(write=False)
        match path.split("/"):
            case ["bodies", name, field]:
                motions.setdefault(unquote(name), {})[field] = array
            case ["joint_forces", name]:
                joint_forces[unquote(name)] = array
    bodies = {name: FloatingMotion(**motion) for name, motion in motions.items()}
    return Solution(arrays["times"], bodies, joint_forces, statistics)


def statistics_row(statistics: Statistics) -> Array:
    """The counts and seconds of a run as numbers."""
    return np.array(astuple(statistics), dtype=np.float64)


def statistics_from_rows(rows: Array) -> Statistics:
    """Sum of rows (k, 5) of `statistics_row`."""
    totals = dict(zip((field.name for field in fields(Statistics)), rows.sum(axis=0).tolist(), strict=True))
    return Statistics(**{name: int(total) if name in _COUNTS else total for name, total in totals.items()})


def _quoted(name: str) -> str:
    """A name that HDF5 takes for one step of a path."""
    quoted = name.replace("%", "%25").replace("/", "%2F")
    return quoted.replace(".", "%2E") if set(quoted) == {"."} else quoted
