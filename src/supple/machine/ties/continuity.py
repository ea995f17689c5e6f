"""What a tie of two modal sub-domains makes equal: combinations of the gap between their interfaces.

Each basis can move its interface in a few directions only. Where all nodes must meet, only motions remain
that both can do, and modes of free parts share few of them: everything else locks. So the choice is one of
the model, and goes with the static shapes that the bases hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError

__all__ = ["EveryNode", "MeanMotion"]

FloatArray = NDArray[np.float64]

_COLLINEAR = 1e-6  # of the size of an interface: what is narrower does not see a turn about its own line


class Continuity(Protocol):
    """The combinations of the gap of two interfaces that vanish."""

    def patterns(self, points: FloatArray, reach: FloatArray) -> FloatArray:
        """L (r, n, 3) with sum_c L_rc . gap_c = 0.

        points : (n, 3) of the interface
        reach : (3 n, m)    gap per motion of both parts of unit kinetic energy
        """
        ...


@dataclass(frozen=True)
class MeanMotion:
    """Equal mean displacement and mean turn of the interfaces: the rigid motion that fits each one best.

    Six combinations; five where the nodes lie on one line, about which the parts turn as on a hinge, three of
    a single node. The forces of the tie are spread as those of an `AveragingInterface`, whose static answers
    a `Rubin` basis holds: with these both parts bend as under the true force. Sections may warp apart, which
    makes a joint of solids a little too soft.
    """

    def patterns(self, points: FloatArray, reach: FloatArray) -> FloatArray:  # noqa: ARG002 - of the protocol
        """See `Continuity`."""
        arms = points - points.mean(axis=0)
        size = max(float(np.linalg.norm(arms, axis=1).max()), 1e-300)
        turns = [np.cross(axis, arms / size).ravel() for axis in np.eye(3)]
        moves = [np.tile(axis, len(points)) for axis in np.eye(3)]
        across, sizes, _ = np.linalg.svd(np.array([*moves, *turns]).T, full_matrices=False)
        kept = across[:, sizes > _COLLINEAR * sizes[0]]
        return kept.T.reshape(-1, len(points), 3)


@dataclass(frozen=True)
class EveryNode:
    """All nodes of the interfaces meet, as far as the two bases can move them apart.

    Of the 3 n combinations those are imposed that the parts can open by more than `tolerance` of what opens
    farthest (singular values of the gap per motion of unit kinetic energy); the others follow from them to
    first order. For bases that share the motions of their interface: static shapes of rigid interfaces, or
    nearly all modes. Few free modes lock.
    """

    tolerance: float = 1e-4

    def __post_init__(self) -> None:
        if not 0 < self.tolerance < 1:
            raise ModelError(f"the tolerance of a tie must lie in (0, 1), got {self.tolerance}")

    def patterns(self, points: FloatArray, reach: FloatArray) -> FloatArray:
        """See `Continuity`."""
        across, sizes, _ = np.linalg.svd(reach, full_matrices=False)
        kept = across[:, sizes > self.tolerance * sizes[0]]
        return kept.T.reshape(-1, len(points), 3)
