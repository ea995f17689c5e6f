"""The spin-up law and its derivatives."""

import jax.numpy as jnp
import numpy as np
import pytest

from supple.errors import ModelError
from supple.machine.laws.spin_up import SpinUp
from supple_benchmarks.beam_motion import angle_history


def test_law_starts_at_rest_and_ends_at_constant_speed():
    angle, rate, acceleration = angle_history(SpinUp(6.0), np.array([0.0, 15.0, 16.0, 20.0]))
    np.testing.assert_allclose(angle, [0.0, 45.0, 51.0, 75.0], atol=1e-13)
    np.testing.assert_allclose(rate, [0.0, 6.0, 6.0, 6.0], atol=1e-13)
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-13)


def test_derivatives_are_those_of_the_formula():
    # theta' = omega/T (t - T/2pi sin(2 pi t/T)),  theta'' = omega/T (1 - cos(2 pi t/T))
    t, speed, T = np.linspace(0.0, 4.0, 9), 8.0, 4.0
    _, rate, acceleration = angle_history(SpinUp(speed, rise_time=T), t)
    np.testing.assert_allclose(
        rate, speed / T * (t - T / (2 * np.pi) * np.sin(2 * np.pi * t / T)), atol=1e-13
    )
    np.testing.assert_allclose(acceleration, speed / T * (1 - np.cos(2 * np.pi * t / T)), atol=1e-13)


def test_speed_and_rise_time_are_checked():
    with pytest.raises(ModelError, match="spin-up speed is inf"):
        SpinUp(np.inf)
    with pytest.raises(ModelError, match="rise time is 0"):
        SpinUp(6.0, rise_time=0.0)


def test_a_law_with_an_infinite_acceleration_is_refused():
    with pytest.raises(ModelError, match="not finite at t = 0 s"):
        angle_history(jnp.sqrt, np.array([0.0, 1.0]))


def test_spin_up_needs_no_floats():
    law = SpinUp(6, 15)
    assert (law.speed, law.rise_time) == (6.0, 15.0)
    assert law == SpinUp(6.0)
