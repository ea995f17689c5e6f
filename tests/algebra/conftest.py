"""A free 3-D truss, a lattice of points joined by springs, with six rigid motions and point masses."""

from __future__ import annotations

from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
import pytest
from scipy import sparse
from scipy.spatial import cKDTree

from supple.algebra import DirectSolver, Rslab, SuperLU


class Truss(NamedTuple):
    nodes: np.ndarray
    stiffness: sparse.csc_array
    mass: sparse.csc_array
    rigid_modes: np.ndarray


def make_truss(n_x: int, n_y: int, n_z: int) -> Truss:
    """Springs along edges and diagonals of a lattice, of stiffness 1e6 * (1 + number mod 3)."""
    grid = np.meshgrid(np.arange(n_x), np.arange(n_y), np.arange(n_z), indexing="ij")
    nodes = 0.5 * np.stack([axis.ravel() for axis in grid], axis=1).astype(float)
    ends = cKDTree(nodes).query_pairs(0.75, output_type="ndarray")
    direction = nodes[ends[:, 1]] - nodes[ends[:, 0]]
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    stretch = np.zeros((len(ends), 3 * len(nodes)))
    for sign, end in ((-1, 0), (1, 1)):
        np.put_along_axis(stretch, 3 * ends[:, [end]] + np.arange(3), sign * direction, axis=1)
    stretch = sparse.csr_array(stretch)
    stiffness = stretch.T @ sparse.diags_array(1e6 * (1 + np.arange(len(ends)) % 3.0)) @ stretch
    mass = sparse.diags_array(np.repeat(1.0 + np.arange(len(nodes)) % 2, 3), format="csc")
    modes = np.zeros((len(nodes), 3, 6))
    modes[:, :, :3] = np.eye(3)
    modes[:, :, 3:] = np.moveaxis(np.cross(np.eye(3)[:, None, :], nodes), 0, 2)
    return Truss(nodes, sparse.csc_array(stiffness), mass, modes.reshape(-1, 6))


@pytest.fixture(scope="session")
def small_truss() -> Truss:
    return make_truss(5, 2, 2)


@pytest.fixture(scope="session")
def truss() -> Truss:
    return make_truss(12, 4, 4)


@pytest.fixture(
    params=[
        SuperLU(),
        pytest.param(Rslab(), marks=pytest.mark.skipif(not find_spec("rslab"), reason="rslab is an extra")),
    ],
    ids=["superlu", "rslab"],
)
def solver(request) -> DirectSolver:
    """Each sparse solver in turn."""
    return request.param


def relative(error: np.ndarray, size: np.ndarray) -> float:
    return float(np.max(np.abs(error)) / np.max(np.abs(size)))


@pytest.fixture(scope="session")
def relative_error():
    """Largest entry of x - reference over the largest of the reference."""
    return lambda x, reference: relative(np.asarray(x) - reference, reference)


@pytest.fixture(scope="session")
def chain():
    """chain(n): stiffness and mass of n unit masses joined by n - 1 unit springs, free at both ends.

    Eigenvalues 4 sin^2(k pi / 2 n), k = 0 .. n - 1.
    """

    def make(n: int) -> tuple[sparse.csc_array, sparse.csc_array]:
        stretch = sparse.diags_array([-np.ones(n - 1), np.ones(n - 1)], offsets=[0, 1], shape=(n - 1, n))
        return sparse.csc_array(stretch.T @ stretch), sparse.eye_array(n, format="csc")

    return make
