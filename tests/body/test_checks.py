from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh

from supple.body import superelement
from supple.errors import ModelError


@pytest.fixture
def matrices(solid):
    return solid.mesh.nodes, solid.stiffness.toarray(), solid.mass.toarray()


def build(nodes, stiffness, mass, **options):
    return superelement("arm", nodes, stiffness, mass, dofs_per_node=3, **options)


def test_sound_matrices_pass(matrices):
    build(*matrices)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("which", ["stiffness", "mass"])
def test_entries_that_are_not_finite(matrices, which, bad):
    nodes, K, M = matrices
    (K if which == "stiffness" else M)[7, 7] = bad
    with pytest.raises(
        ModelError, match=f"body 'arm': the {which} has an entry that is not finite in the row of node 2 uy"
    ):
        build(nodes, K, M)


@pytest.mark.parametrize("which", ["stiffness", "mass"])
def test_matrices_that_are_not_symmetric(matrices, which):
    nodes, K, M = matrices
    matrix = K if which == "stiffness" else M
    matrix[3, 8] += 1e-3 * np.max(matrix)
    with pytest.raises(
        ModelError,
        match=rf"the {which} is not symmetric: the two entries of node [12] u[xz] with .* differ by 1\.0e-03",
    ):
        build(nodes, K, M)


@pytest.mark.parametrize("which", ["stiffness", "mass"])
def test_matrices_of_the_wrong_size(matrices, which):
    nodes, K, M = matrices
    n = len(M)
    cut = {"stiffness": (K[1:, 1:], M), "mass": (K, M[1:, 1:])}[which]
    with pytest.raises(
        ModelError, match=rf"the {which} has shape \({n - 1}, {n - 1}\), but 45 nodes .* need \({n}, {n}\)"
    ):
        build(nodes, *cut)


def test_nodes_of_the_wrong_shape_or_not_finite(matrices):
    nodes, K, M = matrices
    with pytest.raises(ModelError, match=r"nodes have shape \(45, 2\); give \(N, 3\)"):
        build(nodes[:, :2], K, M)
    with pytest.raises(ModelError, match=r"nodes have shape \(0, 3\)"):
        build(nodes[:0], K, M)
    broken = nodes.copy()
    broken[5, 1] = np.nan
    with pytest.raises(ModelError, match=r"node 5 has the coordinates .*nan.*, which are not finite"):
        build(broken, K, M)


def test_a_freedom_without_mass_follows_statically(matrices):
    """Its equilibrium without inertia: the pencil's finite eigenvalues stay, and it is no coordinate."""
    nodes, K, M = matrices
    M[4] = M[:, 4] = 0
    body = build(nodes, K, M)
    assert body.n == len(M) - 1
    inverse = np.sort(eigh(M, K + 1e3 * M, eigvals_only=True))[::-1][6:20]
    np.testing.assert_allclose(body.lowest_modes(20).values[6:], 1 / inverse - 1e3, rtol=1e-7)


def test_a_freedom_with_neither_mass_nor_stiffness_is_refused(matrices):
    nodes, K, M = matrices
    M[4] = M[:, 4] = K[4] = K[:, 4] = 0
    with pytest.raises(ModelError, match=r"among its 1 freedoms without mass .* such as uy of the node at"):
        build(nodes, K, M)


def test_a_negative_density_is_named(matrices):
    nodes, K, M = matrices
    with pytest.raises(ModelError, match=r"node \d+ ux has the mass -.* \(one of 135\).*cannot be negative"):
        build(nodes, K, -M)


def test_an_indefinite_mass_is_counted(matrices):
    nodes, K, M = matrices
    M[0, 30] = M[30, 0] = 2 * np.sqrt(M[0, 0] * M[30, 30])
    with pytest.raises(
        ModelError, match="mass matrix is not positive definite: 1 negative and 0 zero eigenvalues of 135"
    ):
        build(nodes, K, M)


def test_a_rigid_motion_without_mass_is_refused(matrices):
    """Without mass along x, and without stiffness there: no other motion can take it along."""
    nodes, K, M = matrices
    along = np.tile([1.0, 0.0, 0.0], len(nodes))
    push = M @ along
    with pytest.raises(
        ModelError, match="not positive definite: 1 of 1 motions without mass have no stiffness"
    ):
        build(nodes, K, M - np.outer(push, push) / (along @ push))


@pytest.mark.parametrize("softness", [1.0, 1e-4, 1e-7])
def test_a_grounded_stiffness_is_told_with_a_number(matrices, softness):
    nodes, K, M = matrices
    spring = softness * K[16, 16]
    K[16, 16] += spring
    with pytest.raises(
        ModelError,
        match=r"resists rigid motion: .* forces that must cancel sum to \d\.\de-\d\d .* at node 5 uy",
    ):
        build(nodes, K, M)
    if softness < 1e-6:
        build(nodes, K, M, rigid_tolerance=1e-6)


def test_supports_that_fix_a_node(matrices):
    nodes, K, M = matrices
    K[:3, :] = K[:, :3] = 0
    K[:3, :3] = np.eye(3) * np.max(K)
    with pytest.raises(ModelError, match=r"resists rigid motion.*leave supports out of its matrices"):
        build(nodes, K, M)


def test_a_part_without_stiffness_is_a_mechanism(matrices):
    nodes, K, M = matrices
    nodes = np.vstack([nodes, [[2.0, 0, 0]]])
    K = sparse.block_diag([K, np.zeros((3, 3))])
    M = sparse.block_diag([M, np.eye(3)])
    with pytest.raises(ModelError, match="can move in more than six ways without strain"):
        build(nodes, K, M)


def test_two_parts_that_are_not_joined(matrices):
    nodes, K, M = matrices
    with pytest.raises(ModelError, match="can move in more than six ways without strain"):
        build(np.vstack([nodes, nodes + 5]), sparse.block_diag([K, K]), sparse.block_diag([M, M]))


def in_line(nodes):
    """A force between nodes 0 and 1 along their line, which is along an axis: C = c f f^T is a dashpot."""
    along = nodes[1] - nodes[0]
    return np.concatenate([-along, along, np.zeros(3 * len(nodes) - 6)]) / np.linalg.norm(along)


@pytest.mark.parametrize("kind", ["negative entry", "coupling alone", "negative dashpot", "beside beta K"])
def test_damping_that_adds_energy_is_refused(matrices, kind):
    nodes, K, M = matrices
    C, f = np.zeros_like(K), in_line(nodes)
    if kind == "negative entry":
        C[0, 0] = -5.0
    elif kind == "coupling alone":
        C[0, 3] = C[3, 0] = 5.0
    else:
        C -= 5.0 * np.outer(f, f)
    if kind == "beside beta K":
        C += 1e-3 / np.max(K) * K
    with pytest.raises(ModelError, match="its damping has 1 negative eigenvalues, which add energy"):
        build(nodes, K, M, damping=C)


def test_damping_that_dissipates_in_some_motions_only_is_accepted(matrices):
    nodes, K, M = matrices
    f = in_line(nodes)
    for C in (5.0 * np.outer(f, f), 1e-4 * K, 5.0 * np.outer(f, f) + 1e-4 * K, np.zeros_like(K)):
        assert build(nodes, K, M, damping=C).damping is not None


def test_negative_strain_energy_is_counted(matrices, solid):
    nodes, K, M = matrices
    R = np.zeros((len(M), 6))
    R[:, :3] = np.tile(np.eye(3), (len(nodes), 1))
    for i, axis in enumerate(np.eye(3)):
        R[:, 3 + i] = np.cross(axis, nodes).ravel()
    v = np.random.default_rng(1).standard_normal(len(M))
    v -= R @ np.linalg.lstsq(R, v)[0]
    with pytest.raises(
        ModelError, match="its stiffness has 1 negative eigenvalues; strain energy cannot be negative"
    ):
        build(nodes, K - 10 * np.max(K) * np.outer(v, v) / (v @ v), M, rigid_tolerance=1e-8)
