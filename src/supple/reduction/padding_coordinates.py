"""Padding coordinates, which never move: bodies of similar sizes share one compiled program.

A reduced body of r coordinates is padded to R with coordinates of unit mass and the highest frequency of the
body. The padding coordinates are neither coupled nor loaded: they stay at rest, and every number of the run
is unchanged. The array sizes, for which a program is compiled, no longer depend on r. A run then has products
of R coordinates instead of r, but needs no compilation of several seconds for another r. Padding therefore
pays for runs made once, such as the rounds of a self-correction.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import linalg

from supple.reduction.reduced_body import ReducedBody

__all__ = ["filled_up", "padded", "padded_with_zeros"]

MULTIPLE = 16
LARGEST = 32
"""Largest padded size: beyond it, products of the quartic tensor cost a short run more than a compilation."""


def padded(body: ReducedBody) -> ReducedBody:
    """The same body with padding coordinates up to the next larger multiple of sixteen.

    A body of sixteen coordinates is padded, too: the next round adds a few, and shares the program. A body
    with condensed motion, or with 32 coordinates or more, is unchanged.
    """
    if body.condensed is not None or body.r >= LARGEST:
        return body
    return replace(body, padding=MULTIPLE - body.r % MULTIPLE)


def filled_up(body: ReducedBody) -> ReducedBody:
    """The body with its padding coordinates appended to its own as ordinary coordinates."""
    if not body.padding:
        return body
    r, size = body.r, body.r + body.padding
    highest, inert = float(np.max(body.frequencies)), np.eye(body.padding)
    gram = np.zeros((6 + 4 * size,) * 2)
    kept = np.r_[: 6 + 3 * r, 6 + 3 * size : 6 + 3 * size + r]
    gram[np.ix_(kept, kept)] = body.gram
    gram[6 + 3 * size + r :, 6 + 3 * size + r :] = inert
    second = np.triu_indices(size)[1]

    def spread(tensor: np.ndarray) -> np.ndarray:
        """Rows of pairs at their positions among those of all coordinates."""
        whole = np.zeros((len(second), tensor.shape[1]))
        whole[second < r] = tensor
        return whole

    def cubic(tensor: np.ndarray | None) -> np.ndarray | None:
        return None if tensor is None else padded_with_zeros(spread(tensor), body.padding)

    def quartic(tensor: np.ndarray | None) -> np.ndarray | None:
        return None if tensor is None else spread(spread(tensor).T).T

    filled = replace(
        body,
        padding=0,
        gram=gram,
        stiffness=linalg.block_diag(body.stiffness, highest**2 * inert),
        cubic=cubic(body.cubic),
        quartic=quartic(body.quartic),
        damping=np.pad(body.damping, (0, body.padding)),
        damping_cubic=cubic(body.damping_cubic),
        damping_quartic=quartic(body.damping_quartic),
        interfaces=tuple(
            replace(each, motion=padded_with_zeros(each.motion, body.padding)) for each in body.interfaces
        ),
        nodal_basis=padded_with_zeros(body.nodal_basis, body.padding),
        rotation_basis=None
        if body.rotation_basis is None
        else padded_with_zeros(body.rotation_basis, body.padding),
        frequencies=np.append(body.frequencies, np.full(body.padding, highest)),
    )
    # No split into blocks of zeros: the block sizes would depend on r.
    vars(filled)["quartic_blocks"] = filled.quartic
    vars(filled)["damping_quartic_blocks"] = filled.damping_quartic
    return filled


def padded_with_zeros(columns: np.ndarray, more: int) -> np.ndarray:
    """Arrays (.., r) of coordinates, extended by zeros."""
    return np.pad(columns, [(0, 0)] * (columns.ndim - 1) + [(0, more)])
