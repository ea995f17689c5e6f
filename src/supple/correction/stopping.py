"""When rounds may stop: what their differences say of the error, and which rounds were useless.

For estimates from the differences d_k of successive runs, which presume that the next run is better:

    e_k = max(d_k, g d_(k-1)) / sqrt(1 - rho^2),   rho = max(d_k / d_(k-1), d_(k-1) / d_(k-2)),
                                                    g = (d_k / d_0)^(1/k)

adds up what the runs to come will change, were each of them to gain as little as one of the last two did, and
takes a last step that is much smaller than those before for chance. For any estimate: a round that did not
shrink found nothing, and neither can the next one be accepted, whose columns are of the same kind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from supple.body.full_body import FullBody
from supple.reduction import ReductionBasis

__all__ = ["MissedPart", "error_of_differences", "is_useless", "missed_part"]


def error_of_differences(differences: Sequence[float]) -> float:
    """Error of the last run but one, from the distances of successive runs; infinite where none shrank."""
    *before, last = differences
    if not np.isfinite(last):
        return np.inf
    if not before:
        return last
    # A run that broke off says nothing of the rate.
    recent = differences[-3:]
    pairs = [(old, new) for old, new in pairwise(recent) if np.isfinite(old)]
    rho = max((new / old if old > 0 else np.inf for old, new in pairs), default=0.0)
    if rho >= 1:
        return np.inf
    first = before[0]
    usual = (last / first) ** (1 / len(before)) if np.isfinite(first) and first > 0 else 0.0
    guess = usual * before[-1] if np.isfinite(before[-1]) else 0.0
    return max(last, guess) / float(np.sqrt(1 - rho**2))


def is_useless(errors: Sequence[float]) -> bool:
    """Whether the last of the errors is no smaller than that of the round before."""
    return len(errors) > 1 and bool(np.isfinite(errors[-2])) and not errors[-1] < errors[-2]


@dataclass(frozen=True)
class MissedPart:
    """What a basis misses most, where rounds stall.

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
            f"What body '{self.body}' misses moves most at node {self.node} ({x:.4g}, {y:.4g}, {z:.4g}), in "
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
