"""Elimination of small dense systems, by LAPACK and by loops, against the residual of what it solves."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from supple.methods.floating.compiled.elimination import ByLapack, ByLoops

BOTH = pytest.mark.parametrize("elimination", [ByLapack(), ByLoops()], ids=["by LAPACK", "by loops"])


def solution_of(elimination, augmented):
    return jax.jit(elimination.solution)(augmented)


def inverse_of(elimination, matrix):
    return jax.jit(elimination.inverse)(matrix)


def saddle(rng, n, m):
    """A bordered matrix, whose zero corner makes row exchanges necessary, and a load."""
    matrix = rng.standard_normal((n + m, n + m))
    matrix[n:, n:] = 0
    return matrix, rng.standard_normal(n + m)


@BOTH
@pytest.mark.parametrize(("n", "m"), [(1, 0), (7, 4), (24, 12), (60, 6)])
def test_solution_has_no_residual(elimination, n, m):
    matrix, load = saddle(np.random.default_rng(1), n, m)
    solution = solution_of(elimination, np.column_stack([matrix, load]))
    np.testing.assert_allclose(matrix @ solution, load, atol=1e-11)


@BOTH
@pytest.mark.parametrize(("n", "m"), [(1, 0), (7, 4), (24, 12), (60, 6)])
def test_inverse_is_one_from_either_side(elimination, n, m):
    matrix, _ = saddle(np.random.default_rng(2), n, m)
    inverse = np.asarray(inverse_of(elimination, matrix))
    size = np.linalg.norm(inverse, 2) * np.linalg.norm(matrix, 2)
    np.testing.assert_allclose(matrix @ inverse, np.eye(n + m), rtol=0, atol=1e-14 * size)
    np.testing.assert_allclose(inverse @ matrix, np.eye(n + m), rtol=0, atol=1e-14 * size)


@BOTH
def test_other_devices_solve_and_invert_square_matrices_for_many_cases(elimination, monkeypatch):
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    rng = np.random.default_rng(3)
    matrices, loads = (np.stack(each) for each in zip(*(saddle(rng, 7, 4) for _ in range(5)), strict=True))
    augmented = np.concatenate([matrices, loads[:, :, None]], axis=2)
    text = jax.jit(jax.vmap(elimination.solution)).lower(augmented).as_text()
    assert "11x12xf64>" not in text.partition("getrf")[2].partition("\n")[0]
    solutions = jax.jit(jax.vmap(elimination.solution))(augmented)
    np.testing.assert_allclose(np.einsum("cij,cj->ci", matrices, solutions), loads, atol=1e-11)
    inverses = np.asarray(jax.jit(jax.vmap(elimination.inverse))(matrices))
    np.testing.assert_allclose(matrices @ inverses, np.broadcast_to(np.eye(11), matrices.shape), atol=1e-10)


@BOTH
@pytest.mark.parametrize("n", [9, 23, 31, 46])
def test_inverse_of_a_body_in_unlike_units_is_right_in_every_unit(elimination, n):
    """Rows and columns of 18 powers of ten, as of translations beside modal coordinates."""
    rng = np.random.default_rng(6)
    like = rng.standard_normal((n, n))
    like = like @ like.T + n * np.eye(n) + np.triu(rng.standard_normal((n, n)), 1)
    units = 10.0 ** rng.uniform(-9, 9, n)
    inverse = np.asarray(inverse_of(elimination, units[:, None] * like * units))
    np.testing.assert_allclose(units[:, None] * inverse * units @ like, np.eye(n), rtol=0, atol=1e-11)


@BOTH
def test_rows_are_exchanged_where_the_diagonal_is_zero(elimination):
    matrix = np.array([[0.0, 2.0, 0.0], [0.0, 0.0, 5.0], [4.0, 0.0, 0.0]])
    np.testing.assert_allclose(
        solution_of(elimination, np.column_stack([matrix, [6.0, 5.0, 8.0]])), [2.0, 3.0, 1.0]
    )
    np.testing.assert_allclose(inverse_of(elimination, matrix), np.linalg.inv(matrix))


@BOTH
def test_rows_are_exchanged_where_a_pivot_is_small(elimination):
    """Without, the first row would be lost in the second, 1e20 times as large."""
    matrix, load = np.array([[1e-20, 1.0], [1.0, 1.0]]), np.array([1.0, 2.0])
    np.testing.assert_allclose(solution_of(elimination, np.column_stack([matrix, load])), [1.0, 1.0])
    np.testing.assert_allclose(inverse_of(elimination, matrix), np.linalg.inv(matrix))


@BOTH
def test_rows_of_unlike_size(elimination):
    """Those of a machine in other units: a residual of rounding in each."""
    matrix, load = saddle(np.random.default_rng(4), 9, 3)
    rows = 10.0 ** np.linspace(-9, 9, 12)
    solution = solution_of(elimination, np.column_stack([rows[:, None] * matrix, rows * load]))
    np.testing.assert_allclose(matrix @ solution, load, atol=1e-9)


@BOTH
def test_a_singular_matrix_has_no_finite_solution(elimination):
    singular = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0]])
    assert not np.isfinite(solution_of(elimination, np.column_stack([singular, [1.0, 0.0, 1.0]]))).all()
    assert not np.isfinite(inverse_of(elimination, singular)).all()


@BOTH
def test_what_is_not_a_number_stays_so(elimination):
    matrix, load = saddle(np.random.default_rng(5), 4, 2)
    matrix[2, 1] = np.nan
    assert not np.isfinite(solution_of(elimination, np.column_stack([matrix, load]))).all()
    assert not np.isfinite(inverse_of(elimination, matrix)).all()


@BOTH
def test_cases_can_be_mapped_over(elimination):
    rng = np.random.default_rng(3)
    systems = [saddle(rng, 5, 2) for _ in range(3)]
    solutions = jax.jit(jax.vmap(elimination.solution))(np.stack([np.column_stack(s) for s in systems]))
    inverses = jax.jit(jax.vmap(elimination.inverse))(np.stack([matrix for matrix, _ in systems]))
    for (matrix, load), solution, inverse in zip(systems, solutions, inverses, strict=True):
        np.testing.assert_allclose(matrix @ solution, load, atol=1e-12)
        np.testing.assert_allclose(inverse @ load, solution, atol=1e-11)


def test_loops_leave_the_program_no_call(saddle_program):
    """Of a library: with one, XLA would go through a march operation by operation."""
    assert "custom-call" in saddle_program(ByLapack())
    assert "custom-call" not in saddle_program(ByLoops())
    assert "custom-call" in saddle_program(ByLoops(largest=8))


@pytest.fixture
def saddle_program():
    augmented = jax.ShapeDtypeStruct((9, 10), float)
    return lambda elimination: jax.jit(elimination.solution).lower(augmented).compile().as_text()
