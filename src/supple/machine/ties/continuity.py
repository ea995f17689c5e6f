"""Continuity of a tie of two modal parts: combinations of the gap between the interfaces that must be zero.

The modal basis of each part allows only a few motions of its interface. If all nodes must coincide, only
motions that both bases contain remain. The free modes of two parts have few common motions, so the tie locks.
The user therefore chooses the continuity according to the static shapes in the bases.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ModelError

__all__ = ["EveryNode", "MeanMotion"]

_COLLINEAR = 1e-6  # relative width of an interface, below which its rotation about its own line is undefined


@dataclass(frozen=True)
class MeanMotion:
    """Equal mean displacement and mean rotation of the interfaces: the best-fit rigid motion of each.

    There are six combinations; three for a single node; five for nodes on one line, about which the parts
    can rotate as on a hinge. The forces of the tie are distributed as those of an `AveragingInterface`. A
    `Rubin` basis includes the static responses to these forces, so both parts bend as under the true force.
    The sections of both parts warp independently, which makes a tie of solids slightly too soft.
    """

    def patterns(self, points: FloatArray, reach: FloatArray) -> FloatArray:  # noqa: ARG002
        """Coefficients L (r, n, 3) of r combinations: sum_c L_rc . gap_c = 0 over the nodes c.

        points : (n, 3) positions of the nodes of the interface
        reach : (3 n, m)    gap due to each motion of the two parts, scaled to unit kinetic energy
        """
        arms = points - points.mean(axis=0)
        size = max(float(np.linalg.norm(arms, axis=1).max()), 1e-300)
        turns = [np.cross(axis, arms / size).ravel() for axis in np.eye(3)]
        moves = [np.tile(axis, len(points)) for axis in np.eye(3)]
        across, sizes, _ = np.linalg.svd(np.array([*moves, *turns]).T, full_matrices=False)
        kept = across[:, sizes > _COLLINEAR * sizes[0]]
        return kept.T.reshape(-1, len(points), 3)


@dataclass(frozen=True)
class EveryNode:
    """All nodes of the interfaces coincide, in every motion that the two bases contain.

    The combinations are the left singular vectors of `reach`. One is imposed if its singular value exceeds
    `tolerance` times the largest singular value. Suitable if both bases contain the same motions of the
    interface: static shapes of rigid interfaces, or nearly all modes. With few free modes the tie locks.

    tolerance : between 0 and 1
    Raises ModelError for any other tolerance.
    """

    tolerance: float = 1e-4

    def __post_init__(self) -> None:
        if not 0 < self.tolerance < 1:
            raise ModelError(f"the tolerance of a tie must lie in (0, 1), got {self.tolerance}")

    def patterns(self, points: FloatArray, reach: FloatArray) -> FloatArray:
        """Coefficients L (r, n, 3), as of `MeanMotion`."""
        across, sizes, _ = np.linalg.svd(reach, full_matrices=False)
        kept = across[:, sizes > self.tolerance * sizes[0]]
        return kept.T.reshape(-1, len(points), 3)
