"""Motor: torque as a function of speed and command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import numpy as np

from supple.machine.forces.characteristic import Curve, Surface, curve_at, surface_at
from supple.machine.forces.force_element import AxialElement
from supple.machine.forces.relative_motion import axial_motion, moment_pair
from supple.machine.laws.time_law import OverTime
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["MotorCurve"]

_OF_A_CURVE = 2


@dataclass(frozen=True, kw_only=True)
class MotorCurve(AxialElement):
    """Torque on the second end about an axis of the first, as a function of the relative rate, rad per time.

    torque : Curve over the rate, multiplied by the command; or Surface over rate (rows) and command (columns)
    command : a number or a law of time; the output of a controller adds to it
    """

    torque: Curve | Surface
    command: OverTime = 1.0

    law_field: ClassVar[str] = "command"
    blocked_by: ClassVar[tuple[str, ...]] = ("rotation", "tilt about")

    @property
    def parameters(self) -> tuple[np.ndarray, ...]:
        """Arrays of the table."""
        return self.torque.parameters

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:
        """Equal and opposite moments about the first end's axis."""
        rate = axial_motion(first, second).rate
        if len(parameters) == _OF_A_CURVE:
            return moment_pair(first, value * curve_at(rate, parameters))
        return moment_pair(first, surface_at(rate, value, parameters))
