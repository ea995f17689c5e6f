"""Intrinsic lines of few modes beside closed forms: statics, spinning, roll-up, momentum."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.intrinsic import IntrinsicBody
from supple.intrinsic.line_equations import RootTwist, line_rates

Array = NDArray[np.float64]


def spinning_frequencies(body: IntrinsicBody, speed: float) -> Array:
    """Frequencies (m,) of a clamped body about its state at rest in axes that turn about z, rad/s."""
    model = body.model
    n = model.velocities.shape[1]
    root = RootTwist(jnp.array([0.0, 0, 0, 0, 0, speed]), jnp.zeros(6))

    def rates(state: jax.Array) -> jax.Array:
        return jnp.concatenate(line_rates(model, state[:n], state[n:], None, root))

    slope = jax.jit(jax.jacfwd(rates))
    state = jnp.zeros(n + model.omega.shape[0])
    for _ in range(10):
        change = np.linalg.solve(slope(state), rates(state))
        state = state - change
        if np.linalg.norm(change) <= 1e-10 * np.linalg.norm(state):
            break
    values = np.linalg.eigvals(np.asarray(slope(state)))
    return np.sort(values.imag[values.imag > 0])
