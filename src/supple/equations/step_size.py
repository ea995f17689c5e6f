"""Step sizes from local errors, and the rounding error of a position."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray


def position_rounding(length: AnyArray, origins: AnyArray) -> AnyArray:
    """Rounding error of positions, relative to the system's `length`.

    Far from the global origin, positions have fewer significant digits for small changes.
    """
    of: Any = np if isinstance(origins, np.ndarray) else jnp  # NumPy needs no compilation
    return 1e-13 * of.maximum(1.0, of.max(of.abs(origins)) / length)


def at_rounding(length: AnyArray, origins: AnyArray, gap: AnyArray, before: AnyArray) -> AnyArray:
    """Whether a largest gap of the joints is rounding; `before` is that of the iterate before.

    Further iterations remove remaining rounding errors, until there is no improvement.
    """
    rounding = length * position_rounding(length, origins)
    return (gap <= 0.01 * rounding) | ((gap <= rounding) & (gap > 0.1 * before))


@jax.jit
def next_step(
    h: jax.Array | float,
    intended: jax.Array | float,
    error: jax.Array | float,
    tolerance: jax.Array | float,
    largest: jax.Array | float,
) -> jax.Array:
    """Step size after a converged step of size `h` whose local error, of third order, was `error`.

    Every change of the step excites the integrator's spurious roots, which look like errors: the step grows
    only if it can grow by half. Growth is relative to the `intended` step, so that a step shortened to end at
    an output time does not shorten later ones.
    """
    ratio = jnp.where(error > 0, tolerance / jnp.where(error > 0, error, 1.0), jnp.inf)
    best = 0.9 * h * ratio ** (1 / 3)
    steady = (error <= tolerance) & (best < 1.5 * intended)
    best = jnp.where(steady, jnp.minimum(best, intended), best)
    return jnp.clip(best, 0.2 * h, jnp.minimum(2 * jnp.maximum(h, intended), largest))
