"""Spring and damper along the line between two points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np

from supple.errors import ModelError
from supple.multibody.joints.joint import GROUND
from supple.multibody.loads.force_element import ForceElement, check_not_negative
from supple.multibody.marker import Marker, Wrench, point, point_velocity

__all__ = ["SpringDamper"]


@dataclass(frozen=True, kw_only=True)
class SpringDamper(ForceElement):
    """Tension `k (l - l_0) + c dl/dt` along the line between the points; they must stay apart."""

    stiffness: float = 0.0
    damping: float = 0.0
    rest_length: float = 0.0
    anchor: tuple[float, float, float] | None = None
    """Global point of the end that is on the ground, where one is."""

    acts_along_line: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        check_not_negative(self, stiffness=self.stiffness, damping=self.damping, rest_length=self.rest_length)

    @property
    def parameters(self) -> tuple[float, ...]:
        """`(k, c, l_0)`."""
        return (self.stiffness, self.damping, self.rest_length)

    @staticmethod
    def wrenches(first: Marker, second: Marker, value: Any, parameters: Any) -> tuple[Wrench, Wrench]:  # noqa: ARG004
        """Equal and opposite forces along the line."""
        stiffness, damping, rest_length = parameters
        gap = point(second) - point(first)
        length = jnp.sqrt(gap @ gap)
        direction = gap / length
        rate = direction @ (point_velocity(second) - point_velocity(first))
        force = (stiffness * (length - rest_length) + damping * rate) * direction
        return Wrench(force, jnp.zeros(3)), Wrench(-force, jnp.zeros(3))
