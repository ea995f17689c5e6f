"""A checked FlexibleBody from nodal matrices and interfaces, for all functions that build bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

from supple.algebra import read_only
from supple.body.checks import (
    MatrixLike,
    check_dissipates,
    check_moves_rigidly,
    check_nodes,
    checked_nodal_matrix,
)
from supple.body.coordinates import AS_RIGID_BODY, Coordinates, congruent, coordinates, rigid_sets
from supple.body.flexible_body import FlexibleBody
from supple.body.interface import AveragingInterface, RigidInterface
from supple.body.internal_force import LinearForce, QuadraticStrainForce
from supple.body.recovery import Recovery
from supple.body.rigid_motion import nodal_rigid_modes
from supple.body.second_order_tie import with_virtual_nodes
from supple.body.virtual_node import VirtualNode, interface_motions, virtual_nodes
from supple.errors import ModelError
from supple.fem import Attached

if TYPE_CHECKING:
    from supple.fem import FiniteElementModel

RIGID_TOLERANCE = 1e-9
ROUNDED_BOUNDARY = 1e-6
"""Largest force on the boundary grid that counts as rounding, relative to that of inertia at the lowest modal
frequency, `omega^2 M`: the grid would resist rigid motion at a thousandth of that frequency."""


def free_body(
    name: str,
    nodes: NDArray[np.float64],
    nodal_stiffness: MatrixLike,
    nodal_mass: MatrixLike,
    *,
    dofs_per_node: int,
    nodal_damping: MatrixLike | None = None,
    n_modal: int = 0,
    recovery: Recovery | None = None,
    interfaces: tuple[RigidInterface | AveragingInterface, ...],
    model: FiniteElementModel | None = None,
    rotation_operator: sparse.csc_array | None = None,
    rotation_limit: float = np.inf,
    rigid_tolerance: float = RIGID_TOLERANCE,
) -> FlexibleBody:
    """A checked free body: coordinates after ties, M = T^T M_nodal T and K = T^T K_nodal T.

    n_modal : number of modal coordinates, the last rows of the matrices; zero in rigid motions
    recovery : matrix of the motion of points, which become the last nodes, without mass in `nodal_mass`
    Raises ModelError as for `flexible_body` and `superelement`.
    """
    node_ids = None if model is None else model.mesh.node_ids
    attached = Attached() if model is None else model.attached
    check_nodes(name, nodes, node_ids)
    labels = np.arange(len(nodes)) if node_ids is None else node_ids

    def checked(what: str, matrix: MatrixLike) -> sparse.csc_array:
        return checked_nodal_matrix(name, what, matrix, nodes, dofs_per_node, n_modal, labels)

    M_nodal, K_nodal = checked("mass", nodal_mass), checked("stiffness", nodal_stiffness)
    C_nodal = None if nodal_damping is None else checked("damping", nodal_damping)
    K_nodal, C_nodal = freed_boundary(
        K_nodal, M_nodal, C_nodal, n_nodes=len(nodes), dofs_per_node=dofs_per_node
    )
    every = nodes if recovery is None else np.concatenate([nodes, recovery.points])
    tied = np.concatenate([np.empty(0, dtype=np.int64), *(each.nodes for each in attached.rigid)])
    virtual = virtual_nodes(name, every, dofs_per_node, interfaces, node_ids, tied)
    rigid = _rigid_interfaces(name, virtual, len(nodes))
    sets = rigid_sets(name, len(nodes), rigid, attached)
    made = coordinates(
        *(name, nodes, dofs_per_node, K_nodal, M_nodal, sets, attached),
        n_interfaces=len(rigid),
        n_modal=n_modal,
        tolerance=rigid_tolerance,
        node_ids=labels,
    )
    _refuse_rigid(made, name, K_nodal, len(nodes))
    displaced = made.bare[(made.bare < len(nodes) * dofs_per_node) & (made.bare % dofs_per_node < 3)]
    # The check needs the nodal matrices: the eliminations change the size of the forces that cancel.
    R = np.vstack([nodal_rigid_modes(nodes, dofs_per_node), np.zeros((n_modal, 6))])
    check_moves_rigidly(name, "stiffness", K_nodal, R, dofs_per_node, rigid_tolerance, labels)
    C = None
    if C_nodal is not None:
        check_moves_rigidly(name, "damping", C_nodal, R, dofs_per_node, rigid_tolerance, labels)
        C = made.of(C_nodal)
        check_dissipates(name, C, made.stiffness, rigid_tolerance)
    n_nodal, n_wide = len(nodes) * dofs_per_node, len(every) * dofs_per_node
    T = sparse.csc_array(made.expansion[:n_nodal])
    own_mass = sparse.csc_array(M_nodal[:n_nodal, :n_nodal])
    own_mass.resize(n_wide, n_wide)  # zeros for recovered points, also below
    if recovery is not None:
        recovery.check(name, nodes, dofs_per_node, n_nodal + n_modal)
        T = sparse.csc_array(sparse.vstack([T, recovery.rows(dofs_per_node) @ made.expansion]))
        if rotation_operator is not None:
            rotation_operator = sparse.csc_array(rotation_operator, copy=True)
            rotation_operator.resize(rotation_operator.tocsr().indptr.size - 1, n_wide)
    body = FlexibleBody(
        name=name,
        nodes=read_only(every),
        dofs_per_node=dofs_per_node,
        expansion=T,
        nodal_mass=own_mass,
        mass=made.mass,
        stiffness=made.stiffness,
        interfaces=interface_motions(
            every,
            dofs_per_node,
            T,
            virtual,
            rigid_motions=made.last_coordinates(6 * len(rigid)),
            pieces=[members for members, _ in sets[len(sets) - len(rigid) :]],
            turns_finitely=model is not None and model.strains_vanish_in_rotation,
        ),
        rigid_modes=read_only(made.rigid_modes),
        model=model,
        force=LinearForce(made.stiffness) if model is None else _quadratic_force(model, made),
        rotation_operator=rotation_operator,
        rotation_limit=rotation_limit,
        threes=_threes(made, M_nodal, nodes, dofs_per_node, recovery),
        n_modal=n_modal,
        massless=np.unique(displaced // dofs_per_node),
        damping=C,
    )
    for node in virtual:
        if not node.is_rigid:
            body.warn_of_massless(f"body '{name}', interface '{node.name}'", node.node_ids)
    _ = body.grounded_stiffness  # computed now, so that a mechanism is reported when the body is built
    return body


def _rigid_interfaces(
    body: str, virtual: tuple[VirtualNode, ...], n_nodes: int
) -> list[tuple[str, NDArray[np.int64], NDArray[np.float64]]]:
    """Name, nodes and position of each rigid interface; ModelError for one on recovered points."""
    rigid = [(node.name, node.node_ids, node.position) for node in virtual if node.is_rigid]
    for interface, members, _ in rigid:
        if members.max() >= n_nodes:
            raise ModelError(
                f"body '{body}', interface '{interface}': a recovered point follows the boundary and the "
                'modes, so nothing can be tied to it; take kind = "averaging" (AveragingInterface), or a '
                "boundary grid"
            )
    return rigid


def _refuse_rigid(made: Coordinates, body: str, stiffness: sparse.csc_array, n_nodes: int) -> None:
    """Raise ModelError for a body that no motion strains."""
    if len(made.sets) == 1 and len(made.sets[0][0]) == n_nodes and not made.n_modal:
        raise ModelError(f"body '{body}': its interfaces tie every node rigidly; use a RigidBody")
    if made.is_rigid(stiffness):
        raise ModelError(f"body '{body}': no motion strains it: {AS_RIGID_BODY}")


def _threes(
    made: Coordinates,
    nodal_mass: sparse.csc_array,
    nodes: NDArray[np.float64],
    dofs_per_node: int,
    recovery: Recovery | None,
) -> tuple[sparse.csc_array, sparse.csc_array] | None:
    """Map (n0, n) from q to the coordinates in triples q0, and the mass (n0, n0) of q0; None if q0 = q.

    Modal coordinates are not in q0; displacements of recovered points are, if masses of them are known.
    """
    if (rest := made.threes) is None:
        return None
    n_nodal = len(nodes) * dofs_per_node
    whole = sparse.csc_array(made.whole[:n_nodal, : rest.indptr.size - 1])
    masses = None
    if recovery is not None and made.n_modal:
        masses = recovery.masses(nodal_mass.toarray(), nodes, dofs_per_node)
    if recovery is None or masses is None:
        return sparse.csc_array(rest), congruent(whole, sparse.csc_array(nodal_mass[:n_nodal, :n_nodal]))
    rest = sparse.vstack([rest, sparse.csc_array(recovery.matrix) @ made.expansion])
    mass = sparse.block_diag([congruent(whole, _on_axes(masses[0])), _on_axes(masses[1])])
    return sparse.csc_array(rest), sparse.csc_array(mass)


def _on_axes(masses: NDArray[np.float64]) -> sparse.csc_array:
    """Masses and moments of inertia, each along or about three axes, as a diagonal matrix."""
    return sparse.csc_array(sparse.diags_array(np.repeat(masses, 3)))


def _quadratic_force(model: FiniteElementModel, made: Coordinates) -> QuadraticStrainForce:
    """Internal force of the elements, with second-order ties if rotations leave no second-order strain."""
    if not made.sets or not model.strains_vanish_in_rotation:
        return QuadraticStrainForce(model, made.expansion)
    expansion = with_virtual_nodes(made.whole, model.dofs_per_node, len(made.sets))
    if made.rest is not None:
        expansion = sparse.csc_array(expansion @ made.rest)
    return QuadraticStrainForce(model, expansion, made.sets)


def freed_boundary(
    stiffness: sparse.csc_array,
    mass: sparse.csc_array,
    damping: sparse.csc_array | None,
    *,
    n_nodes: int,
    dofs_per_node: int,
) -> tuple[sparse.csc_array, sparse.csc_array | None]:
    """Stiffness and damping of a condensed model, without rounding errors in the rows of its only grid.

    Every motion of a single grid with six freedoms is rigid, so its rows are zero. Programs write the
    difference of large forces instead, which is not small relative to other entries of these rows. Larger
    entries, and the matrices of other models, are returned unchanged.
    """
    n = stiffness.indptr.size - 1
    if n_nodes != 1 or dofs_per_node != 6 or n <= 6 or mass.shape != stiffness.shape:
        return stiffness, damping
    inertia, modal, M = mass.diagonal()[:6], stiffness[6:, 6:].toarray(), mass[6:, 6:].toarray()
    try:
        lowest = float(linalg.eigvalsh(modal, M, subset_by_index=(0, 0))[0])
    except (linalg.LinAlgError, ValueError):  # no positive mass, or no finite number: the body checks both
        return stiffness, damping
    if lowest <= 0 or not (inertia > 0).all():
        return stiffness, damping
    size = np.sqrt(np.concatenate([lowest * inertia, np.maximum(np.diag(modal), 0.0)]))
    limit = ROUNDED_BOUNDARY * np.outer(size[:6], size)
    K = _freed(stiffness, limit)
    return K, None if damping is None else _freed(damping, limit / np.sqrt(lowest))


def _freed(matrix: sparse.csc_array, limit: np.ndarray) -> sparse.csc_array:
    """The matrix without entries of the grid up to the limit (6, n)."""
    entries = matrix.toarray()
    entries[:6][abs(entries[:6]) <= limit] = 0.0
    entries[:, :6][abs(entries[:, :6]) <= limit.T] = 0.0
    return sparse.csc_array(entries)
