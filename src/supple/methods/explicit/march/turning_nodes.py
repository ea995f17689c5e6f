"""Triads at the nodes of shells: their rotation in a step, with its work and damping."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array


class Spins(NamedTuple):
    """Constants of r triads.

    inertia, alpha : (r,) kg m^2 and 1/s;   free : (3, r) 1, or 0 about a fixed axis
    """

    inertia: Array
    alpha: Array
    free: Array


class TriadState(NamedTuple):
    """State of r triads.

    triads : (3, 3, r) rotations since the start, at t_n
    rates : (3, r) angular velocities in space over the step before, rad/s;   moments : (3, r) at t_n, N m
    """

    triads: Array
    rates: Array
    moments: Array


def turned(spins: Spins, state: TriadState, mean: Array, h: Array) -> tuple[TriadState, Array, Array]:
    """Triads after a step h, the work of the moments, and the energy lost by damping, J.

    J w' = m in space, since the inertia is equal about all axes: angular momentum is conserved exactly.
    """
    drag = 0.5 * mean * spins.alpha
    rates = spins.free * ((1 - drag) * state.rates + mean * state.moments / spins.inertia) / (1 + drag)
    middle = 0.5 * (state.rates + rates)
    work = mean * jnp.sum(state.moments * middle)
    lost = mean * jnp.sum(spins.alpha * spins.inertia * middle**2)
    return TriadState(_turned(h * rates, state.triads), rates, state.moments), work, lost


def _turned(angle: Array, triads: Array) -> Array:
    """Triads multiplied by exp(angle), by Rodrigues' formula."""
    square = (angle * angle).sum(axis=0)
    safe = jnp.where(square > 1e-16, square, 1.0)
    size = jnp.sqrt(safe)
    small = square <= 1e-16
    first = jnp.where(small, 1 - square / 6, jnp.sin(size) / size)
    second = jnp.where(small, 0.5 - square / 24, (1 - jnp.cos(size)) / safe)
    once = jnp.cross(angle[:, None], triads, axis=0)
    return triads + first * once + second * jnp.cross(angle[:, None], once, axis=0)
