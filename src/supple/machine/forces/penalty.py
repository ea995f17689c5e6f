"""Penalty force of contacts: compression only, with damping proportional to the elastic force."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import NotNegative, Positive, check_fields
from supple.errors import ModelError
from supple.machine.pose import Parameters

__all__ = ["Penalty"]


@dataclass(frozen=True, kw_only=True)
class Penalty:
    """Contact force `F = k depth^n (1 + a d depth/dt)`, never tensile.

    The force begins and ends at zero, without a jump. The speed v before an impact and the speed w after it
    satisfy, for any mass, k and n,

        v/a - ln(1 + a v)/a^2 = - w/a - ln(1 - a w)/a^2

    so the coefficient of restitution w/v is about 1 - 2 a v/3 for small a v.

    stiffness : k, force per length^n, or moment per rad^n
    exponent : n >= 1; 1.5 for two spheres (Hertz)
    dissipation : a, 1/velocity, or 1/(rad per time) for a moment
    Raises ModelError for a stiffness that is not positive, an exponent below 1, a negative dissipation.
    Source: [HuntCrossley1975]
    """

    stiffness: Positive
    exponent: float = 1.0
    dissipation: NotNegative = 0.0

    def __post_init__(self) -> None:
        check_fields(self)
        if not (np.isfinite(self.stiffness) and self.stiffness > 0):
            raise ModelError(f"a penalty's stiffness must be finite and positive, got {self.stiffness}")
        if not (np.isfinite(self.exponent) and self.exponent >= 1):
            raise ModelError(
                f"a penalty's exponent must be finite and at least 1, got {self.exponent}: below 1 the force "
                "would start with infinite stiffness"
            )
        if not (np.isfinite(self.dissipation) and self.dissipation >= 0):
            raise ModelError(f"a penalty's dissipation must be finite, not negative, got {self.dissipation}")

    @property
    def parameters(self) -> tuple[float, float, float]:
        """`(k, n, a)`."""
        return (self.stiffness, self.exponent, self.dissipation)


def penalty_force(depth: jax.Array, rate: jax.Array, parameters: Parameters) -> jax.Array:
    """`k depth^n (1 + a rate)` for a positive depth and a compressive force, else zero; rate = d depth/dt."""
    stiffness, exponent, dissipation = parameters
    touches = depth > 0
    # `where` evaluates both branches, and powers have no derivative at zero or negative depth.
    inside = jnp.where(touches, depth, 1.0)
    push = stiffness * inside**exponent * jnp.maximum(1 + dissipation * rate, 0.0)
    return jnp.where(touches, push, 0.0)


def penalty_energy(depth: jax.Array, parameters: Parameters) -> jax.Array:
    """`k depth^(n + 1) / (n + 1)` for a positive depth, else zero."""
    stiffness, exponent, _ = parameters
    touches = depth > 0
    inside = jnp.where(touches, depth, 1.0)
    return jnp.where(touches, stiffness * inside ** (exponent + 1) / (exponent + 1), 0.0)
