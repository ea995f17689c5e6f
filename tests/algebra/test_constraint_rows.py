from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from supple.algebra.constrained_solve import dense_rows
from supple.errors import ModelError


def test_rows_are_dense_and_read_only():
    rows = np.arange(6.0).reshape(2, 3)
    for given in (rows, rows.tolist(), sparse.csr_array(rows)):
        result = dense_rows(given, 3)
        np.testing.assert_array_equal(result, rows)
        with pytest.raises(ValueError, match="read-only"):
            result[0, 0] = 1
    assert dense_rows(None, 3).shape == (0, 3)


def test_rows_of_the_wrong_length_or_not_finite():
    with pytest.raises(ModelError, match=r"shape \(2, 3\); give \(m, n\) with n = 4"):
        dense_rows(np.ones((2, 3)), 4)
    with pytest.raises(ModelError, match="NaN or infinite"):
        dense_rows(np.array([[1.0, np.nan]]), 2)
