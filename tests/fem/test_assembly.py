"""Assembly: sums over elements, and their congruence with an expansion T."""

import numpy as np
import pytest
from scipy.sparse import csc_array, eye_array

from supple.errors import ModelError
from supple.fem import HomogeneousSection, assemble, assembly, shell_model, solid_model
from supple.fem.quadratic_strain import tangent
from supple.mesh import CellType, Mesh, block, box_beam

STEP = 1e-30


def shell(material, distorted):
    mesh = distorted(box_beam(1.0, 0.6, 0.4, 3, 1, 1), 0.05)
    walls = {"z_min": 0.01, "y_max": 0.02, "z_max": 0.01, "y_min": 0.02}
    return shell_model(mesh, {name: HomogeneousSection(material, t) for name, t in walls.items()})


def solid(material, distorted):
    """Two cell types side by side: a hexahedron and a tetrahedron on one of its faces' corners."""
    cube = block(1.0, 0.8, 0.6, 1, 1, 1, CellType.HEXA8)
    nodes = np.vstack([cube.nodes, [1.7, 0.1, 0.1]])
    a, b, c = cube.nodes_of("tip")[:3]
    cells = np.array([[a, b, c, 8]])
    p, q, r = nodes[[b, c, 8]] - nodes[a]
    if np.cross(p, q) @ r < 0:
        cells = cells[:, [1, 0, 2, 3]]
    return solid_model(distorted(Mesh(nodes, {**cube.cells, CellType.TETRA4: cells}), 0.05), material)


@pytest.fixture(params=[shell, solid], ids=["shell", "solid"])
def model(request, material, distorted):
    return request.param(material, distorted)


@pytest.fixture
def rigid_end(model, rng):
    """Root held (empty rows), tip tied to six freedoms of its own (rows of several entries)."""
    d, x = model.dofs_per_node, model.mesh.nodes
    tip = np.flatnonzero(x[:, 0] > 0.85)
    free = np.flatnonzero((x[:, 0] > 0.15) & (x[:, 0] <= 0.85))
    n_free = len(free) * d
    T = np.zeros((len(x), d, n_free + 6))
    T[free[:, None], np.arange(d), np.arange(n_free).reshape(-1, d)] = 1
    T[tip[:, None], np.arange(d), n_free + np.arange(d)] = 1
    T[tip, :3, n_free + 3 :] = -np.cross(x[tip][:, None] - [1.0, 0, 0], np.eye(3))
    return csc_array(T.reshape(-1, n_free + 6))


def plain_tangent(model, u):
    """Element by element, into a dense matrix."""
    K = np.zeros((model.n_dofs, model.n_dofs))
    for part in model.blocks:
        for dofs, matrix in zip(part.dofs, tangent(part, u[part.dofs]), strict=True):
            K[np.ix_(dofs, dofs)] += matrix
    return K


def assert_close(actual, expected):
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_tangent_is_the_sum_over_the_elements(model, rng):
    u = 0.05 * rng.normal(size=model.n_dofs)
    assert_close(assemble(model).tangent(u).toarray(), plain_tangent(model, u))


def test_stiffness_of_the_model_is_the_tangent_of_the_undeformed_body(model):
    assert_close(model.stiffness.toarray(), plain_tangent(model, np.zeros(model.n_dofs)))


def test_expansion_is_a_congruence(model, rigid_end, rng):
    T = rigid_end
    reduced, plain = assemble(model, T), assemble(model)
    q, x = 0.05 * rng.normal(size=(2, T.shape[1]))
    assert reduced.n == T.shape[1]
    assert reduced.energy(q) == pytest.approx(plain.energy(T @ q), rel=1e-13)
    assert_close(reduced.internal_force(q), T.T @ plain.internal_force(T @ q))
    assert_close(reduced.tangent(q).toarray(), (T.T @ plain.tangent(T @ q) @ T).toarray())
    assert_close(
        reduced.tangent_derivative(x).toarray(), (T.T @ plain.tangent_derivative(T @ x) @ T).toarray()
    )


def test_force_and_tangent_by_complex_step(model, rigid_end, rng):
    reduced = assemble(model, rigid_end)
    q, x = 0.05 * rng.normal(size=(2, reduced.n))
    ahead = q + STEP * 1j * x
    assert reduced.internal_force(q) @ x == pytest.approx(reduced.energy(ahead).imag / STEP, rel=1e-12)
    assert_close(reduced.tangent(q) @ x, reduced.internal_force(ahead).imag / STEP)
    assert_close(
        reduced.tangent_derivative(x).toarray(), reduced.tangent(STEP * 1j * x).toarray().imag / STEP
    )


def test_pair_forces_are_second_differences_of_the_force(model, rigid_end, rng):
    """f is cubic, so the central second difference of its even part is exact: f''(x, x)."""
    reduced = assemble(model, rigid_end)
    X = rng.normal(size=(reduced.n, 3))
    pairs = reduced.pair_forces(X)

    def second(x):
        return reduced.internal_force(x) + reduced.internal_force(-x)

    for column, (j, k) in enumerate(zip(*np.triu_indices(3), strict=True)):
        difference = 0.25 * (second(X[:, j] + X[:, k]) - second(X[:, j] - X[:, k]))
        np.testing.assert_allclose(pairs[:, column], difference, rtol=0, atol=1e-10 * np.abs(pairs).max())
        assert_close(pairs[:, column], reduced.tangent_derivative(X[:, j]) @ X[:, k])


def test_pair_forces_and_works_do_not_depend_on_the_chunks(model, rng, monkeypatch):
    X = rng.normal(size=(model.n_dofs, 4))
    whole, works = assemble(model).pair_forces(X), assemble(model).works(X, X[:, ::-1])
    monkeypatch.setattr(assembly, "CHUNK", 1)
    assert_close(assemble(model).pair_forces(X), whole)
    for each, expected in zip(assemble(model).works(X, X[:, ::-1]), works, strict=True):
        assert_close(each, expected)


def test_energies_are_those_of_the_columns(model, rigid_end, rng, monkeypatch):
    reduced = assemble(model, rigid_end)
    Q = 0.05 * rng.normal(size=(reduced.n, 3))
    expected = [reduced.energy(q) for q in Q.T]
    monkeypatch.setattr(assembly, "CHUNK", 1)
    np.testing.assert_allclose(reduced.energies(Q), expected, rtol=1e-13)


def test_every_matrix_has_the_same_sorted_pattern(model, rigid_end, rng):
    reduced = assemble(model, rigid_end)
    first, second = (reduced.tangent(rng.normal(size=reduced.n)) for _ in range(2))
    np.testing.assert_array_equal(first.indices, second.indices)
    np.testing.assert_array_equal(first.indptr, reduced.indptr)
    rebuilt = csc_array(first.toarray() != 0)
    rebuilt.sort_indices()
    assert np.isin(_entries(rebuilt), _entries(first)).all()
    assert (np.diff(_entries(first)) > 0).all()


def _entries(matrix):
    n = matrix.shape[1]
    return np.repeat(np.arange(n), np.diff(matrix.indptr)) * n + matrix.indices


def test_expansion_of_another_model_is_refused(model):
    with pytest.raises(
        ModelError, match=f"expansion has 5 rows; the model has {model.n_dofs} nodal freedoms"
    ):
        assemble(model, eye_array(5))
