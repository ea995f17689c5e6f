"""A vector times a law of numbers."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from supple.errors import ModelError
from supple.machine import Scaled, Sine


def test_vector_times_factor():
    vector = np.array([1.0, -2.0, 0.5])
    np.testing.assert_allclose(Scaled(vector, Sine(3.0, 0.25))(1.0), 3.0 * vector, atol=1e-15)


def test_factor_may_be_a_function_or_a_number():
    np.testing.assert_allclose(Scaled([2.0, 0.0, 0.0], jnp.square)(3.0), [18.0, 0.0, 0.0])
    np.testing.assert_allclose(Scaled([2.0, 0.0, 0.0], 4)(3.0), [8.0, 0.0, 0.0])


def test_factor_is_one_number():
    with pytest.raises(
        ModelError, match=r"the factor of a scaled law: its values over time have shape \(3,\)"
    ):
        Scaled([1.0, 0.0, 0.0], Sine([1.0, 2.0, 3.0], 1.0))


def test_vector_is_checked():
    with pytest.raises(ModelError, match="the vector of a scaled law must be finite"):
        Scaled([1.0, np.nan, 0.0], 1.0)
