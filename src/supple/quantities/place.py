"""Places of bodies: an interface, a node, or the mean of some nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from supple.arguments import check_sequence, check_text, given
from supple.arrays import FloatArray
from supple.body import BodyForm, NodeMotion
from supple.body.floating_kinematics import checked_nodes
from supple.errors import ArgumentError, ModelError
from supple.integrate import Motion, Solution
from supple.machine import At, System, as_end

__all__ = ["Place"]


@dataclass(frozen=True)
class Place:
    """A place of a body: an interface by its name, or the mean of some nodes by their numbers."""

    body: str
    at: str | tuple[int, ...]

    def __post_init__(self) -> None:
        check_text("Place, body", self.body, "the name of a body")
        if not isinstance(self.at, str):
            check_sequence("Place, at", self.at, "the name of an interface, or node numbers")
            object.__setattr__(self, "at", tuple(np.asarray(self.at).tolist()))
        if not self.at:
            raise ModelError(f"a place of body '{self.body}': give an interface, or node numbers")

    def body_of(self, system: System, sensor: str) -> BodyForm:
        """The form of the body; ModelError if the body or the place does not exist."""
        body = body_named(system, self.body, sensor)
        if isinstance(self.at, str):
            body.interface(self.at)
        else:
            checked_nodes(self.at, len(body.nodes))
        return body

    def rest(self, body: BodyForm) -> FloatArray:
        """Undeformed position of the place, (3,), mesh axes."""
        if isinstance(self.at, str):
            return body.interface(self.at).position
        return body.nodes[list(self.at)].mean(axis=0)

    def points(self, body: BodyForm, motion: Motion) -> FloatArray:
        """Positions (t, k, 3) of the k nodes in space, or (t, 1, 3) of the interface."""
        if isinstance(self.at, str):
            return body.interface_motion(motion, self.at).position[:, None]
        return body.positions(motion, self.at)

    def point(self, body: BodyForm, motion: Motion) -> FloatArray:
        """Position (t, 3) of the interface, or mean position of the nodes, in space."""
        return _mean(self.points(body, motion))

    def motion(self, system: System, solution: Solution, sensor: str) -> NodeMotion:
        """Position, velocity and acceleration of the place in space, each (t, 3)."""
        body, motion = body_named(system, self.body, sensor), solution.bodies[self.body]
        if isinstance(self.at, str):
            moving = body.interface_motion(motion, self.at)
            return NodeMotion(moving.position, moving.velocity, moving.acceleration)
        return NodeMotion(*map(_mean, body.node_motion(motion, self.at)))


def as_place(what: str, value: Any) -> Place:
    """A `Place` from a `Place`, from "BODY.INTERFACE", or from an `At`; ArgumentError otherwise."""
    if isinstance(value, Place):
        return value
    if isinstance(value, At) or (isinstance(value, str) and "." in value):
        end = as_end(value)
        return Place(end.body, end.interface)
    expected = 'Place(body, at) with an interface or node numbers, or "BODY.INTERFACE"'
    raise ArgumentError(f"{what}: expected {expected}, got {given(value)}")


def body_named(system: System, body: str, sensor: str) -> BodyForm:
    """The form of a body; ModelError, with the most similar name, if there is none."""
    return system.placed(body, f"sensor '{sensor}'").body


def _mean(vectors: FloatArray) -> FloatArray:
    """Mean (t, 3) of vectors (t, k, 3) over the nodes."""
    # A product: `mean` over a short middle axis takes eight times as long.
    k = vectors.shape[1]
    return np.full(k, 1 / k) @ vectors
