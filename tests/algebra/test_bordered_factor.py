"""Bordered factors against the dense solution of the same equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from supple.algebra.bordered_factor import bordered_factor
from supple.errors import AccuracyError

N, M, W = 40, 5, 2
INTERIOR = np.setdiff1d(np.arange(N), [0, 7, 8, 30])


@pytest.fixture(scope="module")
def system():
    rng = np.random.default_rng(3)
    matrix = sparse.random_array((N, N), density=0.1, rng=rng) + 10 * sparse.eye_array(N)
    matrix = matrix + 0.5 * matrix.T  # of symmetric pattern, not symmetric
    return sparse.csr_array(matrix), sparse.csr_array(rng.normal(size=(M, N))), rng.normal(size=(N, W))


@pytest.mark.parametrize("weights", [None, np.array([3.0, -1.5])])
@pytest.mark.parametrize("symmetric", [False, True])
def test_the_solution_is_that_of_the_dense_equations(system, weights, symmetric):
    matrix, constraint, columns = system
    matrix = sparse.csr_array(matrix + matrix.T) if symmetric else matrix
    rng = np.random.default_rng(4)
    loads, gaps = rng.normal(size=(N, 3)), rng.normal(size=(M, 3))
    dense = matrix.toarray()
    if weights is not None:
        dense = dense + columns @ np.diag(weights) @ columns.T
    rows = constraint.toarray()
    whole = np.block([[dense, rows.T], [rows, np.zeros((M, M))]])
    expected = np.linalg.solve(whole, np.vstack([loads, gaps]))[:N]
    found = bordered_factor(matrix, constraint, INTERIOR, columns, weights).solve(loads, gaps)
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-12)


def test_equations_of_any_units_are_solved(system):
    """Rows and columns scaled by twelve orders of magnitude, as metres and radians may be."""
    matrix, constraint, _ = system
    sizes = np.logspace(-6, 6, N)
    scaled = sparse.csr_array(sparse.diags_array(sizes) @ matrix @ sparse.diags_array(sizes))
    rows = sparse.csr_array(constraint @ sparse.diags_array(sizes))
    loads = np.random.default_rng(5).normal(size=(N, 2))
    expected = bordered_factor(matrix, constraint, INTERIOR).solve(loads)
    found = sizes[:, None] * bordered_factor(scaled, rows, INTERIOR).solve(sizes[:, None] * loads)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_constraints_that_repeat_are_refused(system):
    matrix, constraint, _ = system
    twice = sparse.csr_array(sparse.vstack([constraint, constraint[:1]]))
    with pytest.raises(AccuracyError, match="singular"):
        bordered_factor(matrix, twice, INTERIOR)


def test_a_pivot_of_exactly_zero_is_refused(system):
    """A constraint of nothing: no rounding stands between the elimination and a division by zero."""
    matrix, constraint, _ = system
    nothing = sparse.csr_array(sparse.vstack([constraint, sparse.csr_array((1, N))]))
    with pytest.raises(AccuracyError, match="pivot of zero"):
        bordered_factor(matrix, nothing, INTERIOR)
