from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg, sparse
from scipy.sparse.linalg import ArpackNoConvergence

import supple.algebra.eigen as module
from supple.algebra import count_below, grounded_factor, lowest_modes
from supple.errors import AccuracyError, ModelError


def chain_eigenvalues(n, count):
    return 4 * np.sin(np.arange(count) * np.pi / (2 * n)) ** 2


def dense_eigenvalues(truss):
    return linalg.eigh(truss.stiffness.toarray(), truss.mass.toarray(), eigvals_only=True)


@pytest.fixture(scope="module")
def exact(truss):
    return dense_eigenvalues(truss)


@pytest.mark.parametrize("n", [100, 1000], ids=["dense", "sparse"])
def test_a_free_chain_has_its_closed_form_frequencies(chain, solver, n):
    stiffness, mass = chain(n)
    values, vectors = lowest_modes(stiffness, mass, 10, solver=solver)
    # Absolute to the largest eigenvalue: the rigid mode is zero up to round-off.
    np.testing.assert_allclose(values, chain_eigenvalues(n, 10), rtol=1e-8, atol=1e-13)
    # Mode shapes cos(k pi (i + 1/2) / n).
    shapes = np.cos(np.outer(np.arange(n) + 0.5, np.arange(10)) * np.pi / n)
    shapes /= np.linalg.norm(shapes, axis=0)
    np.testing.assert_allclose(np.abs(np.sum(shapes * vectors, axis=0)), 1, rtol=1e-9)


def test_modes_satisfy_their_definition(truss, exact, solver):
    K, M = truss.stiffness, truss.mass
    values, X = lowest_modes(K, M, 20, solver=solver)
    assert np.all(np.diff(values) >= 0)
    assert np.max(np.abs(X.T @ (M @ X) - np.eye(20))) < 1e-12
    assert np.linalg.norm(K @ X - M @ X * values) < 1e-9 * np.linalg.norm(abs(K) @ np.abs(X))
    np.testing.assert_allclose(values[6:], exact[6:20], rtol=1e-10)
    assert np.max(np.abs(values[:6])) < 1e-9 * values[6]
    assert np.all(np.max(X, axis=0) == np.max(np.abs(X), axis=0))


def test_the_mean_axis_modes_are_the_elastic_free_modes(truss, exact, solver):
    D = (truss.mass @ truss.rigid_modes).T
    values, X = lowest_modes(truss.stiffness, truss.mass, 15, constraint=D, solver=solver)
    np.testing.assert_allclose(values, exact[6:21], rtol=1e-10)
    assert np.max(np.abs(D @ X)) < 1e-11 * np.max(np.abs(D) @ np.abs(X))


@pytest.mark.parametrize("limit", [0, 10_000], ids=["sparse", "dense"])
def test_held_freedoms_act_like_removed_ones(truss, solver, monkeypatch, limit):
    monkeypatch.setattr(module, "LARGEST_DENSE", limit)
    n = truss.stiffness.shape[0]
    held, free = np.arange(48), np.arange(48, n)  # the sixteen nodes at one end
    exact = linalg.eigh(
        truss.stiffness[free][:, free].toarray(), truss.mass[free][:, free].toarray(), eigvals_only=True
    )
    D = sparse.csr_array((np.ones(48), (held, held)), (48, n))
    values, X = lowest_modes(truss.stiffness, truss.mass, 8, constraint=D, solver=solver)
    np.testing.assert_allclose(values, exact[:8], rtol=1e-9)
    assert np.max(np.abs(X[held])) < 1e-9 * np.max(np.abs(X))


def three_alike(chain, n=300):
    """Three equal chains, held at one end: every eigenvalue 4 sin^2((2k + 1) pi / (4 n + 2)) three times."""
    stiffness, _ = chain(n + 1)
    held = stiffness[1:, 1:]
    exact = 4 * np.sin((2 * np.arange(20) + 1) * np.pi / (4 * n + 2)) ** 2
    return (
        sparse.block_diag([held] * 3, format="csc"),
        sparse.eye_array(3 * n, format="csc"),
        np.repeat(exact, 3),
    )


@pytest.mark.parametrize("count", [8, 9, 10, 11])
def test_no_copy_of_a_multiple_mode_is_missed(chain, solver, count):
    stiffness, mass, exact = three_alike(chain)
    values, X = lowest_modes(stiffness, mass, count, solver=solver)
    np.testing.assert_allclose(values, exact[:count], rtol=1e-9)
    assert np.max(np.abs(X.T @ X - np.eye(count))) < 1e-12


def test_a_cluster_wider_than_the_guard_modes(chain):
    stiffness, _ = chain(101)
    eight = sparse.block_diag([stiffness[1:, 1:]] * 8, format="csc")
    values = lowest_modes(eight, sparse.eye_array(800, format="csc"), 2).values
    np.testing.assert_allclose(values, 4 * np.sin(np.pi / 402) ** 2, rtol=1e-9)


def sabotage(monkeypatch, change, calls=None):
    """Replace what Lanczos returns by change(values, vectors), in the given calls or in all."""
    honest, done = module.eigsh, []

    def eigsh(*args, **kwargs):
        values, vectors = honest(*args, **kwargs)
        done.append(None)
        return change(values, vectors) if calls is None or len(done) in calls else (values, vectors)

    monkeypatch.setattr(module, "eigsh", eigsh)
    return done


@pytest.mark.parametrize("lost", [[0], [3], [0, 4, 5]])
def test_modes_that_lanczos_loses_are_counted_and_found(truss, exact, monkeypatch, lost, solver):
    D = (truss.mass @ truss.rigid_modes).T
    done = sabotage(monkeypatch, lambda w, X: (np.delete(w, lost), np.delete(X, lost, axis=1)), calls=[1])
    values = lowest_modes(truss.stiffness, truss.mass, 10, constraint=D, solver=solver).values
    assert len(done) > 1
    np.testing.assert_allclose(values, exact[6:16], rtol=1e-9)


def test_a_mode_that_is_never_found_is_an_error(truss, monkeypatch):
    sabotage(monkeypatch, lambda w, X: (w[1:], X[:, 1:]))
    with pytest.raises(
        AccuracyError, match=r"could not be certified in 4 rounds: .* where the inertia counts"
    ):
        lowest_modes(truss.stiffness, truss.mass, 10, constraint=(truss.mass @ truss.rigid_modes).T)


def test_a_cluster_that_never_ends_is_an_error(monkeypatch):
    n = 2000
    with pytest.raises(AccuracyError, match="the modes found end inside a cluster"):
        lowest_modes(sparse.eye_array(n, format="csc"), sparse.eye_array(n, format="csc"), 2)


def test_inaccurate_modes_are_an_error(truss, monkeypatch):
    noise = 1e-4 * np.random.default_rng(0).standard_normal(truss.stiffness.shape[0])[:, None]
    sabotage(monkeypatch, lambda w, X: (w, X + noise))
    with pytest.raises(AccuracyError, match=r"a mode violates its equation by .* \(allowed 1e-06\)"):
        lowest_modes(truss.stiffness, truss.mass, 10)


def test_what_arpack_found_before_giving_up_is_used(truss, exact, monkeypatch):
    honest, calls = module.eigsh, []

    def eigsh(*args, **kwargs):
        values, vectors = honest(*args, **kwargs)
        calls.append(None)
        if len(calls) == 1:
            raise ArpackNoConvergence("no convergence", values[:5], vectors[:, :5])
        return values, vectors

    monkeypatch.setattr(module, "eigsh", eigsh)
    D = (truss.mass @ truss.rigid_modes).T
    values = lowest_modes(truss.stiffness, truss.mass, 10, constraint=D).values
    np.testing.assert_allclose(values, exact[6:16], rtol=1e-9)


def test_the_same_question_has_the_same_answer(truss):
    first, second = (lowest_modes(truss.stiffness, truss.mass, 9).vectors for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_all_modes_and_none(small_truss):
    n = small_truss.stiffness.shape[0]
    D = (small_truss.mass @ small_truss.rigid_modes).T
    every = lowest_modes(small_truss.stiffness, small_truss.mass, n - 6, constraint=D)
    np.testing.assert_allclose(every.values, dense_eigenvalues(small_truss)[6:], rtol=1e-10)
    none = lowest_modes(small_truss.stiffness, small_truss.mass, 0)
    assert none.values.shape == (0,)
    assert none.vectors.shape == (n, 0)


@pytest.mark.parametrize("count", [-1, 55])
def test_more_modes_than_freedoms(small_truss, count):
    with pytest.raises(ModelError, match=f"{count} modes requested of a body with 54 freedoms"):
        lowest_modes(
            small_truss.stiffness,
            small_truss.mass,
            count,
            constraint=(small_truss.mass @ small_truss.rigid_modes).T,
        )


@pytest.mark.parametrize("n", [100, 1000], ids=["dense", "sparse"])
def test_a_stiffness_with_negative_energy(chain, n):
    stiffness, mass = chain(n)
    with pytest.raises(ModelError, match="the stiffness is not positive semi-definite"):
        lowest_modes(stiffness - 1e-3 * mass, mass, 3)


def test_matrices_of_different_size(chain):
    with pytest.raises(
        ModelError, match=r"stiffness \(10, 10\) and mass \(11, 11\) must be square and of one size"
    ):
        lowest_modes(chain(10)[0], chain(11)[1], 2)


@pytest.mark.parametrize("count", [0, 1, 7, 300])
def test_eigenvalues_below_a_value_are_counted(chain, solver, count):
    stiffness, mass = chain(300)
    exact = np.concatenate([[-1.0], chain_eigenvalues(300, 300), [5.0]])
    value = 0.5 * (exact[count] + exact[count + 1])
    assert count_below(stiffness, mass, value, solver=solver) == count


def test_a_constraint_takes_its_eigenvalues_away(truss, exact, solver):
    D = (truss.mass @ truss.rigid_modes).T
    value = 0.5 * (exact[9] + exact[10])
    assert count_below(truss.stiffness, truss.mass, value, solver=solver) == 10
    assert count_below(truss.stiffness, truss.mass, value, constraint=D, solver=solver) == 4


def test_a_known_factor_lends_its_analysis_where_patterns_agree(truss, exact):
    grounded = grounded_factor(truss.stiffness, truss.rigid_modes)
    value = 0.5 * (exact[29] + exact[30])
    assert count_below(truss.stiffness, truss.mass, value, grounded=grounded) == 30
    n = truss.stiffness.shape[0]
    wider = truss.mass + 1e-9 * sparse.csc_array(np.eye(n, k=n - 1) + np.eye(n, k=1 - n))
    assert count_below(truss.stiffness, wider, value, grounded=grounded) == 30


@pytest.mark.parametrize("room", [0, 10**9], ids=["one factor at a time", "two at a time"])
def test_modes_by_the_analysis_of_a_known_factor(truss, exact, monkeypatch, room):
    """In the scale of a large body the known factor gives its numbers back, and has them again after."""
    monkeypatch.setattr(module, "LARGEST_WITH_TWO_FACTORS", room)
    monkeypatch.setattr(module, "LARGEST_DENSE", 0)
    grounded = grounded_factor(truss.stiffness, truss.rigid_modes)
    held, load = grounded.factor._raw is not None, np.sin(np.arange(grounded.n))
    before = grounded.factor.solve(load)
    analysed = []
    monkeypatch.setattr(module, "factorize_symmetric", lambda *_, **__: analysed.append(1))
    values = lowest_modes(truss.stiffness, truss.mass, 20, grounded=grounded).values
    np.testing.assert_allclose(values[6:], exact[6:20], rtol=1e-10)
    assert held
    assert not analysed
    assert (grounded.factor._raw is None) == (room == 0)
    np.testing.assert_allclose(grounded.factor.solve(load), before, rtol=1e-12)


@pytest.mark.parametrize("limit", [0, 10_000], ids=["sparse", "dense"])
def test_low_modes_beside_very_stiff_parts_keep_their_digits(monkeypatch, limit):
    """A chain hung by unit springs, mass by mass, from one 2^40 times as stiff, which does not move."""
    monkeypatch.setattr(module, "LARGEST_DENSE", limit)
    n, stiff = 40, 2.0**40
    fixed = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    stiffness = sparse.csc_array(
        np.kron(np.diag([stiff, 1.0]), fixed) + np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(n))
    )
    values = lowest_modes(stiffness, sparse.eye_array(2 * n, format="csc"), 5).values
    exact = 1 + 4 * np.sin(np.arange(1, 6) * np.pi / (2 * n + 2)) ** 2
    np.testing.assert_allclose(values, exact, rtol=1e-8)
