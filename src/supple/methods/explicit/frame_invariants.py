"""Momentum and energy of a frame over a step, which are invariant in free flight."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.frame_model import FrameModel, FrameState
from supple.methods.explicit.frame_moments import arms, spread

__all__ = ["angular_momentum", "linear_momentum", "step_kinetic_energy", "strain_energy"]


def _moved(model: FrameModel, state: FrameState, h: Array | float) -> tuple[Array, Array, Array]:
    """Points and modes at t_n-1, the start of the step, and sum m xi_a (x_n - x_n-1) / h, (4, 3)."""
    p, y = state.p - h * state.vp, state.y - h * state.vy
    sums = spread(model.moments, y)
    momentum = sums.Xi @ state.vp + (sums.Q @ state.vy) @ arms(state.p).T
    return p, y, momentum


def linear_momentum(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """Sum m (x_n - x_n-1) / h, (3,)."""
    return _moved(model, state, h)[2].sum(axis=0)


def angular_momentum(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """Sum m x_n-1 x (x_n - x_n-1) / h about the origin of space, (3,)."""
    p, _, momentum = _moved(model, state, h)
    return jnp.cross(p, momentum).sum(axis=0)


def step_kinetic_energy(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """1/2 sum m |x_n - x_n-1|^2 / h^2."""
    vp, vy = state.vp, state.vy
    sums = spread(model.moments, state.y - h * vy)
    P = arms(state.p)
    C = jnp.einsum("k,ijkl,l->ij", vy, model.moments.C, vy)
    twice = jnp.sum(vp * (sums.Xi @ vp)) + 2 * jnp.sum(((sums.Q @ vy) @ P.T) * vp) + jnp.sum((P.T @ P) * C)
    return 0.5 * twice


def strain_energy(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """1/2 y_n-1 . K y_n, which leap-frog conserves together with the kinetic energy of the step."""
    return 0.5 * (state.y - h * state.vy) @ (model.stiffness @ state.y)
