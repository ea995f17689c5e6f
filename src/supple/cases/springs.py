"""The springs and dampers of a case."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from supple.cases.shared_rules import axes_with_length, usable_names
from supple.importers.toml import CheckedTable, Mistakes, NonNegative, Raw, Vector, on_each
from supple.machine import SpringDamper, System, TorsionSpringDamper, as_end


class StraightSpring(CheckedTable):
    """A spring and damper along the line between two interfaces that stay apart."""

    kind: Literal["straight"]
    name: str | None = Field(None, description="for sensors")
    first: str = Field(description="BODY.INTERFACE")
    second: str = Field(description="BODY.INTERFACE")
    stiffness: NonNegative = Field(description="force per length")
    damping: NonNegative = Field(0.0, description="force per velocity")
    free_length: NonNegative | None = Field(
        None, description="a length; the distance at the start if left out"
    )

    def build(self, system: System) -> SpringDamper:
        """The spring between bodies of a system."""
        length = self.free_length
        if length is None:
            first, second = (system.initial_point(as_end(end)) for end in (self.first, self.second))
            length = float(np.linalg.norm(second - first))
        return SpringDamper(
            first=self.first,
            second=self.second,
            stiffness=self.stiffness,
            damping=self.damping,
            rest_length=length,
        )


class TorsionSpring(CheckedTable):
    """A spring and damper about an axis, between two interfaces or one and the ground."""

    kind: Literal["torsion"]
    name: str | None = Field(None, description="for sensors")
    first: str = Field(description="ground or BODY.INTERFACE")
    second: str = Field(description="BODY.INTERFACE")
    axis: Vector = Field(description="direction at the start, global axes; its length does not matter")
    stiffness: NonNegative = Field(description="moment per angle in rad")
    damping: NonNegative = Field(0.0, description="moment per angular velocity in rad per time")
    free_angle: float = Field(0.0, description="angle, rad")

    def build(self, _system: System) -> TorsionSpringDamper:
        """The spring between bodies of a system."""
        return TorsionSpringDamper(
            first=self.first,
            second=self.second,
            axis=self.axis,
            stiffness=self.stiffness,
            damping=self.damping,
            rest_angle=self.free_angle,
        )


Spring = Annotated[StraightSpring | TorsionSpring, Field(discriminator="kind")]


def _names_differ(raw: Raw) -> Mistakes:
    yield from usable_names(raw, "spring")


RULES = (on_each("spring", axes_with_length), _names_differ)
