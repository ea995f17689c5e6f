"""From the body tables of a case to the bodies a script would build."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    FlexibleBody,
    Frame,
    MeanAxisFrame,
    ModalDamping,
    NodalFixedFrame,
    RayleighDamping,
    RigidBody,
    RigidInterface,
    flexible_body,
    rayleigh_from_ratios,
    read_superelement,
)
from supple.cli import case_schema as schema
from supple.cli.did_you_mean import did_you_mean
from supple.cli.line_index import KeyPath
from supple.cli.read_case import CaseFile
from supple.errors import ModelError
from supple.fem import (
    GREEN_LAGRANGE,
    VON_KARMAN,
    FiniteElementModel,
    HomogeneousWall,
    Isotropic,
    shell_model,
    solid_model,
)
from supple.importers import read_mesh
from supple.mesh import Mesh
from supple.multibody import FullBody
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    Guyan,
    NoDerivatives,
    NormalModes,
    PickedDerivatives,
    ReducedBody,
    Rubin,
    reduce,
)

Notify = Callable[[str], None]

_KINEMATICS = {"green-lagrange": GREEN_LAGRANGE, "von-karman": VON_KARMAN}


def read_meshes(case_file: CaseFile) -> dict[str, Mesh]:
    """The mesh of each body that has one, by body name.

    Raises
    ------
    CaseError   interfaces, loads or output that name a node set no mesh has: all of them, with their lines
    """
    case = case_file.case
    meshes = {body.name: read_mesh(case_file.resolve(body.mesh)) for body in case.body if body.mesh}
    mistakes = [
        (path, message)
        for path, body, name in _node_set_names(case)
        if body in meshes and (message := _missing(name, meshes[body]))
    ]
    if mistakes:
        raise case_file.error(mistakes)
    return meshes


def _node_set_names(case: schema.Case) -> list[tuple[KeyPath, str, str]]:
    """Where a node set is named: key path, body, set. Loads and output may name interfaces instead."""
    names: list[tuple[KeyPath, str, str]] = []
    interfaces = {f"{body.name}.{interface.name}" for body in case.body for interface in body.interface}
    for i, body in enumerate(case.body):
        for j, interface in enumerate(body.interface):
            if interface.nodes is not None:
                names.append((("body", i, "interface", j, "nodes"), body.name, interface.nodes))
    places: list[tuple[KeyPath, str]] = [(("load", i, "at"), load.at) for i, load in enumerate(case.load)]
    places += [(("output", "track", i), place) for i, place in enumerate(case.output.track)]
    for path, place in places:
        if place not in interfaces:
            body, _, name = place.partition(".")
            names.append((path, body, name))
    return names


def _missing(name: str, mesh: Mesh) -> str:
    if name in mesh.node_sets:
        return ""
    known = ", ".join(mesh.node_sets) or "none"
    return f"there is no node set named {name!r}{did_you_mean(name, mesh.node_sets)}; the mesh has: {known}"


def build_body(
    case_file: CaseFile, table: schema.Body, mesh: Mesh | None, notify: Notify
) -> RigidBody | ReducedBody | FullBody:
    """The body of a table, reduced unless its basis is "none"; `notify` hears of each long step."""
    if table.rigid is not None:
        return _rigid_body(table, table.rigid)
    notify(f"assembling body '{table.name}'")
    body = build_flexible_body(case_file, table, mesh)
    assert table.reduction is not None  # a rule of the case file
    frame = build_frame(table)
    damping = build_damping(table, body, frame)
    if isinstance(table.reduction, schema.FullOrder):
        assert not isinstance(damping, ModalDamping)  # a rule of the case file
        return FullBody(body, frame, damping)
    notify(f"reducing body '{table.name}' ({body.n} freedoms)")
    return reduce(
        body,
        frame,
        build_basis(table.reduction),
        derivatives=build_derivatives(table.reduction.derivatives),
        damping=damping,
    )


def build_flexible_body(case_file: CaseFile, table: schema.Body, mesh: Mesh | None) -> FlexibleBody:
    """The elastic body that a table describes, not yet reduced."""
    interfaces = [_interface(interface) for interface in table.interface]
    if table.superelement is not None:
        matrices = table.superelement
        return read_superelement(
            table.name,
            nodes=case_file.resolve(matrices.nodes),
            stiffness=case_file.resolve(matrices.stiffness),
            mass=case_file.resolve(matrices.mass),
            dofs_per_node=matrices.dofs_per_node,
            interfaces=interfaces,
        )
    if mesh is None:
        raise ModelError(f"body '{table.name}' has no mesh; read the meshes of the case first")
    body = flexible_body(table.name, _model(table, mesh), interfaces)
    return body.linearized() if table.linear else body


def _model(table: schema.Body, mesh: Mesh) -> FiniteElementModel:
    if table.solid is not None:
        solid = table.solid
        return solid_model(mesh, Isotropic(solid.youngs_modulus, solid.poissons_ratio, solid.density))
    shell = table.shell
    assert shell is not None  # a rule of the case file
    material = Isotropic(shell.youngs_modulus, shell.poissons_ratio, shell.density)
    wall = HomogeneousWall(material, shell.thickness)
    return shell_model(mesh, wall, kinematics=_KINEMATICS[shell.kinematics])


def _interface(table: schema.Interface) -> RigidInterface | AveragingInterface:
    kind = RigidInterface if table.kind == "rigid" else AveragingInterface
    nodes = table.nodes if table.nodes is not None else np.array(table.node_indices)
    return kind(table.name, nodes, position=table.position)


def _rigid_body(table: schema.Body, rigid: schema.Rigid) -> RigidBody:
    places = {i.name: np.array(i.position) for i in table.interface if i.position is not None}
    return RigidBody(
        name=table.name,
        mass=rigid.mass,
        inertia=np.array(rigid.inertia),
        centre=np.array(rigid.centre),
        interfaces=places,
    )


def build_frame(table: schema.Body) -> MeanAxisFrame | NodalFixedFrame:
    """The floating frame of an elastic body."""
    if isinstance(table.frame, schema.NodalFixed):
        return NodalFixedFrame(table.frame.interface)
    return MeanAxisFrame()


def build_basis(table: schema.ReducedOrder) -> Rubin | CraigBampton | NormalModes | Guyan:
    """The recipe of the linear columns."""
    match table:
        case schema.Rubin(modes=modes):
            return Rubin(n_modes=modes)
        case schema.CraigBampton(modes=modes):
            return CraigBampton(n_modes=modes)
        case schema.NormalModes(modes=modes):
            return NormalModes(modes)
        case schema.Guyan():
            return Guyan()


def build_derivatives(
    table: schema.Derivatives,
) -> CompressedDerivatives | PickedDerivatives | NoDerivatives:
    """The choice of modal derivatives."""
    match table:
        case schema.AllPairsCompressed(number=number):
            return CompressedDerivatives(number)
        case schema.Picked(number=number):
            return PickedDerivatives(number)
        case schema.NoDerivatives():
            return NoDerivatives()


def build_damping(
    table: schema.Body, body: FlexibleBody, frame: Frame
) -> RayleighDamping | ModalDamping | None:
    """Damping of an elastic body; the frequencies of a Rayleigh ratio are those of the whole mesh."""
    match table.damping:
        case None:
            return None
        case schema.Rayleigh(alpha=alpha, beta=beta):
            return RayleighDamping(alpha, beta)
        case schema.Modal(ratio=ratio):
            return ModalDamping(ratio)
        case schema.RayleighRatio(ratio=ratio, modes=modes, held=held):
            constraint = (NodalFixedFrame(held) if held else frame).constraint(body)
            found = lowest_modes(body.stiffness, body.mass, max(modes), constraint=constraint)
            first, second = (float(np.sqrt(found.values[mode - 1])) for mode in modes)
            return rayleigh_from_ratios(ratio, first, second)
