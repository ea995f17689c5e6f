"""Useless and doubtful rounds of a self-correction, and the motion outside a basis if its target is not met.

The error of a useless round is not smaller than that of the round before. The round after a useless one is
not accepted, because its columns were found in the same way: a loop that ended with the first small estimate
would accept estimates that are too small by chance. If an earlier round met the target, this rule does not
apply.

A doubtful estimate (`BodyError.is_doubtful`) is accepted if two consecutive runs confirm it: their distance
must agree with the estimated error of the first, or both this distance and this error must be at most the
allowed error. The two runs are the previous round and this one, or this round and a run with the next bases.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from supple.body.full_body import FullBody
from supple.reduction import ReducedBody, ReductionBasis
from supple.reduction.locking import TOLERATED

AGREES = 2.0
"""Largest factor by which the distance of two runs may be larger or smaller than the estimated error of the
first run; within this factor, they agree."""


def is_useless(errors: Sequence[float]) -> bool:
    """Whether the last error is no smaller than the one before; False if that one is infinite or missing."""
    return len(errors) > 1 and bool(np.isfinite(errors[-2])) and not errors[-1] < errors[-2]


def locking_loss(body: ReducedBody) -> float:
    """Largest relative deficit of a static deflection caused by locking; 0 if it was not computed.

    A reduced body locks if stiff motion that follows the deflection is outside its basis.
    """
    return 0.0 if body.report.locking is None else body.report.locking.largest_remaining


def locks(body: ReducedBody) -> bool:
    """Whether locking reduces a static deflection by more than the fraction `TOLERATED`."""
    return locking_loss(body) > TOLERATED


def doubt(body: ReducedBody, indicator: float) -> str:
    """Reason why an estimate is doubtful, as text."""
    if locks(body):
        return f"body '{body.name}' locks: static deflections are {100 * locking_loss(body):.2g} % too small"
    return f"motion of {indicator:.2g} at rest is outside the basis of body '{body.name}'"


def is_confirmed(estimated: float, distance: float, allowed: float) -> bool:
    """Whether a run with a richer basis confirms the estimated error of the previous run.

    distance : largest distance of the two runs, in the quantity of interest
    """
    agrees = estimated / AGREES <= distance <= AGREES * estimated
    return agrees or max(estimated, distance) <= allowed


@dataclass(frozen=True)
class MissedPart:
    """The leading motion outside a basis, for the message that the target is not met.

    node : node with the largest displacement
    place : (3,)        its undeformed position
    frequency : float   rad/s; square root of the Rayleigh quotient of this shape
    """

    body: str
    node: int
    place: tuple[float, ...]
    frequency: float

    @property
    def words(self) -> str:
        """Place and frequency as text, with the remedy."""
        x, y, z = self.place
        hertz = self.frequency / (2 * np.pi)
        return (
            f"The motion outside the basis of body '{self.body}' is largest at node {self.node} "
            f"({x:.4g}, {y:.4g}, {z:.4g}), in "
            f"a shape that vibrates at {self.frequency:.3g} rad/s ({hertz:.3g} per unit of time): start with "
            "all modes up to this frequency, or with an interface at this node"
        )


def missed_part(full: FullBody, finer: ReductionBasis, size: int) -> MissedPart:
    """The leading direction that a round added to a basis with `size` coordinates."""
    shape = finer.vectors[:, min(size, finer.r - 1)]
    moved = np.linalg.norm(full.expand(shape), axis=1)
    node = int(np.argmax(moved))
    body = full.body
    frequency = np.sqrt(max(shape @ (body.stiffness @ shape), 0.0) / (shape @ (body.mass @ shape)))
    place = tuple(float(x) for x in body.nodes[node])
    return MissedPart(full.name, node, place, float(frequency))
