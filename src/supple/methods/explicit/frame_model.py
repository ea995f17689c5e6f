"""Four-point frame with its modes as arrays for compiled code, and its state."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from supple.methods.explicit.frame_moments import Moments, Spread, arms, spread
from supple.methods.explicit.frame_points import CORNERS, LINKS
from supple.methods.explicit.spin_stiffness import spin_products

# NumPy, not JAX: a process that has only imported this module may still fork.
_SIGNS = np.eye(4)[LINKS[:, 0]] - np.eye(4)[LINKS[:, 1]]


class FrameModel(NamedTuple):
    """Arrays of a modal sub-domain; its modes are mass-normalised: arm^2 sum_i C_ii = I.

    moments : Moments
    stiffness : (k, k)          K_L, 1/s^2
    squared_lengths : (6,)      squared lengths of the links, m^2
    mass_damping, stiffness_damping : alpha (1/s) and beta (s) of the modes; the frame is undamped
    spin_stiffness : (6, k, k)  stiffness per product of two angular velocities (`PAIRS`), or None
    """

    moments: Moments
    stiffness: Array
    squared_lengths: Array
    mass_damping: Array
    stiffness_damping: Array
    spin_stiffness: Array | None = None


class FrameState(NamedTuple):
    """State of a frame at t_n, with its mean rates over the previous step (at the start: the initial rates).

    p : (4, 3) m;   y : (k,);   vp : (4, 3) m/s;   vy : (k,)
    """

    p: Array
    y: Array
    vp: Array
    vy: Array


class StepLengths(NamedTuple):
    """Lengths of the steps before t_n (zero at the start) and after t_n, s."""

    before: Array | float
    after: Array | float

    @property
    def mean(self) -> Array | float:
        """Time over which a force at t_n acts: half a step at the start."""
        return 0.5 * (self.before + self.after)


class Generalized(NamedTuple):
    """A force, impulse or momentum on the points, (4, 3), and on the modes, (k,)."""

    p: Array
    y: Array

    def __add__(self, other: Generalized) -> Generalized:  # ty: ignore[incompatible-method-override] - sums, as tuples do not
        """Sum of the two."""
        return Generalized(self.p + other.p, self.y + other.y)

    def times(self, factor: Array | float) -> Generalized:
        """Product with a factor."""
        return Generalized(factor * self.p, factor * self.y)


def elastic_force(model: FrameModel, y: Array, rates: Array) -> Array:
    """-(K_L y + beta K_L y'), (k,); the rates y' are those half a step before y."""
    return -(model.stiffness @ (y + model.stiffness_damping * rates))


def spin_force(model: FrameModel, old: FrameState, new: FrameState) -> Array:
    """Force -1/2 (K_G(Omega_n-1/2) + K_G(Omega_n+1/2)) y_n on the modes, (k,), after a completed step."""
    if model.spin_stiffness is None:
        return jnp.zeros_like(old.y)
    both = spin_products(old.p, old.vp) + spin_products(old.p, new.vp)
    return -0.5 * both @ (model.spin_stiffness @ old.y)


def gravity_force(sums: Spread, p: Array, gravity: Array) -> Generalized:
    """Gravity force. Directors (`mass_fields`) add none: their weights on the points sum to zero."""
    return Generalized(sums.Xi.sum(axis=1)[:, None] * gravity, (arms(p).T @ gravity) @ sums.Q.sum(axis=0))


def point_forces(weights: Array, shapes: Array, p: Array, y: Array, forces: Array) -> Generalized:
    """Generalized force B^T f of forces (n, 3) on material points of weights (n, 4) and shapes (n, 3, k)."""
    local = forces @ arms(p)
    xi = weights + (shapes @ y) @ jnp.asarray(CORNERS).T
    return Generalized(xi.T @ forces, jnp.einsum("nik,ni->k", shapes, local))


def material_points(weights: Array, shapes: Array, p: Array, y: Array) -> Array:
    """Positions (n, 3) of material points: always from p and y, never by integrating velocities."""
    return weights @ p + (shapes @ y) @ arms(p).T


def step_kinetic_energy(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """1/2 sum m |x_n - x_n-1|^2 / h^2 over a step h that ends in a state; constant in free flight."""
    vp, vy = state.vp, state.vy
    sums = spread(model.moments, state.y - h * vy)
    P = arms(state.p)
    C = jnp.einsum("k,ijkl,l->ij", vy, model.moments.C, vy)
    twice = jnp.sum(vp * (sums.Xi @ vp)) + 2 * jnp.sum(((sums.Q @ vy) @ P.T) * vp) + jnp.sum((P.T @ P) * C)
    return 0.5 * twice


def link_vectors(p: Array) -> Array:
    """Vectors d = x_I - x_J (6, 3) of points p (4, 3), or their rates from those of the points."""
    return jnp.asarray(_SIGNS) @ p


def link_residual(p: Array, squared_lengths: Array) -> Array:
    """Residuals D = 1/2 (|x_I - x_J|^2 - L^2) of the six rigid links between the points, (6,), m^2."""
    d = link_vectors(p)
    return 0.5 * ((d * d).sum(axis=1) - squared_lengths)


def link_rows(vectors: Array) -> Array:
    """G = dD/dp (6, 12) for link vectors (6, 3)."""
    return (jnp.asarray(_SIGNS)[:, :, None] * vectors[:, None, :]).reshape(6, 12)
