"""Internal force of a body whose elements and ties rotate exactly, with each element in corotated axes.

With strains quadratic in the freedoms, a rotation relative to the body's frame causes a strain of third order
in elements with nodal rotations and in elements at rigid interfaces. Here each element with nodal rotations
has axes rotated by the mean rotation R of its nodes; relative to these axes it has only its deformation,

    u_a' = R^T (x_a - mean x) - (X_a - mean X),      phi_a' = log(R^T exp(phi_a)),

and the nodes of a rigid interface rotate exactly. The force of the element at u', phi' is rotated back. The
difference between this force and the body's `force` is the error of the body's kinematics. The strains of
solids are invariant to rotation, so for solids only the ties differ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray
from supple.body.flexible_body import FlexibleBody
from supple.body.interface import BodyInterface
from supple.body.rigid_motion import are_collinear
from supple.body.tied_recovery import inner_pieces
from supple.body.virtual_node import ARCTAN
from supple.errors import ModelError
from supple.fem import QuadraticStrain
from supple.fem.node_sparsity import cell_nodes
from supple.fem.quadratic_strain import internal_force


def turned_force(body: FlexibleBody, q: FloatArray) -> FloatArray:
    """Internal force (n,) at the body's coordinates q (n,), for elements and ties that rotate exactly.

    Raises ModelError for a body without elements.
    """
    if body.model is None:
        raise ModelError(f"body '{body.name}' has no elements; give a body of finite elements")
    nodal = (body.expansion @ q).reshape(len(body.nodes), body.dofs_per_node)
    pieces = _pieces(body)
    moved = [piece.motion @ q for piece in pieces]
    for piece, motion in zip(pieces, moved, strict=True):
        _place(nodal, body.nodes, piece, motion)
    forces = np.zeros_like(nodal)
    for block in body.model.strains:
        element_nodes = cell_nodes(block.dofs, body.dofs_per_node)
        own = nodal[element_nodes][..., : block.dofs.shape[1] // element_nodes.shape[1]]
        turned = _element_forces(block, body.nodes[element_nodes], own)
        np.add.at(forces[..., : own.shape[-1]], element_nodes, turned)
    wrenches = [
        _on_virtual_node(forces, body.nodes, piece, motion)
        for piece, motion in zip(pieces, moved, strict=True)
    ]
    for piece in pieces:
        forces[piece.nodes] = 0.0
    gathered = body.expansion.T @ forces.ravel()
    for piece, wrench in zip(pieces, wrenches, strict=True):
        gathered += piece.motion.T @ wrench
    return gathered


class _Piece(NamedTuple):
    """Nodes tied to a point: (u, theta) = motion @ q, rotation vector theta (1 + cubic_turn theta.theta)."""

    nodes: NDArray[np.int64]
    position: FloatArray
    motion: csr_array
    cubic_turn: float


def _pieces(body: FlexibleBody) -> list[_Piece]:
    """The rigid interfaces of a body, and its other rigid pieces if these are tied to second order."""
    assert body.model is not None  # checked in turned_force
    found = [
        _Piece(
            each.tied_nodes if len(each.tied_nodes) else each.node_ids,
            each.position,
            each.motion,
            each.cubic_turn,
        )
        for each in body.interfaces
        if _is_rigid(each)
    ]
    if body.is_linear or not body.model.strains_vanish_in_rotation:
        return found
    inner = inner_pieces(body.model.attached.rigid, body.nodes, body.dofs_per_node, body.interfaces)
    for each in inner:
        turn = 0.0 if are_collinear(body.nodes[each.tied_nodes]) else ARCTAN
        found.append(_Piece(each.tied_nodes, each.position, each.motion @ body.expansion, turn))
    return found


def _element_forces(block: QuadraticStrain, corners: FloatArray, freedoms: FloatArray) -> FloatArray:
    """Nodal forces (E, k, d) of elements, from undeformed positions (E, k, 3) and freedoms (E, k, d)."""
    n_elements, k, d = freedoms.shape
    if d == 3:
        return internal_force(block, freedoms.reshape(n_elements, -1)).reshape(freedoms.shape)
    turn = Rotation.from_rotvec(freedoms[..., 3:].mean(axis=1)).as_matrix()
    back = turn.swapaxes(1, 2)
    rest = corners - corners.mean(axis=1, keepdims=True)
    places = corners + freedoms[..., :3]
    seen = (places - places.mean(axis=1, keepdims=True)) @ turn - rest
    nodal = Rotation.from_rotvec(freedoms[..., 3:].reshape(-1, 3)).as_matrix().reshape(-1, k, 3, 3)
    left = Rotation.from_matrix((back[:, None] @ nodal).reshape(-1, 3, 3)).as_rotvec().reshape(-1, k, 3)
    local = internal_force(block, np.concatenate([seen, left], axis=2).reshape(n_elements, -1))
    local = local.reshape(n_elements, k, 6)
    # The moments are conjugate to the local rotation vectors. They are converted to infinitesimal rotations,
    # rotated back, and converted to the nodal rotation vectors.
    spin = np.linalg.solve(_left_jacobian(left).swapaxes(2, 3), local[..., 3:, None])[..., 0]
    moments = (_left_jacobian(freedoms[..., 3:]).swapaxes(2, 3) @ (spin @ back)[..., None])[..., 0]
    return np.concatenate([local[..., :3] @ back, moments], axis=2)


def _is_rigid(interface: BodyInterface) -> bool:
    """Whether each of the six freedoms of an interface equals a coordinate of the body (rigid interface)."""
    return interface.motion.nnz == 6 and bool((interface.motion.data == 1).all())


def _rotation_vector(piece: _Piece, motion: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation vector phi (3,) of a piece, and d phi / d theta (3, 3) by its rotational freedoms theta."""
    theta, c = motion[3:], piece.cubic_turn
    factor = 1 + c * theta @ theta
    return factor * theta, factor * np.eye(3) + 2 * c * np.outer(theta, theta)


def _place(nodal: FloatArray, nodes: FloatArray, piece: _Piece, motion: FloatArray) -> None:
    """Set the freedoms of a piece's nodes in `nodal` to those of its exact rigid motion."""
    phi, _ = _rotation_vector(piece, motion)
    arms = nodes[piece.nodes] - piece.position
    nodal[piece.nodes, :3] = motion[:3] + Rotation.from_rotvec(phi).apply(arms) - arms
    nodal[piece.nodes, 3:] = phi[: nodal.shape[1] - 3]


def _on_virtual_node(forces: FloatArray, nodes: FloatArray, piece: _Piece, motion: FloatArray) -> FloatArray:
    """Force and moment (6,) of the nodal forces on a piece, conjugate to its freedoms (u, theta)."""
    phi, by_freedom = _rotation_vector(piece, motion)
    own = forces[piece.nodes]
    arms = Rotation.from_rotvec(phi).apply(nodes[piece.nodes] - piece.position)
    moment = _left_jacobian(phi).T @ np.cross(arms, own[:, :3]).sum(axis=0)
    if own.shape[1] == 6:
        moment = moment + own[:, 3:].sum(axis=0)
    return np.concatenate([own[:, :3].sum(axis=0), by_freedom.T @ moment])


def _left_jacobian(phi: FloatArray) -> FloatArray:
    """T (.., 3, 3): T dphi/dt is the angular velocity of exp(phi) in the fixed axes, those of phi."""
    angle = np.sqrt((phi**2).sum(axis=-1))[..., None, None]
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    second = np.where(small, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    x, y, z = np.moveaxis(phi, -1, 0)
    o = np.zeros_like(x)
    cross = np.stack([np.stack(row, -1) for row in ((o, -z, y), (z, o, -x), (-y, x, o))], -2)
    return np.asarray(np.eye(3) + first * cross + second * (cross @ cross), dtype=np.float64)
