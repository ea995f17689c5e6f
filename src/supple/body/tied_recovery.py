"""Stress at rigid interfaces, from strains that include the second-order ties.

Linearly tied nodes expand by theta^2 / 2 when their interface rotates by theta relative to the frame. The
strains of adjacent elements exclude this expansion (`second_order_tie`); the strains for stress must, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.arrays import FloatArray
from supple.body.coordinates import rigid_sets
from supple.body.interface import Interface
from supple.body.rigid_motion import averaged_motion
from supple.body.second_order_tie import tied_parts
from supple.fem import Attached, RigidPiece, StressRecovery


@dataclass(frozen=True, eq=False)
class InnerPiece:
    """A rigid piece of a body that is not an interface; its motion is the averaged motion of its nodes.

    position : (3,) of the reference node, m;  tied_nodes : (k,) node numbers
    motion : csr (6, n_nodal), (u, theta) = motion @ u_nodal
    """

    name: str
    position: FloatArray
    tied_nodes: NDArray[np.int64]
    motion: sparse.csr_array


Tied = Interface | InnerPiece
"""Data of an interface for the recovery, of a full or reduced body."""


def inner_pieces(
    pieces: Sequence[RigidPiece], nodes: FloatArray, dofs_per_node: int, interfaces: Sequence[Tied]
) -> tuple[InnerPiece, ...]:
    """The rigid pieces without tied nodes of an interface; pieces that share nodes are merged."""
    if not pieces:
        return ()
    taken = np.concatenate([np.empty(0, dtype=np.int64), *(each.tied_nodes for each in interfaces)])
    found = []
    for members, position in rigid_sets("", len(nodes), (), Attached(rigid=tuple(pieces))):
        if np.isin(members, taken).any():
            continue
        fitted = averaged_motion(nodes[members], np.ones(len(members)), position, dofs_per_node)
        dofs = (members[:, None] * dofs_per_node + np.arange(dofs_per_node)).ravel()
        places = np.repeat(np.arange(6), len(dofs)), np.tile(dofs, 6)
        shape = (6, len(nodes) * dofs_per_node)
        motion = sparse.csr_array((fitted.reshape(6, -1).ravel(), places), shape=shape)
        name = next(each.name for each in pieces if np.isin(each.nodes, members).any())
        found.append(InnerPiece(name, position, members, motion))
    return tuple(found)


def tied_recovery(
    recovery: StressRecovery, nodes: FloatArray, dofs_per_node: int, interfaces: Sequence[Tied]
) -> StressRecovery:
    """The stress recovery as a function of the freedoms of the nodes, then of the virtual nodes of ties.

    Elements without tied nodes are unchanged; other elements include the rotation of the virtual node.
    """
    sets = [(each.tied_nodes, each.position) for each in interfaces if each.tied_nodes.size]
    if not sets:
        return recovery
    sections = tuple(
        replace(section.of(cells), arrays=arrays)
        for section in recovery.sections
        for cells, arrays in tied_parts(section.arrays, nodes, dofs_per_node, sets)
    )
    return replace(recovery, sections=sections)


def with_virtual_freedoms(
    nodal: FloatArray, motions: Sequence[FloatArray], interfaces: Sequence[Tied], dofs_per_node: int
) -> FloatArray:
    """Nodal freedoms (n_nodal, m), then the freedoms of the virtual nodes of interfaces with tied nodes.

    motions : (6, m) of each interface; only the last three rows if dofs_per_node is 3
    """
    own = [
        motion[6 - dofs_per_node :]
        for motion, interface in zip(motions, interfaces, strict=True)
        if interface.tied_nodes.size
    ]
    return np.concatenate([nodal, *own])
