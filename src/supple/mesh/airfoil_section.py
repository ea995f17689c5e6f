"""Airfoil section: the outline of a blade's cross-section, relative to its chord."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from supple.algebra.read_only import read_only
from supple.arrays import FloatArray
from supple.errors import MeshError

__all__ = ["AirfoilSection", "TrailingEdge"]

FEWEST_POINTS = 5
# Largest deviation of the extreme x/c from 0 and 1; beyond it the outline is not relative to its chord.
CHORD_TOLERANCE = 0.02
# Least distance between both sides, y/c, that counts in the search for crossings: rounding of the data at a
# thin trailing edge is no crossing.
CROSSING_TOLERANCE = 1e-5


class TrailingEdge(Enum):
    """Kind of trailing edge of an outline; the value is the part of the chord over which it is closed.

    An airfoil has a blunt trailing edge of small thickness. In the shell mesh both sides meet in one line
    there, so the gap is closed gradually over the last tenth of the chord. A round section (at the root, and
    in the transition to the first airfoil) stays round almost to its end.
    """

    AIRFOIL = 0.1
    ROUND = 0.001


@dataclass(frozen=True, eq=False)
class AirfoilSection:
    """Outline of a cross-section: x/c from the leading (0) to the trailing edge (1), y/c to the upper side.

    Parameters
    ----------
    outline : float array (p, 2)    x/c, y/c from the trailing edge around the leading edge and back, either
                                    side first; each side must be a function of x/c
    trailing_edge : TrailingEdge    part of the chord over which the two ends are joined
    Raises
    ------
    MeshError   wrong shape, too few points, NaN, not relative to the chord, crossing itself, folding back
    """

    name: str
    outline: FloatArray
    trailing_edge: TrailingEdge = TrailingEdge.AIRFOIL

    def __post_init__(self) -> None:
        object.__setattr__(self, "outline", read_only(self.outline))
        _check_outline(self.name, self.outline)

    def heights(self, x: ArrayLike) -> FloatArray:
        """Heights y/c (2, len(x)) of the lower and the upper side at x/c, meeting at the trailing edge.

        A side that ends short of x/c = 1 is extended at its last height. The gap between the sides is closed
        linearly: y -> y - ramp(x) (y(1) - mean of both y(1)). The ramp rises from 0 to 1 over the last part
        of the chord, `trailing_edge.value`.
        """
        x = np.asarray(x, dtype=np.float64)
        first, second = _sides(self.outline)
        # Of several points with the same x/c, `_interpolate` uses the first from the leading edge. At a blunt
        # trailing edge this is the corner; some outlines also list the middle between both corners.
        both = np.array([_interpolate(side, x) for side in (first, second)])
        ends = np.array([_interpolate(side, np.ones(1)) for side in (first, second)])
        ramp = np.clip(1 - (1 - x) / self.trailing_edge.value, 0, 1)
        closed = both - ramp * (ends - ends.mean())
        return closed if closed[0].sum() <= closed[1].sum() else closed[::-1]


def _sides(outline: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Both sides, from the leading edge to the trailing edge."""
    leading = int(np.argmin(outline[:, 0]))
    return outline[leading::-1], outline[leading:]


def _interpolate(side: FloatArray, x: FloatArray) -> FloatArray:
    places, first = np.unique(side[:, 0], return_index=True)
    return np.interp(x, places, side[first, 1])


def _check_outline(name: str, outline: FloatArray) -> None:
    if outline.ndim != 2 or outline.shape[1] != 2:
        raise MeshError(f"section '{name}': outline of shape {outline.shape}; expected (p, 2), rows x/c, y/c")
    if len(outline) < FEWEST_POINTS:
        raise MeshError(
            f"section '{name}': too few points ({len(outline)}); an outline has at least {FEWEST_POINTS}, "
            "from the trailing edge around the leading edge and back"
        )
    bad = np.flatnonzero(~np.isfinite(outline).all(axis=1))
    if bad.size:
        raise MeshError(f"section '{name}': point {bad[0]} is {outline[bad[0]].tolist()}; give numbers")
    low, high = outline[:, 0].min(), outline[:, 0].max()
    if abs(low) > CHORD_TOLERANCE or abs(high - 1) > CHORD_TOLERANCE:
        raise MeshError(
            f"section '{name}': x/c runs from {low:g} to {high:g}, not from 0 to 1; shift the outline to its "
            "leading edge and divide it by its chord"
        )
    for side in _sides(outline):
        back = np.flatnonzero(np.diff(side[:, 0]) < 0)
        if back.size or len(side) < 2:
            where = side[back[0]] if back.size else side[0]
            raise MeshError(
                f"section '{name}': a side folds back in x/c near ({where[0]:g}, {where[1]:g}); list the "
                "points in order from the trailing edge around the leading edge and back"
            )
    _check_crossing(name, outline)


def _check_crossing(name: str, outline: FloatArray) -> None:
    """Both sides are functions of x/c here, so they cross where their difference changes sign."""
    x = np.unique(outline[:, 0])
    first, second = (_interpolate(side, x) for side in _sides(outline))
    apart = np.abs(second - first) > CROSSING_TOLERANCE
    x, upper_first = x[apart], (second < first)[apart]
    crossed = np.flatnonzero(upper_first[1:] != upper_first[:-1])
    if crossed.size:
        raise MeshError(
            f"section '{name}': the outline crosses itself between x/c = {x[crossed[0]]:g} and "
            f"{x[crossed[0] + 1]:g}; correct the points there, or reorder them"
        )
