"""Sums of many matrices by few: what they miss, and how few suffice."""

from __future__ import annotations

import numpy as np
import pytest

from supple.error.equation.few_matrices import few_matrices

K, N = 4, 30


@pytest.fixture(scope="module")
def sums():
    """Two sets of matrices, weights that span three directions and a little more, and a unit of stiffness."""
    rng = np.random.default_rng(3)
    sets = [rng.normal(size=(N, K, K)) * np.logspace(-6, 6, N)[:, None, None] for _ in range(2)]
    weights = rng.normal(size=(200, 3)) @ rng.normal(size=(3, N)) + 1e-6 * rng.normal(size=(200, N))
    return sets, weights / np.logspace(-6, 6, N), np.linalg.inv(np.linalg.cholesky(np.diag([1, 4, 9, 25.0])))


@pytest.mark.parametrize(("missed", "number"), [(1e-3, 3), (1e-9, 30)])
def test_few_combinations_miss_no_more_than_allowed(sums, missed, number):
    sets, weights, unit = sums
    found = few_matrices(sets, weights, unit, missed)
    assert found.weights.shape == (200, number)
    left = np.zeros(200)
    for own, few in zip(sets, found.sets, strict=True):
        apart = np.tensordot(weights, own, axes=1) - np.tensordot(found.weights, few, axes=1)
        left += np.sum((unit.T @ apart @ unit) ** 2, axis=(1, 2))
    assert np.sqrt(left.max()) <= missed
    # One matrix less would miss more.
    if number == 3:
        assert np.linalg.norm(found.weights[:, 2]) > missed


def test_of_nothing_no_matrix_is_needed(sums):
    sets, weights, unit = sums
    assert few_matrices(sets, 0 * weights, unit, 1e-3).weights.shape == (200, 0)


def test_a_large_matrix_that_never_counts_hides_no_other(sums):
    sets, weights, unit = sums
    weights = np.where(np.arange(N) == N - 1, 0.0, weights)
    large = [np.where(np.arange(N)[:, None, None] == N - 1, 1e30, own) for own in sets]
    for own, few in zip(large, (found := few_matrices(large, weights, unit, 1e-6)).sets, strict=True):
        apart = np.tensordot(weights, own, axes=1) - np.tensordot(found.weights, few, axes=1)
        assert np.linalg.norm(unit.T @ apart @ unit, axis=(1, 2)).max() <= 1e-6
