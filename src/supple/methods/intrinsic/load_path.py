"""Load paths: positions and nodes of the stations on which `condense` condenses a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.body import AveragingInterface, FlexibleBody
from supple.body.interface import BodyInterface
from supple.body.rigid_motion import are_collinear
from supple.body.virtual_node import interface_motions, virtual_nodes
from supple.errors import ModelError, did_you_mean
from supple.methods.intrinsic.load_path_tree import ROOT

__all__ = ["LoadPath", "LoadPaths", "NodeSetPath"]


ON_THE_CUT = 1e-6
"""Largest distance from a cut of a node on this cut, relative to the distance between two stations."""


class BodyStations(NamedTuple):
    """Stations of a body: for each its motion, as an interface of the body, and the number of its parent."""

    interfaces: tuple[BodyInterface, ...]
    parents: NDArray[np.intp]


class StationPlan(Protocol):
    """A rule that places stations in a body: LoadPath, LoadPaths or NodeSetPath."""

    def stations(self, body: FlexibleBody) -> BodyStations:
        """The stations, the root first."""


@dataclass(frozen=True)
class LoadPath:
    """Stations for `condense`, at equal distances along the straight line between two interfaces.

    Planes normal to this line, half-way between two stations, cut the body into slices. A station has the
    mean position and the mean motion of the nodes of its slice, weighted by their mass. The stations of a
    curved body therefore follow its curve. The first and the last station are the interfaces themselves.

    root, tip : str     names of the interfaces
    n_stations : int    number of stations, with both ends; at least 2
    """

    root: str
    tip: str
    n_stations: int

    def __post_init__(self) -> None:
        check_fields(self)
        if self.n_stations < 2:
            raise ModelError(f"a load path needs at least two stations, its ends, not {self.n_stations}")

    def stations(self, body: FlexibleBody) -> BodyStations:
        """The stations; ModelError if the nodes of a slice are too few to carry the motion of a section."""
        return LoadPaths((self,)).stations(body)

    def slices(self, body: FlexibleBody, nodes: NDArray[np.intp]) -> list[AveragingInterface]:
        """For each slice between the ends, an averaging interface of those of `nodes` that are in it."""
        start, end = (body.interface(name).position for name in (self.root, self.tip))
        length = float(np.linalg.norm(end - start))
        if not length > 0:
            raise ModelError(
                f"{_where(body)}: its ends '{self.root}' and '{self.tip}' coincide: name two other interfaces"
            )
        place = (body.nodes[nodes] - start) @ (end - start) / length**2
        order = np.argsort(place, kind="stable")
        nodes, place = nodes[order], place[order]
        shares = _shares(body, nodes, place, self.n_stations)
        for number, (own, _) in enumerate(shares, start=1):
            if not _carries_a_section(body, nodes[own]):
                raise ModelError(self._too_few(body, nodes, place, number, length))
        masses = _element_masses(body)[nodes]
        if not (masses > 0).all():
            masses = np.ones(len(nodes))
        return [
            AveragingInterface(
                f"slice {number} of {self.root} - {self.tip}", nodes[own], weights=masses[own] * share
            )
            for number, (own, share) in enumerate(shares, start=1)
        ]

    def _too_few(
        self, body: FlexibleBody, nodes: NDArray[np.intp], place: FloatArray, number: int, length: float
    ) -> str:
        count = len(_shares(body, nodes, place, self.n_stations)[number - 1][0])
        most = 2
        while most + 1 < self.n_stations and _fit(body, nodes, place, most + 1):
            most += 1
        return (
            f"{_where(body)}: slice {number} of the path from '{self.root}' to '{self.tip}', "
            f"{number * length / (self.n_stations - 1):.4g} from the root, has {count} nodes, too few for "
            f"the motion of a section: use at most {most} stations, or a mesh that is finer along the path"
        )


def _shares(
    body: FlexibleBody, nodes: NDArray[np.intp], place: FloatArray, n_stations: int
) -> list[tuple[NDArray[np.intp], FloatArray]]:
    """Positions in `nodes` of the nodes of each slice between the ends, and the weights of these nodes.

    A node on a cut has half its weight in each of the two slices. If both slices have at most two lines of
    nodes, the node belongs to the first slice alone, so that no node contributes to two mean motions.

    place : of each node along the path, ascending; 0 at the root and 1 at the tip
    """
    cuts = (np.arange(n_stations - 1) + 0.5) / (n_stations - 1)
    near = ON_THE_CUT / (n_stations - 1)
    low, high = np.searchsorted(place, cuts - near), np.searchsorted(place, cuts + near, side="right")
    inner = [np.arange(first, past) for first, past in zip(high[:-1], low[1:], strict=True)]
    on_cut = high > low
    lines = [int(on_cut[k]) + int(on_cut[k + 1]) + _lines(body, nodes[own]) for k, own in enumerate(inner)]
    first_owns = [0 < k < len(lines) and max(lines[k - 1], lines[k]) <= 2 for k in range(len(cuts))]
    shares = []
    for number, own in enumerate(inner):
        below, above = (np.arange(low[k], high[k]) for k in (number, number + 1))
        if first_owns[number]:
            below = below[:0]
        weight_above = 1.0 if first_owns[number + 1] else 0.5
        members = np.concatenate([below, own, above])
        weights = np.concatenate(
            [np.full(len(below), 0.5), np.ones(len(own)), np.full(len(above), weight_above)]
        )
        shares.append((members, weights))
    return shares


def _lines(body: FlexibleBody, own: NDArray[np.intp]) -> int:
    """Number of lines of nodes: 0 without nodes, 1 if all are on one line, 3 for two lines or more."""
    if not len(own):
        return 0
    return 1 if are_collinear(body.nodes[own]) else 3


def _fit(body: FlexibleBody, nodes: NDArray[np.intp], place: FloatArray, n_stations: int) -> bool:
    return all(_carries_a_section(body, nodes[own]) for own, _ in _shares(body, nodes, place, n_stations))


def _carries_a_section(body: FlexibleBody, own: NDArray[np.intp]) -> bool:
    return len(own) > 0 and (body.dofs_per_node == 6 or not are_collinear(body.nodes[own]))


@dataclass(frozen=True)
class LoadPaths:
    """A tree of load paths: each begins at an end of an earlier path, the first path at the root of the tree.

    A node of the mesh belongs to the path nearest to it.
    """

    paths: Sequence[LoadPath]

    def __post_init__(self) -> None:
        paths = tuple(self.paths)
        object.__setattr__(self, "paths", paths)
        if not paths:
            raise ModelError("a tree of load paths needs at least one path")
        ends = [paths[0].root]
        for path in paths:
            if path.root not in ends:
                raise ModelError(
                    f"the load path from '{path.root}' to '{path.tip}' begins at no end of an earlier path: "
                    "begin it at such an end, or sort the paths from the root outwards"
                    + did_you_mean(path.root, ends)
                )
            if path.tip in ends:
                raise ModelError(
                    f"the load path from '{path.root}' to '{path.tip}' ends on another path: "
                    "load paths may not form a loop; end it at another interface"
                )
            ends.append(path.tip)

    def stations(self, body: FlexibleBody) -> BodyStations:
        """The stations of all paths, path after path."""
        ends: dict[str, int] = {self.paths[0].root: 0}
        found: list[BodyInterface] = [body.interface(self.paths[0].root)]
        parents: list[int] = [ROOT]
        nearest = np.where(_in_cells(body), self._nearest(body), -1)
        for number, path in enumerate(self.paths):
            slices = _averaged(body, path.slices(body, np.flatnonzero(nearest == number)))
            above = ends[path.root]
            for interface in (*slices, body.interface(path.tip)):
                found.append(interface)
                parents.append(above)
                above = len(found) - 1
            ends[path.tip] = above
        return BodyStations(tuple(found), np.array(parents, dtype=np.intp))

    def _nearest(self, body: FlexibleBody) -> NDArray[np.intp]:
        """The nearest path of each node."""
        squares = []
        for path in self.paths:
            start, end = (body.interface(name).position for name in (path.root, path.tip))
            chord = end - start
            arms = body.nodes - start
            along = np.clip(arms @ chord / max(chord @ chord, np.finfo(float).tiny), 0, 1)
            squares.append(np.sum((arms - along[:, None] * chord) ** 2, axis=1))
        return np.argmin(squares, axis=0)


@dataclass(frozen=True, eq=False)
class NodeSetPath:
    """Stations for `condense` at node sets given by the user, the root first.

    sets : for each station the name of an interface of the body, or node numbers
    parents : (n,) number of the station before each station, as for `load_path_tree`; by default the stations
        follow each other
    """

    sets: Sequence[str | ArrayLike]
    parents: ArrayLike | None = None

    def stations(self, body: FlexibleBody) -> BodyStations:
        """The stations; ModelError for nodes that cannot carry a rotation, or an unknown interface."""
        found = []
        for number, given in enumerate(self.sets):
            if isinstance(given, str):
                found.append(body.interface(given))
            else:
                found += _averaged(body, [AveragingInterface(f"station {number}", np.asarray(given))])
        n = len(found)
        parents = np.arange(-1, n - 1) if self.parents is None else np.asarray(self.parents)
        return BodyStations(tuple(found), parents.astype(np.intp))


def _averaged(body: FlexibleBody, interfaces: Sequence[AveragingInterface]) -> tuple[BodyInterface, ...]:
    resolved = virtual_nodes(body.name, body.nodes, body.dofs_per_node, interfaces)
    return interface_motions(body.nodes, body.dofs_per_node, body.expansion, resolved)


def _in_cells(body: FlexibleBody) -> NDArray[np.bool_]:
    """For each node (N,), whether it is in a cell; a node of springs, masses or ties alone is in no slice."""
    found = np.full(len(body.nodes), body.model is None)
    for cells in () if body.model is None else body.model.mesh.cells.values():
        found[cells] = True
    return found


def _element_masses(body: FlexibleBody) -> FloatArray:
    """Mass (N,) of the elements at the nodes; concentrated masses would shift the mean of a slice."""
    beside = None if body.model is None else body.model.attached.mass
    mass = body.nodal_mass if beside is None else body.nodal_mass - beside
    return np.asarray(mass.diagonal()[:: body.dofs_per_node], dtype=np.float64)


def _where(body: FlexibleBody) -> str:
    return f"load path of body '{body.name}'"
