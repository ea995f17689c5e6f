"""Modes of the box beam as functions of arc length, as in figures 3 to 5 of [Wang2015]."""

from __future__ import annotations

from typing import Any

import numpy as np

from supple.methods.intrinsic import IntrinsicBody

__all__ = ["KINDS", "box_modes", "kinds_of"]

KINDS = ("axial", "chordwise", "flapwise", "torsion")
SHOWN = {"flapwise": (3, 2, 4), "torsion": (2, 3, 3)}
"""Per kind: number of modes, and component of the velocity and of the moment."""
DIGITS = 6


def kinds_of(body: IntrinsicBody) -> list[str]:
    """Kind of each mode, from its largest motion at the tip."""
    return [KINDS[int(np.argmax(column))] for column in np.abs(body.modes.velocities[-1, :4]).T]


def box_modes(body: IntrinsicBody) -> dict[str, Any]:
    """Velocity at stations, moment and curvature at the middles of segments, of flapwise and torsional modes.

    Modes have unit modal mass; their tips move in positive direction.

    s : positions of the stations over the length;   modes : kind, rank, velocity, moment, curvature
    """
    modes, kinds = body.modes, np.array(kinds_of(body))
    rows = []
    for kind, (number, velocity, moment) in SHOWN.items():
        for rank, j in enumerate(np.flatnonzero(kinds == kind)[:number]):
            sign = np.sign(modes.velocities[-1, velocity, j])
            curves = {
                "velocity": modes.velocities[:, velocity, j],
                "moment": modes.forces[:, moment, j],
                "curvature": modes.strains[:, moment, j],
            }
            rows.append(
                {"kind": kind, "rank": rank}
                | {name: (sign * curve).round(DIGITS).tolist() for name, curve in curves.items()}
            )
    places = modes.line.tree.points[:, 0]
    return {"s": (places / places[-1]).round(DIGITS).tolist(), "modes": rows}
