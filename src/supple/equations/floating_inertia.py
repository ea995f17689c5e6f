"""Inertia of a body in a floating frame: all coupling terms from one Gram matrix, with analytic tangent.

The velocity field of the body is `W z` with the constant fields `W = [Phi_t | Phi_w0 | Phi_1 .. Phi_r | V]`
and `z = (v, w, g_1 w, .., g_r w, gdot)`; `G = W^T M W` is the *inertia Gram matrix*. The equations of motion
contain the frame's acceleration relative to gravity, `a = A^T (Rddot - gravity)` in body components. They do
not contain the frame's velocity `v` (Galilean invariance), and gravity needs no load vector. With

    h = G (0, w, g_k w, gdot),     d = G (a, wdot, g_k wdot + gdot_k w, gddot),

    force        p   = d_t + w x h_t
    moment       m   = d_w + sum_k (g_k d_k + gdot_k h_k) + w x (h_w + sum_k g_k h_k)
    deformation  e_k = d_g,k - w . h_k

Everything here is exact for mass matrices whose translational part is a scalar times the identity.
Source: floating-frame theory page; [Wu2019] Appendix A, without its shape-function integrals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import skew, small_product
from supple.arrays import AnyArray
from supple.integrate import StepFactors


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class InertiaArrays:
    """The blocks of the Gram matrix in the order in which the equations of motion use them."""

    fixed: AnyArray
    """(3 + r, 6 + 4r): rows of the translations and of the deformation"""
    by_spin: AnyArray
    """(1 + r, 3 (6 + 4r)): rows of the rotation, then of each `e_i x V_k`, the three axes side by side"""
    by_deformation: AnyArray
    """(12, r^2): coefficients of `w_i` in the gyroscopic matrix (3), their transposes (3), and coefficients
    of `w_i w_j` in the centrifugal matrix (6, `i <= j`)"""
    inertia: AnyArray
    """(r, r): mass of the deformation, the identity for orthonormal shapes"""


class FloatingState(NamedTuple):
    """Motion of a floating frame and of its body's coordinates, all in body components."""

    coordinates: jax.Array
    """(r,)"""
    angular_velocity: jax.Array
    """(3,) `w`"""
    rates: jax.Array
    """(r,)"""
    acceleration: jax.Array
    """(3,) `A^T (Rddot - gravity)`"""
    angular_acceleration: jax.Array
    """(3,)"""
    accelerations: jax.Array
    """(r,)"""


class InertiaTerms(NamedTuple):
    """Inertia force of a moving body, and the data of its tangent from the same evaluation."""

    force: jax.Array
    """`(p, m, e)`, (6 + r,)"""
    weights: jax.Array
    """`(1, g)` and `(0, gdot)`, (2, 1 + r)"""
    spinning: jax.Array
    """Rows of G for the rotation of the deformed body, and their rates, (6, 6 + 4r)"""
    momentum: jax.Array
    """`h_t`, (3,)"""
    angular: jax.Array
    """`h_w + sum_k g_k h_k`, (3,)"""
    coupling: jax.Array
    """`h_k` and `d_k`, (2, r, 3)"""


class _Parts(NamedTuple):
    """A vector (or the rows of a matrix) with the size of the Gram matrix, split by field."""

    translation: jax.Array
    rotation: jax.Array
    coupling: jax.Array
    """(r, 3, ...): the fields `e_i x V_k`"""
    deformation: jax.Array


def _split(vector: jax.Array) -> _Parts:
    r = (vector.shape[0] - 6) // 4
    coupling = vector[6 : 6 + 3 * r].reshape((r, 3, *vector.shape[1:]))
    return _Parts(vector[:3], vector[3:6], coupling, vector[6 + 3 * r :])


def _cross(spin: jax.Array, columns: jax.Array) -> jax.Array:
    """`spin x` each column, (3, k)."""
    x, y, z = columns
    return jnp.stack([spin[1] * z - spin[2] * y, spin[2] * x - spin[0] * z, spin[0] * y - spin[1] * x])


def inertia_arrays(gram: AnyArray) -> InertiaArrays:
    """The Gram matrix (6 + 4r, 6 + 4r) rearranged for the equations of motion."""
    gram = np.asarray(gram)
    n = gram.shape[0]
    r = (n - 6) // 4
    coupled = gram[6 : 6 + 3 * r].reshape(r, 3, n)
    with_rates = coupled[:, :, 6 + 3 * r :].transpose(1, 2, 0)
    squares = coupled[:, :, 6 : 6 + 3 * r].reshape(r, 3, r, 3).transpose(1, 3, 0, 2)
    first, second = np.triu_indices(3)
    weight = np.where(first == second, 0.5, 1.0)[:, None, None]
    both = weight * (squares[first, second] + squares[second, first])
    return InertiaArrays(
        fixed=np.concatenate([gram[:3], gram[6 + 3 * r :]]),
        by_spin=gram[3 : 6 + 3 * r].reshape(1 + r, 3 * n),
        by_deformation=np.concatenate([with_rates, with_rates.transpose(0, 2, 1), both]).reshape(12, r * r),
        inertia=gram[6 + 3 * r :, 6 + 3 * r :],
    )


def inertia_terms(arrays: InertiaArrays, motion: FloatingState) -> InertiaTerms:
    """Inertia force of a moving body, and the data of its tangent from the same evaluation."""
    r = motion.coordinates.shape[0]
    n = 6 + 4 * r
    one, zero = jnp.ones(1), jnp.zeros(1)
    weights = jnp.stack([jnp.concatenate([one, motion.coordinates]), jnp.concatenate([zero, motion.rates])])
    spinning = (weights @ arrays.by_spin).reshape(6, n)
    none = jnp.zeros(3)
    by_fixed = jnp.stack(
        [
            jnp.concatenate([none, motion.rates]),
            jnp.concatenate([motion.acceleration, motion.accelerations]),
        ]
    )
    spun = jnp.stack(
        [
            small_product(motion.angular_velocity, spinning[:3]),
            small_product(motion.angular_acceleration, spinning[:3])
            + small_product(motion.angular_velocity, spinning[3:]),
        ]
    )
    h, d = both = by_fixed @ arrays.fixed + spun
    turning = both[:, 3 : 6 + 3 * r].reshape(2, 1 + r, 3)
    # h and d of the rotation in the deformed body, and of its rate.
    (angular, d_angular), (h_rate, _) = (weights[:, None, :, None] * turning).sum(axis=2)
    moment = d_angular + h_rate + jnp.cross(motion.angular_velocity, angular)
    force = d[:3] + jnp.cross(motion.angular_velocity, h[:3])
    deformation = d[6 + 3 * r :] - small_product(turning[0, 1:], motion.angular_velocity)
    return InertiaTerms(
        force=jnp.concatenate([force, moment, deformation]),
        weights=weights,
        spinning=spinning,
        momentum=h[:3],
        angular=angular,
        coupling=turning[:, 1:],
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
    arrays: InertiaArrays,
    motion: FloatingState,
    terms: InertiaTerms,
    factors: StepFactors,
) -> jax.Array:
    """Derivative of the inertia force by accelerations and the resulting velocities and positions.

    Column j belongs to `d(a, wdot, gddot) = e_j` together with `d(w, gdot) = by_velocity e_j` and
    `dg = by_position e_j`, the combination of a Newmark step; (6 + r, 6 + r). The caller adds the change of
    `a` with the frame's rotation.
    """
    position, velocity = factors
    r = motion.coordinates.shape[0]
    spin = motion.angular_velocity

    # The rows of G for the frame's translation and rotation, and for the rate of the rotation rows.
    rows = jnp.concatenate([arrays.fixed[:3], terms.spinning])
    turning = rows[:, 3 : 6 + 3 * r].reshape(9, 1 + r, 3)
    by_spin = (terms.weights[:, None, :, None] * turning).sum(axis=2)
    turned, turned_faster = (
        small_product(turning[:, 1:], spin),
        small_product(turning[:, 1:], motion.angular_acceleration),
    )
    deformed = rows[:, 6 + 3 * r :]

    # Contributions of the accelerations to d and h in those rows: columns of force, moment and its rate.
    d_columns = jnp.concatenate(
        [
            rows[:, :3],
            by_spin[0] + velocity * by_spin[1],
            deformed + velocity * turned + position * turned_faster,
        ],
        axis=1,
    )
    h_columns = jnp.concatenate(
        [jnp.zeros((9, 3)), velocity * by_spin[0], velocity * deformed + position * turned], axis=1
    )
    h, d = terms.coupling[0].T, terms.coupling[1].T
    carried = jnp.concatenate(
        [
            jnp.zeros((3, 3)),
            -velocity * skew(terms.angular),
            position * (d + _cross(spin, h)) + velocity * h,
        ],
        axis=1,
    )
    force_rows = d_columns[:3] + _cross(spin, h_columns[:3])
    force_rows = force_rows + jnp.pad(-velocity * skew(terms.momentum), ((0, 0), (3, r)))
    moment_rows = d_columns[3:6] + h_columns[6:] + _cross(spin, h_columns[3:6]) + carried

    first, second = np.triu_indices(3)
    among_themselves = jnp.concatenate(
        [
            velocity * spin + position * motion.angular_acceleration,
            -velocity * spin,
            -position * spin[first] * spin[second],
        ]
    )
    deformation_rows = jnp.concatenate(
        [
            deformed[:3].T,
            (deformed[3:6] + velocity * (deformed[6:] - turned[3:6] - h)).T,
            arrays.inertia + (among_themselves @ arrays.by_deformation).reshape(r, r),
        ],
        axis=1,
    )
    return jnp.concatenate([force_rows, moment_rows, deformation_rows])


def velocity_fields(
    coordinates: jax.Array, velocity: jax.Array, angular_velocity: jax.Array, rates: jax.Array
) -> jax.Array:
    """`z` (6 + 4r,) of a body with coordinates and rates (r,); velocities of its frame in body components."""
    carried = (coordinates[:, None] * angular_velocity).reshape(-1)
    return jnp.concatenate([velocity, angular_velocity, carried, rates])


def kinetic_energy(gram: jax.Array, z: jax.Array) -> jax.Array:
    """`T = z G z / 2` of `velocity_fields`."""
    return z @ gram @ z / 2


def frame_momenta(gram: jax.Array, coordinates: jax.Array, z: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Linear momentum, and angular momentum about the frame origin, body components, (3,) each."""
    h = _split(gram @ z)
    return h.translation, h.rotation + coordinates @ h.coupling
