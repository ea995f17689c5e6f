"""Padding coordinates, which stay at rest, so that bodies of similar sizes share one compiled program.

A reduced body of r coordinates is padded to R coordinates; the added ones have unit mass and the highest
frequency of the body. They are neither coupled nor loaded: they stay at rest, and the results of the run do
not change. The array sizes, for which a program is compiled, depend on R alone. A run then computes products
in R instead of r coordinates, but another r with the same R needs no compilation of several seconds. Padding
therefore pays for bodies that run only once, such as in the rounds of a self-correction.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import linalg

from supple.reduction.reduced_body import ReducedBody

__all__ = ["filled_up", "padded", "padded_with_zeros"]

SIZES = 24, 32
"""Padded sizes. The first suffices for all rounds of most self-corrections; above the last, products of the
quartic tensor cost a short run more than a compilation."""


def padded(body: ReducedBody) -> ReducedBody:
    """The same body, with `padding` set to reach the next larger of `SIZES`.

    A body with condensed motion, or with as many coordinates as the last of them, is unchanged.
    """
    if body.condensed is not None or body.r >= SIZES[-1]:
        return body
    return replace(body, padding=next(size for size in SIZES if size > body.r) - body.r)


def filled_up(body: ReducedBody) -> ReducedBody:
    """The body with its padding coordinates appended as ordinary coordinates, and `padding` zero."""
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
        """Rows of the pairs of r coordinates at their positions among the pairs of all; other rows zero."""
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
    # Not split into nonzero blocks (`pair_blocks`), because the sizes of the blocks would depend on r.
    vars(filled)["quartic_blocks"] = filled.quartic
    vars(filled)["damping_quartic_blocks"] = filled.damping_quartic
    return filled


def padded_with_zeros(columns: np.ndarray, more: int) -> np.ndarray:
    """An array (..., r) with `more` columns of zeros appended."""
    return np.pad(columns, [(0, 0)] * (columns.ndim - 1) + [(0, more)])
