"""From nodal matrices and interfaces to a checked FlexibleBody: the step that all builders share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.algebra import read_only
from supple.body.checks import (
    check_moves_rigidly,
    check_nodes,
    checked_nodal_matrix,
)
from supple.body.coordinates import Coordinates, congruent, coordinates, rigid_sets
from supple.body.flexible_body import FlexibleBody
from supple.body.interface import AveragingInterface, RigidInterface
from supple.body.internal_force import LinearForce, QuadraticStrainForce
from supple.body.second_order_tie import with_virtual_nodes
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
    interfaces: tuple[RigidInterface | AveragingInterface, ...],
    model: FiniteElementModel | None = None,
    rotation_operator: sparse.csc_array | None = None,
    rotation_limit: float = np.inf,
    rigid_tolerance: float = RIGID_TOLERANCE,
) -> FlexibleBody:
    """Coordinates that ties leave, M = T^T M_nodal T and K likewise, and what every free body obeys."""
    node_ids = None if model is None else model.mesh.node_ids
    attached = Attached() if model is None else model.attached
    check_nodes(name, nodes, node_ids)
    M_nodal = checked_nodal_matrix(name, "mass", nodal_mass, nodes, dofs_per_node)
    K_nodal = checked_nodal_matrix(name, "stiffness", nodal_stiffness, nodes, dofs_per_node)
    pieces = [each.nodes for each in attached.rigid]
    tied = np.concatenate(pieces) if pieces else None
    virtual = virtual_nodes(name, nodes, dofs_per_node, interfaces, node_ids, tied)
    rigid = [(node.name, node.node_ids, node.position) for node in virtual if node.is_rigid]
    sets = rigid_sets(name, len(nodes), rigid, attached)
    if sum(len(members) for members, _ in sets) == len(nodes):
        raise ModelError(f"body '{name}': its interfaces hold every node rigidly; describe it by a RigidBody")
    made = coordinates(
        *(name, nodes, dofs_per_node, K_nodal, M_nodal, sets, attached),
        n_interfaces=len(rigid),
        tolerance=rigid_tolerance,
    )
    M, K = made.mass, made.stiffness
    check_moves_rigidly(name, K, made.rigid_modes, rigid_tolerance)
    T = made.expansion
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
            rigid_motions=made.last_coordinates(6 * len(rigid)),
            pieces=[members for members, _ in sets[len(sets) - len(rigid) :]],
            turns_finitely=model is not None and model.strains_vanish_when_turned,
        ),
        rigid_modes=read_only(made.rigid_modes),
        model=model,
        force=LinearForce(K) if model is None else _quadratic_force(model, made),
        rotation_operator=rotation_operator,
        rotation_limit=rotation_limit,
        threes=None if made.rest is None else (made.rest, congruent(made.whole, M_nodal)),
    )
    _ = body.grounded_stiffness  # made now, so that a mechanism is named where the body is built
    return body


def _quadratic_force(model: FiniteElementModel, made: Coordinates) -> QuadraticStrainForce:
    """Ties of second order, unless the elements' strains see less of a rotation than they would."""
    if not made.sets or not model.strains_vanish_when_turned:
        return QuadraticStrainForce(model, made.expansion)
    expansion = with_virtual_nodes(made.whole, model.dofs_per_node, len(made.sets))
    if made.rest is not None:
        expansion = sparse.csc_array(expansion @ made.rest)
    return QuadraticStrainForce(model, expansion, made.sets)
