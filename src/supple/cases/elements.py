"""The springs and the other force elements of a case between two interfaces."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Field, Tag

from supple import machine
from supple.cases.laws import ONE, LoadLaw
from supple.cases.shared_rules import End, InterfaceOf, axes_with_length, usable_names
from supple.cases.table import Key, Made, OneOf, part, table_of
from supple.importers.toml import (
    NUMBERS_OR_ROWS,
    Mistakes,
    NonNegative,
    Positive,
    Raw,
    Vector,
    on_each,
    tables,
)

Pair = Annotated[tuple[float, float], Field(strict=False)]
Numbers = Annotated[tuple[float, ...], Field(strict=False)]
Rows = Annotated[tuple[Numbers, ...], Field(strict=False)]
Six = Annotated[tuple[float, float, float, float, float, float], Field(strict=False)]
SixRows = Annotated[tuple[Six, Six, Six, Six, Six, Six], Field(strict=False)]
DiagonalOrRows = Annotated[
    Annotated[Six, Tag(NUMBERS_OR_ROWS[0])] | Annotated[SixRows, Tag(NUMBERS_OR_ROWS[1])],
    Discriminator(lambda given: NUMBERS_OR_ROWS[_has_rows(given)]),
]
Square = Annotated[tuple[Pair, Pair], Field(strict=False)]


def _as_table(value: object) -> object:
    """A single matrix as a table of one."""
    rows = value if isinstance(value, list) else []
    alone = bool(rows) and all(
        isinstance(row, list) and not any(isinstance(each, list) for each in row) for row in rows
    )
    return [value] if alone else value


Squares = Annotated[tuple[Square, ...], Field(strict=False), BeforeValidator(_as_table)]


def _has_rows(given: object) -> bool:
    return isinstance(given, list | tuple) and any(isinstance(each, list | tuple) for each in given)


class Spring(Made):
    """A spring and damper between two interfaces, or one and the ground."""

    name: str | None = Field(None, description="for sensors")
    first: End = Field(description="ground or BODY.INTERFACE")
    second: InterfaceOf = Field(description="BODY.INTERFACE")


_STIFFNESS = Key(default=...)
StraightSpring = table_of(
    machine.SpringDamper,
    "straight",
    Spring,
    stiffness=_STIFFNESS,
    rest_length=Key(name="free_length", default=None),
)
TorsionSpring = table_of(
    machine.TorsionSpringDamper,
    "torsion",
    Spring,
    stiffness=_STIFFNESS,
    rest_angle=Key(float, "angle, rad", "free_angle"),
)
SpringTable = Annotated[Spring, OneOf(StraightSpring, TorsionSpring)]


class Element(Made):
    """The keys common to all elements."""

    name: str | None = Field(None, description="for sensors")
    first: End = Field(description="ground or BODY.INTERFACE")
    second: End = Field("ground", description="ground or BODY.INTERFACE")


def _element(makes: type[machine.ForceElement], kind: str, **by_hand: Any) -> Any:
    return table_of(makes, kind, Element, **by_hand)


def _in_time(kind: Any, description: str = "") -> Any:
    factor = Key(LoadLaw, "factor on value against time", "law", ONE)
    return part(machine.Scaled, vector=Key(kind, description, "value"), factor=factor)


def _surface(x: str, y: str, unit_of_x: str, unit_of_y: str, unit: str) -> Any:
    return part(
        machine.Surface,
        x=Key(Numbers, f"{x}, ascending, {unit_of_x}", x),
        y=Key(Numbers, f"{y}, ascending, {unit_of_y}", y),
        z=Key(Rows, f"a row for each of {x}, a column for each of {y}; {unit}", "values"),
    )


_PENALTY = part(machine.Penalty, exponent=Key(Annotated[float, Field(ge=1.0)], "power of the penetration"))
_CONTACT = {
    "penalty": _PENALTY,
    "friction": part(
        machine.Coulomb,
        coefficient=Key(NonNegative, "coefficient of friction", "friction", 0.0),
        width=Key(Positive, "sliding speed below which friction acts as a damper, a velocity", default=None),
    ),
}
_FOLLOWED = Key(LoadLaw, "prescribed angle or slide over time, rad or length", "law")
_SLIDING = "friction while sliding, a moment or a force"
_WIDTH = Key(description="rate or speed below which friction acts as a damper, rad per time or velocity")

ElementTable = Annotated[
    Element,
    OneOf(
        _element(
            machine.Bushing,
            "bushing",
            stiffness=Key(
                DiagonalOrRows,
                "three of translation, three of rotation, or six rows; force per length, moment per rad",
            ),
            damping=Key(DiagonalOrRows, "as stiffness; force per velocity, moment per angular velocity"),
            offset=Key(
                Vector,
                "offset of the ends at zero force, bushing axes, a length; default: that at the start",
                default=None,
            ),
        ),
        _element(machine.AngleStop, "angle-stop", penalty=_PENALTY),
        _element(machine.SlideStop, "slide-stop", penalty=_PENALTY),
        _element(
            machine.DistanceStop,
            "distance-stop",
            lower=Key(NonNegative, "lower limit of the distance, a length"),
            penalty=_PENALTY,
        ),
        _element(
            machine.RevoluteFriction, "hinge-friction", moment=_in_time(NonNegative, _SLIDING), width=_WIDTH
        ),
        _element(
            machine.PrismaticFriction, "slide-friction", force=_in_time(NonNegative, _SLIDING), width=_WIDTH
        ),
        _element(machine.TorqueBetween, "torque-between", torque=_in_time(float, "amplitude, a moment")),
        _element(machine.ForceBetween, "force-between", force=_in_time(float, "amplitude, a force")),
        _element(
            machine.TabledTorque,
            "tabled-torque",
            torque=_surface("angles", "rates", "rad", "rad per time", "a moment"),
        ),
        _element(
            machine.TabledForce,
            "tabled-force",
            force=_surface("slides", "speeds", "a length", "a velocity", "a force"),
        ),
        _element(
            machine.TabledTension,
            "tabled-tension",
            tension=_surface("distances", "speeds", "a length", "a velocity", "a force"),
        ),
        _element(
            machine.AngleServo,
            "angle-servo",
            angle=_FOLLOWED,
            limit=Key(Positive, "largest magnitude, a moment"),
        ),
        _element(
            machine.SlideServo,
            "slide-servo",
            slide=_FOLLOWED,
            limit=Key(Positive, "largest magnitude, a force"),
        ),
        _element(
            machine.MotorCurve,
            "motor",
            torque=part(
                machine.Curve,
                x=Key(Numbers, "angular velocities, ascending, rad per time", "speeds"),
                z=Key(Numbers, "moments at these speeds; linear in between, constant beyond", "torques"),
            ),
            command=Key(LoadLaw, "command over time; default 1", "law", ONE),
        ),
        _element(machine.Gear, "gear", line=None),
        _element(machine.Screw, "screw", offset=None),
        _element(machine.RackAndPinion, "rack-and-pinion", offset=None),
        _element(
            machine.JournalBearing,
            "bearing",
            stiffness=Key(
                Squares,
                "[[xx, xy], [yx, yy]], or [[[xx, xy], [yx, yy]], ..]: one for each of the speeds, "
                "force per length",
            ),
            damping=Key(Squares, "as stiffness, force per velocity; default: none", default=None),
        ),
        _element(machine.Unbalance, "unbalance"),
        _element(machine.SphereOnPlane, "sphere-on-plane", **_CONTACT),
        _element(
            machine.SphereOnCylinder, "sphere-on-cylinder", **_CONTACT, cylinder_radius=Key(default=None)
        ),
        _element(
            machine.SphereInCylinder, "sphere-in-cylinder", **_CONTACT, cylinder_radius=Key(default=None)
        ),
    ),
]


def _names_differ(raw: Raw) -> Mistakes:
    yield from usable_names(raw, "element")
    springs = {str(each["name"]) for _, each in tables(raw, "spring") if "name" in each}
    for path, each in tables(raw, "element"):
        if "name" in each and str(each["name"]) in springs:
            yield (*path, "name"), f"a spring is already named {each.get('name')!r}; names must differ"


def _contacts_are_whole(raw: Raw) -> Mistakes:
    for path, each in tables(raw, "element"):
        kind = each.get("kind")
        if kind in ("sphere-on-cylinder", "sphere-in-cylinder") and "cylinder_radius" not in each:
            yield path, f"a {kind} needs cylinder_radius; add cylinder_radius = 0.1"
        if str(kind).startswith("sphere") and each.get("friction") and "width" not in each:
            yield (
                path,
                "friction needs width, the sliding speed below which friction acts as a damper; add "
                "width = 0.001",
            )


RULES = (
    on_each("spring", axes_with_length),
    lambda raw: usable_names(raw, "spring"),
    on_each("element", axes_with_length),
    _names_differ,
    _contacts_are_whole,
)
