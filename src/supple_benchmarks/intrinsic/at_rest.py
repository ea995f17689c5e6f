"""Equilibria of beams in large bending: the elastica and the 45-degree bend."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from supple.machine import DeadForce
from supple.methods.intrinsic import CLAMPED, CondensedLine, intrinsic_body
from supple_benchmarks.intrinsic.beams import beam_line
from supple_benchmarks.lines import points_along_x, tip_at_rest
from supple_benchmarks.references.elastica import elastica
from supple_benchmarks.table import Row

__all__ = ["bend_of_45_degrees", "elastica_rows", "order_of"]

LOAD = 10.0
"""Load factor P L^2 / (E I) of the elastica."""


def elastica_rows(quick: bool) -> Iterator[Row]:
    """Distance of the tip from that of the elastica, over the length, by the number of segments (`nodes`)."""
    along, across, _ = elastica(1.0, 1.0, LOAD)
    for n in (10, 20, 40) if quick else (10, 20, 40, 80):
        points = points_along_x(1, n)
        line = beam_line("beam", points, axial=1e6, bending=1.0, torsion=1.0, mass=1.0, radius=0.01)
        tip = _tip(line, LOAD)
        yield {"nodes": n, "error": float(np.hypot(tip[0] - along, tip[2] - across))}


def order_of(rows: list[Row]) -> float:
    """Convergence order of the error with the number of segments."""
    n, error = (np.log([row[key] for row in rows]) for key in ("nodes", "error"))
    return float(-np.polyfit(n, error, 1)[0])


def bend_of_45_degrees(_quick: bool) -> Row:
    """Tip of an arc of 45 degrees and radius 100 under a dead force of 600 normal to its plane.

    The section is a unit square, E = 1e7.
    """
    angles = np.linspace(0, np.pi / 4, 17)
    points = 100 * np.column_stack([1 - np.cos(angles), np.sin(angles), 0 * angles])
    stiffness = 1e7 / 12
    line = beam_line("beam", points, axial=1e7, bending=stiffness, torsion=stiffness, mass=1.0, radius=0.3)
    return {"load": 600, "tip": _tip(line, 600.0).tolist()}


def _tip(line: CondensedLine, force: float) -> np.ndarray:
    return tip_at_rest(intrinsic_body(line, CLAMPED), DeadForce(at="beam.tip", force=(0, 0, force)))
