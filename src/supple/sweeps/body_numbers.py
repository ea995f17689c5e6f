"""Which values may vary within a group of cases, and which separate groups.

Cases that differ only in numbers of the run form a group: they run together, in one compiled program, with
bodies that are reduced once. All other values separate groups: those of bodies (thickness, basis), of the run
(duration, step), and texts.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from supple.cases.body_kinds import kind_of
from supple.cases.parameter_path import number_at, parameter_path
from supple.errors import CaseError
from supple.importers.toml import KeyPath, Raw

_FORCES = ("load", "joint", "spring", "element", "gravity", "tie")
PLACING = ("position", "rotation", "velocity", "centre_velocity", "angular_velocity")
DAMPING_NUMBERS = ("alpha", "beta", "ratio")


def is_number_of_run(place: KeyPath, value: object, raw: Raw) -> bool:
    """Whether cases of one group may differ in the value at a place.

    place : keys that lead to the value;   raw : the tables of the case file
    """
    section, *rest = place
    if section in _FORCES:
        return _holds_numbers(value) or place[-2:] == ("law", "file")
    if section != "body" or not _holds_numbers(value):
        return False
    number, key, *inner = rest
    body = raw["body"][number]
    if key in PLACING or "rigid" in body:
        return True
    return key == "damping" and inner[-1] in DAMPING_NUMBERS and _is_damped_apart(body)


def number_of_run(case: Path, name: str, raw: Raw) -> tuple[KeyPath, float]:
    """Keys and value of a number of the run of a case, from the path of the number.

    Raises CaseError for a path that does not exist, is not a number, or changes a flexible body or the run.
    """
    place = parameter_path(name, raw)
    value = number_at(place, raw)
    if value is None:
        raise CaseError(f"{name} is not a number in {case}; give its value there, or another path")
    if not is_number_of_run(place, value, raw):
        raise CaseError(
            f"{case}: {name} changes a flexible body, the run or the program, and cannot be a parameter: run "
            "or export one case for each value. Parameters are numbers of loads, joints, springs, elements, "
            "gravity and rigid bodies"
        )
    return place, value


def _is_damped_apart(body: Raw) -> bool:
    """Whether the sweep reduces a body from its elements, so that its damping can be changed afterwards."""
    kind, reduction = kind_of(body), body.get("reduction", {})
    whole = isinstance(reduction, Mapping) and reduction.get("basis") == "none"
    others = {"condense", "modal", "explicit", "split"} & body.keys()
    return kind is not None and kind.is_elastic and kind.has_elements and not others and not whole


def _holds_numbers(value: object) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_holds_numbers, value))
    return isinstance(value, int | float) and not isinstance(value, bool)
