"""Inertia of a body in a floating frame: all couplings from one Gram matrix, with analytic tangent.

The velocity field of the body is `W z` with the constant fields `W = [Phi_t | Phi_w0 | Phi_1 .. Phi_r | V]`
and `z = (v, w, g_1 w, .., g_r w, gdot)`; `G = W^T M W` is the *inertia Gram matrix*. Written with the frame's
global acceleration, `a = A^T (Rddot - gravity)` in body components, the frame's velocity `v` drops out of
the equations of motion altogether (a Galilean frame cannot matter), and gravity needs no load vector. With

    h = G (0, w, g_k w, gdot),     d = G (a, wdot, g_k wdot + gdot_k w, gddot),

    force        p   = d_t + w x h_t
    moment       m   = d_w + sum_k (g_k d_k + gdot_k h_k) + w x (h_w + sum_k g_k h_k)
    deformation  e_k = d_g,k - w . h_k

Everything here is exact for mass matrices whose translational part is a scalar times the identity.
Source: floating-frame theory page; [Wu2019] Appendix A, without its shape-function integrals.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.algebra.rotation import skew

__all__ = [
    "FloatingMotion",
    "floating_mass",
    "frame_momenta",
    "inertia_force",
    "inertia_tangent",
    "kinetic_energy",
    "momenta",
]


class FloatingMotion(NamedTuple):
    """Motion of a floating frame and of its body's coordinates, all in body components."""

    coordinates: jax.Array
    """(r,)"""
    spin: jax.Array
    """(3,) angular velocity `w`"""
    rates: jax.Array
    """(r,)"""
    acceleration: jax.Array
    """(3,) `A^T (Rddot - gravity)`"""
    spin_rate: jax.Array
    """(3,)"""
    accelerations: jax.Array
    """(r,)"""


class _Parts(NamedTuple):
    """A vector (or the rows of a matrix) of the Gram matrix's size, split by field."""

    translation: jax.Array
    rotation: jax.Array
    coupling: jax.Array
    """(r, 3, ...): the fields `e_i x V_k`"""
    deformation: jax.Array


def _split(vector: jax.Array) -> _Parts:
    r = (vector.shape[0] - 6) // 4
    coupling = vector[6 : 6 + 3 * r].reshape((r, 3, *vector.shape[1:]))
    return _Parts(vector[:3], vector[3:6], coupling, vector[6 + 3 * r :])


def _join(
    translation: jax.Array, rotation: jax.Array, coupling: jax.Array, deformation: jax.Array
) -> jax.Array:
    return jnp.concatenate([translation, rotation, coupling.reshape(-1), deformation])


def momenta(gram: jax.Array, motion: FloatingMotion) -> jax.Array:
    """`h = G (0, w, g_k w, gdot)`: momenta of a body whose frame origin is at rest, (6 + 4r,)."""
    return gram @ _join(jnp.zeros(3), motion.spin, motion.coordinates[:, None] * motion.spin, motion.rates)


def _rate_of_momenta(gram: jax.Array, motion: FloatingMotion) -> jax.Array:
    coupling = motion.coordinates[:, None] * motion.spin_rate + motion.rates[:, None] * motion.spin
    return gram @ _join(motion.acceleration, motion.spin_rate, coupling, motion.accelerations)


def inertia_force(gram: jax.Array, motion: FloatingMotion) -> jax.Array:
    """Inertia force `p`, moment `m` about the frame origin and generalised forces `e`, (6 + r,)."""
    h = _split(momenta(gram, motion))
    d = _split(_rate_of_momenta(gram, motion))
    angular = h.rotation + motion.coordinates @ h.coupling
    return jnp.concatenate(
        [
            d.translation + jnp.cross(motion.spin, h.translation),
            d.rotation
            + motion.coordinates @ d.coupling
            + motion.rates @ h.coupling
            + jnp.cross(motion.spin, angular),
            d.deformation - h.coupling @ motion.spin,
        ]
    )


def floating_mass(gram: jax.Array, coordinates: jax.Array) -> jax.Array:
    """Mass matrix `Z^T G Z` for `(v, w, gdot)` in body components, (6 + r, 6 + r)."""
    rows = _split(gram)
    columns = jnp.concatenate(
        [
            rows.translation,
            rows.rotation + jnp.einsum("k,kin->in", coordinates, rows.coupling),
            rows.deformation,
        ]
    )
    parts = _split(columns.T)
    by_spin = parts.rotation + jnp.einsum("k,kin->in", coordinates, parts.coupling)
    return jnp.concatenate([parts.translation, by_spin, parts.deformation])


def inertia_tangent(
    gram: jax.Array, motion: FloatingMotion, velocity: jax.Array | float, position: jax.Array | float
) -> jax.Array:
    """Derivative of `inertia_force` for changes of the accelerations that carry velocity and position along.

    Column j answers to `d(a, wdot, gddot) = e_j` together with `d(w, gdot) = velocity e_j` and
    `dg = position e_j`, the combination that a Newmark step needs; (6 + r, 6 + r). The change of `a` with the
    frame's rotation is the caller's.
    """
    r = motion.coordinates.shape[0]
    fields = _split(gram.T)  # G is symmetric: rows by field are columns by field
    h = _split(momenta(gram, motion))
    d = _split(_rate_of_momenta(gram, motion))
    spin, spin_rate = motion.spin, motion.spin_rate

    # Columns of G Z: what d and h owe to the spin, to the rates through the spin, and to the coordinates.
    by_spin = fields.rotation + jnp.einsum("k,kin->in", motion.coordinates, fields.coupling)
    by_rates = jnp.einsum("k,kin->in", motion.rates, fields.coupling)
    turned = jnp.einsum("kin,i->kn", fields.coupling, spin)
    turned_faster = jnp.einsum("kin,i->kn", fields.coupling, spin_rate)

    d_columns = jnp.concatenate(
        [
            fields.translation,
            by_spin + velocity * by_rates,
            fields.deformation + velocity * turned + position * turned_faster,
        ]
    ).T
    h_columns = jnp.concatenate(
        [
            jnp.zeros_like(fields.translation),
            velocity * by_spin,
            velocity * fields.deformation + position * turned,
        ]
    ).T
    dd, dh = _split(d_columns), _split(h_columns)

    cross_spin = skew(spin)
    angular = h.rotation + motion.coordinates @ h.coupling
    force_rows = dd.translation + cross_spin @ dh.translation
    force_rows = force_rows.at[:, 3:6].add(-velocity * skew(h.translation))
    moment_rows = (
        dd.rotation
        + jnp.einsum("k,kin->in", motion.coordinates, dd.coupling)
        + jnp.einsum("k,kin->in", motion.rates, dh.coupling)
        + cross_spin @ (dh.rotation + jnp.einsum("k,kin->in", motion.coordinates, dh.coupling))
    )
    moment_rows = moment_rows.at[:, 3:6].add(-velocity * skew(angular))
    moment_rows = moment_rows.at[:, 6:].add(
        position * (d.coupling.T + cross_spin @ h.coupling.T) + velocity * h.coupling.T
    )
    deformation_rows = dd.deformation - jnp.einsum("i,kin->kn", spin, dh.coupling)
    deformation_rows = deformation_rows.at[:, 3:6].add(-velocity * h.coupling)
    return jnp.concatenate([force_rows, moment_rows, deformation_rows]).reshape(6 + r, 6 + r)


def kinetic_energy(gram: jax.Array, motion: FloatingMotion, velocity: jax.Array) -> jax.Array:
    """`T = z G z / 2` with the frame's velocity `v = A^T Rdot` (3,) in body components."""
    z = _join(velocity, motion.spin, motion.coordinates[:, None] * motion.spin, motion.rates)
    return z @ gram @ z / 2


def frame_momenta(
    gram: jax.Array, motion: FloatingMotion, velocity: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Linear momentum, and angular momentum about the frame origin, body components, (3,) each."""
    z = _join(velocity, motion.spin, motion.coordinates[:, None] * motion.spin, motion.rates)
    h = _split(gram @ z)
    return h.translation, h.rotation + motion.coordinates @ h.coupling
