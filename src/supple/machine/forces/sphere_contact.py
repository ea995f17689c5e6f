"""Penalty contact of a sphere or a point with a plane or a cylinder, with friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import NotNegative, Positive
from supple.errors import ModelError
from supple.machine.forces.force_element import AnchoredElement, AxialElement
from supple.machine.forces.friction import Coulomb, regularized_direction
from supple.machine.forces.penalty import Penalty, penalty_energy, penalty_force
from supple.machine.pose import Parameters, Pose, Wrench, Wrenches

__all__ = ["SphereContact", "SphereInCylinder", "SphereOnCylinder", "SphereOnPlane"]

_NO_FRICTION = (0.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class SphereContact(AnchoredElement, AxialElement):
    """A sphere about the first end against a surface fixed to the second.

    At the deepest point of the sphere, the penalty force acts along the normal n of the surface, and friction
    against the sliding velocity v:

        F = N n - mu N v / sqrt(|v|^2 + w^2),      N = k depth^n (1 + a d depth/dt)

    A disc or a wheel acts as a sphere while its axis is parallel to the plane or to the axis of the cylinder.

    axis : normal of the plane, or axis of the cylinder, at the start, global axes
    radius : radius of the sphere, a length; 0 for a point, such as an interface at a node
    penalty : stiffness and dissipation of the contact
    friction : Coulomb friction; None: no friction
    """

    radius: NotNegative = 0.0
    penalty: Penalty
    friction: Coulomb | None = None

    @property
    def parameters(self) -> tuple[float, ...]:
        """`(radius, mu, w, k, n, a)`."""
        friction = _NO_FRICTION
        if self.friction is not None:
            friction = (self.friction.coefficient, self.friction.width)
        return (self.radius, *friction, *self.penalty.parameters)


@dataclass(frozen=True, kw_only=True)
class SphereOnPlane(SphereContact):
    """A sphere (first end) on a plane through the second end; `axis` is the plane's outward normal."""

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Wrenches on the sphere and on the plane."""
        return _pushed(first, second, _on_plane(first, second, parameters[0]), parameters)

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """Energy of the penalty."""
        return penalty_energy(_on_plane(first, second, parameters[0]).depth, parameters[3:])


@dataclass(frozen=True, kw_only=True)
class _CylinderContact(SphereContact):
    """A sphere against a cylinder about `axis` through the second end."""

    cylinder_radius: Positive

    @property
    def parameters(self) -> tuple[float, ...]:
        """`(radius, mu, w, k, n, a, cylinder_radius)`."""
        return (*super().parameters, self.cylinder_radius)


@dataclass(frozen=True, kw_only=True)
class SphereOnCylinder(_CylinderContact):
    """A sphere (first end) outside a cylinder about `axis` through the second end, for example a cam roller.

    cylinder_radius : radius of the cylinder, a length
    """

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Wrenches on the sphere and on the cylinder."""
        return _pushed(first, second, _on_cylinder(first, second, parameters), parameters[:-1])

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """Energy of the penalty."""
        return penalty_energy(_on_cylinder(first, second, parameters).depth, parameters[3:-1])


@dataclass(frozen=True, kw_only=True)
class SphereInCylinder(_CylinderContact):
    """A sphere (first end) inside a hollow cylinder about `axis` through the second end.

    cylinder_radius : inner radius, larger than the sphere's, a length
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (np.isfinite(self.cylinder_radius) and self.cylinder_radius > self.radius):
            raise ModelError(
                f"{self.label}: the cylinder's radius must be more than the sphere's, got "
                f"{self.cylinder_radius} and {self.radius}"
            )

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Wrenches on the sphere and on the cylinder."""
        return _pushed(first, second, _in_cylinder(first, second, parameters), parameters[:-1])

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """Energy of the penalty."""
        return penalty_energy(_in_cylinder(first, second, parameters).depth, parameters[3:-1])


class _Touch(NamedTuple):
    depth: jax.Array
    normal: jax.Array
    """(3,), from the surface to the sphere"""


def _on_plane(first: Pose, second: Pose, radius: jax.Array) -> _Touch:
    normal = second.axes[:, 2]
    return _Touch(radius - normal @ (first.point - second.point), normal)


def _from_axis(first: Pose, second: Pose) -> tuple[jax.Array, jax.Array]:
    """Distance of the sphere's centre from the cylinder's axis, and unit vector (3,) from the axis to it."""
    axis = second.axes[:, 2]
    between = first.point - second.point
    between = between - (axis @ between) * axis
    square = between @ between
    # On the axis the unit vector is undefined, and zero is returned.
    distance = jnp.sqrt(jnp.where(square > 0, square, 1.0))
    return jnp.where(square > 0, distance, 0.0), between / distance


def _on_cylinder(first: Pose, second: Pose, parameters: Parameters) -> _Touch:
    distance, outwards = _from_axis(first, second)
    return _Touch(parameters[0] + parameters[-1] - distance, outwards)


def _in_cylinder(first: Pose, second: Pose, parameters: Parameters) -> _Touch:
    distance, outwards = _from_axis(first, second)
    return _Touch(distance + parameters[0] - parameters[-1], -outwards)


def _pushed(first: Pose, second: Pose, touch: _Touch, parameters: Parameters) -> Wrenches:
    """Wrenches of the normal force and friction at the deepest point of the sphere, on both ends."""
    radius, friction, width, *penalty = parameters
    arm = -radius * touch.normal
    other_arm = first.point + arm - second.point
    velocity = first.velocity + jnp.cross(first.angular_velocity, arm)
    velocity = velocity - second.velocity - jnp.cross(second.angular_velocity, other_arm)
    approach = -touch.normal @ velocity
    normal_force = penalty_force(touch.depth, approach, penalty)
    sliding = velocity + approach * touch.normal
    force = normal_force * (touch.normal - friction * regularized_direction(sliding, width))
    return Wrench(force, jnp.cross(arm, force)), Wrench(-force, -jnp.cross(other_arm, force))
