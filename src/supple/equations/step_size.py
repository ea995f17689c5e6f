"""Step sizes from local errors, and what counts as a rounding error of a position."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

__all__ = ["next_step", "position_rounding"]


def position_rounding(length: Any, origins: Any) -> Any:
    """Change of position, in parts of the system's `length`, that arithmetic cannot tell from none.

    Far from the global origin, positions themselves have fewer digits after the point.
    """
    of: Any = np if isinstance(origins, np.ndarray) else jnp  # NumPy compiles nothing
    return 1e-13 * of.maximum(1.0, of.max(of.abs(origins)) / length)


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
    only when it can by half. And a step shortened to meet an output time is no reason to go on with short
    ones: it is measured against the step that was `intended`.
    """
    ratio = jnp.where(error > 0, tolerance / jnp.where(error > 0, error, 1.0), jnp.inf)
    best = 0.9 * h * ratio ** (1 / 3)
    steady = (error <= tolerance) & (best < 1.5 * intended)
    best = jnp.where(steady, jnp.minimum(best, intended), best)
    return jnp.clip(best, 0.2 * h, jnp.minimum(2 * jnp.maximum(h, intended), largest))
