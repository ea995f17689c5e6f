"""The loads of a case."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from supple.cases.laws import Constant, Law, TableLaw
from supple.importers.toml import CheckedTable, Mistakes, Raw, Vector, names, tables
from supple.machine import (
    At,
    DeadForce,
    DeadTorque,
    FollowerForce,
    FollowerTorque,
    ForceElement,
    Scaled,
)


class Load(CheckedTable):
    """A force or torque in time."""

    kind: Literal["force", "torque"]
    at: str = Field(description="BODY.INTERFACE; or BODY.NODE_SET, whose nodes share a force evenly")
    vector: Vector = Field(description="a force or moment, along global axes (at the start, if it follows)")
    follower: bool = Field(False, description="true turns the load with its interface")
    law: Law = Field(
        default=Constant(kind="constant", value=1.0), description="factor on vector against time"
    )

    def build(self, body: str, at: str | NDArray[np.int64], folder: Path) -> DeadForce | ForceElement:
        """The load on a body, at an interface or at nodes; over nodes a force is shared evenly.

        folder : where the file of its law lies
        """
        law = self.law
        factor = law.build_of_load(folder) if isinstance(law, TableLaw) else law.build(folder)
        vector = np.array(self.vector)
        if not isinstance(at, str):
            return DeadForce(body=body, at=at, force=Scaled(vector / len(at), factor))
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


def _suit_their_place(raw: Raw) -> Mistakes:
    """A node set carries forces only: it has no axes for a load to turn with, nor rotations for a torque."""
    places = {
        f"{body.get('name')}.{name}" for _, body in tables(raw, "body") for name in names(body, "interface")
    }
    for path, load in tables(raw, "load"):
        turns = load.get("kind") == "torque" or load.get("follower") is True
        if turns and load.get("at") not in places:
            message = "a torque or a follower load acts at an interface; add one around these nodes"
            yield (*path, "at"), message


RULES = (_suit_their_place,)
