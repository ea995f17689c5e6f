"""Loads and drives over time: impulses, chirps, moving loads, loads synchronous with the outputs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np

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

__all__ = ["blow", "chirp", "clamped", "driven", "every", "moving_force", "pushed", "spin", "struck"]

Over = Callable[[Any], Any]
UP = np.array([0.0, 0.0, 1.0])


def clamped(body: str = "body") -> Joint:
    """The root fixed to the ground."""
    return Fixed(name="wall", first=GROUND, second=At(body, "root"))


def driven(angle: Over, axis: tuple[float, float, float] = (0, -1, 0), body: str = "body") -> Joint:
    """The root rotated by an angle over time."""
    return PrescribedRotation(name="hinge", first=GROUND, second=At(body, "root"), axis=axis, angle=angle)


def spin(speed: float, rise: float) -> Over:
    """An angle whose rate grows smoothly to a speed."""

    def angle(t: Any) -> Any:
        s = jnp.minimum(t / rise, 1.0)
        return speed * (rise * (s**3 - s**4 / 2) + jnp.maximum(t - rise, 0.0))

    return angle


def blow(size: float, at: float, length: float) -> Over:
    """A short pulse of sine-squared shape, from `at` to `at` + `length`."""

    def value(t: Any) -> Any:
        s = (t - at) / length
        return size * jnp.where((s > 0) & (s < 1), jnp.sin(jnp.pi * s) ** 2, 0.0)

    return value


def chirp(size: float, low: float, high: float, duration: float) -> Over:
    """A sine whose angular frequency rises linearly from low to high over the duration."""
    rate = (high - low) / duration
    return lambda t: size * jnp.sin(low * t + rate * t**2 / 2)


def every(size: float, period: float, length: float) -> Over:
    """A short pulse of sine-squared shape in the middle of every period."""

    def value(t: Any) -> Any:
        s = (jnp.mod(t, period) - (period - length) / 2) / length
        return size * jnp.where((s > 0) & (s < 1), jnp.sin(jnp.pi * s) ** 2, 0.0)

    return value


def pushed(over: Over, direction: np.ndarray = UP) -> DeadForce:
    """A force of constant direction at the tip."""
    return DeadForce(body="body", at="tip", force=lambda t: over(t) * direction)


def struck(node: int, over: Over, direction: np.ndarray = UP) -> DeadForce:
    """A force of constant direction at one node."""
    return DeadForce(body="body", at=[node], force=lambda t: over(t) * direction)


def following(over: Over, direction: np.ndarray = UP) -> FollowerForce:
    """A follower force at the tip."""
    return FollowerForce(first=At("body", "tip"), force=lambda t: over(t) * direction)


def moving_force(nodes: list[int], places: np.ndarray, size: float, speed: float) -> DeadForce:
    """A force that travels over nodes along a line, shared by the two adjacent nodes."""
    width = float(np.diff(places).max())

    def force(t: Any) -> Any:
        shares = jnp.maximum(0.0, 1 - jnp.abs(places - speed * t) / width)
        return size * shares[:, None] * UP

    return DeadForce(body="body", at=nodes, force=force)


def alone(body: Any, *loads: Any, joints: tuple[Joint, ...] | None = None, **start: Any) -> System:
    """A machine of one body, clamped by default."""
    held = (clamped(),) if joints is None else joints
    return System((Placed(body, **start),), held, loads=tuple(loads))
