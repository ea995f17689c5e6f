"""Where the bodies of a system are, and what its equations are evaluated at."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from supple.algebra.rotation import rotation_exp, rotation_right_jacobian
from supple.algebra.small_product import small_product
from supple.equations.machine_model import Model
from supple.equations.places import over

__all__ = [
    "AnyArray",
    "Configuration",
    "ControlState",
    "ControlStep",
    "SystemMotion",
    "advance",
    "turns_by_increment",
]

AnyArray = Any
"""A NumPy array or a JAX one: both engines keep their states in the same records."""


class Configuration(NamedTuple):
    """Position of every body."""

    origins: AnyArray
    """(nb, 3) frame origins, global"""
    rotations: AnyArray
    """(nb, 3, 3) frame rotations, body to global"""
    coordinates: AnyArray
    """(nq,) deformation coordinates, body after body"""


class ControlState(NamedTuple):
    """Of all controllers, at an instant: one entry each."""

    states: tuple[AnyArray, ...]
    """(k,), and behind them the angles of the joints that it reads, counted beyond pi"""
    rates: tuple[AnyArray, ...]
    """Of the states, (k,)"""
    held: tuple[dict[str, AnyArray], ...]
    """Outputs of sampled controllers by name; empty of others"""
    memory: tuple[dict[str, AnyArray], ...]
    """What sampled controllers remember; no equation reads it"""


class ControlStep(NamedTuple):
    """What controllers have to know of the step: where it began, and how long it is."""

    start: ControlState
    size: AnyArray


class SystemMotion(NamedTuple):
    """What the equations are evaluated at."""

    time: AnyArray
    configuration: Configuration
    velocity: AnyArray
    """(n,)"""
    acceleration: AnyArray
    """(n,)"""
    multipliers: AnyArray
    """(m,)"""
    control: ControlStep | None = None
    """None where there are no controllers"""


def advance(model: Model, configuration: Configuration, increment: jax.Array) -> Configuration:
    """The configuration moved by an increment (n,) of the kind `velocity * time`."""
    frames = model.frames.take(increment)
    turned = over(
        lambda rotation, step: small_product(rotation, rotation_exp(step)),
        configuration.rotations,
        frames[:, 3:],
    )
    deformation = [increment[part.start + 6 : part.stop] for part in model.deforming_slices]
    coordinates = configuration.coordinates
    if deformation:
        coordinates = coordinates + (jnp.concatenate(deformation) if len(deformation) > 1 else deformation[0])
    return Configuration(configuration.origins + frames[:, :3], turned, coordinates)


def turns_by_increment(model: Model, increments: jax.Array) -> jax.Array:
    """`T` of every body, (nb, 3, 3): `dpsi = T(increment) dincrement` of the frame's rotation vector."""
    return over(rotation_right_jacobian, model.frames.take(increments)[:, 3:])
