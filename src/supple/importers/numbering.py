"""Conversion of ids, in any order and with gaps, to numbers from 0."""

from __future__ import annotations

import numpy as np

from supple.arrays import BoolArray, IntArray

__all__ = ["positions_of_ids"]


def positions_of_ids(ids: IntArray, wanted: IntArray) -> tuple[IntArray, BoolArray]:
    """Position of each wanted id in `ids`, and a mask of the ids that exist; only these are valid."""
    if not len(ids):
        return np.zeros(np.shape(wanted), dtype=np.int64), np.zeros(np.shape(wanted), dtype=bool)
    order = np.argsort(ids)
    place = np.minimum(np.searchsorted(ids[order], wanted), len(ids) - 1)
    return order[place], ids[order[place]] == wanted


def in_range(ids: IntArray, listed: range) -> BoolArray:
    """Mask of the ids in an ascending range, which may be too long for an array."""
    return (ids >= listed.start) & (ids < listed.stop) & ((ids - listed.start) % listed.step == 0)


def first_repeated(ids: IntArray) -> int | None:
    """The first position of an id that also occurs before it; None if all ids differ."""
    order = np.argsort(ids, kind="stable")
    again = np.flatnonzero(ids[order][1:] == ids[order][:-1])
    return int(order[1:][again].min()) if again.size else None
