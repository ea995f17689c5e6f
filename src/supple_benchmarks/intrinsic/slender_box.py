"""The box beam as a slender thin-walled beam: frequencies and modes in closed form.

The section table of [Wang2015] is missing in our copy of the text. Values chosen here: length 20, walls 1.0
by 0.1 between mid-surfaces, 0.01 thick, E = 1e6, Poisson's ratio 0.3, density 1, in consistent units.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple_benchmarks.lines import BENDING_ROOTS

__all__ = ["slender_frequency", "slender_mode"]

Array = NDArray[np.float64]

LENGTH, WIDTH, HEIGHT, WALL = 20.0, 1.0, 0.1, 0.01
E, NU, DENSITY = 1e6, 0.3, 1.0

AREA = 2 * (WIDTH + HEIGHT) * WALL
FLAP = WALL * (WIDTH * HEIGHT**2 / 2 + HEIGHT**3 / 6)
CHORD = WALL * (HEIGHT * WIDTH**2 / 2 + WIDTH**3 / 6)
POLAR = FLAP + CHORD
TORSION = 2 * (WIDTH * HEIGHT) ** 2 * WALL / (WIDTH + HEIGHT) * E / (2 * (1 + NU))
"""Torsional stiffness G J by Bredt's formula."""


def slender_frequency(kind: str, rank: int) -> float:
    """A frequency of the clamped slender beam, rad/s: Euler-Bernoulli in bending, Bredt in torsion.

    kind : "axial", "chordwise", "flapwise" or "torsion";   rank : number within the kind, from 0
    """
    if kind in ("axial", "torsion"):
        square = E / DENSITY if kind == "axial" else TORSION / (DENSITY * POLAR)
        return float((2 * rank + 1) * np.pi / 2 / LENGTH * np.sqrt(square))
    inertia = FLAP if kind == "flapwise" else CHORD
    return float((_root(rank) / LENGTH) ** 2 * np.sqrt(E * inertia / (DENSITY * AREA)))


def slender_mode(kind: str, rank: int, s: Array) -> tuple[Array, Array, Array]:
    """Velocity, moment and curvature (k,) at positions s (k,) along the beam, for a mode of unit modal mass.

    kind : "flapwise", with velocity along z and moment about y, or "torsion", with both about x
    rank : number within the kind, from 0
    Source: [Wang2015] (38)-(41).
    """
    if kind == "torsion":
        x = (2 * rank + 1) * np.pi / 2 * s / LENGTH
        moment = -np.sqrt(2 * TORSION / LENGTH) * np.cos(x)
        return np.sqrt(2 / (DENSITY * POLAR * LENGTH)) * np.sin(x), moment, moment / TORSION
    root = _root(rank)
    x = root * s / LENGTH
    share = (np.cos(root) + np.cosh(root)) / (np.sin(root) + np.sinh(root))
    velocity = np.cos(x) - np.cosh(x) - share * (np.sin(x) - np.sinh(x))
    moment = np.sqrt(E * FLAP / LENGTH) * (share * (np.sin(x) + np.sinh(x)) - np.cos(x) - np.cosh(x))
    return velocity / np.sqrt(DENSITY * AREA * LENGTH), moment, moment / (E * FLAP)


def _root(rank: int) -> float:
    # Higher roots are close to odd multiples of pi / 2.
    return BENDING_ROOTS[rank] if rank < len(BENDING_ROOTS) else (2 * rank + 1) * np.pi / 2
