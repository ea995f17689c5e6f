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
"""Default of accelerations that are not given, as in files of earlier versions; they become nan."""


@register_motion
@dataclass(frozen=True, repr=False)
class IntrinsicMotion(FramedMotion):
    """Pose, strains and velocities of an intrinsic body; its axes (`position`, `rotation`) follow its root.

    coordinates : (t, e)     amplitudes -q_2 / w of the elastic modes, for strains and forces
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
