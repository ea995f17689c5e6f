"""Attributes of the datasets of a result file (unit, axes, columns, end of a force), and names of sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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


def name_taken_in_hdf5(name: str, names: Sequence[str]) -> str | None:
    """Reason for which a sensor cannot have its name in an HDF5 file beside all names, or None."""
    if name == "time":
        return "the HDF5 file of the sensors has the output times under the name time; give another name"
    if not name.strip("/"):
        return "in HDF5, / separates groups; give another name"
    above = next((other for other in names if name.startswith(f"{other}/")), None)
    if above is not None:
        return (
            f"in HDF5, / separates groups: its name lies below that of sensor '{above}'; rename one of them"
        )
    return None
