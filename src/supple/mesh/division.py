"""Division of a mesh into parts with common sections."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from supple.arrays import FloatArray, IntArray
from supple.errors import MeshError
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh
from supple.mesh.mesh_part import MeshPart, mesh_part
from supple.mesh.node_sections import NodeSection, flat_section, sections_along, shared_pieces

__all__ = [
    "AlongAxis",
    "ByCellSets",
    "Cut",
    "Cuts",
    "DividedMesh",
    "Division",
    "cuts_at_nodes",
    "cuts_at_sections",
    "divided",
]

CellNumbers = Mapping[CellType, IntArray]


class Division(Protocol):
    """A way to divide a mesh."""

    def cells(self, mesh: Mesh) -> Sequence[CellNumbers]:
        """The cells of each part; every cell in exactly one."""
        ...


@dataclass(frozen=True)
class AlongAxis:
    """Parts of about equal length along an axis, each cut at the nearest section of nodes of the mesh.

    No cut passes through cells: a tie there would make a whole row of cells rigid.

    count : number of parts, at least 2
    axis  : (3,) direction in the mesh axes; by default the longest principal direction of the nodes
    """

    count: int
    axis: ArrayLike | None = None

    def __post_init__(self) -> None:
        if isinstance(self.count, bool) or not isinstance(self.count, int) or self.count < 2:
            raise MeshError(f"a body is divided into at least 2 parts, not {self.count!r}")

    def cells(self, mesh: Mesh) -> Sequence[CellNumbers]:
        """The cells of each part, from the lowest to the highest along the axis.

        Raises MeshError where no flat section of nodes, beyond the previous cut, is within half a part's
        length of a cut.
        """
        direction = _longest_direction(mesh) if self.axis is None else _unit(self.axis)
        along = mesh.nodes @ direction
        ends = np.linspace(along.min(), along.max(), self.count + 1)
        sections = sections_along(mesh, direction)
        chosen: list[NodeSection] = []
        for number, wanted in enumerate(ends[1:-1], start=1):
            near = [each for each in sections if abs(each.position - wanted) < 0.5 * (ends[1] - ends[0])]
            # Planes come first: of two equally near sections the plane is used.
            near.sort(key=lambda each: abs(round((each.position - wanted) / np.ptp(along), 6)))
            beyond = (each for each in near if not chosen or each.contains(chosen[-1]))
            found = next((each for each in beyond if flat_section(mesh, each)), None)
            if found is None:
                raise MeshError(self._no_section(number, float(wanted), direction, sections))
            chosen.append(found)
        below = [section.below() for section in chosen]
        part = {kind: self.count - 1 - sum(each[kind].astype(int) for each in below) for kind in mesh.cells}
        return [{kind: np.flatnonzero(own == i) for kind, own in part.items()} for i in range(self.count)]

    def _no_section(
        self, number: int, wanted: float, direction: FloatArray, sections: Sequence[NodeSection]
    ) -> str:
        axis = f"({', '.join(f'{x:.3g}' for x in direction)})"
        planes = sum(section.is_plane for section in sections)
        if 0 < planes < self.count - 1:
            return (
                f"part {number} of {self.count} has no cell: the mesh is too coarse along {axis}; request "
                f"fewer parts ({planes + 1} at most), or refine it"
            )
        return (
            f"cut {number} of {self.count - 1}, at {wanted:.4g} along {axis}: no section of nodes is near, "
            "and a cut through cells would make a row of them rigid. Mesh the body with a plane of nodes "
            "there, request another number of parts, or divide it by cell sets"
        )


@dataclass(frozen=True)
class ByCellSets:
    """One part per cell set; together the sets contain every cell once.

    names : cell sets, in the order of the parts
    """

    names: Sequence[str]

    def __post_init__(self) -> None:
        if isinstance(self.names, str) or len(self.names) < 2:
            raise MeshError(f"a body is divided by at least 2 cell sets, not {self.names!r}")
        object.__setattr__(self, "names", tuple(self.names))

    def cells(self, mesh: Mesh) -> Sequence[CellNumbers]:
        """The cells of each set."""
        found = [mesh.cells_of(name) for name in self.names]
        for kind, members in mesh.cells.items():
            count = np.zeros(len(members), dtype=int)
            for own in found:
                count[own.get(kind, [])] += 1
            if (count != 1).any():
                cell = int(np.flatnonzero(count != 1)[0])
                raise MeshError(
                    f"{kind.name} cell {cell} (one of {(count != 1).sum()}) is in {count[cell]} of the cell "
                    f"sets {', '.join(self.names)}; each cell belongs to one part"
                )
        return found


@dataclass(frozen=True, eq=False)
class Cut:
    """The common nodes of two parts.

    first, second : numbers of the parts, first < second
    nodes : int array (k,)      numbers, in the whole mesh, of the common nodes
    name : name of these nodes in both parts; cuts with the same name have the same nodes
    """

    first: int
    second: int
    nodes: IntArray
    name: str

    def __contains__(self, part: int) -> bool:
        return part in (self.first, self.second)


@dataclass(frozen=True, eq=False)
class DividedMesh:
    """A mesh in parts.

    parts : a node set belongs to the first part that contains all its nodes. Without such a part, each node
        of the set belongs to the first part that contains the node
    cuts : two parts with several common sections have several cuts
    """

    whole: Mesh
    parts: tuple[MeshPart, ...]
    cuts: tuple[Cut, ...]

    def holder(self, nodes: IntArray) -> int | None:
        """The first part that contains all the given nodes of the whole mesh; None if there is none."""
        return next((i for i, part in enumerate(self.parts) if np.isin(nodes, part.nodes).all()), None)

    @property
    def ties(self) -> Mapping[str, Cut]:
        """The cuts by unique names: the cut's name, followed by its parts if several cuts have this name."""
        count = Counter(cut.name for cut in self.cuts)
        return {
            cut.name if count[cut.name] == 1 else f"{cut.name} {cut.first + 1}-{cut.second + 1}": cut
            for cut in self.cuts
        }

    def cut_nodes(self, part: int) -> Mapping[str, IntArray]:
        """Nodes of the whole mesh at which a part is cut, by name."""
        return {cut.name: cut.nodes for cut in self.cuts if part in cut}

    def neighbours_from(self, start: int) -> Iterator[tuple[int, Cut]]:
        """Other parts connected to part `start`, by number of cuts on the path, with the last cut on it."""
        reached, boundary = {start}, [start]
        while boundary:
            ahead = []
            for cut in (cut for part in boundary for cut in self.cuts if part in cut):
                for part in {cut.first, cut.second} - reached:
                    yield part, cut
                    reached.add(part)
                    ahead.append(part)
            boundary = ahead


Cuts = Callable[[Mesh, Sequence[CellNumbers], Sequence[IntArray]], tuple[Cut, ...]]


def cuts_at_sections(
    mesh: Mesh, cells: Sequence[CellNumbers], members: Sequence[IntArray]
) -> tuple[Cut, ...]:
    """A cut for each connected piece of the common nodes of two parts, named cut-1, cut-2, .."""
    pieces = (
        (first, second, nodes)
        for first, second in combinations(range(len(cells)), 2)
        for nodes in shared_pieces(
            mesh, [cells[first], cells[second]], np.intersect1d(members[first], members[second])
        )
    )
    return tuple(Cut(*piece, f"cut-{number}") for number, piece in enumerate(pieces, start=1))


def cuts_at_nodes(mesh: Mesh, _cells: Sequence[CellNumbers], members: Sequence[IntArray]) -> tuple[Cut, ...]:
    """At each shared node, cuts between the first part that contains it and each other; named node-ID."""
    nodes, count = np.unique(np.concatenate(members), return_counts=True)
    shared = nodes[count > 1]
    inside = np.array([np.isin(shared, own) for own in members])
    first = inside.argmax(axis=0)
    return tuple(
        Cut(int(first[at]), int(part), shared[[at]], f"node-{mesh.node_ids[shared[at]]}")
        for at, part in np.argwhere(inside.T)
        if part != first[at]
    )


def divided(mesh: Mesh, division: Division, cuts: Cuts = cuts_at_sections) -> DividedMesh:
    """Divide a mesh into parts that share the nodes of the sections between them.

    cuts : function that returns the cuts, where parts are tied: cuts_at_sections or cuts_at_nodes

    Raises
    ------
    MeshError   a part without cells, or not connected; nodes without cells linked to several parts;
                errors of the division
    """
    cells = division.cells(mesh)
    members = [np.unique(_nodes(mesh, own)) for own in cells]
    loose = _loose_nodes(mesh, members)
    members = [np.union1d(own, beside) for own, beside in zip(members, loose, strict=True)]
    sets = _shared_out(mesh.node_sets, members)
    parts = []
    for i, (own, node_sets) in enumerate(zip(cells, sets, strict=True)):
        try:
            parts.append(mesh_part(mesh, own, node_sets, loose=loose[i]))
        except MeshError as error:
            raise MeshError(
                f"part {i + 1} of {len(cells)} cannot be a separate body: {error}. Divide the mesh by cell "
                "sets, or along another axis"
            ) from None
    return DividedMesh(mesh, tuple(parts), cuts(mesh, cells, members))


def _nodes(mesh: Mesh, cells: CellNumbers) -> IntArray:
    return np.concatenate([mesh.cells[kind][numbers].ravel() for kind, numbers in cells.items()])


def _loose_nodes(mesh: Mesh, members: Sequence[IntArray]) -> list[IntArray]:
    """For each part, the nodes without cells that springs, masses or ties link to its nodes.

    Linked nodes without cells belong to the first part that contains all nodes of cells to which they are
    linked.
    """
    loose = np.ones(mesh.n_nodes, dtype=bool)
    loose[np.concatenate(members)] = False
    if not loose.any():
        return [np.empty(0, dtype=np.int64) for _ in members]
    inner = mesh.links[loose[mesh.links].all(axis=1)]
    graph = coo_array((np.ones(len(inner)), (inner[:, 0], inner[:, 1])), shape=(mesh.n_nodes,) * 2)
    n, group = connected_components(graph, directed=False)
    outer = mesh.links[loose[mesh.links].sum(axis=1) == 1]
    is_first = loose[outer[:, 0]]
    groups = group[np.where(is_first, outer[:, 0], outer[:, 1])]
    ends = np.where(is_first, outer[:, 1], outer[:, 0])
    count = np.bincount(groups, minlength=n)
    inside = [np.bincount(groups[np.isin(ends, own)], minlength=n) == count for own in members]
    holders = np.array(inside)[:, group[loose]]
    if not holders.any(axis=0).all():
        node = mesh.node_ids[np.flatnonzero(loose)[~holders.any(axis=0)][0]]
        raise MeshError(
            f"node {node} belongs to no cell, and springs, masses or ties link it to several parts; move the "
            "cut away from it, or remove these links from the model and join the parts by them"
        )
    owner = holders.argmax(axis=0)
    return [np.flatnonzero(loose)[owner == part] for part in range(len(members))]


def _shared_out(
    node_sets: Mapping[str, IntArray], members: Sequence[IntArray]
) -> tuple[dict[str, IntArray], ...]:
    """The node sets of each part; each node of a set is assigned to one part (see `DividedMesh`)."""
    found: tuple[dict[str, IntArray], ...] = tuple({} for _ in members)
    for name, nodes in node_sets.items():
        inside = np.array([np.isin(nodes, own) for own in members])
        whole = np.flatnonzero(inside.all(axis=1))
        owner = np.full(len(nodes), whole[0]) if len(whole) else inside.argmax(axis=0)
        for part in np.unique(owner):
            found[part][name] = nodes[owner == part]
    return found


def _longest_direction(mesh: Mesh) -> FloatArray:
    centred = mesh.nodes - mesh.nodes.mean(axis=0)
    direction = np.linalg.svd(centred, full_matrices=False)[2][0]
    return direction * np.sign(direction[np.argmax(abs(direction))])


def _unit(axis: ArrayLike) -> FloatArray:
    given = np.array(axis, dtype=float)
    length = np.linalg.norm(given)
    if given.shape != (3,) or not (np.isfinite(length) and length > 0):
        raise MeshError(f"the axis of a division must be three finite numbers, not all zero; got {axis!r}")
    return given / length
