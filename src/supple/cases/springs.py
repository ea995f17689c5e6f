"""The springs and dampers of a case."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from supple.cases.shared_rules import End, InterfaceOf, axes_with_length, usable_names
from supple.cases.table import Key, Made, OneOf, table_of
from supple.importers.toml import on_each
from supple.machine import SpringDamper, TorsionSpringDamper


class Spring(Made):
    """A spring and damper between two interfaces, or one and the ground."""

    name: str | None = Field(None, description="for sensors")
    first: End = Field(description="ground or BODY.INTERFACE")
    second: InterfaceOf = Field(description="BODY.INTERFACE")


_STIFFNESS = Key(default=...)
StraightSpring = table_of(
    SpringDamper,
    "straight",
    Spring,
    stiffness=_STIFFNESS,
    rest_length=Key(name="free_length", default=None),
)
TorsionSpring = table_of(
    TorsionSpringDamper,
    "torsion",
    Spring,
    stiffness=_STIFFNESS,
    rest_angle=Key(float, "angle, rad", "free_angle"),
)
SpringTable = Annotated[Spring, OneOf(StraightSpring, TorsionSpring)]


RULES = (on_each("spring", axes_with_length), lambda raw: usable_names(raw, "spring"))
