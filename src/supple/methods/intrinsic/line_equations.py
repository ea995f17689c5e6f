"""Equations of motion of a line in its modes, with quadratic couplings alone, in factorised form.

    q_1' = w (q_2 + beta q_2') - d q_1 - Phi_1^T [L_1(x_1) M x_1 + L_2(x_2) e - f]
    q_2' = -w q_1 + Phi_2^T L_1(x_1)^T e,                 e = C x_2

with x_1 = Phi_1 q_1, x_2 = Phi_2 q_2, frequencies w, retardation times beta, decay d, and loads f. e are the
strains, and C is the compliance. For a released body with damping, beta or d is a matrix. A tensor form
would store N^3 coupling terms for N modes. Here the couplings are evaluated at stations and segments, by
vector products and a few products of a matrix and a vector. The result equals that of the tensors for any
choice of modes, and the power of the couplings is exactly zero.

Amplitudes, and all results from them, may have a last axis of cases. The products are then of two matrices,
and one instruction computes several cases, which are adjacent in memory.
Source: [Wang2015] (12)-(14), with their integrals as sums over stations.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.arrays import AnyArray
from supple.methods.intrinsic.line_model import LineModel


class RootTwist(NamedTuple):
    """Prescribed motion of the root in its own axes: velocity and angular velocity (6,), and their rates."""

    twist: AnyArray
    rate: AnyArray


def station_velocities(model: LineModel, q1: jax.Array, root: RootTwist | None = None) -> jax.Array:
    """Velocities and angular velocities (n, 6) of the stations, along their own axes."""
    x1 = model.velocities @ q1
    if root is not None:
        x1 = x1 + model.twists @ root.twist
    return _by_sixes(x1)


def section_strains(model: LineModel, q2: jax.Array) -> jax.Array:
    """Strains and curvatures (n - 1, 6) of the segments, C x_2."""
    return _by_sixes(model.strains @ q2)


def line_forces(model: LineModel, q2: jax.Array) -> jax.Array:
    """Internal forces and moments (n - 1, 6) at the middles of the segments, x_2, along material axes."""
    return _by_sixes(model.forces @ q2)


def line_rates(
    model: LineModel,
    q1: jax.Array,
    q2: jax.Array,
    wrenches: jax.Array | None = None,
    root: RootTwist | None = None,
) -> tuple[jax.Array, jax.Array]:
    """Rates (m,) and (e,) of the amplitudes, or (m, k) and (e, k) of k cases.

    wrenches : (n, 6)   forces and moments on the stations, along material axes; (n, 6, k) of k cases
    root : RootTwist    prescribed motion of the root; None without one
    """
    k = model.n_rigid
    x1 = station_velocities(model, q1, root)
    e = section_strains(model, q2)
    d2 = force_rates(model, x1, q1, e)
    stress = q2 + viscous_forces(model, d2)
    inertial = on_stations(model, x1, q1, stress, e, root)
    if wrenches is not None:
        inertial = inertial - wrenches
    d1 = -_in_modes(model.velocities, inertial) - decay_rates(model, q1)
    if root is not None:
        d1 = d1 - model.velocities.T @ (model.twist_momenta @ root.rate)
    return d1.at[k:].add(_along(model.omega, q2) * stress), d2


def force_rates(model: LineModel, x1: jax.Array, q1: jax.Array, e: jax.Array) -> jax.Array:
    """q_2' (e,), linear in velocities x_1 (n, 6) of amplitudes q_1, at strains e (n - 1, 6)."""
    outer = x1[1:]
    inner = x1[:-1] if model.is_chain else x1[model.inner]
    middle = 0.5 * (outer + inner)
    strain_power = _along(model.lengths, e) * l1_transposed(middle, e)
    elastic = q1[model.n_rigid :]
    return _in_modes(model.forces, strain_power) - _along(model.omega, elastic) * elastic


def viscous_forces(model: LineModel, d2: jax.Array) -> jax.Array:
    """Viscous part of the amplitudes of the forces, beta q_2' (e,), at rates q_2'."""
    if model.retardation.ndim == 2:
        return model.retardation @ d2
    return _along(model.retardation, d2) * d2


def decay_rates(model: LineModel, q1: jax.Array) -> jax.Array:
    """Decay of the amplitudes of the velocities by damping, d q_1 (m,)."""
    return model.decay @ q1 if model.decay.ndim == 2 else _along(model.decay, q1) * q1


def on_stations(
    model: LineModel, x1: jax.Array, q1: jax.Array, stress: jax.Array, e: jax.Array, root: RootTwist | None
) -> jax.Array:
    """Forces of inertia and bending on the stations (n, 6): L_1(x_1) M x_1 + L_2(x_2) e."""
    half = 0.5 * _along(model.lengths, e) * l2(line_forces(model, stress), e)
    return on_ends(model, turning_forces(model, x1, q1, root), half)


def on_ends(model: LineModel, values: jax.Array, of_segments: jax.Array) -> jax.Array:
    """Values at stations (n, 6) with those of segments (n - 1, 6) added at both their ends."""
    inner = slice(None, -1) if model.is_chain else model.inner
    return values.at[1:].add(of_segments).at[inner].add(of_segments)


def turning_forces(model: LineModel, x1: jax.Array, q1: jax.Array, root: RootTwist | None) -> jax.Array:
    """L_1(x_1) M x_1 (n, 6): centrifugal and gyroscopic forces of the stations."""
    return l1(x1, momenta(model, x1, q1, root))


def momenta(model: LineModel, x1: jax.Array, q1: jax.Array, root: RootTwist | None) -> jax.Array:
    """M x_1 (n, 6) from velocities and their amplitudes."""
    if model.station_masses is not None:
        # Column by column: compiled into one pass, for one case and for many.
        columns = (_along(model.station_masses[:, :, j], x1) * x1[:, None, j] for j in range(6))
        return sum(columns, jnp.zeros(()))
    p = model.momenta @ q1
    if root is not None:
        p = p + model.twist_momenta @ root.twist
    return _by_sixes(p)


def l1(x1: jax.Array, p: jax.Array) -> jax.Array:
    """L_1(x_1) p = [w x p_v; v x p_v + w x p_w]."""
    v, w = x1[:, :3], x1[:, 3:]
    return jnp.concatenate([_cross(w, p[:, :3]), _cross(v, p[:, :3]) + _cross(w, p[:, 3:])], axis=1)


def l1_transposed(x1: jax.Array, e: jax.Array) -> jax.Array:
    """L_1(x_1)^T e = -[w x gamma + v x kappa; w x kappa]."""
    v, w = x1[:, :3], x1[:, 3:]
    return -jnp.concatenate([_cross(w, e[:, :3]) + _cross(v, e[:, 3:]), _cross(w, e[:, 3:])], axis=1)


def l2(x2: jax.Array, e: jax.Array) -> jax.Array:
    """L_2(x_2) e = [f x kappa; f x gamma + m x kappa]."""
    f, m = x2[:, :3], x2[:, 3:]
    return jnp.concatenate([_cross(f, e[:, 3:]), _cross(f, e[:, :3]) + _cross(m, e[:, 3:])], axis=1)


def _cross(a: jax.Array, b: jax.Array) -> jax.Array:
    """Vector product by columns: jnp.cross permutes axes, which costs more than the product."""
    a0, a1, a2 = a[:, 0], a[:, 1], a[:, 2]
    b0, b1, b2 = b[:, 0], b[:, 1], b[:, 2]
    return jnp.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=1)


def _by_sixes(values: jax.Array) -> jax.Array:
    """(n, 6) from (6 n,), with any further axes."""
    return values.reshape(-1, 6, *values.shape[1:])


def _in_modes(modes: jax.Array, values: jax.Array) -> jax.Array:
    """Components (m,) in modes (6 n, m) of values (n, 6), with any further axes."""
    if values.ndim == 2:
        return values.reshape(-1) @ modes
    return modes.T @ values.reshape(-1, *values.shape[2:])


def _along(values: jax.Array, other: jax.Array) -> jax.Array:
    """Values with added axes of length one, for products with arrays of more axes."""
    return values.reshape(values.shape + (1,) * (other.ndim - values.ndim))
