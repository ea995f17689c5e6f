"""The largest vector along a motion, against all vectors at all instants."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array

from supple.algebra import largest_vector as module
from supple.algebra.largest_vector import largest_vector


@pytest.mark.parametrize("n_times", [1, 2, 64, 65, 1000])
@pytest.mark.parametrize("seed", range(8))
def test_no_instant_has_a_larger_one(seed, n_times):
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(30, 4)) * [1.0, 3.0, 10.0, 100.0]
    times = np.linspace(0, 20, n_times)[:, None]
    vibrations = np.sin(times * rng.uniform(0.5, 40, size=4) + rng.uniform(0, 6, size=4))
    coordinates = vibrations * rng.normal(size=4) / [1.0, 10.0, 100.0, 1000.0]
    lengths = np.sqrt((np.reshape(coordinates @ rows.T, (n_times, -1, 3)) ** 2).sum(axis=2).max(axis=1))
    for given in (rows, csr_array(rows)):
        value, row = largest_vector(given, coordinates)
        assert value == pytest.approx(lengths.max(), rel=1e-14)
        assert row == int(np.argmax(lengths))


@pytest.mark.parametrize("seed", range(20))
def test_of_one_coordinate_the_bound_is_the_value(seed):
    """Rounding may not exclude the longest vector."""
    rng = np.random.default_rng(seed)
    rows, coordinates = rng.normal(size=(6, 1)), rng.uniform(-1, 1, size=(200, 1))
    coordinates[64] *= 1.5 / abs(coordinates[64])  # evaluated first
    value, row = largest_vector(rows, coordinates)
    assert row == int(np.argmax(np.abs(coordinates[:, 0])))
    assert value == pytest.approx(
        np.abs(coordinates).max() * np.sqrt((rows.reshape(2, 3) ** 2).sum(axis=1).max())
    )


def test_few_instants_of_a_vibration_are_looked_at(monkeypatch):
    rng = np.random.default_rng(1)
    times = np.linspace(0, 60, 3001)[:, None]
    coordinates = np.sin(times * [4.2, 12.6, 20.0]) * np.exp(-0.03 * times) / [1.0, 10.0, 20.0]
    looked = []
    own = module._lengths
    monkeypatch.setattr(module, "_lengths", lambda rows, q: looked.append(len(q)) or own(rows, q))
    largest_vector(rng.normal(size=(30, 3)), coordinates)
    assert sum(looked) < 300


def test_what_is_no_number_is_reported_as_that():
    coordinates = np.full((200, 2), np.nan)
    assert np.isnan(largest_vector(np.ones((3, 2)), coordinates)[0])
