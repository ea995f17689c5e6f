"""Readings of a controller: positions and velocities, not accelerations, which depend on its outputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from supple.errors import ModelError
from supple.machine.ends import GROUND, At, as_end

__all__ = ["EndReading", "JointReading"]


@dataclass(frozen=True)
class JointReading:
    """Angle, rate, slide and speed of a joint, an `AxialMotion`, as of a `JointMotionSensor`.

    The angle continues beyond pi, as long as a step rotates the joint by less than half a revolution.
    """

    joint: str
    """Name of the joint"""


@dataclass(frozen=True)
class EndReading:
    """Position and motion of an interface, a `Pose`: point, axes, velocity, angular velocity; global."""

    at: At | Any
    """"BODY.INTERFACE" or `At(body, interface)`; its axes are global ones at assembly"""

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", as_end(self.at))
        if self.at == GROUND:
            raise ModelError(
                "a controller reads the ground, which does not move: give an interface of a body"
            )


Reading = JointReading | EndReading
