"""Useless and doubtful rounds of a self-correction, and the motion outside a basis where they stall.

A round that is no better than the one before found nothing, and neither is the next one accepted, whose
columns are of the same kind: a loop that ends with the first estimate small enough would end with those that
are too small by chance.

An estimate that is doubtful (`BodyError.is_doubtful`) is accepted once two runs confirm it: their distance
must be what was estimated of the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from supple.body.full_body import FullBody
from supple.reduction import ReducedBody, ReductionBasis
from supple.reduction.locking import TOLERATED

__all__ = ["MissedPart", "doubt", "is_confirmed", "is_useless", "missed_part", "withheld"]

AGREES = 2.0
"""Factor between a distance of runs and the error estimated of the first, within which they agree."""


def is_useless(errors: Sequence[float]) -> bool:
    """Whether the last of the errors is no smaller than that of the round before."""
    return len(errors) > 1 and bool(np.isfinite(errors[-2])) and not errors[-1] < errors[-2]


def withheld(body: ReducedBody) -> float:
    """Share of a static answer that a reduced body withholds because it locks: stiff motion is missing."""
    return 0.0 if body.report.locking is None else body.report.locking.largest_remaining


def doubt(body: ReducedBody, indicator: float) -> str:
    """Why an estimate is doubtful, in words."""
    if withheld(body) > TOLERATED:
        return f"body '{body.name}' locks: it withholds {100 * withheld(body):.2g} % of a static answer"
    return f"body '{body.name}' lacks {indicator:.2g} at rest"


def is_confirmed(estimated: float, distance: float, allowed: float) -> bool:
    """Whether a run with a richer basis confirms the error estimated of the run before.

    distance : of the two runs
    """
    agrees = estimated / AGREES <= distance <= AGREES * estimated
    return agrees or max(estimated, distance) <= allowed


@dataclass(frozen=True)
class MissedPart:
    """The largest motion outside a basis, where rounds stall.

    node, place : where it moves most; place (3,) of the undeformed node
    frequency : float   rad/s of a vibration of this shape, by Rayleigh's quotient
    """

    body: str
    node: int
    place: tuple[float, ...]
    frequency: float

    @property
    def words(self) -> str:
        """Place and frequency, and what to start with."""
        x, y, z = self.place
        hertz = self.frequency / (2 * np.pi)
        return (
            f"The motion outside the basis of body '{self.body}' is largest at node {self.node} "
            f"({x:.4g}, {y:.4g}, {z:.4g}), in "
            f"a shape that vibrates at {self.frequency:.3g} rad/s ({hertz:.3g} per unit of time): start with "
            "all modes up to there, or with an interface at that place"
        )


def missed_part(full: FullBody, finer: ReductionBasis, size: int) -> MissedPart:
    """The leading direction that a round added to a basis of a size."""
    shape = finer.vectors[:, min(size, finer.r - 1)]
    moved = np.linalg.norm(full.expand(shape), axis=1)
    node = int(np.argmax(moved))
    body = full.body
    frequency = np.sqrt(max(shape @ (body.stiffness @ shape), 0.0) / (shape @ (body.mass @ shape)))
    place = tuple(float(x) for x in body.nodes[node])
    return MissedPart(full.name, node, place, float(frequency))
