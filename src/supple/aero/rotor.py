"""Rotor: chord, twist and polars of its blades along the radius."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from supple.aero.polar import BlendedPolars, Polar, blend_polars
from supple.algebra.read_only import read_only
from supple.arrays import FloatArray
from supple.errors import ModelError

__all__ = ["Rotor"]

ROUNDING = 1e-6
"""Distance from the blade, relative to the tip radius, up to which a radius is off by rounding only."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Rotor:
    """Equal blades given at stations; chord, twist and coefficients vary linearly in between.

    radius : (n,)    m from the rotor axis, increasing, n >= 2; the last one is that of the tip
    chord : (n,)    m, above zero
    twist : (n,)    rad, positive rotates the nose into the wind
    polars : (n,)
    Raises ModelError for unequal lengths, NaN, radii out of order or not above zero, chord not above zero, no
    blades.
    """

    radius: FloatArray
    chord: FloatArray
    twist: FloatArray
    polars: tuple[Polar, ...]
    n_blades: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "polars", tuple(self.polars))
        for name in ("radius", "chord", "twist"):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.shape != self.radius.shape or values.ndim != 1 or values.size < 2:
                raise ModelError(
                    f"rotor: {name} has shape {values.shape}; give one value for each of two or more stations"
                )
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                raise ModelError(f"rotor: {name} of station {bad[0]} is {values[bad[0]]}; give a number")
        if len(self.polars) != self.radius.size:
            raise ModelError(
                f"rotor: {len(self.polars)} polars for {self.radius.size} stations; give one per station"
            )
        back = np.flatnonzero(np.diff(self.radius, prepend=0.0) <= 0)
        if back.size:
            raise ModelError(
                f"rotor: radius {self.radius[back[0]]:g} of station {back[0]} is out of order; list the "
                "stations outward, all off the axis"
            )
        bad = np.flatnonzero(self.chord <= 0)
        if bad.size:
            raise ModelError(
                f"rotor: chord {self.chord[bad[0]]:g} of station {bad[0]}; a chord is above zero"
            )
        if self.n_blades != int(self.n_blades) or self.n_blades < 1:
            raise ModelError(f"rotor: {self.n_blades} blades; give a whole number, at least one")

    @property
    def tip_radius(self) -> float:
        """Radius of the tip, m."""
        return float(self.radius[-1])

    def on_blade(self, radius: ArrayLike) -> FloatArray:
        """Radii (k,), with those that rounding puts beyond an end of the blade moved to this end.

        Raises ModelError for radii off the blade.
        """
        radius = np.asarray(radius, dtype=np.float64)
        inside = np.clip(radius, self.radius[0], self.radius[-1])
        outside = np.flatnonzero(~(abs(radius - inside) <= ROUNDING * self.tip_radius))
        if outside.size:
            raise ModelError(
                f"radius {radius[outside[0]]:g} lies off the blade, which runs from {self.radius[0]:g} to "
                f"{self.radius[-1]:g}; radius is span plus hub radius"
            )
        return inside

    def polars_at(self, radius: ArrayLike) -> BlendedPolars:
        """Polars at radii (k,), blended linearly between neighbouring stations; ModelError off the blade."""
        radius = self.on_blade(radius)
        inner = np.clip(np.searchsorted(self.radius, radius, side="right") - 1, 0, self.radius.size - 2)
        part = (radius - self.radius[inner]) / (self.radius[inner + 1] - self.radius[inner])
        return blend_polars(self.polars, inner, part)
