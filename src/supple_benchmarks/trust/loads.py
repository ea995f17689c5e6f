"""Loads and drives over time: impulses, chirps, moving loads, loads synchronous with the outputs."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from supple.body import FullBody
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    Fixed,
    FollowerForce,
    Joint,
    Placed,
    PrescribedRotation,
    System,
)
from supple.machine.system import Load

__all__ = ["Over", "alone", "blow", "chirp", "driven", "every", "following", "pushed", "spin", "struck"]

Over = Callable[[jax.Array], jax.Array]
UP = np.array([0.0, 0.0, 1.0])


def driven(angle: Over, body: str = "body") -> Joint:
    """The root rotated by an angle over time, about -y."""
    return PrescribedRotation(
        name="hinge", first=GROUND, second=At(body, "root"), axis=(0, -1, 0), angle=angle
    )


def spin(speed: float, rise: float) -> Over:
    """An angle whose rate grows smoothly to a speed."""

    def angle(t: jax.Array) -> jax.Array:
        s = jnp.minimum(t / rise, 1.0)
        return speed * (rise * (s**3 - s**4 / 2) + jnp.maximum(t - rise, 0.0))

    return angle


def blow(size: float, at: float, length: float) -> Over:
    """A short pulse of sine-squared shape, from `at` to `at` + `length`."""

    def value(t: jax.Array) -> jax.Array:
        s = (t - at) / length
        return size * jnp.where((s > 0) & (s < 1), jnp.sin(jnp.pi * s) ** 2, 0.0)

    return value


def chirp(size: float, low: float, high: float, duration: float) -> Over:
    """A sine whose angular frequency rises linearly from low to high over the duration."""
    rate = (high - low) / duration
    return lambda t: size * jnp.sin(low * t + rate * t**2 / 2)


def every(size: float, period: float, length: float) -> Over:
    """A short pulse of sine-squared shape in the middle of every period."""
    pulse = blow(size, (period - length) / 2, length)
    return lambda t: pulse(jnp.mod(t, period))


def pushed(over: Over, direction: np.ndarray = UP) -> DeadForce:
    """A force of constant direction at the tip."""
    return DeadForce(body="body", at="tip", force=lambda t: over(t) * direction)


def struck(node: int, over: Over) -> DeadForce:
    """A force along z at one node."""
    return DeadForce(body="body", at=[node], force=lambda t: over(t) * UP)


def following(over: Over) -> FollowerForce:
    """A follower force at the tip."""
    return FollowerForce(first=At("body", "tip"), force=lambda t: over(t) * UP)


def moving_force(nodes: list[int], places: np.ndarray, size: float, speed: float) -> DeadForce:
    """A force that travels over nodes along a line, shared by the two adjacent nodes."""
    width = float(np.diff(places).max())

    def force(t: jax.Array) -> jax.Array:
        shares = jnp.maximum(0.0, 1 - jnp.abs(places - speed * t) / width)
        return size * shares[:, None] * UP

    return DeadForce(body="body", at=nodes, force=force)


def alone(body: FullBody, *loads: Load, joint: Joint | None = None) -> System:
    """A machine of one body, by default with its root fixed to the ground."""
    held = joint or Fixed(name="wall", first=GROUND, second=At("body", "root"))
    return System((Placed(body),), (held,), loads=loads)
