"""Natural frequencies of an exported body, as a reference for the program that imports it."""

from __future__ import annotations

import numpy as np
from scipy import linalg

from supple.arrays import FloatArray
from supple.reduction import ReducedBody

__all__ = ["StatedFrequencies", "floating_frequencies"]


StatedFrequencies = list[tuple[str, FloatArray]]
"""Description of each support, and the lowest frequencies of the body on it, cycles per unit of time."""

N_STATED = 6
N_RIGID = 6


def floating_frequencies(body: ReducedBody) -> StatedFrequencies:
    """Lowest frequencies of a body in a floating frame: free, and with the frame at rest."""
    stiffness, mass, _ = free_matrices(body)
    free = frequencies(stiffness, mass)[N_RIGID:]
    at_rest = frequencies(body.stiffness, mass[N_RIGID:, N_RIGID:])
    return [("free", free[:N_STATED]), ("its frame at rest", at_rest[:N_STATED])]


def free_matrices(body: ReducedBody) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Stiffness, mass and damping (6 + r, 6 + r), for rigid motion of the mesh axes and the r coordinates."""
    own = np.r_[:N_RIGID, N_RIGID + 3 * body.r : len(body.gram)]
    mass = np.array(body.gram[np.ix_(own, own)])
    still = np.zeros((N_RIGID, N_RIGID))
    return linalg.block_diag(still, body.stiffness), mass, linalg.block_diag(still, body.damping)


def frequencies(stiffness: FloatArray, mass: FloatArray) -> FloatArray:
    """All natural frequencies, cycles per unit of time, ascending."""
    if not len(mass):
        return np.empty(0)
    scale = 1.0 / np.sqrt(np.diag(mass))
    both = np.outer(scale, scale)
    squares = linalg.eigh(stiffness * both, mass * both, eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)


def frequency_lines(stated: StatedFrequencies) -> list[str]:
    """Lines for the header of a file."""
    lines = [
        f"  {words}: {', '.join(f'{value:.6g}' for value in values) or 'none'}" for words, values in stated
    ]
    return ["reference frequencies, cycles per unit of time", *lines]
