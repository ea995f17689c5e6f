"""Directions in which the cases of a sweep move, and runs in them."""

from __future__ import annotations

import numpy as np
import pytest

from supple.sweeps.leading_columns import principal_directions


@pytest.fixture
def stiffness():
    """Of six columns, from soft to a million times stiffer."""
    rotated = np.linalg.qr(np.random.default_rng(2).normal(size=(6, 6)))[0]
    return rotated @ np.diag(np.logspace(0, 6, 6)) @ rotated.T


@pytest.mark.parametrize("missed", [0.5, 1e-2, 1e-4])
def test_they_miss_no_more_energy_than_is_allowed_and_one_fewer_misses_more(stiffness, missed):
    rng = np.random.default_rng(1)
    factor = np.linalg.cholesky(stiffness)
    weighed = rng.normal(size=(50, 6)) * np.logspace(0, -5, 6) @ np.linalg.qr(rng.normal(size=(6, 6)))[0]
    motions = np.linalg.solve(factor.T, weighed.T).T

    def rest(directions):
        # What is nearest in the energy norm.
        onto = np.linalg.solve(directions.T @ stiffness @ directions, directions.T @ stiffness)
        return np.linalg.norm((motions - motions @ onto.T @ directions.T) @ factor)

    found, whole = principal_directions(motions, stiffness, missed), np.linalg.norm(weighed)
    assert found.T @ found == pytest.approx(np.eye(found.shape[1]), abs=1e-12)
    assert rest(found) <= missed * whole * (1 + 1e-9)
    if found.shape[1] > 1:
        one_fewer = principal_directions(motions, stiffness, 10.0)
        assert one_fewer.shape[1] == 1
        shorter = np.linalg.svd(weighed, compute_uv=False)[found.shape[1] - 1 :]
        assert np.linalg.norm(shorter) > missed * whole


def test_small_motion_is_kept_where_it_is_stiff():
    """Of a membrane: a thousandth of the motion, and all of the energy."""
    stiffness = np.diag([1.0, 1e8])
    motions = np.array([[1.0, 1e-3], [1.0, -1e-3]])
    (direction,) = principal_directions(motions, stiffness, 0.2).T
    assert abs(direction) == pytest.approx([0.0, 1.0], abs=1e-9)
    assert principal_directions(motions, stiffness, 1e-3).shape[1] == 2
