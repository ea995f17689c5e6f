"""Ties, supports, and contacts of explicit parts with rigid obstacles or with each other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Field

from supple.cases.shared_rules import PlaceOf
from supple.cases.table import Key, Made, OneOf, table_of
from supple.importers.toml import (
    CheckedTable,
    KeyPath,
    Mistakes,
    Positive,
    Raw,
    Vector,
    on_each,
    table,
    tables,
    unknown,
)
from supple.machine import (
    At,
    Collocated,
    Contact,
    EveryNode,
    MeanMotion,
    Mortar,
    RigidCylinder,
    RigidPlane,
    RigidSphere,
    Support,
    SurfaceContact,
    Tie,
)


def _end(place: str) -> At:
    body, _, nodes = place.partition(".")
    return At(body, nodes)


_MOVING: dict[str, Any] = {
    "velocity": Key(Vector, "initial velocity, a velocity; constant if mass is not given"),
    "mass": Key(Positive, "mass of an obstacle that is free to move, a mass; default: infinite"),
}
_RADIUS = Key(Positive, "radius, a length")
Plane = table_of(
    RigidPlane,
    "plane",
    point=Key(Vector, "point on the plane, global axes, a length"),
    normal=Key(Vector, "normal, towards the side of the nodes"),
    **_MOVING,
)
Cylinder = table_of(
    RigidCylinder,
    "cylinder",
    point=Key(Vector, "point on the axis, global axes, a length"),
    axis=Key(Vector, "direction, global axes"),
    radius=_RADIUS,
    **_MOVING,
)
Sphere = table_of(
    RigidSphere, "sphere", centre=Key(Vector, "centre, global axes, a length"), radius=_RADIUS, **_MOVING
)


class ContactTable(CheckedTable):
    """Penalty contact of nodes with an obstacle or another part."""

    nodes: PlaceOf = Field(description="BODY.NODE_SET")
    obstacle: Annotated[Made, OneOf(Plane, Cylinder, Sphere)] | None = None
    surface: PlaceOf | None = Field(
        None, description="BODY.NODE_SET: instead of an obstacle, the outer faces of another part on this set"
    )
    stiffness: Positive | None = Field(None, description="force per depth; default: from fraction")
    fraction: float = Field(
        0.2,
        gt=0.0,
        le=1.0,
        description="stiffness relative to m omega_max^2 of a node; divides the step by at most "
        "sqrt(1 + fraction), with a surface by sqrt(1 + 2 fraction)",
    )

    def build(self) -> Contact | SurfaceContact:
        """The contact."""
        if self.surface is not None:
            return SurfaceContact(_end(self.nodes), _end(self.surface), self.stiffness, self.fraction)
        assert self.obstacle is not None  # a rule of the case file
        return Contact(_end(self.nodes), self.obstacle.build(), self.stiffness, self.fraction)


MeanContinuity = table_of(MeanMotion, "mean-motion")
_OPENING = Field(gt=0.0, lt=1.0)
NodalContinuity = table_of(
    EveryNode,
    "every-node",
    tolerance=Key(
        Annotated[float, _OPENING],
        "singular value, relative to the largest, below which a combination of gaps is not constrained",
    ),
)
CollocatedTransfer = table_of(Collocated, "collocated")
MortarTransfer = table_of(Mortar, "mortar")


class TieTable(CheckedTable):
    """Nodes that move with another part."""

    nodes: PlaceOf = Field(description="BODY.NODE_SET; of a modal part only if the other part is modal")
    on: str = Field(description="the part that the nodes are tied to")
    transfer: Annotated[Made, OneOf(CollocatedTransfer, MortarTransfer)] = Field(
        CollocatedTransfer(kind="collocated"), description="how nodes follow a modal part of another mesh"
    )
    continuity: Annotated[Made, OneOf(MeanContinuity, NodalContinuity)] = Field(
        MeanContinuity(kind="mean-motion"), description="continuity of two modal parts"
    )
    within: Positive = Field(1e-6, description="largest distance from the part, relative to the set's size")

    def build(self) -> Tie:
        """The tie."""
        return Tie(_end(self.nodes), self.on, self.within, self.transfer.build(), self.continuity.build())


class SupportTable(CheckedTable):
    """Nodes of an explicit part that are fixed."""

    nodes: PlaceOf = Field(description="BODY.NODE_SET of an explicit part")
    axes: str = Field("xyz", pattern="^[xyz]{1,3}$", description="fixed directions, global axes")
    rotations: bool = Field(False, description="true also fixes rotations of shells about these axes")

    def build(self) -> Support:
        """The support."""
        axes = tuple("xyz".index(axis) for axis in sorted(set(self.axes)))
        turns = tuple(axis + 3 for axis in axes) if self.rotations else ()
        return Support(_end(self.nodes), axes + turns)


def _touches_one_thing(path: KeyPath, contact: Raw) -> Mistakes:
    given = [key for key in ("obstacle", "surface") if key in contact]
    if len(given) != 1:
        seen = " and ".join(given) or "neither"
        yield path, f"a contact needs exactly one of obstacle, surface; this one has {seen}"


def _is_stiff_by_one_key(path: KeyPath, contact: Raw) -> Mistakes:
    if "stiffness" in contact and "fraction" in contact:
        message = "the stiffness is given, so the fraction has no effect; remove one of the two"
        yield (*path, "fraction"), message


def _part_places(raw: Raw) -> Iterator[tuple[KeyPath, object]]:
    """Every BODY.NODE_SET of ties, contacts and supports, with the path of its key."""
    for section in ("tie", "contact", "support"):
        for path, item in tables(raw, section):
            for key in ("nodes", "surface"):
                if key in item:
                    yield (*path, key), item[key]


def _suit_their_parts(raw: Raw) -> Mistakes:
    """The rule that ties and contacts are at modal or explicit parts, and supports at explicit elements.

    Nodes of explicit elements are tied to a modal part, not the other way round.
    """
    kinds = {
        str(body.get("name")): "modal" if "modal" in body else "explicit" if "explicit" in body else None
        for _, body in tables(raw, "body")
    }
    for path, place in _part_places(raw):
        name = str(place).partition(".")[0]
        if name in kinds and kinds[name] is None:
            yield (
                path,
                f"body {name!r} has a floating frame; give it modal = {{..}} or explicit = {{..}}",
            )
        elif path[0] == "support" and kinds.get(name) == "modal":
            yield path, "supports are for explicit elements, and this part is modal; give it explicit = {..}"
    for path, tie in tables(raw, "tie"):
        name, on = str(tie.get("nodes")).partition(".")[0], tie.get("on")
        if not isinstance(on, str):
            continue  # the schema reports it
        if on not in kinds:
            yield (*path, "on"), unknown("body", on, list(kinds))
        elif name == on:
            yield (*path, "on"), "a part cannot be tied to itself; name another part"
        elif (kinds.get(name), kinds.get(on)) == ("modal", "explicit"):
            message = (
                "a modal part cannot be tied to an explicit one; give the nodes of the explicit part, and "
                "tie them to the modal one (on)"
            )
            yield (*path, "nodes"), message
        elif table(tie, "transfer").get("kind") == "mortar" and kinds.get(on) == "explicit":
            message = (
                "explicit parts are tied node to node; a mortar is for ties to modal parts: remove the key"
            )
            yield (*path, "transfer"), message
        elif "continuity" in tie and kinds.get(name) == "explicit":
            message = "explicit nodes are tied one by one; remove the key, or tie two modal parts"
            yield (*path, "continuity"), message


RULES = (on_each("contact", _touches_one_thing, _is_stiff_by_one_key), _suit_their_parts)
