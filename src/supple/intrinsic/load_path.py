"""Load paths through a mesh: where the stations of a condensation are, and which nodes each stands for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arguments import check_fields
from supple.body import AveragingInterface, FlexibleBody
from supple.body.interface import BodyInterface
from supple.body.rigid_motion import are_collinear
from supple.body.virtual_node import interface_motions, virtual_nodes
from supple.errors import ModelError, did_you_mean
from supple.intrinsic.load_path_tree import ROOT

__all__ = ["BodyStations", "LoadPath", "LoadPaths", "NodeSetPath", "StationPlan"]

Array = NDArray[np.float64]


ON_THE_CUT = 1e-6
"""Of the distance of two stations."""


class BodyStations(NamedTuple):
    """Stations of a body: the motion of each in the body's coordinates, and the station that it hangs on."""

    interfaces: tuple[BodyInterface, ...]
    parents: NDArray[np.intp]


class StationPlan(Protocol):
    """How stations are placed in a body."""

    def stations(self, body: FlexibleBody) -> BodyStations:
        """The stations, the root first."""
        ...


@dataclass(frozen=True)
class LoadPath:
    """Stations at equal distances between two interfaces, each standing for the slice of the mesh around it.

    The body is cut by planes across the straight line from the root to the tip, half-way between stations. A
    station follows the mean motion of the nodes of its slice, weighted by their mass, and stands at their
    centre; so the stations of a curved body follow its curve. Root and tip are the interfaces themselves.

    root, tip : str     names of interfaces
    n_stations : int    with both ends, at least 2
    """

    root: str
    tip: str
    n_stations: int

    def __post_init__(self) -> None:
        check_fields(self)
        if self.n_stations < 2:
            raise ModelError(f"a load path needs two stations at least, its ends, not {self.n_stations}")

    def stations(self, body: FlexibleBody) -> BodyStations:
        """The stations; ModelError for a slice with too few nodes, with its number and the remedy."""
        return LoadPaths((self,)).stations(body)

    def slices(self, body: FlexibleBody, nodes: NDArray[np.intp]) -> list[AveragingInterface]:
        """An averaging interface for each slice between the ends, of those nodes that are in it."""
        start, end = (body.interface(name).position for name in (self.root, self.tip))
        length = float(np.linalg.norm(end - start))
        if not length > 0:
            raise ModelError(f"{_where(body)}: its ends '{self.root}' and '{self.tip}' are at one place")
        along = (body.nodes[nodes] - start) @ (end - start) / length
        place = along / length * (self.n_stations - 1)
        masses = body.nodal_mass.diagonal()[nodes * body.dofs_per_node]
        if not (masses > 0).all():
            masses = np.ones(len(nodes))
        found = []
        for number in range(1, self.n_stations - 1):
            distance = np.abs(place - number)
            inside = distance <= 0.5 + ON_THE_CUT
            self._check(body, nodes[inside], number, along)
            # A node on the cut is half in either slice.
            weights = masses[inside] * np.where(distance[inside] > 0.5 - ON_THE_CUT, 0.5, 1.0)
            name = f"slice {number} of {self.root} - {self.tip}"
            found.append(AveragingInterface(name, nodes[inside], weights=weights))
        return found

    def _check(self, body: FlexibleBody, own: NDArray[np.intp], number: int, along: Array) -> None:
        enough = len(own) > 0 and (body.dofs_per_node == 6 or not are_collinear(body.nodes[own]))
        if enough:
            return
        length = float(np.linalg.norm(body.interface(self.tip).position - body.interface(self.root).position))
        inside = np.unique(np.round(along[(along > 0) & (along < length)] / length, 6))
        widest = float(np.diff(np.concatenate([[0.0], inside, [1.0]])).max())
        distance = number * length / (self.n_stations - 1)
        raise ModelError(
            f"{_where(body)}: slice {number} of the path from '{self.root}' to '{self.tip}', {distance:.4g} "
            f"from the root, holds {len(own)} nodes, too few for the motion of a section: take "
            f"{max(2, int(1 / widest) + 1)} stations or fewer, or a mesh that is finer along the path"
        )


@dataclass(frozen=True)
class LoadPaths:
    """A tree of load paths: each begins at an end of one before it, the first at the root.

    A node belongs to the path that it is nearest to.
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
                    f"the load path from '{path.root}' to '{path.tip}' begins at no end of a path before it"
                    + did_you_mean(path.root, ends)
                )
            if path.tip in ends:
                raise ModelError(
                    f"the load path from '{path.root}' to '{path.tip}' ends where another path has been: "
                    "load paths may not form a loop; end it at another interface"
                )
            ends.append(path.tip)

    def stations(self, body: FlexibleBody) -> BodyStations:
        """The stations of all paths, one after the other."""
        ends: dict[str, int] = {self.paths[0].root: 0}
        found: list[BodyInterface] = [body.interface(self.paths[0].root)]
        parents: list[int] = [ROOT]
        nearest = self._nearest(body)
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
        """The path that each node is nearest to."""
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
    """Stations at node sets of one's own, the root first.

    sets : of each station the name of an interface of the body, or node numbers
    parents : (n,)      as for `load_path_tree`; one station after the other when omitted
    """

    sets: Sequence[str | ArrayLike]
    parents: ArrayLike | None = None

    def stations(self, body: FlexibleBody) -> BodyStations:
        """The stations; ModelError for sets that cannot carry a rotation, or name no interface."""
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


def _where(body: FlexibleBody) -> str:
    return f"load path of body '{body.name}'"
