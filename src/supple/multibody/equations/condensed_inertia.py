"""Inertia of the condensed motion z, which follows the coordinates of a reduced body, to leading order.

Beside its columns a body moves by `z(g)`, quadratic in the coordinates: a bent beam draws its tip in. To
second order in the coordinates the kinetic energy needs three moments of z about the frame,

    s = sum m z,     c = sum m x cross z,     J: the change of the inertia tensor,     each `g G_i g / 2`,

and gains, with the frame's velocity `v` and angular velocity `w` in body components,

    T_z = v . (ds/dt + w x s) + w . dc/dt + w J w / 2.

So Lagrange's equations gain, with `a = A^T (Rddot - gravity)`,

    force        p   = dds + 2 w x ds + wdot x s + w x (w x s)
    moment       m   = s x a + ddc + w x dc + dJ w + J wdot + w x J w
    deformation  e   = [ a_i S_i + wdot_i C_i - w_i w_j J_ij / 2 ] g

The bracket stiffens a body, whose columns do not stretch, by centrifugal force, weight and thrust. As all of
it is of one Lagrangian, energy and momenta are kept. Source: this project's own; theory page on tensors.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import skew
from supple.algebra.small_product import small_product
from supple.integrate import StepFactors

__all__ = [
    "CondensedMomenta",
    "CondensedTerms",
    "condensed_inertia",
    "condensed_mass",
    "condensed_momenta",
    "condensed_tangent",
    "unpacked_moments",
]

N_MOMENTS = 12
"""s and c (3 each), and J_ij, i <= j (6)."""
_FIRST, _SECOND = np.triu_indices(3)
_PLACE = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])


class CondensedTerms(NamedTuple):
    """Inertia force of z, and what its tangent needs of the same evaluation."""

    force: jax.Array
    """`(p, m, e)`, (6 + r,)"""
    moments: jax.Array
    """(12,)"""
    rates: jax.Array
    """(12,)"""
    rows: jax.Array
    """`G_i g`, `G_i gdot`, `G_i gddot`, (3, 12, r)"""


class CondensedMomenta(NamedTuple):
    """What z adds to energy and momenta; the momenta of the frame in body components."""

    kinetic: jax.Array
    linear: jax.Array
    angular: jax.Array
    first_moment: jax.Array
    """s (3,)"""


def unpacked_moments(packed: Any) -> np.ndarray:
    """G (12, r, r) of second derivatives (12, r(r+1)/2) in the order of numpy.triu_indices(r)."""
    packed = np.asarray(packed)
    r = int(np.sqrt(2 * packed.shape[1]))
    first, second = np.triu_indices(r)
    moments = np.zeros((N_MOMENTS, r, r))
    moments[:, first, second] = moments[:, second, first] = packed
    return moments


def _of_motion(moments: jax.Array, coordinates: jax.Array, rates: jax.Array) -> Any:
    """The moments (12,), their rates, and `G_i g` (12, r)."""
    rows = moments @ coordinates
    return rows @ coordinates / 2, rows @ rates, rows


def _on(spin: jax.Array) -> jax.Array:
    """The matrix (3, 6) that takes packed J_ij to `J spin`."""
    x, y, z = spin
    o = jnp.zeros_like(x)
    return jnp.array([[x, y, z, o, o, o], [o, x, o, y, z, o], [o, o, x, o, y, z]])


def _weights(acceleration: jax.Array, spin: jax.Array, angular_acceleration: jax.Array) -> jax.Array:
    """Coefficients (12,) of the G_i in the stiffness by inertia."""
    halved = np.where(_FIRST == _SECOND, 0.5, 1.0)
    return jnp.concatenate([acceleration, angular_acceleration, -halved * spin[_FIRST] * spin[_SECOND]])


def condensed_inertia(moments: jax.Array, motion: Any) -> CondensedTerms:
    """Inertia force of z of a moving body.

    moments : (12, r, r)        motion : FloatingState
    """
    g, spin, rate, a, spin_rate, acceleration = motion
    rows = jnp.moveaxis(moments @ jnp.stack([g, rate, acceleration], axis=1), 2, 0)
    now, by_rate = rows[0] @ g / 2, rows[0] @ rate
    second = rows[0] @ acceleration + rows[1] @ rate
    s, ds, dc = now[:3], by_rate[:3], by_rate[3:6]
    angular = small_product(_on(spin), now[6:])
    force = (
        second[:3] + 2 * jnp.cross(spin, ds) + jnp.cross(spin_rate, s) + jnp.cross(spin, jnp.cross(spin, s))
    )
    moment = (
        jnp.cross(s, a)
        + second[3:6]
        + jnp.cross(spin, dc + angular)
        + small_product(_on(spin), by_rate[6:])
        + small_product(_on(spin_rate), now[6:])
    )
    deformation = _weights(a, spin, spin_rate) @ rows[0]
    return CondensedTerms(jnp.concatenate([force, moment, deformation]), now, by_rate, rows)


def condensed_tangent(
    moments: jax.Array, motion: Any, terms: CondensedTerms, factors: StepFactors
) -> jax.Array:
    """What z adds to `inertia_tangent`, (6 + r, 6 + r)."""
    position, velocity = factors
    _, spin, _, a, spin_rate, _ = motion
    s, ds, dc = terms.moments[:3], terms.rates[:3], terms.rates[3:6]
    J, dJ = terms.moments[6:][_PLACE], terms.rates[6:][_PLACE]
    rows, by_rate, by_acceleration = terms.rows
    turn, on_spin = skew(spin), _on(spin)
    # How the first and second rates of s and c follow the accelerations of the coordinates.
    first = velocity * rows[:6] + position * by_rate[:6]
    second = rows[:6] + 2 * velocity * by_rate[:6] + position * by_acceleration[:6]
    angular = small_product(on_spin, rows[6:])
    force_rows = jnp.concatenate(
        [
            jnp.zeros((3, 3)),
            -skew(s) - velocity * (skew(2 * ds + jnp.cross(spin, s)) + small_product(turn, skew(s))),
            second[:3]
            + small_product(2 * turn, first[:3])
            + small_product(position * (skew(spin_rate) + small_product(turn, turn)), rows[:3]),
        ],
        axis=1,
    )
    moment_rows = jnp.concatenate(
        [
            skew(s),
            J + velocity * (dJ - skew(dc + small_product(J, spin)) + small_product(turn, J)),
            second[3:]
            + small_product(turn, first[3:] + position * angular)
            + small_product(on_spin, velocity * rows[6:] + position * by_rate[6:])
            + position * (small_product(_on(spin_rate), rows[6:]) - small_product(skew(a), rows[:3])),
        ],
        axis=1,
    )
    r = moments.shape[-1]
    stiffness = (_weights(a, spin, spin_rate) @ moments.reshape(N_MOMENTS, r * r)).reshape(r, r)
    deformation_rows = jnp.concatenate(
        [rows[:3].T, (rows[3:6] - velocity * angular).T, position * stiffness], axis=1
    )
    return jnp.concatenate([force_rows, moment_rows, deformation_rows])


def condensed_mass(moments: jax.Array, coordinates: jax.Array) -> jax.Array:
    """What z adds to the mass matrix for `(v, w, gdot)` in body components, (6 + r, 6 + r)."""
    now, _, rows = _of_motion(moments, coordinates, coordinates)
    r, turned = coordinates.shape[0], skew(now[:3])
    return jnp.block(
        [
            [jnp.zeros((3, 3)), -turned, rows[:3]],
            [turned, now[6:][_PLACE], rows[3:6]],
            [rows[:3].T, rows[3:6].T, jnp.zeros((r, r))],
        ]
    )


def condensed_momenta(moments: jax.Array, motion: Any, velocity: jax.Array) -> CondensedMomenta:
    """Energy and momenta of z with the frame's velocity `v` (3,) in body components."""
    now, rates, _ = _of_motion(moments, motion.coordinates, motion.rates)
    spin, s = motion.angular_velocity, now[:3]
    moved, turned = rates[:3] + jnp.cross(spin, s), now[6:][_PLACE] @ spin
    return CondensedMomenta(
        kinetic=velocity @ moved + spin @ rates[3:6] + spin @ turned / 2,
        linear=moved,
        angular=rates[3:6] + turned + jnp.cross(s, velocity),
        first_moment=s,
    )
