"""Attributes of the datasets of a result file: unit, axes, columns, and the end that a force acts on."""

from __future__ import annotations

from collections.abc import Mapping
from urllib.parse import unquote

from supple.integrate import JOINT_AXES, JOINT_COMPONENTS
from supple.units import UnitSystem

Labels = Mapping[str, str | list[str]]

_OF_MOTION = {
    "position": ("length", "global axes"),
    "velocity": ("velocity", "global axes"),
    "acceleration": ("acceleration", "global axes"),
    "angular_velocity": ("angular_velocity", "body axes"),
}


def dataset_labels(path: str, metadata: Mapping[str, object]) -> Labels:
    """Attributes of the dataset at a path; empty for datasets not listed here.

    metadata : of the run, with "units" (text of a UnitSystem) and "NAME: second end" of each joint. A unit
        without a name is ""; an end that is not given is "second end"
    """
    units = UnitSystem.parsed(str(metadata.get("units", "")))
    match path.split("/"):
        case ["times"]:
            return {"unit": units.time}
        case ["bodies", _, field] if field in _OF_MOTION:
            quantity, axes = _OF_MOTION[field]
            return {"unit": getattr(units, quantity), "axes": axes}
        case ["joint_forces", name]:
            return {
                "unit": [units.force] * 3 + [units.moment] * 3,
                "acts_on": str(metadata.get(second_end_key(unquote(name)), "second end")),
                "axes": JOINT_AXES,
                "columns": list(JOINT_COMPONENTS),
            }
    return {}


def second_end_key(joint: str) -> str:
    """The name in metadata of the end that a joint's forces act on."""
    return f"{joint}: second end"
