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
    update = LowRankUpdate(factorize_general(sparse.csc_array(matrix)), columns, 0.7)
    expected = np.linalg.solve(matrix.toarray() + 0.7 * columns @ columns.T, b)
    np.testing.assert_allclose(update.solve(b), expected, rtol=1e-9)
    np.testing.assert_allclose(update.solve(b[:, 0]), expected[:, 0], rtol=1e-9)
