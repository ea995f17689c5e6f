from __future__ import annotations

import importlib.util
import subprocess

import numpy as np
import pytest
from scipy import sparse

import supple.algebra.sparse_factor as module
from supple.algebra import (
    Inertia,
    Rslab,
    SuperLU,
    factorize_general,
    factorize_symmetric,
    installed_solver,
    lowest_modes,
)
from supple.errors import AccuracyError, ModelError, SuppleWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip
from supple.other_processes import python_command


def shifted(truss, shift):
    return truss.stiffness - shift * truss.mass


@pytest.mark.parametrize("columns", [(), (0,), (1,), (5,), (2 * module.BLOCK_COLUMNS + 3,)])
def test_solves_one_many_or_no_loads(truss, solver, columns, relative_error):
    A = shifted(truss, -1e3)
    x = np.random.default_rng(1).standard_normal((truss.stiffness.shape[0], *columns))
    solution = factorize_symmetric(A, solver=solver).solve(A @ x)
    assert solution.shape == x.shape
    if x.size:
        assert relative_error(solution, x) < 1e-10


def test_takes_any_format_and_type(solver):
    dense = np.array([[4, 1, 0], [1, 3, 1], [0, 1, 2]])
    b = np.array([1, 2, 3])
    exact = np.linalg.solve(dense, b)
    twice = sparse.coo_array(
        (np.repeat(0.5, 14), (np.tile([0, 0, 1, 1, 1, 2, 2], 2), np.tile([0, 1, 0, 1, 2, 1, 2], 2))), (3, 3)
    )  # every entry in two halves of one
    for matrix in (dense, dense.astype(np.float32), sparse.csr_array(dense), sparse.coo_array(dense)):
        np.testing.assert_allclose(factorize_symmetric(matrix, solver=solver).solve(b), exact, rtol=1e-14)
    factor = factorize_symmetric(twice + sparse.diags_array([3.0, 2.0, 1.0]), solver=solver)
    np.testing.assert_allclose(factor.solve(b), exact, rtol=1e-14)


def test_inertia_counts_the_signs_of_a_diagonal(solver):
    diagonal = np.random.default_rng(0).permutation(np.concatenate([-np.arange(1, 8), np.arange(1.0, 24)]))
    assert factorize_symmetric(sparse.diags_array(diagonal), solver=solver).inertia == Inertia(7, 0, 23)


@pytest.mark.parametrize("k", [0, 1, 7, 100, 199])
def test_inertia_counts_the_eigenvalues_below_a_shift(chain, solver, k):
    n = 200
    stiffness, mass = chain(n)
    shift = 4 * np.sin((k + 0.5) * np.pi / (2 * n)) ** 2  # between eigenvalues k and k + 1 (from zero)
    assert factorize_symmetric(stiffness - shift * mass, solver=solver).inertia == Inertia(
        k + 1, 0, n - k - 1
    )


def test_inertia_of_a_truss_agrees_with_its_dense_eigenvalues(small_truss, solver):
    A = shifted(small_truss, 2.87e6)
    eigenvalues = np.linalg.eigvalsh(A.toarray())
    expected = Inertia(int(np.sum(eigenvalues < 0)), 0, int(np.sum(eigenvalues > 0)))
    assert 6 < expected.negative < 54
    assert factorize_symmetric(A, solver=solver).inertia == expected


def test_superlu_says_when_it_cannot_tell_the_inertia():
    exchange = sparse.csc_array(np.array([[0.0, 1.0], [1.0, 0.0]]))
    factor = factorize_symmetric(exchange, solver=SuperLU())
    np.testing.assert_allclose(factor.solve([3.0, 5.0]), [5, 3])
    with pytest.raises(AccuracyError, match=r"exchanged rows.*supple\[fast\]"):
        _ = factor.inertia


def test_a_free_body_is_singular(truss, solver):
    with pytest.raises(AccuracyError, match="576 x 576 matrix is singular to working precision"):
        factorize_symmetric(truss.stiffness, solver=solver)


@pytest.mark.parametrize("matrix", [np.zeros((3, 3)), np.ones((4, 4)), np.diag([1.0, 0.0, 2.0])])
def test_an_exactly_singular_matrix_is_named(solver, matrix):
    with pytest.raises(AccuracyError, match="singular to working precision"):
        factorize_symmetric(matrix, solver=solver)


def test_poor_factors_are_refused(monkeypatch, truss):
    A = shifted(truss, -1e3)
    good = SuperLU().symmetric(A)
    monkeypatch.setattr(
        SuperLU, "symmetric", lambda self, _: good._replace(solve=lambda b: 1.01 * good.solve(b))
    )
    with pytest.raises(AccuracyError, match=r"one refinement step changes a solution by 1.0e-02"):
        factorize_symmetric(A, solver=SuperLU())


def test_a_stiff_but_regular_body_is_accepted(solver):
    # Condition 1e10: a slender beam of thin shells.
    A = sparse.diags_array(np.logspace(0, 10, 50)) + 1e-3 * sparse.eye_array(50)
    b = np.ones(50)
    np.testing.assert_allclose(A @ factorize_symmetric(A, solver=solver).solve(b), b, rtol=1e-12)


def test_new_values_on_the_same_pattern(truss, solver, relative_error):
    factor = factorize_symmetric(shifted(truss, -1e3), solver=solver)
    other = shifted(truss, 2e3)
    again = factor.refactorize(other)
    x = np.random.default_rng(2).standard_normal(again.n)
    assert relative_error(again.solve(other @ x), x) < 1e-9
    assert again.inertia.negative == 6
    assert factor.inertia.negative == 0
    with pytest.raises(ModelError, match=r"new matrix has shape \(3, 3\)"):
        factor.refactorize(np.eye(3))
    with pytest.raises(AccuracyError, match="singular"):
        factor.refactorize(truss.stiffness)


def test_numbers_given_back_are_computed_again_and_no_sooner(truss, solver):
    A = shifted(truss, -1e3)
    counted = []

    class Counting:
        def symmetric(self, matrix):
            counted.append(matrix)
            raw = solver.symmetric(matrix)
            return raw._replace(refactorize=self.symmetric)

    factor = factorize_symmetric(A, solver=Counting())
    b = np.ones(factor.n)
    before = factor.solve(b)
    factor.release()
    assert len(counted) == 1
    np.testing.assert_array_equal(factor.solve(b), before)
    factor.solve(b)
    assert len(counted) == 2
    factor.release()
    assert factor.refactorize(shifted(truss, 2e3)).inertia.negative == 6


def test_unsymmetric_values(truss, solver, relative_error):
    A = shifted(truss, -1e3)
    gyroscopic = sparse.triu(A, 1) * 1e-2
    A = sparse.csc_array(A + gyroscopic - gyroscopic.T)
    x = np.random.default_rng(3).standard_normal((A.shape[0], 3))
    factor = factorize_general(A, solver=solver)
    assert relative_error(factor.solve(A @ x), x) < 1e-9
    assert relative_error(factor.refactorize(2 * A).solve(A @ x), 0.5 * x) < 1e-9
    with pytest.raises(ModelError, match="unsymmetric matrix has no inertia"):
        _ = factor.inertia


def test_multiplier_rows_with_zero_diagonal(truss, solver, relative_error):
    A = sparse.block_array(
        [[shifted(truss, -1e3), truss.rigid_modes], [truss.rigid_modes.T, None]], format="csc"
    )
    x = np.random.default_rng(4).standard_normal(A.shape[0])
    assert relative_error(factorize_general(A, solver=solver).solve(A @ x), x) < 1e-9


@pytest.mark.skipif(not importlib.util.find_spec("rslab"), reason="rslab is an extra")
def test_both_solvers_agree_on_a_thin_shell():
    wall = HomogeneousSection(Isotropic(7e10, 0.3, 2700.0), 0.005)
    model = shell_model(strip(5.0, 0.4, 40, 4), wall)
    load = np.random.default_rng(5).standard_normal(model.n_dofs)
    shifted = model.stiffness + 10.0 * model.mass
    solutions = [factorize_symmetric(shifted, solver=solver).solve(load) for solver in (Rslab(), SuperLU())]
    np.testing.assert_allclose(solutions[0], solutions[1], rtol=1e-6, atol=1e-6 * np.abs(solutions[1]).max())
    values = [
        lowest_modes(model.stiffness, model.mass, 16, solver=solver).values[6:]
        for solver in (Rslab(), SuperLU())
    ]
    np.testing.assert_allclose(values[0], values[1], rtol=1e-6)


def test_the_installed_solver_is_the_fast_one_when_it_is_there(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: object())
    assert isinstance(installed_solver(), Rslab)
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    assert isinstance(installed_solver(), SuperLU)


def test_large_problems_without_the_fast_solver_are_warned_of(monkeypatch):
    monkeypatch.setattr(module, "LARGEST_COMFORTABLE_SUPERLU", 10)
    with pytest.warns(
        SuppleWarning, match=r"factoring 11 freedoms .* solids hours .* pip install 'supple\[fast\]'"
    ):
        factorize_symmetric(sparse.eye_array(11), solver=SuperLU())


def test_what_cannot_be_factored(solver):
    with pytest.raises(ModelError, match=r"shape \(2, 3\) cannot be factored; it must be square"):
        factorize_symmetric(np.ones((2, 3)), solver=solver)
    with pytest.raises(ModelError, match=r"shape \(0, 0\) cannot be factored"):
        factorize_symmetric(sparse.csc_array((0, 0)), solver=solver)
    with pytest.raises(ModelError, match="NaN or infinite"):
        factorize_symmetric(np.diag([1.0, np.nan]), solver=solver)
    with pytest.raises(ModelError, match="NaN or infinite"):
        factorize_general(np.diag([1.0, np.inf]), solver=solver)


@pytest.mark.parametrize("shape", [(), (3,), (3, 2), (4, 2, 1)])
def test_loads_of_the_wrong_shape(solver, shape):
    with pytest.raises(ModelError, match=r"the matrix has 4 rows, so give \(n,\) or \(n, k\)"):
        factorize_symmetric(np.eye(4), solver=solver).solve(np.ones(shape))


IN_THREADS = """
from threading import Thread
import numpy as np
from supple.algebra import Rslab, factorize_symmetric

def factor():
    solution = factorize_symmetric(2.0 * np.eye(300), solver=Rslab()).solve(np.ones(300))
    assert np.all(solution == 0.5)

for _ in range(8):
    thread = Thread(target=factor)
    thread.start()
    thread.join()
print("no thread crashed")
"""


def test_the_fast_solver_serves_threads_that_end():
    """In a new process, whose first thread that factors loads the library; the next one used to crash."""
    pytest.importorskip("rslab")
    ended = subprocess.run(python_command("-c", IN_THREADS), capture_output=True, text=True, check=False)
    assert ended.stdout == "no thread crashed\n", ended.stderr
