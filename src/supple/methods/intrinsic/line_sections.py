"""Force and moment across a section of an intrinsic body, from a segment of its line."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.body.sections import CuttingPlane
from supple.errors import ModelError
from supple.integrate.motion import Motion

__all__ = ["cut_segments", "line_section_loads"]

Array = NDArray[np.float64]


def line_section_loads(body: Any, motion: Motion, plane: CuttingPlane) -> Array:
    """Force and moment (t, 6) of the part beyond a plane on the part before it, along material axes.

    These are the section forces of the segment cut by the plane, with the moment about the point of the
    plane. If the plane contains a station, they are the mean of both adjacent segments.

    Raises
    ------
    ModelError   a plane that cuts no segment, or several
    """
    found = [_of_segment(body, motion, plane, *cut) for cut in cut_segments(body, plane)]
    return np.mean(found, axis=0)


def cut_segments(body: Any, plane: CuttingPlane) -> list[tuple[int, float]]:
    """The segment cut by a plane, or both at its station, with 1 if its outer end is beyond it, else -1.

    Raises ModelError as `line_section_loads`.
    """
    tree = body.line.tree
    heights = plane.heights(tree.points)
    found = []
    for outside in (heights >= 0, heights > 0):
        segments = np.flatnonzero(outside[1:] != outside[tree.inner])
        if len(segments) > 1:
            raise ModelError(
                f"body '{body.name}': a section cuts one segment of its line, and the plane through "
                f"{plane.point} across {plane.normal} cuts {len(segments)}; turn its normal along the line"
            )
        found += [(int(segment), 1.0 if outside[segment + 1] else -1.0) for segment in segments]
    if not found:
        raise ModelError(
            f"body '{body.name}': the plane through {plane.point} across {plane.normal} cuts no segment "
            "of its line; move it, or turn its normal along the line"
        )
    return found


def _of_segment(body: Any, motion: Motion, plane: CuttingPlane, segment: int, sense: float) -> Array:
    loads = sense * body.section_loads(motion)[:, segment]
    arm = body.line.tree.middles[segment] - plane.point
    return np.hstack([loads[:, :3], loads[:, 3:] + np.cross(arm, loads[:, :3])])
