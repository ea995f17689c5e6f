"""The analysis set of a Nastran file: physical freedoms (ASET, BSET, CSET), modal coordinates (QSET, SPOINT).

A scalar point has component 0. Matrix rows are in the order of ids, grids and scalar points together.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from supple.arrays import IntArray
from supple.importers.nastran.bulk_data import BulkCard, BulkFile

_PHYSICAL, _MODAL = ("ASET", "BSET", "CSET"), ("QSET",)
# Largest difference of A and B in A THRU B; a larger one is an error.
_LONGEST_RANGE = 10**6


def retained_freedoms(file: BulkFile, grids: IntArray, *, modal: bool = True) -> IntArray | None:
    """Freedoms (n, 2) of the analysis set, id and component, in Nastran's order; None if no card lists any.

    grids : (N,) ids of the grids;  modal : False leaves QSET out

    Raises
    ------
    ImportFormatError   missing points; invalid components
    """
    sets = (*_PHYSICAL, *_MODAL) if modal else _PHYSICAL
    rows = _freedoms(file, sets, set(grids.tolist()), scalar_points(file))
    return np.array(sorted(rows), dtype=np.int64) if rows else None


def modal_freedoms(file: BulkFile, grids: IntArray) -> IntArray:
    """Freedoms (k, 2) that are modal coordinates, id and component: those of QSET, and all scalar points.

    grids, errors : as for `retained_freedoms`
    """
    points = scalar_points(file)
    rows = _freedoms(file, _MODAL, set(grids.tolist()), points) | {(point, 0) for point in points}
    return np.array(sorted(rows), dtype=np.int64).reshape(-1, 2)


def scalar_points(file: BulkFile) -> set[int]:
    """Ids of SPOINT cards."""
    return {point for card in file.named("SPOINT") for point in _listed(card, 0, None)}


def _freedoms(
    file: BulkFile, sets: tuple[str, ...], grids: set[int], points: set[int]
) -> set[tuple[int, int]]:
    rows: set[tuple[int, int]] = set()
    for card in file.named(*sets):
        pairs = [i for i in range(0, len(card.fields), 2) if card.word(i)]
        if not pairs:
            raise card.error("names no grids; add them, or is the file cut short?")
        for i in pairs:
            rows |= _of_point(
                card, card.integer(i, "a grid or scalar point"), card.word(i + 1), grids, points
            )
    for card in file.named(*(f"{name}1" for name in sets)):
        for point in _listed(card, 1, grids | points):
            rows |= _of_point(card, point, card.word(0), grids, points)
    return rows


def _of_point(
    card: BulkCard, point: int, word: str, grids: set[int], points: set[int]
) -> set[tuple[int, int]]:
    if point in points:
        if word not in ("", "0"):
            raise card.error(f"scalar point {point} has no component '{word}'; leave it blank, or 0")
        return {(point, 0)}
    if point not in grids:
        raise card.error(f"names {point}, which is no GRID or SPOINT of the file; add its card")
    if not word or len(set(word)) < len(word) or not set(word) <= set("123456"):
        raise card.error(f"components '{word}' are not some of 123456, each once; correct them")
    return {(point, int(component)) for component in word}


def _listed(card: BulkCard, start: int, known: set[int] | None) -> Iterable[int]:
    """Ids of a list, or ids of A THRU B that are in `known`; all ids of A THRU B if `known` is None."""
    if card.word(start + 1) != "THRU":
        ids = [card.integer(i, "a point") for i in range(start, len(card.fields)) if card.word(i)]
        if not ids:
            raise card.error("names no grids; add them, or is the file cut short?")
        return ids
    first, last = card.integer(start, "the first point"), card.integer(start + 2, "the last point")
    further = [word for word in card.fields[start + 3 :] if word]
    if further:
        raise card.error(f"'{further[0]}' follows {first} THRU {last}; write it on a separate card")
    if not 0 <= last - first <= _LONGEST_RANGE:
        raise card.error(f"{first} THRU {last} is no range; correct it")
    inside = range(first, last + 1)
    found = inside if known is None else sorted(known.intersection(inside))
    if not found:
        raise card.error(f"no grid lies in {first} THRU {last}; correct the range")
    return found
