"""Coulomb friction that depends on the force in a joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import NotNegative, Positive, check_instance
from supple.machine.ends import GROUND, At
from supple.machine.forces.force_element import ForceElement
from supple.machine.forces.friction import regularized_direction
from supple.machine.forces.relative_motion import axial_motion, force_pair, moment_pair
from supple.machine.joints.joint import Joint
from supple.machine.joints.prismatic import Prismatic
from supple.machine.joints.revolute import Revolute
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["HingeFriction", "JointFriction", "SlideFriction"]


@dataclass(frozen=True, kw_only=True)
class JointFriction(ForceElement):
    """Friction `mu N v / sqrt(v^2 + w^2)` in a joint, where N is the joint force across the axis.

    N depends on the motion: it is computed from the joint's Lagrange multipliers at the same instant. Forces
    along the axis and moments cause no friction.

    joint : a joint of the machine          coefficient : mu, not negative
    width : w; for |v| below w the friction acts as a damper
    """

    joint: Joint
    coefficient: NotNegative
    width: Positive
    first: At | Any = GROUND
    second: At | Any = GROUND
    """`first` and `second` are set to the ends of the joint; given values are ignored."""

    reads_reaction: ClassVar[bool] = True
    kinds: ClassVar[tuple[type[Joint], ...]] = ()
    """Supported types of joints"""

    def __post_init__(self) -> None:
        names = " or ".join(kind.__name__ for kind in self.kinds)
        check_instance(type(self).__name__, self.joint, self.kinds, f"a joint of the machine, {names}")
        object.__setattr__(self, "first", self.joint.first)
        object.__setattr__(self, "second", self.joint.second)
        super().__post_init__()

    @property
    def label(self) -> str:
        """Name for messages."""
        return f"{type(self).__name__} in joint '{self.joint.name}'"

    @property
    def initial_axes(self) -> np.ndarray:
        """Axes of the joint."""
        return self.joint.initial_axes


@dataclass(frozen=True, kw_only=True)
class HingeFriction(JointFriction):
    """Moment `mu r N v / sqrt(v^2 + w^2)` against the rate v of a hinge whose pin has the radius r.

    width : w, rad per time         radius : r
    """

    radius: Positive

    kinds: ClassVar[tuple[type[Joint], ...]] = (Revolute,)

    @property
    def parameters(self) -> tuple[float, ...]:
        """`(mu r, w)`."""
        return (self.coefficient * self.radius, self.width)

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:
        """Equal and opposite moments about the axis; `value` (2,) is the joint force across the axis."""
        lever, width = parameters
        rate = axial_motion(first, second).rate
        return moment_pair(first, -lever * _size(value) * regularized_direction(rate, width))


@dataclass(frozen=True, kw_only=True)
class SlideFriction(JointFriction):
    """Force `mu N v / sqrt(v^2 + w^2)` against the speed v of a slide.

    width : w, a velocity
    """

    kinds: ClassVar[tuple[type[Joint], ...]] = (Prismatic,)
    parameter_fields: ClassVar[tuple[str, ...]] = ("coefficient", "width")

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:
        """Equal and opposite forces along the axis; `value` (2,) is the joint force across the axis."""
        coefficient, width = parameters
        speed = axial_motion(first, second).speed
        force = -coefficient * _size(value) * regularized_direction(speed, width)
        return force_pair(first, second, force * first.axes[:, 2], jnp.zeros(3))


def _size(across: jax.Array) -> jax.Array:
    """Magnitude of a force (2,), with a finite derivative at zero."""
    square = across @ across
    return jnp.where(square > 0, jnp.sqrt(jnp.where(square > 0, square, 1.0)), 0.0)
