"""Force and moment across a section of an intrinsic body, from a segment of its line."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.body.sections import CuttingPlane
from supple.errors import ModelError
from supple.integrate.motion import Motion

__all__ = ["line_section_loads"]

Array = NDArray[np.float64]


def line_section_loads(body: Any, motion: Motion, plane: CuttingPlane) -> Array:
    """Force and moment (t, 6) of the part beyond a plane on the part before it, along material axes.

    These are the section forces of the segment cut by the plane, with the moment about the point of the
    plane. If the plane contains a station, they are the mean of both adjacent segments.

    Raises
    ------
    ModelError   a plane that cuts no segment, or several
    """
    tree = body.line.tree
    heights = plane.heights(tree.points)
    found = [
        _of_segment(body, motion, plane, outside)
        for outside in (heights >= 0, heights > 0)
        if (outside[1:] != outside[tree.inner]).any()
    ]
    if not found:
        raise ModelError(
            f"body '{body.name}': the plane through {plane.point} across {plane.normal} cuts no segment "
            "of its line; move it, or turn its normal along the line"
        )
    return np.mean(found, axis=0)


def _of_segment(body: Any, motion: Motion, plane: CuttingPlane, outside: NDArray[np.bool_]) -> Array:
    tree = body.line.tree
    segments = np.flatnonzero(outside[1:] != outside[tree.inner])
    if len(segments) > 1:
        raise ModelError(
            f"body '{body.name}': a section cuts one segment of its line, and the plane through "
            f"{plane.point} across {plane.normal} cuts {len(segments)}; turn its normal along the line"
        )
    (segment,) = segments
    loads = body.section_loads(motion)[:, segment] * (1.0 if outside[segment + 1] else -1.0)
    arm = tree.middles[segment] - plane.point
    return np.hstack([loads[:, :3], loads[:, 3:] + np.cross(arm, loads[:, :3])])
