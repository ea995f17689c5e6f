"""The loads of a case."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from supple.cases.body_kinds import NO_INTERFACES, at_elements
from supple.cases.laws import ONE, LoadLaw
from supple.cases.shared_rules import PlaceOf
from supple.cases.table import Key, Made, OneOf, part, table_of
from supple.errors import ModelError
from supple.importers.toml import Mistakes, Raw, Vector, names, tables
from supple.machine import (
    At,
    BaseAcceleration,
    DeadForce,
    DeadTorque,
    FollowerForce,
    FollowerPressure,
    FollowerTorque,
    ForceElement,
    Scaled,
)
from supple.quantities import Place


class Force(Made):
    """A force or torque over time."""

    kind: Literal["force", "torque"] = Field(description="force or torque")
    at: PlaceOf = Field(description="BODY.INTERFACE; or BODY.NODE_SET, whose nodes share a force evenly")
    vector: Vector = Field(description="global components (for a follower at the start), force or moment")
    follower: bool = Field(False, description="true rotates the load with its interface")
    law: LoadLaw = Field(ONE, description="factor on vector against time")

    def build(self, *context: Any) -> DeadForce | ForceElement:
        """The load.

        context : the folder of the law's file, and a function from `at` to the `Place`
        """
        folder, place, *_ = context
        body, at = place(self.at).body, place(self.at).at
        factor, vector = self.law.build(folder), np.array(self.vector)
        if not isinstance(at, str):
            return DeadForce(body=body, at=np.array(at), force=Scaled(vector / len(at), factor))
        history = Scaled(vector, factor)
        match self.kind, self.follower:
            case "force", False:
                return DeadForce(body=body, at=at, force=history)
            case "force", True:
                return FollowerForce(first=At(body, at), force=history)
            case "torque", False:
                return DeadTorque(first=At(body, at), torque=history)
            case _:
                return FollowerTorque(first=At(body, at), torque=history)


def _faces(at: str, _: Path, __: Callable[[str], Place], pressed: Callable[[str], np.ndarray]) -> np.ndarray:
    found = pressed(at)
    if not len(found):
        raise ModelError(
            f"a pressure on '{at}' needs an outer face of a solid or shell with all corners in the set; "
            "give a set with whole faces"
        )
    return found


_FACTOR = Key(LoadLaw, "factor against time", "law", ONE)
Pressure = table_of(
    FollowerPressure,
    "pressure",
    body=Key(
        PlaceOf,
        "BODY.NODE_SET; the pressure acts on the outer faces of this set, inwards",
        "at",
        through=lambda at, *_: at.partition(".")[0],
    ),
    faces=Key(str, name="at", through=_faces),
    pressure=part(Scaled, vector=Key(float, "positive inwards, force per area", "pressure"), factor=_FACTOR),
)
Base = table_of(
    BaseAcceleration,
    "base-acceleration",
    acceleration=part(Scaled, vector=Key(Vector, "an acceleration, global axes"), factor=_FACTOR),
)
Load = Annotated[Made, OneOf(Force, Pressure, Base)]


def _suit_their_place(raw: Raw) -> Mistakes:
    """The rule that torques and follower loads are at interfaces: node sets have no axes and no rotations."""
    places = {
        f"{body.get('name')}.{name}" for _, body in tables(raw, "body") for name in names(body, "interface")
    }
    explicit = {str(body.get("name")) for _, body in tables(raw, "body") if "explicit" in body}
    for path, load in tables(raw, "load"):
        turns = load.get("kind") == "torque" or load.get("follower") is True
        at = str(load.get("at"))
        if turns and at not in places:
            name = at.partition(".")[0]
            message = "a torque or a follower load needs an interface; add one at these nodes"
            yield (*path, "at"), f"{name!r} {NO_INTERFACES}" if name in explicit else message


_OF_PRESSURE = ("to carry a pressure", "a pressure acts on the faces of")
RULES = (
    _suit_their_place,
    lambda raw: at_elements(raw, tables(raw, "load"), {"pressure": _OF_PRESSURE}),
)
