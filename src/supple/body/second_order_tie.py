"""Strains of the elements at rigid interfaces, to second order in the rotation of the interfaces.

A set of nodes tied linearly, u_a = u_v + theta x r_a, expands by theta^2 / 2 when it rotates by theta; the
strain of the adjacent elements resists the rotation. To second order the set moves as a rigid body,

    u_a = u_v + theta x r_a + 1/2 theta x (theta x r_a):       u = T q + 1/2 Q(q, q)

This u is inserted into eps = B u + 1/2 N(Gu, Gu), and eps is truncated after the terms quadratic in q, so
that the force remains a cubic polynomial and the energy a sum of squares:

    eps = B T q + 1/2 [ N(GTq, GTq) + B Q(q, q) ]

When the interface rotates, the adjacent elements have a strain of order theta^3, and an energy of order
theta^6. To third order, this energy is least for a rotation of the elements by arctan |theta|. A joint at the
interface has this rotation (`BodyInterface.cubic_turn`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy import sparse

from supple.arrays import FloatArray, IntArray
from supple.fem import QuadraticStrain
from supple.fem.node_sparsity import cell_nodes

RigidSet = tuple[IntArray, FloatArray]


def second_order_strains(
    blocks: Sequence[QuadraticStrain],
    nodes: FloatArray,
    dofs_per_node: int,
    rigid_sets: Sequence[RigidSet],
) -> tuple[QuadraticStrain, ...]:
    """The strains of a body with second-order ties, in the freedoms of its nodes and of its virtual nodes.

    Elements without nodes of a rigid set are unchanged. Other elements also depend on the virtual nodes of
    their sets. The rotations theta of a virtual node are three additional gradients, with
    N_theta,theta = B Q.

    blocks : strains of the elements in the nodal freedoms u
    nodes : (N, 3)
    rigid_sets : (node numbers (k,), position of the virtual node (3,)) of each set; no node is in two sets
    Returns QuadraticStrain blocks in the freedoms of the N nodes and the virtual nodes, ordered as the rows
    of `with_virtual_nodes`.
    """
    return tuple(part for block in blocks for _, part in tied_parts(block, nodes, dofs_per_node, rigid_sets))


def tied_parts(
    block: QuadraticStrain, nodes: FloatArray, dofs_per_node: int, rigid_sets: Sequence[RigidSet]
) -> Iterator[tuple[IntArray, QuadraticStrain]]:
    """Parts of a block, one for each number of rigid sets at an element: element numbers and strains."""
    set_of = np.full(len(nodes), -1)
    arms = np.zeros((len(nodes), 3))
    for number, (node_ids, position) in enumerate(rigid_sets):
        own = nodes[node_ids] - position
        if own.any():  # zero for a single node at the virtual node
            set_of[node_ids], arms[node_ids] = number, own
    element_nodes = cell_nodes(block.dofs, dofs_per_node)
    sets = np.sort(set_of[element_nodes], axis=1)
    first = np.concatenate([sets[:, :1] >= 0, (np.diff(sets) > 0) & (sets[:, 1:] >= 0)], axis=1)
    counts = first.sum(axis=1)
    for count in np.unique(counts):
        chosen = counts == count
        part = block if chosen.all() else block.of(np.flatnonzero(chosen))
        if count == 0:
            yield np.flatnonzero(chosen), part
            continue
        own = sets[chosen][first[chosen]].reshape(-1, count)
        held = set_of[element_nodes[chosen]][:, None] == own[..., None]
        own_arms = np.where(held[..., None], arms[element_nodes[chosen]][:, None], 0.0)
        yield np.flatnonzero(chosen), _tied(part, len(set_of) + own, own_arms, dofs_per_node)


def with_virtual_nodes(expansion: sparse.csc_array, dofs_per_node: int, n_sets: int) -> sparse.csc_array:
    """The expansion T, followed by rows for the virtual nodes, whose coordinates come last.

    A virtual node has the freedoms (u_v, theta_v) if dofs_per_node is 6, and theta_v if it is 3.

    Returns csc (n_nodal + n_sets * dofs_per_node, n).
    """
    n = expansion.indptr.size - 1
    columns = n - 6 * n_sets + 6 * np.arange(n_sets)[:, None] + np.arange(6 - dofs_per_node, 6)
    shape = (columns.size, n)
    rows = sparse.csc_array((np.ones(columns.size), (np.arange(columns.size), columns.ravel())), shape=shape)
    return sparse.csc_array(sparse.vstack([expansion, rows]))


def _tied(block: QuadraticStrain, virtual: IntArray, arms: FloatArray, dofs_per_node: int) -> QuadraticStrain:
    """Strains of elements that also depend on c virtual nodes.

    virtual : (E, c) numbers of the virtual nodes
    arms : (E, c, k, 3) from each virtual node to the nodes of the element; 0 for nodes not tied to it
    Solids in a model with shells use 3 of the 6 freedoms of their nodes, and theta of the virtual nodes.
    """
    n_elements, n_points, n_strains, n = block.B.shape
    d, (c, k) = block.G.shape[2], arms.shape[1:3]
    per_node = n // k
    rotations = d + 3 * np.arange(c)[:, None] + np.arange(3)
    columns = n + per_node * np.arange(c)[:, None] + np.arange(per_node - 3, per_node)

    B = np.zeros((n_elements, n_points, n_strains, n + c * per_node))
    B[..., :n] = block.B
    G = np.zeros((n_elements, n_points, d + 3 * c, n + c * per_node))
    G[:, :, :d, :n] = block.G
    G[:, :, rotations.ravel(), columns.ravel()] = 1
    N = np.zeros((n_elements, n_points, n_strains, d + 3 * c, d + 3 * c))
    N[..., :d, :d] = block.N
    by_displacement = block.B.reshape(n_elements, n_points * n_strains, k, per_node)[..., :3]
    for number, rows in enumerate(rotations):
        second = _second_displacement(arms[:, number]).reshape(n_elements, 3 * k, 9)
        strains = by_displacement.reshape(n_elements, -1, 3 * k) @ second
        N[:, :, :, rows[:, None], rows] = strains.reshape(n_elements, n_points, n_strains, 3, 3)
    dofs = np.concatenate(
        [
            block.dofs,
            (virtual[..., None] * dofs_per_node + np.arange(dofs_per_node - per_node, dofs_per_node)).reshape(
                -1, c * per_node
            ),
        ],
        1,
    )
    return replace(block, dofs=dofs, B=B, G=G, N=N)


def _second_displacement(arms: FloatArray) -> FloatArray:
    """Symmetric forms Q (E, k, 3, 3, 3) of arms r (E, k, 3): theta x (theta x r) = Q(theta, theta)."""
    eye = np.eye(3)
    along = eye[:, :, None] * arms[..., None, None, :]
    return 0.5 * (along + along.swapaxes(-1, -2)) - arms[..., None, None] * eye
