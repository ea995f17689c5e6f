"""A checked FlexibleBody from nodal matrices and interfaces, for all functions that build bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.algebra import read_only
from supple.body.checks import (
    check_dissipates,
    check_moves_rigidly,
    check_nodes,
    checked_nodal_matrix,
)
from supple.body.coordinates import Coordinates, congruent, coordinates, rigid_sets
from supple.body.flexible_body import FlexibleBody
from supple.body.interface import AveragingInterface, RigidInterface
from supple.body.internal_force import LinearForce, QuadraticStrainForce
from supple.body.recovery import Recovery
from supple.body.rigid_motion import nodal_rigid_modes
from supple.body.second_order_tie import with_virtual_nodes
from supple.body.single_boundary import freed_boundary
from supple.body.virtual_node import interface_motions, virtual_nodes
from supple.errors import ModelError
from supple.fem import Attached

if TYPE_CHECKING:
    from supple.fem import FiniteElementModel

RIGID_TOLERANCE = 1e-9


def free_body(
    name: str,
    nodes: NDArray[np.float64],
    nodal_stiffness: Any,
    nodal_mass: Any,
    *,
    dofs_per_node: int,
    nodal_damping: Any = None,
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

    Raises
    ------
    ModelError   as for `flexible_body` and `superelement`
    """
    node_ids = None if model is None else model.mesh.node_ids
    attached = Attached() if model is None else model.attached
    check_nodes(name, nodes, node_ids)
    labels = np.arange(len(nodes)) if node_ids is None else node_ids

    def checked(what: str, matrix: Any) -> sparse.csc_array:
        return checked_nodal_matrix(name, what, matrix, nodes, dofs_per_node, n_modal, labels)

    M_nodal, K_nodal = checked("mass", nodal_mass), checked("stiffness", nodal_stiffness)
    C_nodal = None if nodal_damping is None else checked("damping", nodal_damping)
    own = {"n_nodes": len(nodes), "dofs_per_node": dofs_per_node}
    K_nodal, C_nodal = freed_boundary(K_nodal, M_nodal, C_nodal, **own)
    every = nodes if recovery is None else np.concatenate([nodes, recovery.points])
    pieces = [each.nodes for each in attached.rigid]
    tied = np.concatenate(pieces) if pieces else None
    virtual = virtual_nodes(name, every, dofs_per_node, interfaces, node_ids, tied)
    rigid = [(node.name, node.node_ids, node.position) for node in virtual if node.is_rigid]
    for interface, members, _ in rigid:
        if members.max() >= len(nodes):
            raise ModelError(
                f"body '{name}', interface '{interface}': a recovered point follows the boundary and the "
                'modes, so nothing can be tied to it; take kind = "averaging" (AveragingInterface), or a '
                "boundary grid"
            )
    sets = rigid_sets(name, len(nodes), rigid, attached)
    if len(sets) == 1 and len(sets[0][0]) == len(nodes) and not n_modal:
        raise ModelError(f"body '{name}': its interfaces tie every node rigidly; use a RigidBody")
    made = coordinates(
        *(name, nodes, dofs_per_node, K_nodal, M_nodal, sets, attached),
        n_interfaces=len(rigid),
        n_modal=n_modal,
        tolerance=rigid_tolerance,
    )
    displaced = made.bare[(made.bare < len(nodes) * dofs_per_node) & (made.bare % dofs_per_node < 3)]
    M, K = made.mass, made.stiffness
    # The check needs the nodal matrices: the eliminations change the size of the forces that cancel.
    R = np.vstack([nodal_rigid_modes(nodes, dofs_per_node), np.zeros((n_modal, 6))])
    check_moves_rigidly(name, "stiffness", K_nodal, R, dofs_per_node, rigid_tolerance, labels)
    C = None
    if C_nodal is not None:
        check_moves_rigidly(name, "damping", C_nodal, R, dofs_per_node, rigid_tolerance, labels)
        C = made.of(C_nodal)
        check_dissipates(name, C, K, rigid_tolerance)
    n_nodal = len(nodes) * dofs_per_node
    of_all, T = made.expansion, made.expansion
    if n_modal:
        T = sparse.csc_array(T[:n_nodal])
    own_mass = sparse.csc_array(M_nodal[:n_nodal, :n_nodal])
    threes = _threes(made, own_mass)
    if recovery is not None:
        recovery.check(name, nodes, dofs_per_node, n_nodal + n_modal)
        T = sparse.csc_array(sparse.vstack([T, recovery.rows(dofs_per_node) @ of_all]))
        masses = recovery.masses(M_nodal.toarray(), nodes, dofs_per_node) if n_modal else None
        if masses is not None:
            points = sparse.csc_array(recovery.matrix) @ of_all
            threes = _with_points(_threes(made, _of_nodes(masses[0])), points, masses[1])
        own_mass, rotation_operator = _widened(own_mass, rotation_operator, len(every) * dofs_per_node)
    body = FlexibleBody(
        name=name,
        nodes=read_only(every),
        dofs_per_node=dofs_per_node,
        expansion=T,
        nodal_mass=own_mass,
        mass=M,
        stiffness=K,
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
        force=LinearForce(K) if model is None else _quadratic_force(model, made),
        rotation_operator=rotation_operator,
        rotation_limit=rotation_limit,
        threes=threes,
        n_modal=n_modal,
        massless=np.unique(displaced // dofs_per_node),
        damping=C,
    )
    for node in virtual:
        if not node.is_rigid:
            body.warn_of_massless(f"body '{name}', interface '{node.name}'", node.node_ids)
    _ = body.grounded_stiffness  # computed now, so that a mechanism is reported when the body is built
    return body


def _threes(
    made: Coordinates, nodal_mass: sparse.csc_array
) -> tuple[sparse.csc_array, sparse.csc_array] | None:
    """Map (n0, n) from q to the coordinates in triples q0, and the mass (n0, n0) of q0; None if q0 = q.

    Modal coordinates are not in q0.
    """
    rest = made.threes
    if rest is None:
        return None
    n_threes, n_nodal = rest.indptr.size - 1, nodal_mass.indptr.size - 1
    whole = sparse.csc_array(made.whole[:n_nodal, :n_threes])
    return sparse.csc_array(rest), congruent(whole, nodal_mass)


def _of_nodes(masses: NDArray[np.float64]) -> sparse.csc_array:
    """Masses and moments of inertia (N, 1 or 2) as a diagonal matrix of the nodal freedoms."""
    return sparse.csc_array(sparse.diags_array(np.repeat(masses, 3)))


def _with_points(
    of_nodes: tuple[sparse.csc_array, sparse.csc_array] | None,
    points: sparse.csc_array,
    masses: NDArray[np.float64],
) -> tuple[sparse.csc_array, sparse.csc_array] | None:
    """Result of `_threes`, extended by displacements (3 P, n) and masses (P,) of points; None for None."""
    if of_nodes is None:
        return None
    rest, mass = of_nodes
    own = sparse.diags_array(np.repeat(masses, 3))
    return (
        sparse.csc_array(sparse.vstack([rest, points])),
        sparse.csc_array(sparse.block_diag([mass, own])),
    )


def _widened(
    mass: sparse.csc_array, rotations: sparse.csc_array | None, n: int
) -> tuple[sparse.csc_array, sparse.csc_array | None]:
    """Mass and rotation operator, extended to n nodal freedoms with zeros for the added freedoms."""
    k = n - (mass.indptr.size - 1)
    wide = sparse.csc_array(sparse.block_diag([mass, sparse.csc_array((k, k))], format="csc"))
    if rotations is None:
        return wide, None
    none = sparse.csc_array((rotations.tocsr().indptr.size - 1, k))
    return wide, sparse.csc_array(sparse.hstack([rotations, none]))


def _quadratic_force(model: FiniteElementModel, made: Coordinates) -> QuadraticStrainForce:
    """Internal force of the elements, with second-order ties if rotations leave no second-order strain."""
    if not made.sets or not model.strains_vanish_in_rotation:
        return QuadraticStrainForce(model, made.expansion)
    expansion = with_virtual_nodes(made.whole, model.dofs_per_node, len(made.sets))
    if made.rest is not None:
        expansion = sparse.csc_array(expansion @ made.rest)
    return QuadraticStrainForce(model, expansion, made.sets)
