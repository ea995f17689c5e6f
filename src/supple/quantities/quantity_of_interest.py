"""Quantities of interest with error estimates: positions, the force of a joint, stress at nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from supple.arrays import FloatArray
from supple.body import BodyForm
from supple.integrate import FramedMotion, Solution
from supple.machine import System
from supple.quantities.reading import QuantityKind

__all__ = ["QuantityOfInterest", "WholeBody"]


ROUND_OFF = 1e-12
"""Largest displacement of an undeformed body, relative to its size."""
_ROWS = 64
"""Number of output times whose nodal positions are in memory at once."""


class QuantityOfInterest(Protocol):
    """A quantity of a run, such as a sensor; its error is the largest RMS error of its points over time."""

    @property
    def name(self) -> str:
        """Name in the error report; for a whole body the name of the body."""
        ...

    @property
    def words(self) -> str:
        """Description of the quantity and its norm."""
        ...

    @property
    def quantity(self) -> QuantityKind:
        """Kind of the quantity, which determines the unit of its error."""
        ...

    @property
    def body(self) -> str | None:
        """The body of the quantity; None for a quantity of the machine."""
        ...

    def at_points(self, system: System, solution: Solution, /) -> FloatArray:
        """Values at the output times, (t, points, components)."""
        ...

    def size(self, system: System, solution: Solution, /) -> float:
        """Reference size for a relative error."""
        ...


def quantity_distance(
    quantity: QuantityOfInterest, system: System, solution: Solution, other_system: System, other: Solution
) -> float:
    """Largest RMS distance over the points of a quantity between two runs; infinite if a run stopped early.

    It is also infinite if the runs have different numbers of output times.
    """
    if solution.stopped is not None or other.stopped is not None or len(solution.times) != len(other.times):
        return np.inf
    largest = 0.0
    for rows in blocks_of_times(len(solution.times)):
        found = quantity.at_points(system, solution.at(rows))
        apart = found - quantity.at_points(other_system, other.at(rows))
        largest = max(largest, float(np.mean(_squares(apart), axis=1).max()))
    return float(np.sqrt(largest))


@dataclass(frozen=True)
class WholeBody:
    """Positions of all nodes of a body in space."""

    body: str
    quantity: ClassVar[QuantityKind] = QuantityKind.LENGTH

    @property
    def name(self) -> str:
        """Name of the body."""
        return self.body

    @property
    def words(self) -> str:
        """Description of the quantity and its norm."""
        return f"positions of body '{self.body}': RMS over its nodes, largest over the run"

    def at_points(self, system: System, solution: Solution) -> FloatArray:
        """Positions (t, N, 3)."""
        return system.placed(self.body, "stated error").body.positions(solution.bodies[self.body])

    def size(self, system: System, solution: Solution) -> float:
        """Largest displacement of a node over the run, relative to the body's first interface.

        At least `ROUND_OFF` of the size of the body: rounding errors of a body that nothing deforms are not
        compared with each other.
        """
        body = system.placed(self.body, "stated error").body
        found = largest_displacement(body, solution.motion(self.body, FramedMotion).coordinates)
        return max(found, ROUND_OFF * float(np.ptp(body.nodes, axis=0).max(initial=0.0)))


def largest_displacement(
    body: BodyForm, coordinates: FloatArray, nodes: np.ndarray | slice = slice(None)
) -> float:
    """Largest displacement of a node over time, relative to the first interface; without one, to the frame.

    coordinates : (t, r)
    nodes : nodes to evaluate; all by default
    The rotation of the interface relative to the frame is assumed to be small.
    """
    sizes = []
    for rows in blocks_of_times(len(coordinates)):
        displaced = body.expand(coordinates[rows])[:, nodes]
        if body.interfaces:
            base = body.interfaces[0]
            fields = _rigid_fields(body.nodes[nodes] - base.position)
            displaced = displaced - np.tensordot(coordinates[rows] @ base.motion.T, fields, axes=1)
        sizes.append(np.sqrt(_squares(displaced).max()))
    return float(max(sizes))


def _rigid_fields(arms: FloatArray) -> FloatArray:
    """Displacements (6, k, 3) at points (k, 3) by unit translations, then by small rotations."""
    axes = np.eye(3)[:, None]
    return np.concatenate([np.broadcast_to(axes, (3, *arms.shape)), np.cross(axes, arms)])


def _squares(vectors: FloatArray) -> FloatArray:
    """Squared lengths (t, k) of vectors (t, k, c)."""
    return np.einsum("tkc,tkc->tk", vectors, vectors)


def blocks_of_times(n: int) -> list[slice]:
    """Slices of n output times, in blocks of `_ROWS`."""
    return [slice(start, start + _ROWS) for start in range(0, n, _ROWS)]
