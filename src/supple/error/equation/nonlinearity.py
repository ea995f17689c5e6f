"""Nonlinearity of an error: size of a second correction over the first."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.error.equation.error_history import ErrorEquation, ErrorHistory

__all__ = ["second_corrections"]


MOST_INSTANTS = 10
"""Largest number of times at which a second correction is computed."""
IMAGINARY = 1e-20
"""Size of an imaginary step along an error: it gives the derivative of the polynomial force to round-off."""


def second_corrections(equation: ErrorEquation, histories: Mapping[str, ErrorHistory]) -> dict[str, float]:
    """Second elastic correction over the first, quasi-static, at the times of the largest errors; by body.

        K_t(q) d = -( f(q + e) - f(q) - K_t(q) e ),    |d| / |e| in the mass norm

    with q the motion of the run and e its estimated error; zero for a linear body.
    """
    return {
        name: 0.0
        if history.body.full.is_linear
        else _second_correction(history, lambda row, name=name: equation.stiffness(name, row))
        for name, history in histories.items()
    }


def _second_correction(history: ErrorHistory, stiffness: Callable[[int], FloatArray]) -> float:
    """The ratio for a nonlinear body; `stiffness` gives `Z^T K_t Z` (k, k) at a step of the run."""
    assessed = history.body
    motion, Z = assessed.motion, assessed.space.vectors
    force = assessed.full.body.assembly.internal_force
    largest = 0.0
    for row in _worst(history.rms).tolist():
        q = motion.vectors @ motion.coordinates[row]
        found = history.coordinates[row]
        size = np.linalg.norm(found)
        if not size:
            continue
        e = Z @ found
        at_run = force(q + 1j * IMAGINARY * e)
        left = force(q + e) - at_run.real - at_run.imag / IMAGINARY
        second = np.linalg.lstsq(stiffness(row), Z.T @ left, rcond=None)[0]
        largest = max(largest, float(np.linalg.norm(second) / size))
    return largest


def _worst(rms: FloatArray) -> NDArray[np.intp]:
    """Indices of the steps with the largest errors, at some distance from each other."""
    spans = np.array_split(np.arange(len(rms)), min(len(rms), 4 * MOST_INSTANTS))
    peaks = np.array([span[np.argmax(rms[span])] for span in spans])
    return peaks[np.argsort(rms[peaks])[::-1][:MOST_INSTANTS]]
