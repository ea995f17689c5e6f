"""From a case file to the system and the run that a script would describe."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from supple.body import FlexibleBody
from supple.cases import case_tables as schema
from supple.cases.laws import time_function
from supple.cli.build_bodies import (
    Notify,
    build_body,
    build_flexible_body,
    build_model,
    checked_line,
    read_meshes,
)
from supple.cli.build_reduction import build_start, corrects_itself
from supple.cli.read_case import CaseFile
from supple.cli.reduced_file import read_body
from supple.correction import ReductionStart
from supple.errors import ModelError
from supple.fem import stress_recovery
from supple.integrate import AdaptiveStep, FixedStep, GeneralizedAlpha, Run, Validity
from supple.machine import (
    GROUND,
    At,
    Ball,
    Cylindrical,
    DeadForce,
    DeadTorque,
    Fixed,
    FollowerForce,
    FollowerTorque,
    ForceElement,
    Joint,
    Placed,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    SpringDamper,
    System,
    TorsionSpringDamper,
    Universal,
)
from supple.mesh import Mesh
from supple.multibody.equations.model import initial_point


@dataclass(frozen=True, eq=False)
class BuiltCase:
    """The system of a case, with the meshes and the elements of its bodies, by body name.

    starts : of the bodies that stand in the system in full, to be reduced as far as their accuracy allows
    """

    case_file: CaseFile
    system: System
    meshes: Mapping[str, Mesh]
    flexible: Mapping[str, FlexibleBody]
    starts: Mapping[str, ReductionStart]


def build_case(case_file: CaseFile, notify: Notify) -> BuiltCase:
    """Read meshes, assemble and reduce bodies, and join them.

    notify : hears of each long step as it begins, and how far a search has come

    Raises
    ------
    CaseError   a node set that its mesh does not have; stress to draw of elements that have none
    SuppleError whatever the meshes, bodies, reductions and joints find wrong
    """
    case = case_file.case
    notify("reading meshes")
    meshes = read_meshes(case_file)
    flexible = {}
    for table in case.body:
        if table.rigid is None and table.reduced is None:
            notify(f"assembling body '{table.name}'")
            flexible[table.name] = build_flexible_body(case_file, table, meshes.get(table.name))
            notify(checked_line(flexible[table.name]))
    if case.output.colour == "von-mises":
        _check_stress(case_file, meshes, flexible)
    bodies = tuple(_placed(case_file, table, flexible.get(table.name), notify) for table in case.body)
    joints = tuple(build_joint(table, case_file.path.parent) for table in case.joint)
    unloaded = System(bodies=bodies, joints=joints, gravity=np.array(case.gravity))
    loads = [build_load(table, case, meshes, case_file.path.parent) for table in case.load]
    springs = [build_spring(table, unloaded) for table in case.spring]
    starts = {
        table.name: build_start(table, flexible[table.name]) for table in case.body if corrects_itself(table)
    }
    return BuiltCase(case_file, replace(unloaded, loads=(*loads, *springs)), meshes, flexible, starts)


def with_faces(meshes: Mapping[str, Mesh]) -> dict[str, Mesh]:
    """The meshes that can be drawn: beams alone have no faces."""
    return {name: mesh for name, mesh in meshes.items() if any(kind.dimension > 1 for kind in mesh.cells)}


def _check_stress(
    case_file: CaseFile, meshes: Mapping[str, Mesh], flexible: Mapping[str, FlexibleBody]
) -> None:
    """CaseError where what is drawn has no stress: better now than when the run is over."""
    tables = {table.name: table for table in case_file.case.body}
    drawn = with_faces(meshes)
    mistakes = [] if drawn else ["stress colours faces, and beams have none; remove the key"]
    for name, mesh in drawn.items():
        # A linear body has left its elements behind.
        model = flexible[name].model or build_model(case_file, tables[name], mesh)
        try:
            stress_recovery(model)
        except ModelError as error:
            mistakes.append(f"body '{name}': {error}; remove the key")
    if mistakes:
        raise case_file.error((("output", "colour"), mistake) for mistake in mistakes)


def build_run(table: schema.Simulation, *, strict: bool = False) -> Run:
    """The span of time of a case, and how it is stepped through."""
    return Run(
        table.duration,
        table.output_step,
        step=_step(table),
        method=GeneralizedAlpha(table.rho_inf),
        validity=Validity(strict=strict),
    )


def _step(table: schema.Simulation) -> FixedStep | AdaptiveStep:
    if table.step is not None:
        return FixedStep(table.step)
    assert table.adaptive is not None  # a rule of the case file
    return AdaptiveStep(table.adaptive.first, table.adaptive.largest, table.adaptive.tolerance)


def _placed(case_file: CaseFile, table: schema.Body, flexible: FlexibleBody | None, notify: Notify) -> Placed:
    return Placed(
        build_body(table, flexible, notify)
        if table.reduced is None
        else read_body(case_file.resolve(table.reduced), table.name),
        position=np.array(table.position),
        rotation=np.array(table.rotation),
        velocity=np.array(table.velocity),
        angular_velocity=np.array(table.angular_velocity),
    )


def end(text: str) -> At:
    """The end that `ground` or `BODY.INTERFACE` means."""
    body, _, interface = text.partition(".")
    return GROUND if text == "ground" else At(body, interface)


_WITHOUT_AXIS = {"fixed": Fixed, "ball": Ball}
_ALONG_ONE_AXIS = {"revolute": Revolute, "cylindrical": Cylindrical, "prismatic": Prismatic}


def build_joint(table: schema.Joint, folder: Path) -> Joint:
    """The joint that a table describes."""
    ends: dict[str, Any] = {"first": end(table.first), "second": end(table.second), "name": table.name or ""}
    if table.kind in _WITHOUT_AXIS:
        return _WITHOUT_AXIS[table.kind](**ends)
    axis = _given(table.axis)
    if table.kind in _ALONG_ONE_AXIS:
        return _ALONG_ONE_AXIS[table.kind](**ends, axis=axis)
    if table.kind == "universal":
        return Universal(**ends, first_axis=axis, second_axis=_given(table.second_axis))
    if table.kind == "prescribed-rotation":
        return PrescribedRotation(**ends, axis=axis, angle=_law(table, folder))
    return PrescribedTranslation(**ends, axis=axis, displacement=_law(table, folder))


def _given(axis: schema.Vector | None) -> tuple[float, float, float]:
    assert axis is not None  # a rule of the case file
    return axis


def _law(table: schema.Joint, folder: Path) -> Any:
    assert table.law is not None  # a rule of the case file
    return time_function(table.law, folder)


def build_load(
    table: schema.Load, case: schema.Case, meshes: Mapping[str, Mesh], folder: Path
) -> DeadForce | ForceElement:
    """The load that a table describes; over a node set a force is shared evenly."""
    factor = time_function(table.law, folder)
    vector = np.array(table.vector)
    name, _, place = table.at.partition(".")
    body = next(body for body in case.body if body.name == name)
    if place not in [interface.name for interface in body.interface]:
        nodes = meshes[name].nodes_of(place)
        return DeadForce(body=name, at=nodes, force=lambda t: vector / len(nodes) * factor(t))

    def history(t: Any) -> Any:
        return vector * factor(t)

    match table.kind, table.follower:
        case "force", False:
            return DeadForce(body=name, at=place, force=history)
        case "force", True:
            return FollowerForce(first=At(name, place), force=history)
        case "torque", False:
            return DeadTorque(first=At(name, place), torque=history)
        case _:
            return FollowerTorque(first=At(name, place), torque=history)


def build_spring(table: schema.Spring, system: System) -> SpringDamper | TorsionSpringDamper:
    """The spring and damper that a table describes."""
    first, second = end(table.first), end(table.second)
    if isinstance(table, schema.TorsionSpring):
        return TorsionSpringDamper(
            first=first,
            second=second,
            axis=table.axis,
            stiffness=table.stiffness,
            damping=table.damping,
            rest_angle=table.free_angle,
        )
    length = table.free_length
    if length is None:
        length = float(np.linalg.norm(initial_point(system, second) - initial_point(system, first)))
    return SpringDamper(
        first=first, second=second, stiffness=table.stiffness, damping=table.damping, rest_length=length
    )
