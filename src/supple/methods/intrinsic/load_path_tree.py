"""Tree of load paths: stations joined by straight segments, and sums along it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve_triangular

from supple.algebra import read_only
from supple.arguments import check_numbers
from supple.arrays import FloatArray
from supple.errors import ModelError

__all__ = ["LoadPathTree", "load_path_tree"]


ROOT = -1
"""Parent of the root station, which has none."""

SHORTEST = 1e-9
"""Smallest length of a segment, relative to the largest extent of the stations along an axis."""


@dataclass(frozen=True, eq=False)
class LoadPathTree:
    """Stations in space and the parent of each; built and checked by `load_path_tree`.

    Segment i ends at station i + 1 and begins at its parent.

    points : (n, 3)     positions at rest, m
    parents : (n,)      parent of each station, a lower number; `ROOT` for the first
    """

    points: FloatArray
    parents: NDArray[np.intp]

    @property
    def n(self) -> int:
        """Number of stations."""
        return len(self.points)

    @property
    def inner(self) -> NDArray[np.intp]:
        """(n - 1,) the station at which each segment begins."""
        return self.parents[1:]

    @cached_property
    def lengths(self) -> FloatArray:
        """(n - 1,) lengths of the segments, m."""
        return read_only(np.linalg.norm(self._chords, axis=1))

    @property
    def mean_length(self) -> float:
        """Mean length of the segments, which scales rotations to displacements; 1 for a single station."""
        return float(self.lengths.mean()) if self.n > 1 else 1.0

    @cached_property
    def directions(self) -> FloatArray:
        """(n - 1, 3) unit vectors of the segments, from the root outwards."""
        return read_only(self._chords / self.lengths[:, None])

    @cached_property
    def middles(self) -> FloatArray:
        """(n - 1, 3) mid-points of the segments."""
        return read_only(0.5 * (self.points[1:] + self.points[self.inner]))

    @property
    def is_chain(self) -> bool:
        """Whether the stations follow one another without a branch."""
        return bool(np.array_equal(self.inner, np.arange(self.n - 1)))

    @property
    def ends(self) -> NDArray[np.intp]:
        """Ends of the load paths: the root, the tips, and the branching points."""
        children = np.bincount(self.inner, minlength=self.n)
        return np.flatnonzero((children != 1) | (np.arange(self.n) == 0))

    @cached_property
    def ancestors(self) -> tuple[NDArray[np.intp], ...]:
        """Ancestors 1, 2, 4, .. segments nearer the root, (n,) each; the root where there is none."""
        jumps = [np.maximum(self.parents, 0)]
        while jumps[-1].any():
            jumps.append(jumps[-1][jumps[-1]])
        return tuple(jumps[:-1])

    @property
    def _chords(self) -> FloatArray:
        return self.points[1:] - self.points[self.inner]

    def outboard_sums(self, values: FloatArray) -> FloatArray:
        """Sums (n, k) of values (n, k) over each station and all stations outboard of it."""
        ones = np.ones(self.n - 1)
        upward = sparse.csr_array((-ones, (self.inner, np.arange(1, self.n))), shape=(self.n, self.n))
        return spsolve_triangular((sparse.eye_array(self.n) + upward).tocsr(), values, lower=False)


def load_path_tree(points: ArrayLike, parents: ArrayLike | None = None) -> LoadPathTree:
    """A checked tree of stations.

    Parameters
    ----------
    points : (n, 3)         positions of the stations, the root first, m
    parents : (n,) or None  parent of each station, a lower number, -1 for the root; by default each station
                            follows the one before
    Raises
    ------
    ModelError      points or parents of the wrong shape, a loop, a second root, a station before its parent,
                    a segment of length zero; the message states the number of the station
    """
    check_numbers("load path, points", points)
    places = read_only(points)
    if places.ndim != 2 or places.shape[1] != 3 or len(places) == 0:
        raise ModelError(f"a load path needs points (n, 3), not an array of shape {places.shape}")
    strange = np.flatnonzero(~np.isfinite(places).all(axis=1))
    if strange.size:
        raise ModelError(
            f"station {strange[0]} of the load path is at {places[strange[0]].tolist()}: its position must "
            "be three finite numbers"
        )
    n = len(places)
    given = np.arange(-1, n - 1) if parents is None else np.asarray(parents)
    if given.shape != (n,) or not np.issubdtype(given.dtype, np.integer):
        raise ModelError(f"a load path of {n} stations needs {n} whole numbers as parents, not {given}")
    _check_tree(given)
    tree = LoadPathTree(places, read_only(given, np.intp))
    short = np.flatnonzero(tree.lengths <= SHORTEST * np.ptp(places, axis=0).max())
    if short.size:
        end = int(short[0]) + 1
        raise ModelError(
            f"the segment of the load path between stations {given[end]} and {end} has length "
            f"{tree.lengths[end - 1]:.3g}: merge the two stations"
        )
    return tree


def _check_tree(parents: NDArray[np.integer]) -> None:
    n = len(parents)
    if parents[0] != ROOT:
        raise ModelError(f"station 0 of the load path must be its root, with parent -1, not {parents[0]}")
    outside = np.flatnonzero((parents[1:] < 0) | (parents[1:] >= n)) + 1
    if outside.size:
        raise ModelError(
            f"station {outside[0]} of the load path has parent {parents[outside[0]]}, which does not exist: "
            f"stations are 0 to {n - 1}, and only the root has parent -1"
        )
    above = parents
    for _ in range(n.bit_length()):  # each round doubles the distance to the ancestor
        above = np.where(above == ROOT, ROOT, above[above])
    looped = np.flatnonzero(above != ROOT)
    if looped.size:
        raise ModelError(
            f"the load path has a loop through station {looped[0]}: internal forces are statically "
            "determinate only in a tree; cut the loop, or use a floating frame for the body"
        )
    early = np.flatnonzero(parents >= np.arange(n))
    if early.size:
        raise ModelError(
            f"station {early[0]} of the load path has parent {parents[early[0]]}, which comes after "
            "it: number the stations from the root outwards"
        )
