"""Lateral buckling of a narrow cantilever under a dead force at its tip, in closed form."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_bvp
from scipy.optimize import brentq
from scipy.special import jv


def lateral_buckling_load(weak_bending, strong_bending, torsion, length):
    """Critical tip force: J_(-1/4)(P L^2 / 2 sqrt(B C)) = 0, that is P = 4.0126 sqrt(B C) / L^2.

    The deflection before buckling stiffens the beam: B and C are divided by (1 - B/S) and (1 - C/S) with S
    the strong bending stiffness, to first order in both ratios.
    Sources: S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability (1961), section 6.3; the deflection:
    D. H. Hodges, D. A. Peters, Int. J. Solids Struct. 11 (1975) 1269-1280.
    """
    root = 2 * brentq(lambda z: jv(-0.25, z), 1.5, 2.5)
    before = (1 - weak_bending / strong_bending) * (1 - torsion / strong_bending)
    return root * np.sqrt(weak_bending * torsion / before) / length**2


def warped_buckling_load(weak_bending, torsion, warping, length):
    """Critical tip force if warping is prevented at the root.

    E Gamma phi'''' = G J phi'' + P^2 / B (L - x)^2 phi,  phi = phi' = 0 at the root, no moments at the tip.
    Source: V. Z. Vlasov, Thin-walled elastic beams (1961).
    """

    def slope(x, y, square):
        bent = square[0] * (length - x) ** 2 * y[0]
        return np.array([y[1], y[2], y[3], torsion / warping * (y[2] + bent)])

    def ends(root, tip, _):
        return np.array([root[0], root[1], tip[2], warping * tip[3] - torsion * tip[1], tip[0] - 1])

    x = length * (1 - np.cos(np.linspace(0, np.pi, 400))) / 2
    s = np.pi / 2 * x / length
    guess = np.array([np.sin(s), np.cos(s), -np.sin(s), -np.cos(s)])
    solution = solve_bvp(slope, ends, x, guess, p=[16 / length**4], tol=1e-6)
    if not solution.success:
        raise RuntimeError(f"no buckling load: {solution.message}")
    return float(np.sqrt(solution.p[0] * weak_bending * torsion))
