"""The loads of a case."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from supple.cases.law_tables import Constant, Law
from supple.cases.laws import time_function
from supple.cases.raw_tables import Mistakes, Raw, names, tables
from supple.cases.table import Table, Vector
from supple.machine import (
    At,
    DeadForce,
    DeadTorque,
    FollowerForce,
    FollowerTorque,
    ForceElement,
    System,
)
from supple.machine.system import interface_names
from supple.mesh import Mesh


class Load(Table):
    """A force or torque in time."""

    kind: Literal["force", "torque"]
    at: str = Field(description="BODY.INTERFACE; or BODY.NODE_SET, whose nodes share a force evenly")
    vector: Vector = Field(description="N or N m, along global axes (at the start, if it follows)")
    follower: bool = Field(False, description="true turns the load with its interface")
    law: Law = Field(
        default=Constant(kind="constant", value=1.0), description="factor on vector against time"
    )

    def build(self, system: System, meshes: Mapping[str, Mesh], folder: Path) -> DeadForce | ForceElement:
        """The load on a system; over a node set a force is shared evenly.

        folder : where the file of its law lies
        """
        factor = time_function(self.law, folder)
        vector = np.array(self.vector)
        name, _, place = self.at.partition(".")
        body = system.bodies[system.body_index(name)].body
        if place not in interface_names(body):
            nodes = meshes[name].nodes_of(place)
            return DeadForce(body=name, at=nodes, force=lambda t: vector / len(nodes) * factor(t))

        def history(t: Any) -> Any:
            return vector * factor(t)

        match self.kind, self.follower:
            case "force", False:
                return DeadForce(body=name, at=place, force=history)
            case "force", True:
                return FollowerForce(first=At(name, place), force=history)
            case "torque", False:
                return DeadTorque(first=At(name, place), torque=history)
            case _:
                return FollowerTorque(first=At(name, place), torque=history)


def _suit_their_place(raw: Raw) -> Mistakes:
    """A node set carries forces only: it has no axes for a load to turn with, nor rotations for a torque."""
    places = {
        f"{body.get('name')}.{name}" for _, body in tables(raw, "body") for name in names(body, "interface")
    }
    for path, load in tables(raw, "load"):
        turns = load.get("kind") == "torque" or load.get("follower") is True
        if turns and load.get("at") not in places:
            yield (
                (*path, "at"),
                "a torque or a follower load acts at an interface; add one around these nodes",
            )


RULES = (_suit_their_place,)
