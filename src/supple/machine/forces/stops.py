"""Stops: limits of an angle, a slide or a distance, by penalty."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ModelError
from supple.machine.forces.force_element import AnchoredElement, AxialElement, ForceElement
from supple.machine.forces.penalty import Penalty, penalty_energy, penalty_force
from supple.machine.forces.relative_motion import (
    axial_motion,
    force_pair,
    line_motion,
    moment_pair,
    tension_pair,
    wrapped,
)
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["AngleStop", "DistanceStop", "SlideStop"]


@dataclass(frozen=True, kw_only=True)
class _Stop(ForceElement):
    """A force by a penalty beyond a lower and an upper limit."""

    lower: float
    upper: float
    penalty: Penalty

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_limits()

    def _check_limits(self) -> None:
        if not self.lower <= self.upper:  # also for NaN
            raise ModelError(
                f"{self.label}: lower must not be above upper, got {self.lower} and {self.upper}"
            )

    @property
    def parameters(self) -> tuple[float, ...]:
        """Limits and penalty."""
        return (self.lower, self.upper, *self.penalty.parameters)


@dataclass(frozen=True, kw_only=True)
class AngleStop(_Stop, AxialElement):
    """Moment that limits the angle of the second end about the first end's axis to `lower <= phi <= upper`.

    The angle is counted from -pi to pi about the middle of both limits: it does not jump near a limit.

    lower, upper : limits of the angle, rad, between -pi and pi
    penalty : Penalty, whose depth is the angle beyond a limit, rad
    """

    def _check_limits(self) -> None:
        if not -np.pi < self.lower <= self.upper < np.pi:
            raise ModelError(
                f"{self.label}: the limits must be -pi < lower <= upper < pi, because the angle jumps at pi; "
                f"got {self.lower} and {self.upper}"
            )

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """A moment towards the range between the limits."""
        motion = axial_motion(first, second)
        return moment_pair(first, _push(_near_limits(motion.angle, parameters), motion.rate, parameters))

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """Energy of the penalty."""
        return _stored(_near_limits(axial_motion(first, second).angle, parameters), parameters)


@dataclass(frozen=True, kw_only=True)
class SlideStop(_Stop, AxialElement):
    """Force that limits the slide `x = z_1 . (r_2 - r_1)` along the first end's axis: `lower <= x <= upper`.

    lower, upper : limits of the slide, a length; infinite: no stop on that side
    penalty : Penalty, whose depth is the slide beyond a limit
    """

    lower: float = -np.inf
    upper: float = np.inf

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """A force towards the range between the limits."""
        motion = axial_motion(first, second)
        push = _push(motion.slide, motion.speed, parameters)
        return force_pair(first, second, push * first.axes[:, 2], jnp.zeros(3))

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """Energy of the penalty."""
        return _stored(axial_motion(first, second).slide, parameters)


@dataclass(frozen=True, kw_only=True)
class DistanceStop(_Stop, AnchoredElement):
    """Force that limits the distance of two points to `lower <= l <= upper`: a rope or a bump stop.

    lower, upper : limits of the distance, a length; an infinite upper limit is no stop
    penalty : Penalty, whose depth is the distance beyond a limit
    """

    lower: float = 0.0
    upper: float = np.inf

    acts_along_line: ClassVar[bool] = True

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Equal and opposite forces along the line."""
        motion = line_motion(first, second)
        return tension_pair(motion, -_push(motion.length, motion.rate, parameters))

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """Energy of the penalty."""
        between = second.point - first.point
        return _stored(jnp.sqrt(between @ between), parameters)


def _near_limits(angle: jax.Array, parameters: Parameters) -> jax.Array:
    """The angle, by whole revolutions within pi of the middle of both limits."""
    middle = (parameters[0] + parameters[1]) / 2
    return middle + wrapped(angle - middle)


def _push(place: jax.Array, rate: jax.Array, parameters: Parameters) -> jax.Array:
    """Positive force below the lower limit, negative above the upper one."""
    lower, upper, *penalty = parameters
    return penalty_force(lower - place, -rate, penalty) - penalty_force(place - upper, rate, penalty)


def _stored(place: jax.Array, parameters: Parameters) -> jax.Array:
    lower, upper, *penalty = parameters
    return penalty_energy(lower - place, penalty) + penalty_energy(place - upper, penalty)
