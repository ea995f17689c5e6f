"""What the error of a run is stated of: a whole body, the deflection of a place, the force of a joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.integrate import Solution
from supple.machine import System
from supple.quantities.run_distance import blocks_of_times, largest_displacement

__all__ = ["Deflection", "JointForce", "JudgedQuantity", "WholeBody"]

Array = NDArray[np.float64]


class JudgedQuantity(Protocol):
    """A quantity of a run; its error is the largest over time of its RMS over the points."""

    @property
    def name(self) -> str:
        """Under which statements are kept; of a whole body that of the body."""
        ...

    @property
    def words(self) -> str:
        """What it is and in which norm, in words."""
        ...

    @property
    def body(self) -> str | None:
        """The body that it is of; None of a quantity of the machine."""
        ...

    def values(self, system: System, solution: Solution) -> Array:
        """At the output times, (t, points, components)."""
        ...

    def size(self, system: System, solution: Solution) -> float:
        """What an error in it is small against."""
        ...


def quantity_distance(
    quantity: JudgedQuantity, system: System, solution: Solution, other_system: System, other: Solution
) -> float:
    """Largest distance of two runs in a quantity, RMS over its points; infinite where one broke off."""
    if solution.stopped is not None or other.stopped is not None or len(solution.times) != len(other.times):
        return np.inf
    largest = 0.0
    for rows in blocks_of_times(len(solution.times)):
        apart = quantity.values(system, solution.at(rows)) - quantity.values(other_system, other.at(rows))
        largest = max(largest, float(np.mean(np.sum(apart**2, axis=2), axis=1).max()))
    return float(np.sqrt(largest))


@dataclass(frozen=True)
class WholeBody:
    """Positions of all nodes of a body in space."""

    body: str

    @property
    def name(self) -> str:
        """That of the body."""
        return self.body

    @property
    def words(self) -> str:
        """The quantity and its norm."""
        return f"positions of body '{self.body}': RMS over its nodes, largest over the run"

    def values(self, system: System, solution: Solution) -> Array:
        """Positions (t, N, 3)."""
        return _form(system, self.body).positions(solution.bodies[self.body])

    def size(self, system: System, solution: Solution) -> float:
        """Largest displacement of a node, seen from the first interface."""
        return largest_displacement(_form(system, self.body), solution.bodies[self.body])


@dataclass(frozen=True)
class Deflection:
    """Positions in space of some nodes of a body, such as those at its tip.

    nodes : node numbers, or the name of an interface: the nodes that it is made of are not asked, its own
        motion is
    """

    body: str
    nodes: tuple[int, ...] | str
    label: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.nodes, str):
            object.__setattr__(self, "nodes", tuple(int(node) for node in self.nodes))
        if not self.nodes:
            raise ModelError(f"deflection of body '{self.body}': name an interface, or give node numbers")

    @property
    def name(self) -> str:
        """The label, or body and place."""
        place = self.nodes if isinstance(self.nodes, str) else f"{len(self.nodes)} nodes"
        return self.label or f"{self.body}.{place}"

    @property
    def words(self) -> str:
        """The quantity and its norm."""
        norm = "" if isinstance(self.nodes, str) or len(self.nodes) == 1 else "RMS over its nodes, "
        return f"position of {self.name}: {norm}largest over the run"

    def values(self, system: System, solution: Solution) -> Array:
        """Positions (t, k, 3)."""
        form, motion = _form(system, self.body), solution.bodies[self.body]
        if isinstance(self.nodes, str):
            return form.interface_motion(motion, self.nodes).position[:, None]
        return form.positions(motion, np.array(self.nodes))

    def size(self, system: System, solution: Solution) -> float:
        """Largest displacement of a node of the body, seen from its first interface."""
        form, motion = _form(system, self.body), solution.bodies[self.body]
        if isinstance(self.nodes, str):
            return largest_displacement(form, motion)
        return largest_displacement(form, motion, np.array(self.nodes))


@dataclass(frozen=True)
class JointForce:
    """Force of a joint on its second end, in the axes of the joint."""

    joint: str

    @property
    def name(self) -> str:
        """Says which joint's force."""
        return f"force of {self.joint}"

    @property
    def words(self) -> str:
        """The quantity and its norm."""
        return f"force of joint '{self.joint}': largest over the run"

    @property
    def body(self) -> str | None:
        """None: it is between two."""
        return None

    def values(self, system: System, solution: Solution) -> Array:  # noqa: ARG002 - the solution holds it
        """Force (t, 1, 3)."""
        if self.joint not in solution.joint_forces:
            known = ", ".join(solution.joint_forces) or "none"
            raise ModelError(
                f"there is no joint '{self.joint}' whose force could be judged; there is: {known}"
            )
        return solution.joint_forces[self.joint][:, None, :3]

    def size(self, system: System, solution: Solution) -> float:
        """The largest force."""
        return float(np.linalg.norm(self.values(system, solution), axis=2).max())


def _form(system: System, name: str) -> Any:
    return system.bodies[system.body_index(name, "stated error")].body
