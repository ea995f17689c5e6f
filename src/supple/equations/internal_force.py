"""Internal force and damping of reduced bodies, as a term of the equations."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.equations.floating_inertia import FloatingState
from supple.equations.machine_model import BodyGroup
from supple.equations.places import over
from supple.equations.polynomial_force import polynomial_damping, polynomial_force
from supple.integrate import StepFactors


class InternalMatrices(NamedTuple):
    """Data of the tangent from the force, (k, r, r) each."""

    stiffness: jax.Array
    """Tangents of the elastic forces"""
    damping: jax.Array
    """D(g)"""


def force(group: BodyGroup, states: FloatingState) -> tuple[jax.Array, InternalMatrices]:
    """`(0, f(g) + D(g) dg/dt)` of every body, (k, 6 + r), and the matrices of its tangent."""

    def of_body(stiffness, tensors, undeformed, gained, coordinates, rates):
        (cubic, quartic), (damping_cubic, damping_quartic) = tensors, gained
        elastic, tangent_stiffness = polynomial_force(stiffness, cubic, quartic, coordinates)
        present = polynomial_damping(undeformed, damping_cubic, damping_quartic, coordinates)
        force = jnp.concatenate([jnp.zeros(6), elastic + present @ rates])
        return force, InternalMatrices(tangent_stiffness, present)

    return over(
        of_body,
        group.stiffness,
        (group.cubic, group.quartic),
        group.damping,
        (group.damping_cubic, group.damping_quartic),
        states.coordinates,
        states.rates,
    )


def tangent(matrices: InternalMatrices, factors: StepFactors) -> jax.Array:
    """Derivative of the internal forces with respect to the coordinates' new accelerations, (k, r, r).

    The change of D(g) with g is neglected: damping is small compared with the elastic force, and Newton's
    iteration converges as fast as with this term.
    """
    return factors.by_position * matrices.stiffness + factors.by_velocity * matrices.damping
