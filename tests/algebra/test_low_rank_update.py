"""A factored matrix plus a product of few columns, beside the dense sum."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from supple.algebra.low_rank_update import LowRankUpdate
from supple.algebra.sparse_factor import factorize_general


@pytest.mark.parametrize("loads", [1, 3])
def test_it_solves_the_sum(loads):
    rng = np.random.default_rng(0)
    matrix = sparse.random_array((30, 30), density=0.1, rng=rng) + 5 * sparse.eye_array(30)
    columns, b = rng.standard_normal((30, 4)), rng.standard_normal((30, loads))
    weights = np.array([0.7, -0.2, 0.3, -0.5])
    update = LowRankUpdate(factorize_general(sparse.csc_array(matrix)), columns, weights)
    expected = np.linalg.solve(matrix.toarray() + columns @ np.diag(weights) @ columns.T, b)
    np.testing.assert_allclose(update.solve(b), expected, rtol=1e-9)
    np.testing.assert_allclose(update.solve(b[:, 0]), expected[:, 0], rtol=1e-9)
