"""The ends of joints and forces: their markers, and maps between the bodies and the markers' local freedoms.

The twelve local freedoms of a marker are defined in `marker.py`.
"""

from __future__ import annotations

from collections.abc import Iterator

import jax
import jax.numpy as jnp

from supple.algebra.rotation import small_product
from supple.arrays import AnyArray
from supple.equations.configuration import Configuration
from supple.equations.machine_model import Ends, ForceGroup, JointGroup
from supple.equations.marker import Marker
from supple.equations.places import MatrixBlock, Places, over

Element = JointGroup | ForceGroup


def markers(ends: Ends, configuration: Configuration, velocity: jax.Array | None = None) -> Marker:
    """States of k markers, stacked. Without `velocity` (n,), and on the ground, all their rates are zero."""
    if ends.velocities is None or ends.coordinates is None:
        k = len(ends.bodies)
        zero = jnp.zeros((k, 3))
        eye = jnp.broadcast_to(jnp.eye(3), (k, 3, 3))
        return Marker(zero, eye, zero, zero, jnp.zeros(k), ends.offset, ends.axes, zero, zero, zero, zero)
    coordinates = ends.coordinates.take(configuration.coordinates)
    own = jnp.zeros((len(ends.bodies), ends.velocities.size))
    if velocity is not None:
        own = ends.velocities.take(velocity)
    origin, rotation = (_of_bodies(ends, item) for item in (configuration.origins, configuration.rotations))
    local, rates = over(lambda motion, q, v: (motion @ q, motion @ v), ends.motion, coordinates, own[:, 6:])
    return Marker(
        origin=origin,
        rotation=rotation,
        displacement=local[:, :3],
        rotation_vector=local[:, 3:],
        cubic_turn=ends.cubic_turn,
        offset=ends.offset,
        axes=ends.axes,
        velocity=own[:, :3],
        angular_velocity=own[:, 3:6],
        displacement_rate=rates[:, :3],
        rotation_vector_rate=rates[:, 3:],
    )


def _of_bodies(ends: Ends, per_body: AnyArray) -> AnyArray:
    """Rows of an array (nb, ...) for the bodies of the ends, (k, ...)."""
    return Places(ends.bodies, 1).take(per_body)[:, 0]


def turns_of(ends: Ends, turns: jax.Array) -> jax.Array | None:
    """Rows of `turns_by_increment` (nb, 3, 3) for the bodies of the ends, (k, 3, 3); None for the ground."""
    return None if ends.on_ground else _of_bodies(ends, turns)


def forces_on_bodies(
    element: Element, local: tuple[jax.Array, jax.Array]
) -> Iterator[tuple[Places, jax.Array]]:
    """Generalised forces (k, 6 + r) at both ends of elements, from forces on the local freedoms (k, 12)."""
    for ends, part in zip((element.first, element.second), local, strict=True):
        if ends.velocities is not None:
            own = over(
                lambda motion, force: jnp.concatenate([force[:6], motion.T @ force[6:]]), ends.motion, part
            )
            yield ends.velocities, own


def columns_on_velocities(ends: Ends, by_local: jax.Array, turns: jax.Array | None) -> jax.Array:
    """Columns for the bodies' velocities (k, m, 6 + r) from columns for the local freedoms (k, m, 12).

    The three columns of a frame's rotation are for the variation `dpsi`, `dA = A skew(dpsi)`; with `turns`
    (k, 3, 3), they are for the increments of its rotation vector.
    """

    def of_end(motion: jax.Array, columns: jax.Array, *turn: jax.Array) -> jax.Array:
        rotation = small_product(columns[:, 3:6], turn[0]) if turn else columns[:, 3:6]
        return jnp.concatenate([columns[:, :3], rotation, columns[:, 6:] @ motion], axis=1)

    return over(of_end, ends.motion, by_local, *(() if turns is None else (turns,)))


def blocks_on_bodies(
    element: Element, local: tuple[tuple[jax.Array, jax.Array], ...], turns: jax.Array | None
) -> Iterator[MatrixBlock]:
    """Blocks for the bodies from matrices (k, 12, 12) for the local freedoms.

    local : `local[i][j]` has rows for end i and columns for end j of the elements

    With `turns` (nb, 3, 3), columns of rotations are for increments of the bodies' rotation vectors.
    """
    both = element.first, element.second
    for row_ends, row in zip(both, local, strict=True):
        for column_ends, part in zip(both, row, strict=True):
            if row_ends.velocities is None or column_ends.velocities is None:
                continue
            own_turns = None if turns is None else turns_of(column_ends, turns)
            columns = columns_on_velocities(column_ends, part, own_turns)
            values = over(
                lambda motion, own: jnp.concatenate([own[:6], motion.T @ own[6:]]), row_ends.motion, columns
            )
            yield MatrixBlock(row_ends.velocities, column_ends.velocities, values)
