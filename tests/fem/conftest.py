"""What the tests of the elements share: materials, irregular meshes, and small static solvers."""

import numpy as np
import pytest
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from supple.fem import Isotropic, assemble
from supple.mesh import Mesh


def factor(matrix):
    return splu(
        csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options={"SymmetricMode": True}
    )


@pytest.fixture
def material():
    return Isotropic(youngs_modulus=2.1e11, poissons_ratio=0.3, density=7800.0)


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def distorted():
    """Mesh with every node moved by an affine map and a wave: no two cells alike, quadratic cells curved."""

    def distort(mesh, amplitude):
        x = mesh.nodes
        wave = amplitude * np.sin(x @ [[0.7, 1.9, -1.2], [2.1, 0.6, 1.7], [1.3, -1.6, 0.8]] + [0.3, 1.1, 2.5])
        return Mesh(x + wave, mesh.cells, mesh.node_sets, mesh.cell_sets)

    return distort


@pytest.fixture
def rigid_modes():
    """Unit translations and rotations about the origin as nodal freedoms, (n, 6)."""

    def modes(model):
        x = model.mesh.nodes
        R = np.zeros((len(x), model.dofs_per_node, 6))
        for i in range(3):
            e = np.eye(3)[i]
            R[:, :3, i] = e
            R[:, :3, 3 + i] = np.cross(e, x)
            if model.dofs_per_node == 6:
                R[:, 3:, 3 + i] = e
        return R.reshape(-1, 6)

    return modes


@pytest.fixture
def held():
    """Expansion T whose rows of the held (node, freedom) pairs are empty."""

    def expansion(model, *holds):
        free = np.ones((model.mesh.n_nodes, model.dofs_per_node), dtype=bool)
        for nodes, freedoms in holds:
            free[np.ix_(nodes, freedoms)] = False
        rows = np.flatnonzero(free)
        return csc_array((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(model.n_dofs, len(rows)))

    return expansion


@pytest.fixture
def solve_linear():
    """Nodal displacements (N, d) under nodal loads (N, d)."""

    def solve(model, T, load):
        q = factor(T.T @ model.stiffness @ T).solve(T.T @ load.ravel())
        return (T @ q).reshape(load.shape)

    return solve


@pytest.fixture
def solve_nonlinear():
    """Nodal displacements (N, d) under dead loads, by Newton's method in load steps."""

    def solve(model, T, load, steps=4):
        assembly = assemble(model, T)
        q, f = np.zeros(assembly.n), T.T @ load.ravel()
        for step in np.linspace(0, 1, steps + 1)[1:]:
            for _ in range(30):
                residual = step * f - assembly.internal_force(q)
                if np.linalg.norm(residual) < 1e-9 * np.linalg.norm(f):
                    break
                q = q + factor(assembly.tangent(q)).solve(residual)
            else:
                raise AssertionError(f"Newton did not converge at load {step}")
        return (T @ q).reshape(load.shape)

    return solve
