"""Readings of a controller: positions and velocities; not accelerations, which depend on the outputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from supple.errors import ModelError
from supple.machine.ends import GROUND, At, as_end

__all__ = ["EndReading", "JointReading"]


@dataclass(frozen=True)
class JointReading:
    """`AxialMotion` of a joint: angle, rate, slide and speed, as in `JointMotionSensor`.

    The angle continues beyond pi if each step rotates the joint by less than half a revolution.
    """

    joint: str
    """Name of the joint"""
    near: float = 0.0
    """Angle, rad, within half a revolution of which the initial angle lies; set by `Start`"""


@dataclass(frozen=True)
class EndReading:
    """`Pose` of an interface in global components: point, axes, velocity, angular velocity."""

    at: At | Any
    """"BODY.INTERFACE" or `At(body, interface)`; its axes coincide with the global axes at assembly"""

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", as_end(self.at))
        if self.at == GROUND:
            raise ModelError(
                "a controller reads the ground, which does not move: give an interface of a body"
            )


Reading = JointReading | EndReading
