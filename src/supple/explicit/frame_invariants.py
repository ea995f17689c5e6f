"""Momentum and energy of a frame over a step: what free flight must keep."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from supple.explicit.frame_model import FrameModel, FrameState
from supple.explicit.frame_moments import arms, spread

__all__ = ["angular_momentum", "kinetic_energy", "linear_momentum", "strain_energy"]


def _moved(model: FrameModel, state: FrameState) -> tuple[Array, Array, Array]:
    """The frame at the step's start, and sum m xi_a (x_n - x_n-1) (4, 3) there."""
    p, y = state.p - state.dp, state.y - state.dy
    sums = spread(model.moments, y)
    momentum = sums.Xi @ state.dp + (sums.Q @ state.dy) @ (arms(p) + arms(state.dp)).T
    return p, y, momentum


def linear_momentum(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """Sum m (x_n - x_n-1) / h, (3,)."""
    return _moved(model, state)[2].sum(axis=0) / h


def angular_momentum(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """Sum m x_n-1 x (x_n - x_n-1) / h about the origin of space, (3,)."""
    p, _, momentum = _moved(model, state)
    return jnp.cross(p, momentum).sum(axis=0) / h


def kinetic_energy(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """1/2 sum m |x_n - x_n-1|^2 / h^2."""
    p, y = state.p - state.dp, state.y - state.dy
    dp, dy = state.dp, state.dy
    sums = spread(model.moments, y)
    both = arms(p) + arms(dp)
    Q = sums.Q @ dy
    C = jnp.einsum("k,ijkl,l->ij", dy, model.moments.C, dy)
    twice = jnp.sum(dp * (sums.Xi @ dp)) + 2 * jnp.sum((Q @ both.T) * dp) + jnp.sum((both.T @ both) * C)
    return 0.5 * twice / h**2


def strain_energy(model: FrameModel, state: FrameState) -> Array:
    """1/2 y_n-1 . K y_n, which leap-frog keeps with the kinetic energy of the step."""
    return 0.5 * (state.y - state.dy) @ (model.stiffness @ state.y)
