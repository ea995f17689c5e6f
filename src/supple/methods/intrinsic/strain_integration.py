"""Positions and rotations of the stations by integration of the strains from the root outwards."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.algebra.rotation import angle_quotients
from supple.methods.intrinsic.line_equations import section_strains
from supple.methods.intrinsic.line_model import LineModel


class StationPlaces(NamedTuple):
    """Rotations and positions of stations.

    rotations : (n, 3, 3)   material axes to global ones
    positions : (n, 3)      global
    """

    rotations: jax.Array
    positions: jax.Array


def rotation_of(quaternion: jax.Array) -> jax.Array:
    """Rotation matrix of a quaternion (4,) of any length, real part first; (3, 3, k) for k cases (4, k).

    Source: [Wang2015] (6), divided by the squared length.
    """
    s, v = quaternion[0], quaternion[1:]
    x, y, z = v
    zero = jnp.zeros_like(x)
    cross = jnp.stack([zero, -z, y, z, zero, -x, -y, x, zero]).reshape(3, 3, *s.shape)
    square = (v * v).sum(axis=0)
    inside = 2 * v[:, None] * v[None] + (s * s - square) * _identity(s) + 2 * s * cross
    return inside / (s * s + square)


def station_places(
    model: LineModel, q2: jax.Array, rotation: jax.Array, position: jax.Array
) -> StationPlaces:
    """Rotations and positions of all stations from those of the root; q_2 may have a last axis of cases.

    Strain gamma and curvature kappa are constant along a segment of length h and direction t:

        R_1 = R_0 exp(h kappa),     r_1 = r_0 + R_0 J(h kappa) (gamma + t) h

    The motions of the segments are multiplied in groups of 1, 2, 4, .. segments. The number of rounds is the
    binary logarithm of the number of segments in the longest path.
    """
    e = section_strains(model, q2)
    one = (1,) * (e.ndim - 2)
    lengths = model.lengths.reshape(-1, 1, *one)
    turn = lengths * e[:, 3:]
    stretch = lengths * (e[:, :3] + model.directions.reshape(-1, 3, *one))
    turned, moved = _segments(turn, stretch)
    rotations = jnp.concatenate([_identity(turn[0, 0])[None], turned])
    arms = jnp.concatenate([jnp.zeros_like(moved[:1]), moved])
    for above in model.ancestors:
        before = rotations[above]
        arms = arms[above] + _times(before, arms)
        rotations = _products(before, rotations)
    return StationPlaces(_products(rotation[None], rotations), position + _times(rotation[None], arms))


def _segments(psi: jax.Array, d: jax.Array) -> tuple[jax.Array, jax.Array]:
    """exp(psi) and J(psi) d of rotation vectors and chords (n, 3, ...).

    exp(psi) = 1 + a skew(psi) + b (psi psi^T - |psi|^2)
    J(psi) d = d + b psi x d + c (psi (psi . d) - |psi|^2 d)
    """
    square, along = (psi * psi).sum(axis=1), (psi * d).sum(axis=1)
    a, b, c = angle_quotients(square)
    x, y, z = psi[:, 0], psi[:, 1], psi[:, 2]
    zero = jnp.zeros_like(x)
    skew = jnp.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3, *x.shape[1:])
    a, b, c = (each[:, None] for each in (a, b, c))
    square, along = square[:, None], along[:, None]
    outer = psi[:, :, None] * psi[:, None] - square[:, None] * _identity(x[0])
    turned = _identity(x[0]) + a[:, None] * skew + b[:, None] * outer
    return turned, d + b * _times(skew, d) + c * (along * psi - square * d)


def _identity(like: jax.Array) -> jax.Array:
    return jnp.broadcast_to(jnp.eye(3).reshape(3, 3, *(1,) * like.ndim), (3, 3, *like.shape))


def _products(a: jax.Array, b: jax.Array) -> jax.Array:
    # Term by term: compiled into one pass, for one case and for many.
    return sum((a[:, :, k, None] * b[:, None, k] for k in range(1, 3)), a[:, :, 0, None] * b[:, None, 0])


def _times(a: jax.Array, b: jax.Array) -> jax.Array:
    return sum((a[:, :, k] * b[:, None, k] for k in range(1, 3)), a[:, :, 0] * b[:, None, 0])
