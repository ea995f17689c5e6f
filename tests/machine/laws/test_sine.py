"""The sine of time."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from supple.errors import ModelError
from supple.machine import Sine

TIMES = np.linspace(0.0, 3.0, 31)


def test_sine_turns_frequency_times_a_second():
    np.testing.assert_allclose(
        jax.jit(jax.vmap(Sine(2.0, 0.5)))(TIMES), 2.0 * np.sin(2.0 * np.pi * 0.5 * TIMES), atol=1e-14
    )


def test_sine_of_a_vector():
    np.testing.assert_allclose(Sine([1.0, -2.0, 0.0], 0.25)(1.0), [1.0, -2.0, 0.0], atol=1e-15)


def test_numbers_are_checked():
    with pytest.raises(ModelError, match="the amplitude of a sine must be finite, got inf"):
        Sine(float("inf"), 1.0)
    with pytest.raises(ModelError, match=r"the frequency of a sine, in Hz, must be finite, got nan"):
        Sine(1.0, float("nan"))
