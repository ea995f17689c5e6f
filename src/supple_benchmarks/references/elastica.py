"""The elastica: an inextensible cantilever without shear under a transverse dead force, by shooting."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

__all__ = ["elastica", "force_for_rotation"]


def elastica(bending_stiffness: float, length: float, tip_force: float) -> tuple[float, float, float]:
    """Tip (along, across, rotation) of a cantilever that lies along x, clamped at its root.

    E I theta'' = -P cos theta,  theta(0) = 0,  theta'(L) = 0. The unknown is the tip rotation, from which the
    equation is integrated to the root.
    """
    load = tip_force / bending_stiffness

    def shot(tip):
        def rates(_, y):
            angle, bend, _, _ = y
            return [bend, -load * np.cos(angle), np.cos(angle), np.sin(angle)]

        return solve_ivp(rates, (length, 0.0), [tip, 0.0, 0.0, 0.0], rtol=1e-11, atol=1e-12).y[:, -1]

    tip = brentq(lambda angle: shot(angle)[0], 0.0, np.pi / 2, xtol=1e-13)
    _, _, along, across = shot(tip)
    return float(-along), float(-across), float(tip)


def force_for_rotation(bending: float, length: float, rotation: float) -> tuple[float, NDArray[np.float64]]:
    """Dead force, N, that rotates the tip of an elastica by `rotation`, rad; tip position (along, across)."""
    scale = bending / length**2

    def missing(force: float) -> float:
        return elastica(bending, length, force)[2] - rotation

    force = brentq(missing, 1e-3 * scale, 20 * scale, xtol=1e-12 * scale)
    assert isinstance(force, float)
    return force, np.array(elastica(bending, length, force)[:2])
