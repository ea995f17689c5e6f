"""Sample times at which residuals are evaluated."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import RigidBody
from supple.error.sample_times import load_peaks, stratified_samples
from supple.machine import At, FollowerForce, Placed, System, Table


@pytest.mark.parametrize("seed", range(5))
def test_one_instant_falls_in_each_interval(seed):
    rows = stratified_samples(1001, 50, seed)
    assert len(rows) == 50
    np.testing.assert_array_equal((rows - 1) * 50 // 1000, np.arange(50))


def test_the_start_is_never_looked_at_and_few_times_are_looked_at_once():
    np.testing.assert_array_equal(stratified_samples(3, 50, 0), [1, 2])


def test_draws_differ_but_repeat():
    np.testing.assert_array_equal(stratified_samples(1001, 20, 3), stratified_samples(1001, 20, 3))
    assert (stratified_samples(1001, 20, 3) != stratified_samples(1001, 20, 4)).any()


def test_a_blow_between_the_intervals_is_met():
    """A blow of 0.02 s in 10 s: where it begins, is largest, and ends."""
    body = RigidBody("lump", 1.0, [0, 0, 0], np.eye(3), {"eye": [0, 0, 0]})
    blow = Table([0.0, 3.11, 3.12, 3.13, 10.0], [[0, 0, 0.0]] * 2 + [[0, 0, 5.0]] + [[0, 0, 0.0]] * 2)
    system = System((Placed(body),), (), (FollowerForce(first=At("lump", "eye"), force=blow),))
    times = np.linspace(0, 10, 1001)
    found = times[load_peaks(system, times)]
    for instant in (3.11, 3.12, 3.13):
        assert np.abs(found - instant).min() < 1e-9
