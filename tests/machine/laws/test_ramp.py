"""The smooth ramp."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from supple.errors import ModelError
from supple.machine import Ramp


def test_ramp_follows_its_polynomial():
    s = np.linspace(0.0, 1.0, 11)
    expected = 4.0 * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)
    np.testing.assert_allclose(jax.jit(jax.vmap(Ramp(4.0, 2.0)))(2.0 * s), expected, atol=1e-14)


def test_ramp_is_at_rest_before_and_after():
    ramp = Ramp(4.0, 2.0)
    assert [float(ramp(time)) for time in (-1.0, 0.0, 2.0, 9.0)] == [0.0, 0.0, 4.0, 4.0]
    for derivative in (jax.jit(jax.grad(ramp)), jax.jit(jax.grad(jax.grad(ramp)))):
        for time in (-1.0, 0.0, 2.0, 9.0):
            assert float(derivative(time)) == pytest.approx(0.0, abs=1e-12)


def test_ramp_of_a_vector():
    np.testing.assert_allclose(Ramp([1.0, -2.0, 0.0], 2.0)(1.0), [0.5, -1.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("duration", [0.0, -1.0, np.inf, np.nan])
def test_duration_is_checked(duration):
    with pytest.raises(ModelError, match=r"the duration of a ramp, in s, must be finite and positive, got"):
        Ramp(1.0, duration)


def test_value_is_checked():
    with pytest.raises(ModelError, match="the value of a ramp must be finite, got nan"):
        Ramp(float("nan"), 1.0)
