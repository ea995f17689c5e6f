"""Coordinates that never move: bodies of nearby sizes run by one compiled program.

A reduced body of r coordinates is filled up to R by such of unit mass and its highest frequency, that
nothing couples or loads: they stay at rest, and every number of the run is what it was. The sizes of the
arrays, which a compiled program is made for, no longer tell r. It costs the products of R coordinates instead
of r, against several seconds of the compiler for every other r; so it is for runs made once, as the rounds of
a self-correction are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import linalg

from supple.reduction.reduced_body import ReducedBody

__all__ = ["filled_up", "with_room"]

MULTIPLE = 16
LARGEST = 32
"""Coordinates: beyond, products of the quartic tensor take longer than a compiler in runs of some seconds."""


def with_room(body: ReducedBody) -> ReducedBody:
    """The same body, to be run with inert coordinates: up to the next multiple of sixteen."""
    if body.condensed is not None or body.r > LARGEST or body.r % MULTIPLE == 0:
        return body
    return replace(body, inert=-body.r % MULTIPLE)


def filled_up(body: ReducedBody) -> ReducedBody:
    """The body with its inert coordinates as coordinates like all others, behind them."""
    r, size = body.r, body.r + body.inert
    if not body.inert:
        return body
    highest, inert = body.frequencies[-1], np.eye(body.inert)
    gram = np.zeros((6 + 4 * size,) * 2)
    kept = np.r_[: 6 + 3 * r, 6 + 3 * size : 6 + 3 * size + r]
    gram[np.ix_(kept, kept)] = body.gram
    gram[6 + 3 * size + r :, 6 + 3 * size + r :] = inert

    first, second = np.triu_indices(size)
    pairs, own = np.flatnonzero(second < r), np.arange(r)

    def spread(tensor: np.ndarray | None, rows: np.ndarray, columns: np.ndarray) -> np.ndarray | None:
        if tensor is None:
            return None
        whole = np.zeros((len(first), len(first) if columns is pairs else size))
        whole[np.ix_(rows, columns)] = tensor
        return whole

    def wider(columns: np.ndarray) -> np.ndarray:
        return np.pad(columns, [(0, 0)] * (columns.ndim - 1) + [(0, body.inert)])

    filled = replace(
        body,
        inert=0,
        gram=gram,
        stiffness=linalg.block_diag(body.stiffness, highest**2 * inert),
        cubic=spread(body.cubic, pairs, own),
        quartic=spread(body.quartic, pairs, pairs),
        damping=linalg.block_diag(body.damping, 0 * inert),
        damping_cubic=spread(body.damping_cubic, pairs, own),
        damping_quartic=spread(body.damping_quartic, pairs, pairs),
        interfaces=tuple(replace(each, motion=wider(each.motion)) for each in body.interfaces),
        nodal_basis=wider(body.nodal_basis),
        rotation_basis=None if body.rotation_basis is None else wider(body.rotation_basis),
        frequencies=np.append(body.frequencies, np.full(body.inert, highest)),
    )
    # Not by the blocks of their zeros, which would tell r.
    vars(filled)["quartic_blocks"] = filled.quartic
    vars(filled)["damping_quartic_blocks"] = filled.damping_quartic
    return filled
