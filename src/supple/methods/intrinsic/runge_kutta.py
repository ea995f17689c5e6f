"""One step of the classical Runge-Kutta rule, and its stability limit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import numpy as np

__all__ = ["growth", "linear_eigenvalues", "runge_kutta_step"]

Rates = Callable[[Any, Any], Any]
"""Function of time and state that returns the rates."""


def runge_kutta_step(rates: Rates, time: Any, state: Any, h: Any) -> Any:
    """The state after a step h, to fourth order."""

    def moved(by: Any, factor: float) -> Any:
        return jax.tree.map(lambda y, k: y + factor * h * k, state, by)

    k1 = rates(time, state)
    k2 = rates(time + h / 2, moved(k1, 0.5))
    k3 = rates(time + h / 2, moved(k2, 0.5))
    k4 = rates(time + h, moved(k3, 1.0))
    return jax.tree.map(lambda y, a, b, c, d: y + h / 6 * (a + 2 * (b + c) + d), state, k1, k2, k3, k4)


def linear_eigenvalues(omega: np.ndarray, decay: np.ndarray, retardation: np.ndarray) -> np.ndarray:
    """Eigenvalues s (2 e,) of the linear modes, s^2 + (d + w beta w) s + w^2 = 0.

    decay, retardation : (e,) or (e, e)    d and beta
    """
    if decay.ndim == retardation.ndim == 1:
        half = 0.5 * (decay + retardation * omega**2)
        root = np.sqrt((half**2 - omega**2).astype(complex))
        return np.concatenate([-half + root, -half - root])
    whole, late = (each if each.ndim == 2 else np.diag(each) for each in (decay, retardation))
    damping = whole + omega[:, None] * late * omega
    elastic = np.diag(omega)
    return np.linalg.eigvals(np.block([[-damping, elastic], [-elastic, np.zeros_like(elastic)]]))


def growth(eigenvalues: np.ndarray, h: float) -> float:
    """Largest factor by which a step multiplies a linear mode, at most 1 for a stable step.

    |1 + z + z^2/2 + z^3/6 + z^4/24|, z = h s. Without damping the factor exceeds 1 where w h > 2 sqrt 2.
    """
    z = h * eigenvalues
    return float(np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24).max(initial=0.0))
