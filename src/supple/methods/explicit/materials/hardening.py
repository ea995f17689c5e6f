"""Isotropic hardening: yield stress as a function of equivalent plastic strain."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Protocol

import jax.numpy as jnp
from jax import Array

from supple.errors import ModelError

__all__ = ["Hardening", "LinearHardening", "PowerHardening"]


class Hardening(Protocol):
    """A hardening curve; frozen and hashable."""

    def yield_stress(self, strain: Array) -> Array:
        """Yield stress at an equivalent plastic strain, Pa."""
        ...

    def multiplier(self, trial: Array, strain: Array, three_mu: float) -> Array:
        """Increment d >= 0 of the plastic strain with trial - 3 mu d = yield_stress(strain + d)."""
        ...


@dataclass(frozen=True)
class LinearHardening:
    """sigma_y = initial + modulus eps_p.

    initial, modulus : Pa
    Raises ModelError for an initial yield stress that is not positive, or softening.
    """

    initial: float
    modulus: float = 0.0

    def __post_init__(self) -> None:
        _check(self.initial, self.modulus)

    def yield_stress(self, strain: Array) -> Array:
        """Yield stress at an equivalent plastic strain, Pa."""
        return self.initial + self.modulus * strain

    def multiplier(self, trial: Array, strain: Array, three_mu: float) -> Array:
        """Plastic strain increment, exact: (trial - sigma_y) / (3 mu + modulus)."""
        return jnp.maximum(trial - self.yield_stress(strain), 0.0) / (three_mu + self.modulus)


@dataclass(frozen=True)
class PowerHardening:
    """sigma_y = initial + factor eps_p^exponent: Ludwik, or Johnson-Cook at one strain rate.

    initial, factor : Pa;   exponent in (0, 1]
    Raises ModelError for an exponent outside this range, and as `LinearHardening`.
    """

    initial: float
    factor: float
    exponent: float

    def __post_init__(self) -> None:
        _check(self.initial, self.factor)
        if not 0 < self.exponent <= 1:
            raise ModelError(f"the exponent of power hardening must lie in (0, 1], got {self.exponent}")

    def yield_stress(self, strain: Array) -> Array:
        """Yield stress at an equivalent plastic strain, Pa."""
        return self.initial + self.factor * jnp.maximum(strain, 0.0) ** self.exponent

    def multiplier(self, trial: Array, strain: Array, three_mu: float) -> Array:
        """Plastic strain increment by 12 bisections and 4 Newton steps.

        The bisection starts between 0 and the increment without hardening.
        """
        excess = jnp.maximum(trial - self.yield_stress(strain), 0.0)
        low, high = jnp.zeros_like(excess), excess / three_mu
        for _ in range(12):
            middle = 0.5 * (low + high)
            over = trial - three_mu * middle > self.yield_stress(strain + middle)
            low, high = jnp.where(over, middle, low), jnp.where(over, high, middle)
        d = 0.5 * (low + high)
        for _ in range(4):
            at = jnp.maximum(strain + d, 1e-30)
            slope = self.factor * self.exponent * at ** (self.exponent - 1)
            d = jnp.clip(d + (trial - three_mu * d - self.yield_stress(at)) / (three_mu + slope), low, high)
        return jnp.where(excess > 0, d, 0.0)


def _check(initial: float, growth: float) -> None:
    if not (isfinite(initial) and initial > 0):
        raise ModelError(f"the initial yield stress must be positive and finite, got {initial}")
    if not (isfinite(growth) and growth >= 0):
        raise ModelError(
            f"hardening must not be negative, got {growth}: results with softening depend on the mesh; give "
            "0 or more"
        )
