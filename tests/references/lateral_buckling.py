"""Lateral buckling of a narrow cantilever under a dead force at its tip, in closed form."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.special import jv


def lateral_buckling_load(weak_bending, strong_bending, torsion, length):
    """Critical tip force: J_(-1/4)(P L^2 / 2 sqrt(B C)) = 0, that is P = 4.0126 sqrt(B C) / L^2.

    The deflection before buckling stiffens the beam: B and C divided by (1 - B/S) and (1 - C/S) with S the
    strong bending stiffness, to first order in both ratios.
    Sources: S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability (1961), section 6.3; the deflection:
    D. H. Hodges, D. A. Peters, Int. J. Solids Struct. 11 (1975) 1269-1280.
    """
    root = 2 * brentq(lambda z: jv(-0.25, z), 1.5, 2.5)
    before = (1 - weak_bending / strong_bending) * (1 - torsion / strong_bending)
    return root * np.sqrt(weak_bending * torsion / before) / length**2
