"""The joints of a case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, get_args

from pydantic import Field

from supple import machine
from supple.cases.laws import Law
from supple.cases.shared_rules import End, InterfaceOf, axes_with_length, joint_label, usable_names
from supple.cases.table import Made
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, NonNegative, Positive, Raw, Vector, on_each

JointKind = Literal[
    "fixed",
    "ball",
    "revolute",
    "universal",
    "cylindrical",
    "prismatic",
    "point-on-line",
    "prescribed-rotation",
    "prescribed-translation",
]
_KINDS: Mapping[str, type[machine.Joint]] = MappingProxyType(
    {kind: getattr(machine, kind.title().replace("-", "")) for kind in get_args(JointKind)}
)
_RENAMED = {"first_axis": "axis", "angle": "law", "displacement": "law"}


def _known(kind: str) -> dict[str, str]:
    """The keys that a kind of joint has besides its ends, by the fields of its class."""
    own = (each.name for each in fields(_KINDS[kind]) if each.name not in ("first", "second", "name"))
    return {name: _RENAMED.get(name, name) for name in own}


def _needed(kind: str) -> set[str]:
    """The keys among these without a default."""
    needed = {each.name for each in fields(_KINDS[kind]) if each.default is MISSING}
    return {key for name, key in _known(kind).items() if name in needed}


_EXAMPLES = {
    "axis": "[1, 0, 0]",
    "second_axis": "[0, 1, 0]",
    "x_axis": "[1, 0, 0]",
    "law": '{kind = "spin-up", speed = 1.0, duration = 10.0}',
}


class Friction(CheckedTable):
    """Coulomb friction proportional to the force in the joint."""

    coefficient: NonNegative = Field(description="coefficient of friction")
    width: Positive = Field(
        description="sliding speed below which friction acts as a damper, rad per time or velocity"
    )
    radius: Positive | None = Field(None, description="revolute: radius of the pin, a length")

    def build(self, joint: machine.Joint) -> machine.JointFriction:
        """The friction in a joint."""
        if self.radius is None:
            return machine.SlideFriction(joint=joint, coefficient=self.coefficient, width=self.width)
        return machine.HingeFriction(
            joint=joint, coefficient=self.coefficient, radius=self.radius, width=self.width
        )


class JointTable(CheckedTable):
    """A connection of two interfaces, or of one with the ground."""

    kind: JointKind = Field(description="degrees of freedom that the joint constrains")
    name: str | None = Field(None, description="label in results; default: kind and ends")
    first: End = Field(description="ground or BODY.INTERFACE")
    second: InterfaceOf = Field(description="BODY.INTERFACE")
    axis: Vector | None = Field(None, description="direction at the start, global axes, of any length")
    x_axis: Vector | None = Field(None, description="fixed: x axis of the joint forces, global axes")
    second_axis: Vector | None = Field(None, description="universal: the other cross-pin axis, global axes")
    law: Law | None = Field(None, description="prescribed joints: angle or distance over time, rad or length")
    friction: Friction | None = Field(
        None, description="revolute and prismatic: friction proportional to the joint force"
    )

    @property
    def label(self) -> str:
        """The label of the joint."""
        return self.name or joint_label(self.kind, self.first, self.second)

    def build(self, folder: Path) -> machine.Joint:
        """The joint; `folder` contains the files of laws."""
        own: dict[str, Any] = {name: getattr(self, key) for name, key in _known(self.kind).items()}
        own = {name: value.build(folder) if isinstance(value, Made) else value for name, value in own.items()}
        return _KINDS[self.kind](first=self.first, second=self.second, name=self.label, **own)


def _has_what_its_kind_needs(path: KeyPath, joint: Raw) -> Mistakes:
    kind = str(joint.get("kind"))
    if kind not in _KINDS:
        return
    needed, known = _needed(kind), _known(kind).values()
    for key, example in _EXAMPLES.items():
        if key in needed and key not in joint:
            yield path, f"a {kind} joint needs {key}; add {key} = {example}"
        if key in joint and key not in known:
            yield (*path, key), f"a {kind} joint takes no {key}; remove the key"
    friction = joint.get("friction")
    if isinstance(friction, Mapping):
        if kind not in ("revolute", "prismatic"):
            yield (*path, "friction"), f"a {kind} joint takes no friction; remove the key"
        elif kind == "revolute" and "radius" not in friction:
            yield (
                (*path, "friction"),
                "the friction of a revolute joint needs the radius of its pin; add radius = 0.01",
            )
        elif kind == "prismatic" and "radius" in friction:
            yield (
                (*path, "friction", "radius"),
                "the friction of a prismatic joint takes no radius; remove the key",
            )


RULES = (
    lambda raw: usable_names(raw, "joint"),
    on_each("joint", _has_what_its_kind_needs, axes_with_length),
)
