"""Linear combinations of freedoms of nodes under construction, for springs, masses and constraints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from supple.arrays import FloatArray
from supple.importers.deck import ScalarTerms

Terms = list[tuple[int, float]]
"""Freedoms, 6 * node + component (0 to 5) in basic axes, each with its factor."""

# Largest component of a direction, relative to the largest one, that is treated as zero.
_NONE = 1e-14


@dataclass(eq=False)
class FreedomSums:
    """Linear combinations; `terms` returns them as one object.

    freedoms, factors : of all terms, one combination after the other;  counts : number of terms of each
    lines, values, dependent : one entry for each combination, as in `ScalarTerms`
    """

    freedoms: list[int] = field(default_factory=list)
    factors: list[float] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    dependent: list[int] = field(default_factory=list)

    def add(
        self, terms: Iterable[tuple[int, float]], line: int, *, value: float = 0.0, dependent: int = -1
    ) -> None:
        """Add a combination; factors of one freedom are summed, and a combination of zeros is omitted.

        line : in the file;  dependent : the freedom that a constraint eliminates, or -1
        """
        total: dict[int, float] = {}
        for freedom, factor in terms:
            total[freedom] = total.get(freedom, 0.0) + factor
        kept = {freedom: factor for freedom, factor in total.items() if factor}
        if not kept:
            return
        self.freedoms += kept
        self.factors += kept.values()
        self.counts.append(len(kept))
        self.lines.append(line)
        self.values.append(value)
        self.dependent.append(dependent if dependent in kept else -1)

    def terms(self, *, constraints: bool = False) -> tuple[ScalarTerms, ...]:
        """The combinations as one ScalarTerms, with values or of constraints; empty if there are none."""
        if not self.counts:
            return ()
        rows = np.repeat(np.arange(len(self.counts)), self.counts)
        freedoms, lines, dependent = (
            np.array(each, dtype=np.int64) for each in (self.freedoms, self.lines, self.dependent)
        )
        factors = np.array(self.factors)
        if constraints:
            return (ScalarTerms(rows, freedoms, factors, lines, dependent=dependent),)
        return (ScalarTerms(rows, freedoms, factors, lines, np.array(self.values)),)


def motion_along(
    node: int,
    direction: FloatArray,
    factor: float = 1.0,
    *,
    arm: FloatArray | None = None,
    rotation: bool = False,
) -> Terms:
    """Terms of  factor d . (u + theta x arm)  of a node, or of  factor d . theta  if `rotation`.

    direction : (3,) d;  arm : (3,) from the node; None is zero
    """
    first, least = 6 * node + (3 if rotation else 0), _NONE * float(np.abs(direction).max())
    parts = [(first + i, d) for i, d in enumerate(direction.tolist()) if abs(d) > least]
    if arm is not None:
        turn = np.cross(arm, direction)  # d . (theta x arm) = theta . (arm x d)
        least *= max(1.0, float(np.abs(arm).max()))
        parts += [(6 * node + 3 + i, d) for i, d in enumerate(turn.tolist()) if abs(d) > least]
    return [(freedom, factor * value) for freedom, value in parts]


def relative_motion(
    node: int, reference: int, direction: FloatArray, *, arm: FloatArray | None = None, rotation: bool = False
) -> Terms:
    """Motion relative to a reference node:  d . (u - u_r - theta_r x arm), or  d . (theta - theta_r).

    direction : (3,) d;  arm : (3,) from the reference node to the node; None is zero
    rotation : selects the second form
    """
    carried = motion_along(reference, direction, -1.0, arm=None if rotation else arm, rotation=rotation)
    return motion_along(node, direction, rotation=rotation) + carried
