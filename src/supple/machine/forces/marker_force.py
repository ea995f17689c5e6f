"""Forces and torques at an interface, over time: dead (direction fixed in space) or follower (rotating)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp

from supple.machine.forces.force_element import ForceElement
from supple.machine.laws.time_law import OverTime
from supple.machine.pose import Parameters, Pose, Wrench, Wrenches

__all__ = ["DeadTorque", "FollowerForce", "FollowerTorque"]


def _at_rest() -> Wrench:
    return Wrench(jnp.zeros(3), jnp.zeros(3))


@dataclass(frozen=True, kw_only=True)
class FollowerForce(ForceElement):
    """A force that rotates with its interface."""

    force: OverTime
    """(3,) components along the interface's axes, which in the initial configuration are the global ones."""

    law_field: ClassVar[str] = "force"
    value_shape: ClassVar[tuple[int, ...]] = (3,)
    acts_on_first_alone: ClassVar[bool] = True

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """`F = A_p f(t)` on the first end, where A_p are the axes of this end; zero on the second end."""
        return Wrench(first.axes @ value, jnp.zeros(3)), _at_rest()


@dataclass(frozen=True, kw_only=True)
class FollowerTorque(ForceElement):
    """A torque that rotates with its interface."""

    torque: OverTime
    """(3,) components along the interface's axes, which in the initial configuration are the global ones."""

    law_field: ClassVar[str] = "torque"
    value_shape: ClassVar[tuple[int, ...]] = (3,)
    acts_on_first_alone: ClassVar[bool] = True

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """`M = A_p m(t)` on the first end, where A_p are the axes of this end; zero on the second end."""
        return Wrench(jnp.zeros(3), first.axes @ value), _at_rest()


@dataclass(frozen=True, kw_only=True)
class DeadTorque(ForceElement):
    """A torque with a direction fixed in space."""

    torque: OverTime
    """(3,) global components."""

    law_field: ClassVar[str] = "torque"
    value_shape: ClassVar[tuple[int, ...]] = (3,)
    acts_on_first_alone: ClassVar[bool] = True

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """`M = m(t)` on the first end; zero on the second end."""
        return Wrench(jnp.zeros(3), jnp.asarray(value)), _at_rest()
