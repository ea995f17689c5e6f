"""From the body tables of a case to the bodies a script would build."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    FlexibleBody,
    Frame,
    FullBody,
    MeanAxisFrame,
    ModalDamping,
    ModelCheck,
    NodalFixedFrame,
    NodalMatrices,
    RayleighDamping,
    RigidBody,
    RigidInterface,
    check_elements,
    check_model,
    check_nodal_matrices,
    connection_interface,
    connection_named,
    flexible_body,
    labelled_superelement,
    nastran_model,
    rayleigh_from_ratios,
    read_nodal_matrices,
    read_superelement,
    rigid_mass_properties,
)
from supple.cases import case_tables as schema
from supple.cases.line_index import KeyPath
from supple.cli.build_reduction import build_basis, build_derivatives, corrects_itself, search_words
from supple.cli.did_you_mean import did_you_mean
from supple.cli.read_case import CaseFile
from supple.errors import ModelError
from supple.fem import (
    GREEN_LAGRANGE,
    VON_KARMAN,
    FiniteElementModel,
    HomogeneousSection,
    Isotropic,
    shell_model,
    solid_model,
)
from supple.importers import Connection, NastranModel, read_matrix, read_mesh, read_nastran
from supple.mesh import Mesh
from supple.reduction import ReducedBody, reduce


class Notify(Protocol):
    """What hears of the long steps of a build."""

    def __call__(self, step: str, detail: str = "", /) -> None:
        """A step begins; or, of the step that goes on, how far it has come."""
        ...


_KINEMATICS = {"green-lagrange": GREEN_LAGRANGE, "von-karman": VON_KARMAN}


def read_meshes(case_file: CaseFile) -> dict[str, Mesh]:
    """The mesh of each body that has one, by body name.

    Raises
    ------
    CaseError   interfaces, loads or output that name a node set no mesh has: all of them, with their lines
    """
    case = case_file.case
    # Matrices stand for elements of any kind, also such as a mesh cannot have: only their nodes are read.
    meshes = {
        body.name: read_mesh(case_file.resolve(body.mesh))
        for body in case.body
        if body.mesh and body.matrices is None
    }
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
    table: schema.Body, flexible: FlexibleBody | None, notify: Notify
) -> RigidBody | ReducedBody | FullBody:
    """The body of a table; full if its basis is "none", or if its reduction is to correct itself.

    flexible : from `build_flexible_body`; None for a rigid body
    notify : hears of each long step
    """
    if table.rigid is not None:
        return _rigid_body(table, table.rigid)
    assert flexible is not None
    frame = build_frame(table)
    damping = build_damping(table, flexible, frame)
    if isinstance(table.reduction, schema.FullOrder) or corrects_itself(table):
        assert not isinstance(damping, ModalDamping)  # a rule of the case file
        return FullBody(flexible, frame, damping)
    assert table.reduction is not None  # it would correct itself
    step = f"reducing body '{table.name}' ({flexible.n} freedoms)"
    notify(step)
    reduced = reduce(
        flexible,
        frame,
        build_basis(table.reduction, lambda detail: notify(step, detail)),
        derivatives=build_derivatives(table.reduction.derivatives),
        damping=damping,
    )
    proven = reduced.report.certificate
    if proven is not None:  # the numbers tried last are not those that were kept
        notify(step, search_words(proven.n_fixed_interface_modes, proven.largest_error))
    return reduced


def build_flexible_body(case_file: CaseFile, table: schema.Body, mesh: Mesh | None) -> FlexibleBody:
    """The elastic body that a table describes, not yet reduced.

    Raises
    ------
    ModelError   whatever is wrong with the model: all findings of its check, if that refuses it
    """
    try:
        body = _flexible_body(case_file, table, mesh)
    except ModelError:
        check_body(case_file, table, mesh, n_frequencies=0).raise_if_refused(table.name)
        raise
    return body.linearized() if table.linear else body


def checked_line(body: FlexibleBody) -> str:
    """What the checks of a body found, in a line: they refuse all but free, symmetric, positive models."""
    found = rigid_mass_properties(body.nodal_mass, body.nodes, body.dofs_per_node)
    return f"checked body '{body.name}': free, no mechanism, symmetric, mass {found.mass:.5g}"


def check_body(
    case_file: CaseFile, table: schema.Body, mesh: Mesh | None, *, n_frequencies: int
) -> ModelCheck:
    """Check of the nodal matrices of an elastic body, before its interfaces."""
    if table.matrices is not None:
        matrices = _nodal_matrices(case_file, table, table.matrices)
        return check_nodal_matrices(
            matrices, n_frequencies=n_frequencies, rigid_tolerance=table.matrices.rigid_tolerance
        )
    if table.superelement is not None:
        nodes, stiffness, mass = (
            read_matrix(case_file.resolve(getattr(table.superelement, what)))
            for what in ("nodes", "stiffness", "mass")
        )
        return check_model(
            nodes.toarray(),
            stiffness,
            mass,
            dofs_per_node=table.superelement.dofs_per_node,
            n_frequencies=n_frequencies,
        )
    return check_elements(build_model(case_file, table, _known(table, mesh)), n_frequencies=n_frequencies)


def _flexible_body(case_file: CaseFile, table: schema.Body, mesh: Mesh | None) -> FlexibleBody:
    if table.superelement is not None:
        matrices = table.superelement
        return read_superelement(
            table.name,
            nodes=case_file.resolve(matrices.nodes),
            stiffness=case_file.resolve(matrices.stiffness),
            mass=case_file.resolve(matrices.mass),
            dofs_per_node=matrices.dofs_per_node,
            interfaces=[_interface(interface, ()) for interface in table.interface],
        )
    if table.matrices is not None:
        nodal = _nodal_matrices(case_file, table, table.matrices)
        _check_rigid_connections(table, nodal.connections)
        return labelled_superelement(
            table.name,
            nodal,
            [_interface(interface, nodal.connections) for interface in table.interface],
            rigid_tolerance=table.matrices.rigid_tolerance,
        )
    model = build_model(case_file, table, _known(table, mesh))
    connections = _nastran_file(case_file, table).connections if table.nastran is not None else ()
    _check_rigid_connections(table, connections)
    return flexible_body(
        table.name, model, [_interface(interface, connections) for interface in table.interface]
    )


def _check_rigid_connections(table: schema.Body, connections: Sequence[Connection]) -> None:
    """ModelError for an RBE2 that is no interface: it stiffens the body that the file describes."""
    taken = {interface.connection for interface in table.interface}
    taken |= {interface.nodes for interface in table.interface if interface.kind == "rigid"}
    left = [c.name for c in connections if c.weights is None and c.name not in taken]
    if left:
        raise ModelError(
            f"body '{table.name}': {', '.join(left)} of {table.mesh} ties nodes rigidly and is not among the "
            f'interfaces; add an interface with connection = "{left[0]}", or remove the RBE2 from the file'
        )


def build_model(case_file: CaseFile, table: schema.Body, mesh: Mesh) -> FiniteElementModel:
    """The elements of a shell, solid or Nastran body."""
    if table.nastran is not None:
        kinematics = _KINEMATICS[table.nastran.kinematics]
        return nastran_model(_nastran_file(case_file, table), kinematics=kinematics)
    if table.solid is not None:
        solid = table.solid
        return solid_model(mesh, Isotropic(solid.youngs_modulus, solid.poissons_ratio, solid.density))
    shell = table.shell
    assert shell is not None  # a rule of the case file
    material = Isotropic(shell.youngs_modulus, shell.poissons_ratio, shell.density)
    wall = HomogeneousSection(material, shell.thickness)
    return shell_model(mesh, wall, kinematics=_KINEMATICS[shell.kinematics])


def _known(table: schema.Body, mesh: Mesh | None) -> Mesh:
    if mesh is None:
        raise ModelError(f"body '{table.name}' has no mesh; read the meshes of the case first")
    return mesh


def _nastran_file(case_file: CaseFile, table: schema.Body) -> NastranModel:
    assert table.mesh is not None  # a rule of the case file
    return read_nastran(case_file.resolve(table.mesh))


def _nodal_matrices(case_file: CaseFile, table: schema.Body, given: schema.Matrices) -> NodalMatrices:
    assert table.mesh is not None  # a rule of the case file
    return read_nodal_matrices(
        nodes=case_file.resolve(table.mesh),
        stiffness=case_file.resolve(given.stiffness),
        mass=case_file.resolve(given.mass),
        stiffness_name=given.stiffness_name,
        mass_name=given.mass_name,
    )


def _interface(
    table: schema.Interface, connections: Sequence[Connection]
) -> RigidInterface | AveragingInterface:
    if table.connection is not None:
        return connection_interface(connection_named(table.connection, connections), table.name)
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
