"""Frequencies of a reduced body with one interface held in space: what a test on a clamp would measure."""

from __future__ import annotations

import numpy as np
from scipy import linalg

from supple.algebra.rotation import skew
from supple.reduction.reduced_body import ReducedBody


def held_frequencies(body: ReducedBody, interface: str) -> np.ndarray:
    """Natural frequencies (rad/s, ascending) of a reduced body with one interface clamped and the rest free.

        q = R a + V gamma,   [ R_p  B_p V ] (a, gamma) = 0,   R_p the rigid motions at the interface p

    The floating frame moves freely, so the answer is that of the clamped body in any frame: as many
    frequencies as there are coordinates, less those that the frame itself holds at p.

    Raises
    ------
    ModelError  the body has no interface of that name
    """
    place = body.interface(interface)
    r = body.r
    fields = np.r_[0:6, 6 + 3 * r : 6 + 4 * r]
    mass = body.gram[np.ix_(fields, fields)]
    stiffness = linalg.block_diag(np.zeros((6, 6)), body.stiffness)
    rigid = np.block([[np.eye(3), -np.asarray(skew(place.position))], [np.zeros((3, 3)), np.eye(3)]])
    free = linalg.null_space(np.hstack([rigid, place.motion]))
    values = linalg.eigh(free.T @ stiffness @ free, free.T @ mass @ free, eigvals_only=True)
    return np.sqrt(np.maximum(values, 0.0))
