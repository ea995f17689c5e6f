from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.reduction import CraigBamptonFamily, KnownEigenvalues, count_eigenvalues

N = 8


@pytest.fixture(scope="module")
def reduced(solid_body, mean_axis, lowest_squares):
    """Eigenvalues of a reduced body, and their exact errors."""
    family = CraigBamptonFamily(solid_body)
    exact = KnownEigenvalues(lowest_squares(solid_body, mean_axis, N))
    return family.vibrations(14, N).values, family.errors(14, N, exact)


def test_a_true_claim_is_proven(solid_body, reduced):
    values, errors = reduced
    groups = count_eigenvalues(solid_body, values, 1.001 * errors.max())
    assert all(group.proven for group in groups)
    assert [group.first for group in groups] == [1, *(group.last + 1 for group in groups[:-1])]
    assert groups[-1].last == N


def test_a_false_claim_is_found_at_the_eigenvalue_that_breaks_it(solid_body, reduced):
    values, errors = reduced
    worst = int(np.argmax(errors)) + 1
    others = np.delete(errors, worst - 1).max()
    groups = count_eigenvalues(solid_body, values, max(0.99 * errors.max(), 1.001 * others))
    assert [(group.first, group.last) for group in groups if not group.proven] == [(worst, worst)]


def test_close_eigenvalues_share_a_count_until_it_objects(solid_body, mean_axis, lowest_squares, reduced):
    wide = count_eigenvalues(solid_body, reduced[0], 3.0)
    assert len(wide) < N
    assert all(group.proven for group in wide)
    # Both values are right, but that of the second, a quarter of it, lies above the first eigenvalue.
    first = lowest_squares(solid_body, mean_axis, 1)[0]
    groups = count_eigenvalues(solid_body, [3.96 * first, 4.6 * first], 3.0)
    assert [(group.first, group.last, group.counted) for group in groups] == [(1, 1, 0), (2, 2, 1)]
    assert all(group.proven for group in groups)


@pytest.mark.parametrize(
    ("values", "tolerance"), [([2.0, 1.0], 0.1), ([0.0, 1.0], 0.1), ([1.0, 2.0], 0.0), ([[1.0]], 0.1)]
)
def test_values_that_cannot_be_counted(solid_body, values, tolerance):
    with pytest.raises(ModelError, match="positive, ascending eigenvalues"):
        count_eigenvalues(solid_body, values, tolerance)
