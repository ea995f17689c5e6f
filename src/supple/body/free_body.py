"""From nodal matrices and interfaces to a checked FlexibleBody: the step that all builders share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.algebra import read_only
from supple.body.checks import (
    check_moves_rigidly,
    check_nodes,
    check_positive_mass,
    checked_nodal_matrix,
)
from supple.body.flexible_body import FlexibleBody
from supple.body.interface import AveragingInterface, RigidInterface
from supple.body.internal_force import LinearForce, QuadraticStrainForce
from supple.body.massless_motion import StaticallyTied, massless_motions, tie_statically
from supple.body.rigid_elimination import rigid_elimination
from supple.body.rigid_motion import nodal_rigid_modes
from supple.body.second_order_tie import RigidSet, with_virtual_nodes
from supple.body.virtual_node import interface_motions, virtual_nodes
from supple.errors import ModelError

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
    interfaces: tuple[RigidInterface | AveragingInterface, ...],
    model: FiniteElementModel | None = None,
    rotation_operator: sparse.csc_array | None = None,
    rotation_limit: float = np.inf,
    rigid_tolerance: float = RIGID_TOLERANCE,
) -> FlexibleBody:
    """Eliminate rigid interfaces, M = T^T M_nodal T and K likewise, and check what every free body obeys."""
    node_ids = None if model is None else model.mesh.node_ids
    check_nodes(name, nodes, node_ids)
    M_nodal = checked_nodal_matrix(name, "mass", nodal_mass, nodes, dofs_per_node)
    K_nodal = checked_nodal_matrix(name, "stiffness", nodal_stiffness, nodes, dofs_per_node)
    virtual = virtual_nodes(name, nodes, dofs_per_node, interfaces, node_ids)
    rigid = [node for node in virtual if node.is_rigid]

    rigid_sets = [(node.node_ids, node.position) for node in rigid]
    T = rigid_elimination(nodes, dofs_per_node, rigid_sets)
    if sum(node.node_ids.size for node in rigid) == len(nodes):
        raise ModelError(f"body '{name}': its interfaces hold every node rigidly; describe it by a RigidBody")
    check_positive_mass(name, M_nodal, dofs_per_node)
    M, K = _congruent(T, M_nodal), _congruent(T, K_nodal)

    free = np.ones(len(nodes), dtype=bool)
    for node in rigid:
        free[node.node_ids] = False
    R = np.vstack(
        [
            nodal_rigid_modes(nodes[free], dofs_per_node),
            nodal_rigid_modes(np.array([node.position for node in rigid]).reshape(-1, 3), 6),
        ]
    )
    check_moves_rigidly(name, K, R, rigid_tolerance)
    tied = _massless_tied(name, K, M, 6 * len(rigid), rigid_tolerance)
    if tied is not None:
        T, R = sparse.csc_array(T @ tied.expansion), R[tied.kept]
        M, K = _congruent(tied.expansion, M), _congruent(tied.expansion, K)

    body = FlexibleBody(
        name=name,
        nodes=read_only(nodes),
        dofs_per_node=dofs_per_node,
        expansion=T,
        nodal_mass=M_nodal,
        mass=M,
        stiffness=K,
        interfaces=interface_motions(
            nodes,
            dofs_per_node,
            T,
            virtual,
            turns_finitely=model is not None and model.strains_vanish_when_turned,
        ),
        rigid_modes=read_only(R),
        model=model,
        force=LinearForce(K) if model is None else _quadratic_force(model, T, rigid_sets),
        rotation_operator=rotation_operator,
        rotation_limit=rotation_limit,
    )
    _ = body.grounded_stiffness  # made now, so that a mechanism is named where the body is built
    return body


def _massless_tied(
    name: str, K: sparse.csc_array, M: sparse.csc_array, n_rigid: int, tolerance: float
) -> StaticallyTied | None:
    """How motions without mass follow the others; None where every motion carries mass."""
    try:
        motions = massless_motions(M, tolerance)
        if not motions.shape[1]:
            return None
        return tie_statically(K, motions, np.arange(len(motions)) < len(motions) - n_rigid)
    except ModelError as error:
        raise ModelError(
            f"body '{name}': the mass matrix is not positive definite: {error}; is the density positive "
            "everywhere?"
        ) from None


def _quadratic_force(
    model: FiniteElementModel, T: sparse.csc_array, rigid_sets: Sequence[RigidSet]
) -> QuadraticStrainForce:
    """Ties of second order, unless the elements' strains see less of a rotation than they would."""
    if not rigid_sets or not model.strains_vanish_when_turned:
        return QuadraticStrainForce(model, T)
    expansion = with_virtual_nodes(T, model.dofs_per_node, len(rigid_sets))
    return QuadraticStrainForce(model, expansion, rigid_sets)


def _congruent(T: sparse.csc_array, matrix: sparse.csc_array) -> sparse.csc_array:
    product = T.T @ matrix @ T
    return sparse.csc_array(0.5 * (product + product.T))
