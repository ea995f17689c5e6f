"""Conversion of ids, in any order and with gaps, to numbers from 0."""

from __future__ import annotations

from dataclasses import dataclass, field

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


@dataclass(frozen=True, eq=False)
class Labels:
    """Scopes and ids of items; ids are unique within a scope."""

    scopes: IntArray
    ids: IntArray
    _sorted: dict[int, tuple[IntArray, IntArray]] = field(default_factory=dict)

    def numbers(self, scope: int, ids: IntArray) -> tuple[IntArray, BoolArray]:
        """Numbers of ids in a scope, and a mask of the ids that exist; only these have a valid number."""
        # Ids are looked up line by line, so they are sorted once.
        if scope not in self._sorted:
            mine = self.of(scope)
            mine = mine[np.argsort(self.ids[mine], kind="stable")]
            self._sorted[scope] = mine, self.ids[mine]
        mine, known = self._sorted[scope]
        if not len(mine):
            return np.zeros(ids.shape, dtype=np.int64), np.zeros(ids.shape, dtype=bool)
        place = np.minimum(np.searchsorted(known, ids), len(known) - 1)
        return mine[place], known[place] == ids

    def of(self, scope: int) -> IntArray:
        """Numbers of all items in a scope."""
        return np.flatnonzero(self.scopes == scope)
