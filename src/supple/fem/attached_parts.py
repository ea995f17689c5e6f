"""Assignment of springs, masses and ties to the parts of a model; concentrated masses by node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array
from scipy.sparse.csgraph import connected_components

from supple.arrays import IntArray
from supple.errors import ModelError
from supple.fem.attached import Attached, Constraints, RigidPiece
from supple.fem.mass import CellMass
from supple.fem.quadratic_strain import QuadraticStrain


def attached_parts(
    attached: Attached, parts: Sequence[IntArray], node_ids: IntArray, dofs_per_node: int
) -> tuple[Attached, ...]:
    """The attachments of each part; an attachment belongs to the first part that contains all its nodes.

    parts : nodes of each part, ascending; parts may share nodes;  node_ids : (N,) node names for messages
    Raises ModelError for a spring, mass, dashpot, tie or constraint whose nodes lie in several parts.
    """
    shares = _Shares(tuple(parts), node_ids, dofs_per_node)
    return tuple(shares.of(attached, part) for part in range(len(parts)))


@dataclass(frozen=True, eq=False)
class _Shares:
    """Parts by their nodes, and the assignment of attachments to them."""

    parts: tuple[IntArray, ...]
    node_ids: IntArray
    d: int

    def of(self, given: Attached, part: int) -> Attached:
        """The attachments of a part, in the node numbers of the part."""
        springs = (self.springs(each, part) for each in given.springs)
        return Attached(
            springs=tuple(each for each in springs if len(each.dofs)),
            mass=self.matrix(given.mass, part, "a concentrated mass"),
            damping=self.matrix(given.damping, part, "a dashpot"),
            rigid=tuple(
                replace(each, nodes=np.searchsorted(self.parts[part], each.nodes))
                for each in given.rigid
                if self.holder_of_piece(each) == part
            ),
            constraints=self.constraints(given.constraints, part),
        )

    def holders(self, group: IntArray, nodes: IntArray, n: int, called: Callable[[int], str]) -> IntArray:
        """The first part (n,) that contains all nodes of each group; ModelError if no part does.

        group, nodes : (k,) group and node of each member;  called : name of a group in messages
        """
        sizes = np.bincount(group, minlength=n)
        inside = [np.bincount(group[np.isin(nodes, own)], minlength=n) == sizes for own in self.parts]
        found = np.array(inside)
        lost = np.flatnonzero(~found.any(axis=0))
        if lost.size:
            ids = ", ".join(str(i) for i in self.node_ids[np.unique(nodes[group == lost[0]])[:6]])
            raise ModelError(
                f"{called(int(lost[0]))} (one of {lost.size}) acts between nodes of several parts: {ids}; "
                "move the cut away from these nodes, or join the parts by a joint or force element instead"
            )
        return found.argmax(axis=0)

    def freedoms(self, given: IntArray, part: int) -> IntArray:
        """Freedoms in the numbering of a part."""
        return np.searchsorted(self.parts[part], given // self.d) * self.d + given % self.d

    def holder_of_piece(self, piece: RigidPiece) -> int:
        """The part that contains all nodes of a rigid tie."""
        group = np.zeros(len(piece.nodes), dtype=np.int64)
        return int(self.holders(group, piece.nodes, 1, lambda _: f"rigid tie {piece.name}")[0])

    def springs(self, given: QuadraticStrain, part: int) -> QuadraticStrain:
        """The springs of a part."""
        E, n = given.dofs.shape
        group, nodes = np.repeat(np.arange(E), n), given.dofs.ravel() // self.d
        own = np.flatnonzero(self.holders(group, nodes, E, lambda _: "a spring") == part)
        made = given.of(own)
        return replace(made, dofs=self.freedoms(made.dofs, part))

    def matrix(self, given: csc_array | None, part: int, what: str) -> csc_array | None:
        """The block of a part in a matrix of the nodal freedoms; None where it is empty."""
        if given is None:
            return None
        entries = coo_array(given)
        i, j = (np.asarray(each, dtype=np.int64) for each in entries.coords)
        graph = coo_array((np.ones(len(i)), (i // self.d, j // self.d)), shape=(len(self.node_ids),) * 2)
        _, group = connected_components(graph, directed=False)
        nodes = np.unique(np.concatenate([i, j]) // self.d)
        own = np.unique(group[nodes], return_inverse=True)[1]
        holders = np.full(len(self.node_ids), -1)
        holders[nodes] = self.holders(own, nodes, int(own.max(initial=-1)) + 1, lambda _: what)[own]
        mine = holders[i // self.d] == part
        if not mine.any():
            return None
        places = self.freedoms(i[mine], part), self.freedoms(j[mine], part)
        size = len(self.parts[part]) * self.d
        return csc_array(coo_array((entries.data[mine], places), shape=(size, size)))

    def constraints(self, given: Constraints | None, part: int) -> Constraints | None:
        """The constraints of a part; None if it has none."""
        if given is None:
            return None
        entries = coo_array(given.matrix)
        rows, freedoms = (np.asarray(each, dtype=np.int64) for each in entries.coords)
        n = len(given.labels)
        holders = self.holders(rows, freedoms // self.d, n, lambda row: given.labels[row])
        own = np.flatnonzero(holders == part)
        if not own.size:
            return None
        mine = holders[rows] == part
        places = np.searchsorted(own, rows[mine]), self.freedoms(freedoms[mine], part)
        size = len(self.parts[part]) * self.d
        dependent = given.dependent[own]
        return Constraints(
            csr_array(coo_array((entries.data[mine], places), shape=(len(own), size))),
            np.where(dependent < 0, -1, self.freedoms(np.maximum(dependent, 0), part)),
            tuple(given.labels[row] for row in own),
        )


def point_masses(attached: Attached, dofs_per_node: int) -> CellMass | None:
    """Concentrated masses as cells of one node; None if there are none.

    Raises ModelError for a mass shared by several nodes, as a scalar mass between two grids.
    """
    if attached.mass is None:
        return None
    entries, d = coo_array(attached.mass), dofs_per_node
    i, j = (np.asarray(each, dtype=np.int64) for each in entries.coords)
    if (shared := (i // d != j // d) & (entries.data != 0)).any():
        raise ModelError(
            f"{np.count_nonzero(shared)} terms of concentrated masses act between nodes; each mass must have "
            "one node: remove these masses from the model"
        )
    nodes, place = np.unique(i // d, return_inverse=True)
    blocks = np.zeros((len(nodes), 6, 6))
    np.add.at(blocks, (place, i % d, j % d), entries.data)
    return CellMass(nodes[:, None], np.zeros((len(nodes), 1, 1)), coupled=blocks)
