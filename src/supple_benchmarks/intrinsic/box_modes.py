"""Modes of the box beam as functions of arc length, as in figures 3 to 5 of [Wang2015]."""

from __future__ import annotations

import numpy as np

from supple.methods.intrinsic import IntrinsicBody
from supple_benchmarks.intrinsic.slender_box import WIDTH
from supple_benchmarks.table import Row

__all__ = ["KINDS", "box_modes", "kinds_of"]

KINDS = ("axial", "chordwise", "flapwise", "torsion")
SHOWN = {"flapwise": (3, 2, 4), "torsion": (2, 3, 3)}
"""Per kind: number of modes, component (0 to 5) of the velocity, component of moment and curvature."""
DIGITS = 6


def kinds_of(body: IntrinsicBody) -> list[str]:
    """Kind of each mode: its largest motion at the tip, of displacements x, y, z and rotation about x.

    The rotation is multiplied by the width of the box, so the kind does not depend on the unit of length.
    """
    motions = np.abs(body.modes.velocities[-1, :4].T) * [1.0, 1.0, 1.0, WIDTH]
    return [KINDS[int(np.argmax(motion))] for motion in motions]


def box_modes(body: IntrinsicBody) -> Row:
    """Flapwise and torsional modes along the box: velocity, moment, curvature.

    Velocities belong to stations, moments and curvatures to the middles of segments. Modes have unit modal
    mass; their sign is such that the velocity of the tip is positive.

    Returns
    -------
    s : positions of the stations over the length
    modes : kind, rank from 0 within the kind, velocity, moment and curvature of each mode
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
