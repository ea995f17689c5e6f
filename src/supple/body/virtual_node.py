"""Virtual nodes: interfaces with checked node numbers, positions and motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.algebra import read_only
from supple.body.interface import AveragingInterface, BodyInterface, RigidInterface
from supple.body.rigid_motion import are_collinear, averaged_motion
from supple.errors import ModelError

# Coefficients `cubic_turn` of rigid and averaging interfaces: arctan t = t - t^3 / 3 + ..,
# arcsin t = t + t^3 / 6 + ..
ARCTAN, ARCSIN = -1 / 3, 1 / 6


@dataclass(frozen=True, eq=False)
class VirtualNode:
    """An interface with its node numbers (k,) and position (3,); weights (k,), None for a rigid interface."""

    name: str
    node_ids: NDArray[np.int64]
    position: NDArray[np.float64]
    weights: NDArray[np.float64] | None

    @property
    def is_rigid(self) -> bool:
        """Whether the nodes follow the virtual node (rigid); otherwise it follows the nodes (averaging)."""
        return self.weights is None


def virtual_nodes(
    body: str,
    nodes: NDArray[np.float64],
    dofs_per_node: int,
    interfaces: Sequence[RigidInterface | AveragingInterface],
    labels: NDArray[np.int64] | None = None,
    tied: NDArray[np.int64] | None = None,
) -> tuple[VirtualNode, ...]:
    """Virtual nodes of the interfaces, which are given by node numbers.

    labels : (N,) ids of the nodes, for messages; by default node numbers
    tied : numbers of nodes of rigid pieces, which have the rotation of their piece
    Raises ModelError for interfaces without nodes, with invalid or repeated nodes, with equal names, weights
    or positions that are invalid; nodes in two rigid interfaces; collinear nodes without rotations.
    """
    labels = np.arange(len(nodes)) if labels is None else labels
    held_by: dict[int, str] = {}
    placed: dict[str, VirtualNode] = {}
    for interface in interfaces:
        where = f"body '{body}', interface '{interface.name}'"
        if interface.name in placed:
            raise ModelError(f"{where}: another interface has this name; names must differ")
        node_ids = _node_ids(where, interface, labels)
        points = nodes[node_ids]
        turns = dofs_per_node == 6 or (tied is not None and bool(np.isin(node_ids, tied).any()))
        if not turns and are_collinear(points):
            raise ModelError(
                f"{where}: its {len(points)} nodes lie on one line or point, and the nodes of solids have no "
                "rotations, so it cannot carry a rotation; give at least three nodes that are not on a line"
            )
        if isinstance(interface, RigidInterface):
            twice = [node for node in node_ids.tolist() if node in held_by]
            if twice:
                raise ModelError(
                    f"{where}: node {labels[twice[0]]} (one of {len(twice)}) is already rigid in interface "
                    f"'{held_by[twice[0]]}'; a node can belong to one rigid interface only"
                )
            held_by.update(dict.fromkeys(node_ids.tolist(), interface.name))
            weights, centroid = None, points.mean(axis=0)
        else:
            weights = _weights(where, interface, len(points))
            centroid = weights @ points / weights.sum()
        position = _position(where, interface, centroid)
        placed[interface.name] = VirtualNode(interface.name, node_ids, position, weights)
    return tuple(placed.values())


def interface_motions(
    nodes: NDArray[np.float64],
    dofs_per_node: int,
    expansion: sparse.csc_array,
    virtual: Sequence[VirtualNode],
    *,
    rigid_motions: sparse.csr_array | None = None,
    pieces: Sequence[NDArray[np.int64]] = (),
    turns_finitely: bool = False,
) -> tuple[BodyInterface, ...]:
    """The interfaces of a body, with the motion (6, n) of each virtual node.

    expansion : csc (n_nodal, n), u_nodal = expansion @ q
    rigid_motions : (6 k, n) of the k rigid virtual nodes, in order;  pieces : nodes tied to each of these
    turns_finitely : whether rotations relative to the frame leave no second-order strain in the body
    Raises ModelError for an averaging interface on collinear nodes of which some have no rotation.
    """
    n_nodal = dofs_per_node * len(nodes)
    number = 0
    result = []
    for node in virtual:
        tied = np.empty(0, dtype=np.int64)
        if node.weights is None:
            assert rigid_motions is not None
            motion = sparse.csr_array(rigid_motions[6 * number : 6 * number + 6])
            tied = pieces[number] if turns_finitely else tied
            number += 1
        else:
            _check_rotations(node, nodes, dofs_per_node, expansion)
            averages = averaged_motion(nodes[node.node_ids], node.weights, node.position, dofs_per_node)
            dofs = (node.node_ids[:, None] * dofs_per_node + np.arange(dofs_per_node)).ravel()
            columns = np.broadcast_to(dofs, (6, dofs.size)).ravel()
            rows = np.repeat(np.arange(6), dofs.size)
            nodal = sparse.csr_array((averages.ravel(), (rows, columns)), shape=(6, n_nodal))
            motion = sparse.csr_array(nodal @ expansion)
        # Of collinear nodes or a single node, theta is the rotation of the nodes themselves: cubic_turn = 0.
        by_displacement = turns_finitely and not are_collinear(nodes[node.node_ids])
        cubic_turn = (ARCTAN if node.is_rigid else ARCSIN) if by_displacement else 0.0
        result.append(BodyInterface(node.name, node.position, motion, node.node_ids, cubic_turn, tied))
    return tuple(result)


def _check_rotations(
    node: VirtualNode, nodes: NDArray[np.float64], dofs_per_node: int, expansion: sparse.csc_array
) -> None:
    """Raise ModelError for collinear nodes of which some have no rotation; other nodes need none."""
    if dofs_per_node == 3 or not are_collinear(nodes[node.node_ids]):
        return
    rotations = (node.node_ids[:, None] * 6 + np.arange(3, 6)).ravel()
    if (np.diff(sparse.csr_array(expansion.tocsr()[rotations]).indptr) == 0).any():
        raise ModelError(
            f"interface '{node.name}': its {len(node.node_ids)} nodes lie on one line or point, and some are "
            "of solids, which have no rotations, so it cannot carry a rotation; give at least three nodes "
            "that are not on a line"
        )


def _node_ids(
    where: str, interface: RigidInterface | AveragingInterface, labels: NDArray[np.int64]
) -> NDArray[np.int64]:
    n_nodes = len(labels)
    given = np.atleast_1d(np.asarray(interface.nodes))
    if given.size == 0:
        raise ModelError(f"{where}: it has no nodes; give at least one")
    if given.ndim != 1 or not np.issubdtype(given.dtype, np.integer):
        raise ModelError(
            f"{where}: nodes must be a list of node numbers, not {given.dtype} of shape {given.shape}"
        )
    outside = given[(given < 0) | (given >= n_nodes)]
    if outside.size:
        raise ModelError(f"{where}: there is no node {outside[0]}; the body's nodes are 0 to {n_nodes - 1}")
    unique, counts = np.unique(given, return_counts=True)
    if np.any(counts > 1):
        raise ModelError(f"{where}: node {labels[unique[np.argmax(counts)]]} is listed {counts.max()} times")
    return read_only(given, np.int64)


def _weights(where: str, interface: AveragingInterface, count: int) -> NDArray[np.float64]:
    if interface.weights is None:
        return read_only(np.ones(count))
    weights = np.asarray(interface.weights, dtype=np.float64)
    if weights.shape != (count,):
        raise ModelError(f"{where}: {count} nodes but weights of shape {weights.shape}; give one per node")
    if not np.all(np.isfinite(weights) & (weights > 0)):
        raise ModelError(f"{where}: weights must be positive numbers; the smallest is {weights.min()}")
    return read_only(weights)


def _position(
    where: str, interface: RigidInterface | AveragingInterface, centroid: NDArray[np.float64]
) -> NDArray[np.float64]:
    position = read_only(centroid if interface.position is None else interface.position)
    if position.shape != (3,) or not np.all(np.isfinite(position)):
        raise ModelError(f"{where}: position must be three finite numbers, not {position}")
    return position
