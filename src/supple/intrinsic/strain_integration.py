"""Places of the stations from the strains between them: rotations and positions out from the root."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.algebra.rotation import rotation_exp, rotation_right_jacobian
from supple.intrinsic.line_equations import section_strains
from supple.intrinsic.line_model import LineModel

__all__ = ["Places", "rotation_of", "station_places"]


class Places(NamedTuple):
    """Where stations are.

    rotations : (n, 3, 3)   material axes to global ones
    positions : (n, 3)      global
    """

    rotations: jax.Array
    positions: jax.Array


def rotation_of(quaternion: jax.Array) -> jax.Array:
    """Rotation matrix of a quaternion (4,) of any length, real part first.

    Source: [Wang2015] (6), divided by the squared length.
    """
    s, v = quaternion[0], quaternion[1:]
    x, y, z = v
    zero = jnp.zeros_like(x)
    cross = jnp.stack([zero, -z, y, z, zero, -x, -y, x, zero]).reshape(3, 3)
    inside = 2 * jnp.outer(v, v) + (s * s - v @ v) * jnp.eye(3) + 2 * s * cross
    return inside / (quaternion @ quaternion)


def station_places(model: LineModel, q2: jax.Array, rotation: jax.Array, position: jax.Array) -> Places:
    """Rotations and positions of all stations from those of the root.

    Strain gamma and curvature kappa are constant along a segment of length h and direction t:

        R_1 = R_0 exp(h kappa),     r_1 = r_0 + R_0 J(h kappa) (gamma + t) h

    The motions of the segments are multiplied in pairs of 1, 2, 4, .. of them: as many rounds as the
    logarithm of the longest path, on any tree.
    """
    e = section_strains(model, q2)
    turn = model.lengths[:, None] * e[:, 3:]
    stretch = model.lengths[:, None] * (e[:, :3] + model.directions)
    bent = jax.vmap(lambda psi, d: rotation_right_jacobian(-psi) @ d)(turn, stretch)
    rotations = jnp.concatenate([jnp.eye(3)[None], jax.vmap(rotation_exp)(turn)])
    arms = jnp.concatenate([jnp.zeros((1, 3)), bent])
    for above in model.ancestors:
        before = rotations[above]
        arms = arms[above] + _times(before, arms)
        rotations = _products(before, rotations)
    return Places(
        _products(jnp.broadcast_to(rotation, rotations.shape), rotations), position + arms @ rotation.T
    )


def _products(a: jax.Array, b: jax.Array) -> jax.Array:
    return (a[:, :, :, None] * b[:, None, :, :]).sum(axis=2)


def _times(a: jax.Array, b: jax.Array) -> jax.Array:
    return (a * b[:, None, :]).sum(axis=2)
