"""Polar: lift and drag coefficients of a section over its angle of attack, and their blend along a blade."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from supple.algebra.read_only import read_only
from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError

__all__ = ["Polar"]


@dataclass(frozen=True, eq=False)
class Polar:
    """Lift and drag coefficients at angles of attack; linear in between, undefined outside.

    angle : (m,)    rad, increasing
    lift, drag : (m,)
    Raises ModelError for unequal lengths, fewer than two angles, NaN, or angles out of order.
    """

    name: str
    angle: FloatArray
    lift: FloatArray
    drag: FloatArray

    def __post_init__(self) -> None:
        for field in ("angle", "lift", "drag"):
            object.__setattr__(self, field, read_only(getattr(self, field)))
        if self.angle.ndim != 1 or self.angle.size < 2:
            raise ModelError(f"polar '{self.name}': angles of shape {self.angle.shape}; give at least two")
        if not self.angle.shape == self.lift.shape == self.drag.shape:
            raise ModelError(
                f"polar '{self.name}': {self.angle.size} angles, {self.lift.size} lift and {self.drag.size} "
                "drag coefficients; give one of each per angle"
            )
        bad = np.flatnonzero(~np.isfinite(np.column_stack([self.angle, self.lift, self.drag])).all(axis=1))
        if bad.size:
            raise ModelError(f"polar '{self.name}': row {bad[0]} is not finite; give numbers")
        back = np.flatnonzero(np.diff(self.angle) <= 0)
        if back.size:
            raise ModelError(
                f"polar '{self.name}': angles out of order in row {back[0] + 1}, "
                f"{np.degrees(self.angle[back[0] + 1]):g} deg; list them ascending, each once"
            )


@dataclass(frozen=True)
class BlendedPolars:
    """Coefficients of several sections over common angles: `angle` (m,), `lift` and `drag` (k, m).

    `lowest` and `highest` (k,) bound the angles that the polars of each section cover.
    """

    angle: FloatArray
    lift: FloatArray
    drag: FloatArray
    lowest: FloatArray
    highest: FloatArray

    def coefficients(self, section: ArrayLike, angle: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Lift and drag coefficients of sections, by number, at angles of attack of the same shape.

        The coefficients are constant beyond the first and the last angle.
        """
        section, angle = np.asarray(section, dtype=np.int64), np.asarray(angle)
        upper = np.clip(np.searchsorted(self.angle, angle, side="right"), 1, self.angle.size - 1)
        low, high = self.angle[upper - 1], self.angle[upper]
        part = np.clip((angle - low) / (high - low), 0, 1)
        lift = (1 - part) * self.lift[section, upper - 1] + part * self.lift[section, upper]
        drag = (1 - part) * self.drag[section, upper - 1] + part * self.drag[section, upper]
        return lift, drag


def blend_polars(polars: Sequence[Polar], inner: IntArray, part: FloatArray) -> BlendedPolars:
    """Polars (1 - part) polars[inner] + part polars[inner + 1] of k sections, 0 <= part <= 1.

    Piecewise linear functions and their blends are exact on the union of their angles.
    """
    angle = np.unique(np.concatenate([polar.angle for polar in polars]))
    lift = np.array([np.interp(angle, polar.angle, polar.lift) for polar in polars])
    drag = np.array([np.interp(angle, polar.angle, polar.drag) for polar in polars])
    lowest = np.array([polar.angle[0] for polar in polars])
    highest = np.array([polar.angle[-1] for polar in polars])
    # A polar with weight zero need not cover the angle.
    first, second = np.where(part < 1, inner, inner + 1), np.where(part > 0, inner + 1, inner)
    weight = part[:, None]
    return BlendedPolars(
        angle,
        (1 - weight) * lift[inner] + weight * lift[inner + 1],
        (1 - weight) * drag[inner] + weight * drag[inner + 1],
        np.maximum(lowest[first], lowest[second]),
        np.minimum(highest[first], highest[second]),
    )
