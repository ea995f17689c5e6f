"""Blade stations: section, chord, twist and pitch axis along the span."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
import scipy  # its parts are imported when first used
from numpy.typing import ArrayLike

from supple.algebra.read_only import read_only
from supple.arrays import FloatArray
from supple.errors import MeshError
from supple.mesh.airfoil_section import AirfoilSection

__all__ = ["BladeStations"]

# Sections are resampled at this many points of x/c, dense at both edges (cosine spacing).
N_SHAPE_POINTS = 201
SHAPE_POINTS = read_only((1 - np.cos(np.linspace(0, np.pi, N_SHAPE_POINTS))) / 2)


@dataclass(frozen=True, eq=False, kw_only=True)
class BladeStations:
    """The outer shape of a blade at stations along its span, with monotone cubics (PCHIP) between them.

    The pitch axis is z, from the root; x points to the upper (suction, downwind) side, y to the trailing
    edge. The point (x/c, y/c) of a section is at
        X = xi sin(twist) + eta cos(twist) + prebend,   xi = (x/c - pitch_axis) chord,
        Y = xi cos(twist) - eta sin(twist) + sweep,     eta = (y/c) chord,     Z = span:
    positive twist rotates the nose to -x, into the wind. Sections stay normal to z, also where the axis
    bends.

    Parameters
    ----------
    span : float array (n,)         m, increasing, n >= 2
    sections : AirfoilSection (n,)
    chord : float array (n,)        m, above zero
    twist : float array (n,)        rad
    pitch_axis : float array (n,)   x/c of the point on the pitch axis
    prebend, sweep : float (n,)     m, offsets of the axis along x and y
    Raises
    ------
    MeshError   unequal lengths, fewer than two stations, NaN, span out of order, chord not above zero
    """

    span: FloatArray
    sections: tuple[AirfoilSection, ...]
    chord: FloatArray
    twist: FloatArray
    pitch_axis: FloatArray
    prebend: ArrayLike = 0.0
    sweep: ArrayLike = 0.0

    def __post_init__(self) -> None:
        span = read_only(self.span)
        if span.ndim != 1 or span.size < 2:
            raise MeshError(f"a blade has at least two stations in one row; span has shape {span.shape}")
        object.__setattr__(self, "sections", tuple(self.sections))
        if len(self.sections) != span.size:
            raise MeshError(f"{len(self.sections)} sections for {span.size} stations; give one per station")
        for name in (field.name for field in fields(self) if field.name != "sections"):
            values = np.asarray(getattr(self, name), dtype=np.float64)
            values = np.full(span.shape, values) if values.ndim == 0 else values
            if values.shape != span.shape:
                raise MeshError(
                    f"{name} has shape {values.shape} for {span.size} stations; give one value per station"
                )
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                raise MeshError(f"station {bad[0]}: {name} is {values[bad[0]]}; give a number")
            object.__setattr__(self, name, read_only(values))
        back = np.flatnonzero(np.diff(span) <= 0)
        if back.size:
            raise MeshError(
                f"stations out of order: station {back[0] + 1} at {span[back[0] + 1]:g} follows one at "
                f"{span[back[0]]:g}; list them from root to tip, each span once"
            )
        bad = np.flatnonzero(self.chord <= 0)
        if bad.size:
            raise MeshError(f"station {bad[0]}: chord is {self.chord[bad[0]]:g}; a chord is above zero")

    @cached_property
    def _curves(self) -> scipy.interpolate.PchipInterpolator:
        curves = np.column_stack([self.chord, self.twist, self.pitch_axis, self.prebend, self.sweep])
        return scipy.interpolate.PchipInterpolator(self.span, curves)

    def curves(self, span: ArrayLike) -> tuple[FloatArray, ...]:
        """Chord, twist, pitch axis, prebend and sweep at the spans (k,), each (k,)."""
        return tuple(self._curves(span).T)

    def shapes(self, span: ArrayLike) -> FloatArray:
        """Heights y/c (k, 2, N_SHAPE_POINTS) of lower and upper side at SHAPE_POINTS, at the spans (k,)."""
        heights = np.array([section.heights(SHAPE_POINTS) for section in self.sections])
        return scipy.interpolate.PchipInterpolator(self.span, heights)(span)
