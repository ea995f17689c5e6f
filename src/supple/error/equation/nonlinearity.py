"""How far an error is from being small: what a second correction would be, in parts of the first."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.error.equation.error_history import ErrorHistory

__all__ = ["second_correction"]

MOST_INSTANTS = 10


def second_correction(history: ErrorHistory) -> float:
    """Size of a second elastic correction over the first at the worst instants, at rest.

        K_t(q + e) d = -( f(q + e) - f(q) - K_t(q) e ),    |d| / |e| in the mass norm

    with q the motion about which the error e was found; zero for a linear body.
    """
    assessed = history.body
    body, motion, Z = assessed.full.body, assessed.motion, assessed.space.vectors
    if body.is_linear:
        return 0.0
    largest = 0.0
    for row in _worst(history.rms):
        q = motion.vectors @ motion.coordinates[row]
        found = history.coordinates[row]
        size = np.linalg.norm(found)
        if not size:
            continue
        e = Z @ found
        assembly = body.assembly
        left = assembly.internal_force(q + e) - assembly.internal_force(q) - assembly.tangent(q) @ e
        stiffness = Z.T @ (assembly.tangent(q + e) @ Z)
        second = np.linalg.lstsq(stiffness, Z.T @ left, rcond=None)[0]
        largest = max(largest, float(np.linalg.norm(second) / size))
    return largest


def _worst(rms: NDArray[np.float64]) -> NDArray[np.intp]:
    """Instants of the largest errors, at some distance from each other."""
    spans = np.array_split(np.arange(len(rms)), min(len(rms), 4 * MOST_INSTANTS))
    peaks = np.array([span[np.argmax(rms[span])] for span in spans])
    return peaks[np.argsort(rms[peaks])[::-1][:MOST_INSTANTS]]
