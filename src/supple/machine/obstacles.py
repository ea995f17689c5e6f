"""Rigid obstacles: planes, cylinders, spheres; fixed, driven at a velocity, or free with a mass."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import jax.numpy as jnp
import numpy as np
from jax import Array

from supple.arguments import check_fields
from supple.errors import ModelError

__all__ = ["RigidCylinder", "RigidPlane", "RigidSphere", "is_moving", "moved"]

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class RigidPlane:
    """The half space behind a plane; the normal points to the side of the nodes.

    point : (3,) m;   normal : (3,) of any length;   velocity : (3,) m/s;   mass : kg
    Raises ModelError for a zero normal, or a mass that is not positive.
    """

    point: Vector
    normal: Vector
    velocity: Vector = (0.0, 0.0, 0.0)
    mass: float = float("inf")

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "normal", _unit("the normal of a plane", self.normal))
        _check_mass(self.mass)

    def gap(self, x: Array) -> tuple[Array, Array]:
        """Distances (n,) of points (3, n) from the surface in its initial position, and its normals (3, n).

        A distance is negative inside the obstacle; normals are unit vectors that point out of the obstacle.
        """
        n = jnp.array(self.normal)[:, None]
        return (n * (x - jnp.array(self.point)[:, None])).sum(axis=0), jnp.broadcast_to(n, x.shape)


@dataclass(frozen=True)
class RigidSphere:
    """A sphere.

    centre : (3,) m;   radius : m;   velocity : (3,) m/s;   mass : kg
    Raises ModelError for a mass or radius that is not positive.
    """

    centre: Vector
    radius: float
    velocity: Vector = (0.0, 0.0, 0.0)
    mass: float = float("inf")

    def __post_init__(self) -> None:
        check_fields(self)
        _check_mass(self.mass)
        _check_radius(self.radius)

    def gap(self, x: Array) -> tuple[Array, Array]:
        """Distances (n,) and normals (3, n), as of `RigidPlane`."""
        return _from_core(x - jnp.array(self.centre)[:, None], self.radius)


@dataclass(frozen=True)
class RigidCylinder:
    """An infinite cylinder.

    point : (3,) m, on the axis;   axis : (3,) of any length;   radius : m;   velocity : (3,) m/s;   mass : kg
    Raises ModelError for a zero axis, or a mass or radius that is not positive.
    """

    point: Vector
    axis: Vector
    radius: float
    velocity: Vector = (0.0, 0.0, 0.0)
    mass: float = float("inf")

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "axis", _unit("the axis of a cylinder", self.axis))
        _check_mass(self.mass)
        _check_radius(self.radius)

    def gap(self, x: Array) -> tuple[Array, Array]:
        """Distances (n,) and normals (3, n), as of `RigidPlane`."""
        axis = jnp.array(self.axis)[:, None]
        arm = x - jnp.array(self.point)[:, None]
        return _from_core(arm - axis * (axis * arm).sum(axis=0), self.radius)


Obstacle = RigidPlane | RigidSphere | RigidCylinder
"""A rigid surface that translates from a velocity, which is constant if the mass is infinite."""
_Obstacle = TypeVar("_Obstacle", bound=Obstacle)


def is_moving(obstacle: Obstacle) -> bool:
    """Whether an obstacle is driven or free."""
    return any(obstacle.velocity) or np.isfinite(obstacle.mass)


def moved(obstacle: _Obstacle, offset: np.ndarray, velocity: np.ndarray) -> _Obstacle:
    """A moving obstacle after a displacement (3,), at a velocity (3,); a fixed one is unchanged."""
    if not is_moving(obstacle):
        return obstacle
    place = "centre" if isinstance(obstacle, RigidSphere) else "point"
    at = np.asarray(getattr(obstacle, place)) + offset
    return replace(obstacle, **{place: tuple(at.tolist())}, velocity=tuple(velocity.tolist()))


def _from_core(arm: Array, radius: float) -> tuple[Array, Array]:
    squared = (arm * arm).sum(axis=0)
    distance = jnp.sqrt(jnp.where(squared > 0, squared, 1.0))
    return jnp.where(squared > 0, distance, 0.0) - radius, arm / distance


def _unit(what: str, vector: Vector) -> tuple[float, ...]:
    size = float(np.linalg.norm(vector))
    if not size > 0:
        raise ModelError(f"{what} must not vanish, got {vector}")
    return tuple(float(c) / size for c in vector)


def _check_mass(mass: float) -> None:
    if not mass > 0:
        raise ModelError(
            f"the mass of an obstacle must be positive (infinite for a constant velocity), got {mass}"
        )


def _check_radius(radius: float) -> None:
    if not (np.isfinite(radius) and radius > 0):
        raise ModelError(f"the radius of an obstacle must be a positive length, got {radius}")
