"""Expansion: motion of the nodes of a body from that of the stations of its line."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from supple.algebra import read_only
from supple.arrays import FloatArray
from supple.methods.intrinsic.load_path_tree import LoadPathTree

AT_ONCE = 2**22
"""Largest number of components of vectors from segments to points in memory at a time."""


@dataclass(frozen=True, eq=False)
class Expansion:
    """Map from n stations to N nodes: weighted rigid motion of two stations, plus a shape due to strains.

        r_a = sum_i w_ai (r_i + R_i (X_a - X_i + D_a gamma))

    r_a are the positions of nodes, r_i and R_i the positions and rotations of stations, X the positions
    at rest, w the weights, and gamma the elastic amplitudes. D gamma is the static shape of the condensation
    minus the weighted rigid motion: warping of sections, and the curve of a coarse segment.

    nodes : (N, 3)              positions at rest, m
    stations, weights : (N, 2)  two stations for each node; weights add up to one
    modes : (N, d, e)           displacement of the nodal freedoms by elastic amplitude, d = 3 or 6; its first
                                three components minus the rigid part are D
    warping : (N, 3, e)         D
    """

    nodes: FloatArray
    stations: NDArray[np.intp] = field(repr=False)
    weights: FloatArray = field(repr=False)
    modes: FloatArray = field(repr=False)
    warping: FloatArray = field(repr=False)

    def arms(self, tree: LoadPathTree) -> FloatArray:
        """(N, 2, 3) vectors from the stations to the nodes at rest."""
        return self.nodes[:, None] - tree.points[self.stations]


def expansion_of_stations(tree: LoadPathTree, velocities: FloatArray) -> Expansion:
    """Expansion whose nodes are the stations; velocities (n, 6, e) are those of the elastic modes."""
    own = np.repeat(np.arange(tree.n)[:, None], 2, axis=1)
    weights = np.tile([1.0, 0.0], (tree.n, 1))
    return Expansion(tree.points, own, weights, velocities, np.zeros((tree.n, 3, velocities.shape[2])))


def carried_by_stations(
    tree: LoadPathTree, nodes: FloatArray, nodal_modes: FloatArray, station_modes: FloatArray
) -> Expansion:
    """Expansion of nodes by the two stations of the nearest segment, weighted by the position along it.

    nodal_modes : (N, d, e)     linear displacement of the nodes in elastic modes
    station_modes : (n, 6, e)   motion of the stations in the same modes
    """
    stations, weights = shares_of_stations(tree, nodes)
    arms = nodes[:, None] - tree.points[stations]
    rigid = np.zeros((len(nodes), 3, station_modes.shape[2]))
    for end in range(2):  # one end at a time, to save memory on large meshes
        moved = station_modes[stations[:, end]]
        shift = moved[:, :3] + np.cross(moved[:, 3:], arms[:, end, :, None], axis=1)
        rigid += weights[:, end, None, None] * shift
    return Expansion(
        read_only(nodes),
        stations,
        read_only(weights),
        read_only(nodal_modes),
        read_only(nodal_modes[:, :3] - rigid),
    )


def shares_of_stations(tree: LoadPathTree, points: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
    """Two stations (N, 2) of the segment nearest to each point, and weights (N, 2), linear along it."""
    if tree.n == 1:
        return np.zeros((len(points), 2), dtype=np.intp), np.tile([1.0, 0.0], (len(points), 1))
    start, direction, length = tree.points[tree.inner], tree.directions, tree.lengths
    nearest = np.empty(len(points), dtype=np.intp)
    size = max(1, AT_ONCE // (3 * len(length)))
    for first in range(0, len(points), size):
        arms = points[first : first + size, None] - start
        along = np.clip(np.einsum("psi,si->ps", arms, direction), 0, length)
        off = arms - along[..., None] * direction
        nearest[first : first + size] = np.einsum("psi,psi->ps", off, off).argmin(axis=1)
    along = np.einsum("pi,pi->p", points - start[nearest], direction[nearest])
    share = np.clip(along / length[nearest], 0, 1)
    stations = np.column_stack([tree.inner[nearest], nearest + 1])
    return stations, np.column_stack([1 - share, share])
