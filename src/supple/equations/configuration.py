"""Configurations of a system, and the arguments of its equations."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.algebra.rotation import rotation_exp, rotation_right_jacobian, small_product
from supple.arrays import AnyArray
from supple.equations.machine_model import Model
from supple.equations.places import over


class Configuration(NamedTuple):
    """Position, orientation and deformation of every body."""

    origins: AnyArray
    """(nb, 3) frame origins, global"""
    rotations: AnyArray
    """(nb, 3, 3) frame rotations, body to global"""
    coordinates: AnyArray
    """(nq,) deformation coordinates, body after body"""


class ControlState(NamedTuple):
    """State of all controllers at one time; every tuple has one entry per controller."""

    states: tuple[AnyArray, ...]
    """(k,) states, followed by the angles of the joints that are read, with whole revolutions"""
    rates: tuple[AnyArray, ...]
    """Rates of the states, (k,)"""
    held: tuple[dict[str, AnyArray], ...]
    """Outputs of sampled controllers by name; empty for other controllers"""
    memory: tuple[dict[str, AnyArray], ...]
    """Memory of sampled controllers; not part of any equation"""


class ControlStep(NamedTuple):
    """Data of a time step for controllers: their state at its start, and its length."""

    start: ControlState
    size: AnyArray


class SystemMotion(NamedTuple):
    """Arguments of the equations of motion."""

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
    """The configuration after an increment (n,), in the order of the velocities."""
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
