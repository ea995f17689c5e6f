"""Motion of an intrinsic body over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from supple.integrate import FramedMotion, register_motion

__all__ = ["IntrinsicMotion"]


UNKNOWN = np.empty(0)
"""Accelerations missing in files of earlier versions; they are set to nan."""


@register_motion
@dataclass(frozen=True, repr=False)
class IntrinsicMotion(FramedMotion):
    """Root, strains and velocities of an intrinsic body; `position` and `rotation` are those of its root.

    coordinates : (t, e)     amplitudes of the elastic modes with these strains and forces, -q_2 / w
    """

    kind: ClassVar[str] = "intrinsic"
    dimensions: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {
            "rotation": ("axis", "body_axis"),
            "coordinates": ("coordinate",),
            "rates": ("velocity_mode",),
            "accelerations": ("velocity_mode",),
        }
    )

    rates: np.ndarray
    """(t, k + e) amplitudes of the velocities, q_1: rigid modes, then elastic ones."""
    acceleration: np.ndarray = field(default_factory=lambda: UNKNOWN)
    """(t, 3) acceleration of the origin of the body's axes, global components."""
    angular_acceleration: np.ndarray = field(default_factory=lambda: UNKNOWN)
    """(t, 3) angular acceleration, body components."""
    accelerations: np.ndarray = field(default_factory=lambda: UNKNOWN)
    """(t, k + e) time derivative of `rates`."""

    def __post_init__(self) -> None:
        likes = (("acceleration", 3), ("angular_acceleration", 3), ("accelerations", self.rates.shape[1]))
        for name, size in likes:
            if getattr(self, name) is UNKNOWN:
                object.__setattr__(self, name, np.full((len(self.position), size), np.nan))
