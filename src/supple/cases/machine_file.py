"""A machine of rigid bodies from another program's file, as if its tables were in the case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field
from scipy.spatial.transform import Rotation

from supple.body import RigidBody
from supple.cases.body_kinds import kind_of
from supple.cases.shared_rules import FileName
from supple.errors import SuppleError
from supple.importers.text_file import is_file
from supple.importers.toml import CheckedTable, KeyPath, Raw
from supple.machine import (
    AngleStop,
    Bushing,
    ForceElement,
    Joint,
    Placed,
    SlideStop,
    TorsionSpringDamper,
    Universal,
    read_mujoco,
)

Mistake = tuple[KeyPath, str]


class MachineFile(CheckedTable):
    """Rigid bodies, joints, springs and stops of a URDF or MJCF file, added to the case."""

    mujoco: FileName = Field(
        description="URDF or MJCF file beside the case file; pip install 'supple[mujoco]'"
    )
    leave_out: tuple[str, ...] = Field(
        (),
        strict=False,
        description='features of the file that are omitted: "actuators", "tendons", "friction", "armature", '
        '"equality", "gravcomp", "fluid", "flex", "flags", "limits", "nonlinear"',
    )


def with_machine(raw: Raw, folder: Path) -> tuple[Raw, list[Mistake]]:
    """The raw case with the tables of its machine file added, and the mistakes in them.

    A body of the case replaces the body of the same name in the file, at the position of that body. Its
    interfaces take the positions of the file's interfaces of the same name, which are at joints. A body
    without a kind adds its keys to the rigid body of the file.
    """
    given = raw.get("machine")
    name = given.get("mujoco") if isinstance(given, Mapping) else None
    if not isinstance(given, Mapping) or not isinstance(name, str) or not is_file(folder / name):
        return raw, []
    leave_out = given.get("leave_out", [])
    try:
        system = read_mujoco(folder / name, leave_out=leave_out if isinstance(leave_out, list) else [])
    except SuppleError as error:
        return raw, [(("machine", "mujoco"), str(error))]
    made = {name: _body(system.placed(name), body) for name, body in system.bodies_of(RigidBody).items()}
    bodies, mistakes = [], list[Mistake]()
    for number, body in enumerate(_listed(raw, "body")):
        own = made.pop(str(body.get("name")), None) if isinstance(body, Mapping) else None
        bodies.append(body if own is None else _in_its_place(body, own, ("body", number), mistakes))
    loads = _with_names([_load(load) for load in system.loads])
    added = {
        "joint": [_joint(joint) for joint in system.joints],
        "spring": [load for load in loads if load["kind"] == "torsion"],
        "element": [load for load in loads if load["kind"] != "torsion"],
    }
    tables = {section: [*_listed(raw, section), *new] for section, new in added.items()}
    gravity = {} if "gravity" in raw else {"gravity": _numbers(system.gravity)}
    return {**raw, **gravity, **tables, "body": [*bodies, *made.values()]}, mistakes


def _listed(raw: Raw, section: str) -> Sequence[Any]:
    given = raw.get(section, [])
    return given if isinstance(given, list) else []


def _body(placed: Placed, body: RigidBody) -> dict[str, object]:
    return {
        "name": body.name,
        "rigid": {"mass": body.mass, "centre": _numbers(body.centre), "inertia": body.inertia.tolist()},
        "interface": [{"name": each, "position": _numbers(at)} for each, at in body.points.items()],
        "position": _numbers(placed.position),
        "rotation": _numbers(Rotation.from_matrix(placed.rotation).as_rotvec()),
    }


def _in_its_place(
    body: Mapping[str, Any], rigid: dict[str, Any], path: KeyPath, mistakes: list[Mistake]
) -> dict[str, object]:
    """A body of the case with the position of the machine's body, and its interfaces at the joints."""
    for key in ("position", "rotation"):
        if key in body:
            message = f"the machine file defines the position of body '{rigid['name']}'; remove the key"
            mistakes.append(((*path, key), message))
    places = {each["name"]: each["position"] for each in rigid["interface"]}
    given = [each for each in _listed(body, "interface") if isinstance(each, Mapping)]
    names = {each.get("name") for each in given}
    if kind_of(body) is None:
        interfaces = [*(each for each in rigid["interface"] if each["name"] not in names), *given]
        return {**rigid, **body, "interface": interfaces}
    missing = [name for name in places if name not in names]
    if missing and "reduced" not in body:
        message = f"the machine file has joints at its {', '.join(missing)}; add interfaces of these names"
        mistakes.append((path, message))
    at_joints = [
        {**each, "position": places[each["name"]]}
        if each.get("name") in places and not {"position", "connection"} & set(each)
        else each
        for each in given
    ]
    stands = {key: rigid[key] for key in ("position", "rotation")}
    return {**body, **stands, **({"interface": at_joints} if given else {})}


def _joint(joint: Joint) -> dict[str, object]:
    kind = type(joint).__name__.lower()
    axes = {}
    if isinstance(joint, Universal):
        axes = {"axis": _numbers(joint.first_axis), "second_axis": _numbers(joint.second_axis)}
    elif (axis := getattr(joint, "axis", None)) is not None:
        axes = {"axis": _numbers(axis)}
    return {"kind": kind, "name": joint.name, **_ends(joint), **axes}


def _with_names(loads: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The tables with numbers after names that occur again, as of the springs of one ball joint."""
    names = [load["name"] for load in loads]
    earlier = [names[:place].count(name) for place, name in enumerate(names)]
    return [
        {**load, "name": f"{load['name']} {count + 1}"} if count else load
        for load, count in zip(loads, earlier, strict=True)
    ]


def _load(load: object) -> dict[str, object]:
    """A torsion spring, a stop, or the bushing that represents the spring of a slide or ball joint."""
    match load:
        case TorsionSpringDamper():
            kind, word = "torsion", "spring"
            own = {"stiffness": load.stiffness, "damping": load.damping, "free_angle": load.rest_angle}
        case AngleStop() | SlideStop():
            kind, word = "angle-stop" if isinstance(load, AngleStop) else "slide-stop", "stop"
            own = {"lower": load.lower, "upper": load.upper, "stiffness": load.penalty.stiffness}
        case Bushing():
            kind, word = "bushing", "spring"
            own = {"stiffness": _numbers(np.diag(load.stiffness)), "damping": _numbers(np.diag(load.damping))}
            own |= {} if load.offset is None else {"offset": _numbers(load.offset)}
        case _:
            raise NotImplementedError(f"a machine file has a {type(load).__name__}, which has no table")
    name = f"{load.second.interface} {word}"
    return {"kind": kind, "name": name, **_ends(load), "axis": _numbers(load.axis), **own}


def _ends(pair: Joint | ForceElement) -> dict[str, str]:
    return {"first": str(pair.first), "second": str(pair.second)}


def _numbers(values: ArrayLike) -> list[float]:
    return np.asarray(values, dtype=float).tolist()
