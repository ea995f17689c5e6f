"""Elimination of a bordering column against the residual of what it solves."""

from __future__ import annotations

import jax
import numpy as np

from supple.multibody.compiled.elimination import solve_bordering_column


def saddle(rng, n, m):
    """A bordered matrix, whose zero corner makes row exchanges necessary, and a load."""
    matrix = rng.standard_normal((n + m, n + m))
    matrix[n:, n:] = 0
    return matrix, rng.standard_normal(n + m)


def test_solution_has_no_residual():
    matrix, load = saddle(np.random.default_rng(1), 7, 4)
    solution = solve_bordering_column(np.column_stack([matrix, load]))
    np.testing.assert_allclose(matrix @ solution, load, atol=1e-13)


def test_rows_are_exchanged_where_the_diagonal_is_zero():
    matrix = np.array([[0.0, 2.0], [4.0, 0.0]])
    np.testing.assert_allclose(solve_bordering_column(np.column_stack([matrix, [6.0, 8.0]])), [2.0, 3.0])


def test_cases_can_be_mapped_over():
    rng = np.random.default_rng(3)
    systems = [saddle(rng, 5, 2) for _ in range(3)]
    solutions = jax.vmap(solve_bordering_column)(np.stack([np.column_stack(s) for s in systems]))
    for (matrix, load), solution in zip(systems, solutions, strict=True):
        np.testing.assert_allclose(matrix @ solution, load, atol=1e-12)
