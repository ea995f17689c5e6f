"""Motion of the nodes of an explicit sub-domain, one row per output time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from supple.integrate.motion import Motion, register_motion

__all__ = ["NodalMotion"]


@register_motion
@dataclass(frozen=True, repr=False)
class NodalMotion(Motion):
    """Motion of the nodes of an explicit sub-domain."""

    kind: ClassVar[str] = "nodal"
    dimensions: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {
            **dict.fromkeys(("nodes", "velocities", "accelerations"), ("node", "axis")),
            **dict.fromkeys(("plastic_strain", "alive", "von_mises"), ("element",)),
        }
    )

    nodes: np.ndarray
    """(t, N, 3) positions in space."""
    velocities: np.ndarray
    """(t, N, 3) means over the previous step; at the start, the initial velocities"""
    accelerations: np.ndarray
    """(t, N, 3)"""
    plastic_strain: np.ndarray
    """(t, E) equivalent plastic strain of each element, the largest of its points; zero if elastic."""
    alive: np.ndarray
    """(t, E) 1, or 0 once an element is deleted."""
    von_mises: np.ndarray
    """(t, E) von Mises stress of each element, Pa, the largest of its points; zero for deleted ones."""
