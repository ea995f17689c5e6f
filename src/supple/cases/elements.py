"""The machine elements of a case: what acts between two interfaces besides springs and joints."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from supple import machine
from supple.cases.laws import Law, TableLaw
from supple.cases.shared_rules import axes_with_length, usable_names
from supple.importers.toml import CheckedTable, Mistakes, NonNegative, Positive, Raw, Vector, on_each, tables

Pair = Annotated[tuple[float, float], Field(strict=False)]
Numbers = Annotated[tuple[float, ...], Field(strict=False)]
Six = Annotated[tuple[float, float, float, float, float, float], Field(strict=False)]
Square = Annotated[tuple[Pair, Pair], Field(strict=False)]
Teeth = Annotated[tuple[int, int], Field(strict=False)]

_AXIS = Field(description="direction at the start, global axes; it stays with the first end")


class _Element(CheckedTable):
    """What all elements share; keys of the same name are the element's own."""

    name: str | None = Field(None, description="for sensors")
    first: str = Field(description="ground or BODY.INTERFACE")
    second: str = Field("ground", description="ground or BODY.INTERFACE")

    makes: ClassVar[Callable[..., machine.ForceElement]]
    """The class of the element, where the keys say all."""

    def build(self, _folder: Path) -> machine.ForceElement:
        """The element; its laws' files lie in the folder."""
        return type(self).makes(**self._own())

    def _own(self, *left_out: str) -> dict[str, Any]:
        """The keys that the element has too, those that say something."""
        skipped = {"kind", "name", *left_out}
        own = {key: getattr(self, key) for key in type(self).model_fields if key not in skipped}
        return {key: value for key, value in own.items() if value is not None}


class _Pushing(_Element):
    stiffness: Positive = Field(description="force per length (moment per rad) to the power of the exponent")
    exponent: float = Field(1.0, ge=1.0)
    dissipation: NonNegative = Field(0.0, description="per velocity: restitution near 1 - 2/3 dissipation v")

    @property
    def _penalty(self) -> machine.Penalty:
        return machine.Penalty(stiffness=self.stiffness, exponent=self.exponent, dissipation=self.dissipation)

    def _rest(self, *left_out: str) -> dict[str, Any]:
        return {**self._own("stiffness", "exponent", "dissipation", *left_out), "penalty": self._penalty}


def _value(law: Law | None, folder: Path) -> Any:
    if law is None:
        return 1.0
    return law.build_of_load(folder) if isinstance(law, TableLaw) else law.build(folder)


class Bushing(_Element):
    """Stiffness and damping against all six motions, diagonal in the axes of the first end."""

    kind: Literal["bushing"]
    makes = machine.Bushing
    axis: Vector = Field((0.0, 0.0, 1.0), description="z of the bushing at the start, global axes")
    x_axis: Vector | None = Field(None, description="near which x lies")
    stiffness: Six = Field(description="three of translation, three of rotation")
    damping: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class AxialStop(_Pushing):
    """A stop of an angle or of a slide."""

    kind: Literal["angle-stop", "slide-stop"]
    axis: Vector = _AXIS
    lower: float
    upper: float

    def build(self, _folder: Path) -> machine.ForceElement:
        """The stop."""
        made = machine.AngleStop if self.kind == "angle-stop" else machine.SlideStop
        return made(**self._rest())


class DistanceStop(_Pushing):
    """A stop of the distance of two points."""

    kind: Literal["distance-stop"]
    lower: NonNegative = 0.0
    upper: float | None = None
    anchor: Vector | None = Field(None, description="global point of an end on the ground")

    def build(self, _folder: Path) -> machine.ForceElement:
        """The stop."""
        return machine.DistanceStop(**self._rest())


class Friction(_Element):
    """Coulomb friction of a preload in a hinge or a slide."""

    kind: Literal["hinge-friction", "slide-friction"]
    axis: Vector = _AXIS
    value: NonNegative = Field(description="moment, or force, of sliding")
    law: Law | None = Field(None, description="factor on value against time")
    width: Positive = Field(description="rate, or speed, below which it acts as a damper")

    def build(self, folder: Path) -> machine.ForceElement:
        """The friction."""
        size = machine.Scaled(self.value, _value(self.law, folder))
        own = self._own("value", "law")
        if self.kind == "hinge-friction":
            return machine.RevoluteFriction(**own, moment=size)
        return machine.PrismaticFriction(**own, force=size)


class Between(_Element):
    """A torque about an axis, or a force along it, on the second end; the opposite on the first."""

    kind: Literal["torque-between", "force-between"]
    axis: Vector = _AXIS
    value: float
    law: Law | None = Field(None, description="factor on value against time")

    def build(self, folder: Path) -> machine.ForceElement:
        """The torque or force."""
        size, own = machine.Scaled(self.value, _value(self.law, folder)), self._own("value", "law")
        if self.kind == "torque-between":
            return machine.TorqueBetween(**own, torque=size)
        return machine.ForceBetween(**own, force=size)


class Servo(_Element):
    """Spring and damper that make an angle or a slide follow a law."""

    kind: Literal["angle-servo", "slide-servo"]
    axis: Vector = _AXIS
    law: Law = Field(description="angle in rad, or slide, against time")
    stiffness: NonNegative
    damping: NonNegative = 0.0
    limit: Positive | None = Field(None, description="largest moment or force")

    def build(self, folder: Path) -> machine.ForceElement:
        """The servo."""
        wanted, own = _value(self.law, folder), self._own("law")
        if self.kind == "angle-servo":
            return machine.AngleServo(**own, angle=wanted)
        return machine.SlideServo(**own, slide=wanted)


class Motor(_Element):
    """A torque by the rate at which the second end turns, times a command."""

    kind: Literal["motor"]
    axis: Vector = _AXIS
    speeds: Numbers = Field(description="rad per time, ascending")
    torques: Numbers = Field(description="at these; straight lines between, held beyond")
    law: Law | None = Field(None, description="the command against time; 1 if left out")

    def build(self, folder: Path) -> machine.ForceElement:
        """The motor."""
        curve = machine.Curve(self.speeds, self.torques)
        own = self._own("speeds", "torques", "law")
        return machine.MotorCurve(**own, torque=curve, command=_value(self.law, folder))


class Gear(_Element):
    """Spur gear of two wheels on parallel axes."""

    kind: Literal["gear"]
    makes = machine.Gear
    axis: Vector = _AXIS
    teeth: Teeth = Field(description="of both wheels; negative of a ring with inner teeth")
    stiffness: Positive
    damping: NonNegative = 0.0
    anchor: Vector | None = Field(None, description="global centre of a wheel that is the ground")


class Screw(_Element):
    """A slide that follows an angle."""

    kind: Literal["screw"]
    makes = machine.Screw
    axis: Vector = _AXIS
    pitch: float = Field(description="length per turn, positive for a right-hand thread")
    stiffness: Positive
    damping: NonNegative = 0.0


class Rack(_Element):
    """A pinion (second end) that rolls along a rack (first)."""

    kind: Literal["rack-and-pinion"]
    makes = machine.RackAndPinion
    axis: Vector = Field(description="of the pinion at the start, global axes")
    direction: Vector = Field(description="of the rack at the start, global axes")
    radius: float = Field(
        description="of the pitch circle; it touches at - axis x direction, or the other side"
    )
    stiffness: Positive
    damping: NonNegative = 0.0


class Bearing(_Element):
    """Stiffness and damping across the axis of a rotor, the second end, by speed."""

    kind: Literal["bearing"]
    makes = machine.JournalBearing
    axis: Vector = _AXIS
    x_axis: Vector | None = Field(None, description="near which x lies")
    speeds: Numbers = (0.0, 1.0)
    stiffness: Annotated[tuple[Square, ...], Field(strict=False)] = Field(
        description="[[[xx, xy], [yx, yy]], ..]: a matrix for each of the speeds"
    )
    damping: Annotated[tuple[Square, ...], Field(strict=False)] | None = None


class Unbalance(_Element):
    """Centrifugal force of a small mass beside an interface."""

    kind: Literal["unbalance"]
    makes = machine.Unbalance
    moment: Vector = Field(description="mass times eccentricity, global axes at the start")


class Contact(_Pushing):
    """A sphere or point (first end) against a surface that belongs to the second."""

    kind: Literal["sphere-on-plane", "sphere-on-cylinder", "sphere-in-cylinder"]
    axis: Vector = Field(
        description="normal of the plane, or axis of the cylinder, at the start, global axes"
    )
    radius: NonNegative = 0.0
    cylinder_radius: Positive | None = None
    friction: NonNegative = Field(0.0, description="coefficient")
    width: Positive | None = Field(None, description="friction: sliding speed below which it is a damper")
    anchor: Vector | None = Field(None, description="global point of the surface, if it is on the ground")

    def build(self, _folder: Path) -> machine.ForceElement:
        """The contact."""
        own = self._rest("friction", "width")
        if self.width is not None:
            own["friction"] = machine.Coulomb(coefficient=self.friction, width=self.width)
        kinds = {
            "sphere-on-plane": machine.SphereOnPlane,
            "sphere-on-cylinder": machine.SphereOnCylinder,
            "sphere-in-cylinder": machine.SphereInCylinder,
        }
        return kinds[self.kind](**own)


ElementTable = Annotated[
    Bushing
    | AxialStop
    | DistanceStop
    | Friction
    | Between
    | Servo
    | Motor
    | Gear
    | Screw
    | Rack
    | Bearing
    | Unbalance
    | Contact,
    Field(discriminator="kind"),
]


def _names_differ(raw: Raw) -> Mistakes:
    yield from usable_names(raw, "element")
    springs = {each.get("name") for _, each in tables(raw, "spring")} - {None}
    for path, each in tables(raw, "element"):
        if each.get("name") in springs:
            yield (*path, "name"), f"a spring is already named {each.get('name')!r}; names must differ"


def _contacts_are_whole(raw: Raw) -> Iterator[tuple[Any, str]]:
    for path, each in tables(raw, "element"):
        kind = each.get("kind")
        if kind in ("sphere-on-cylinder", "sphere-in-cylinder") and "cylinder_radius" not in each:
            yield path, f"a {kind} needs cylinder_radius; add cylinder_radius = 0.1"
        if kind == "sphere-on-plane" and "cylinder_radius" in each:
            yield (*path, "cylinder_radius"), "a plane has no cylinder_radius; remove the key"
        if str(kind).startswith("sphere") and each.get("friction") and "width" not in each:
            yield (
                path,
                "friction needs width, the sliding speed below which it acts as a damper; add width = 0.001",
            )


RULES = (on_each("element", axes_with_length), _names_differ, _contacts_are_whole)
