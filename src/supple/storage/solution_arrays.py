"""A solution as a flat mapping of arrays, one row per output time, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, fields
from types import MappingProxyType
from typing import Any
from urllib.parse import unquote

import numpy as np

from supple.arrays import FloatArray
from supple.integrate import FloatingMotion, Solution, Statistics, motion_from_arrays
from supple.integrate.solution import LARGEST

_GROUPS = ("joint_forces", "multipliers", "series")
"""Groups of arrays by name."""
_COUNTS = ("steps", "iterations", "rejected_steps", "factorizations")


def to_arrays(solution: Solution) -> dict[str, FloatArray]:
    """Arrays by path: times, bodies/<name>/<field>, and GROUP/<name> for each GROUP of `_GROUPS`."""
    arrays = {"times": solution.times}
    for name, motion in solution.bodies.items():
        arrays |= {f"bodies/{_quoted(name)}/{field}": array for field, array in motion.arrays().items()}
    for group in _GROUPS:
        arrays |= {f"{group}/{_quoted(name)}": own for name, own in getattr(solution, group).items()}
    return {path: np.asarray(array, dtype=np.float64) for path, array in arrays.items()}


def motion_kinds(solution: Solution) -> dict[str, str]:
    """Kind of motion by the path of the body's group."""
    return {f"bodies/{_quoted(name)}": motion.kind for name, motion in solution.bodies.items()}


def from_arrays(
    arrays: Mapping[str, FloatArray],
    statistics: Statistics,
    kinds: Mapping[str, str] = MappingProxyType({}),
    engine_state: Mapping[str, FloatArray] = MappingProxyType({}),
) -> Solution:
    """The solution from arrays as `to_arrays` returns them; its arrays are read-only.

    kinds : kind of motion by path of the body's group; `FloatingMotion` where missing
    """
    motions: dict[str, dict[str, FloatArray]] = {}
    groups: dict[str, dict[str, FloatArray]] = {group: {} for group in _GROUPS}
    for path, array in arrays.items():
        array.setflags(write=False)
        match path.split("/"):
            case ["bodies", name, field]:
                motions.setdefault(name, {})[field] = array
            case [group, name]:
                groups[group][unquote(name)] = array
    for path in [path for path, kind in kinds.items() if kind == "series"]:  # files of older versions
        name = path.removeprefix("bodies/")
        groups["series"][unquote(name)] = motions.pop(name)["values"]
    bodies = {
        unquote(name): motion_from_arrays(kinds.get(f"bodies/{name}", FloatingMotion.kind), motion)
        for name, motion in motions.items()
    }
    joint_forces, multipliers, series = (groups[group] for group in _GROUPS)
    return Solution(
        arrays["times"],
        bodies,
        joint_forces,
        statistics,
        engine_state=engine_state,
        multipliers=multipliers,
        series=series,
    )


def statistics_row(statistics: Statistics) -> FloatArray:
    """The statistics of a run as numbers (9,)."""
    return np.array(astuple(statistics), dtype=np.float64)


def statistics_from_rows(rows: FloatArray) -> Statistics:
    """Statistics of a run from those of its chunks, rows (k, 9) of `statistics_row`."""
    names = [field.name for field in fields(Statistics)]
    totals: dict[str, Any] = {
        name: float(column.max(initial=0.0) if name in LARGEST else column.sum())
        for name, column in zip(names, rows.T, strict=True)
    }
    return Statistics(**{name: int(total) if name in _COUNTS else total for name, total in totals.items()})


def _quoted(name: str) -> str:
    """A name as one component of an HDF5 path."""
    quoted = name.replace("%", "%25").replace("/", "%2F")
    return quoted.replace(".", "%2E") if set(quoted) == {"."} else quoted
