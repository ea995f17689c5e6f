"""Internal force and damping of reduced bodies, as a term of the equations."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from supple.integrate import StepFactors
from supple.multibody.equations.floating_inertia import FloatingState
from supple.multibody.equations.model import BodyGroup
from supple.multibody.equations.places import over
from supple.multibody.equations.polynomial_force import polynomial_force

__all__ = ["force", "tangent"]


def force(group: BodyGroup, states: FloatingState) -> tuple[jax.Array, jax.Array]:
    """`(0, f(g) + D dg/dt)` of every body, (k, 6 + r), and the tangent stiffness, (k, r, r)."""

    def of_body(stiffness, tensors, damping, coordinates, rates):
        cubic, quartic = tensors
        elastic, tangent_stiffness = polynomial_force(stiffness, cubic, quartic, coordinates)
        return jnp.concatenate([jnp.zeros(6), elastic + damping @ rates]), tangent_stiffness

    return over(
        of_body,
        group.stiffness,
        (group.cubic, group.quartic),
        group.damping,
        states.coordinates,
        states.rates,
    )


def tangent(group: BodyGroup, stiffness: jax.Array, factors: StepFactors) -> jax.Array:
    """Derivative of the internal forces for the new accelerations of the coordinates, (k, r, r)."""
    return factors.by_position * stiffness + factors.by_velocity * group.damping
