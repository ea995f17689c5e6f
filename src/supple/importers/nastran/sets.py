"""Sets of a Nastran file: supports (SPC, SPC1, PS of GRID) and the analysis set (ASET, ASET1) as node "
"sets."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.importers.nastran.bulk_data import BulkCard, BulkFile
from supple.importers.nastran.grids import GridPoints
from supple.importers.nastran.retained_freedoms import retained_freedoms

IntArray = NDArray[np.int64]

SET_CARDS = ("SPC", "SPC1", "ASET", "ASET1")


def node_sets(file: BulkFile, grids: GridPoints) -> dict[str, IntArray]:
    """Node sets: `spcS_C` of support set S and components C, `spc_C` of PS fields, `aset`; each node once.

    Raises
    ------
    ImportFormatError   missing grids; components that are none; a support that moves
    """
    found: dict[str, list[int]] = {}
    for number, components in enumerate(grids.supports.tolist()):
        if components and components != "0":
            found.setdefault(f"spc_{_components(grids.cards[number], components)}", []).append(number)
    for card in file.named("SPC"):
        for grid, components, place in _pairs(card, 1, 3):
            if card.real(place + 2, "the enforced displacement", 0.0) != 0:
                raise card.error("an enforced displacement is not read; prescribe it by a joint with a law")
            name = f"spc{card.integer(0, 'the set id')}_{_components(card, components)}"
            found.setdefault(name, []).extend(grids.numbers(card, [grid]).tolist())
    for card in file.named("SPC1"):
        name = f"spc{card.integer(0, 'the set id')}_{_components(card, card.word(1))}"
        found.setdefault(name, []).extend(_listed(card, 2, grids))
    physical = retained_freedoms(file, grids.ids, modal=False)
    if physical is not None:
        found["aset"] = grids.lookup(np.unique(physical[physical[:, 1] > 0, 0]))[0].tolist()
    return {name: np.array(list(dict.fromkeys(members)), dtype=np.int64) for name, members in found.items()}


def _pairs(card: BulkCard, start: int, step: int) -> list[tuple[int, str, int]]:
    """Grid id, components and place of each pair on a card."""
    places = [i for i in range(start, len(card.fields), step) if card.word(i)]
    if not places:
        raise card.error("names no grids; add them, or is the file cut short?")
    return [(card.integer(i, "a grid"), card.word(i + 1), i) for i in places]


def _listed(card: BulkCard, start: int, grids: GridPoints) -> list[int]:
    """Grid numbers of a list G1 G2 .. or of G1 THRU G2, which names the grids there are in between."""
    if card.word(start + 1) == "THRU":
        first, last = card.integer(start, "the first grid"), card.integer(start + 2, "the last grid")
        further = [word for word in card.fields[start + 3 :] if word]
        if further:
            raise card.error(f"'{further[0]}' follows {first} THRU {last}; write it on a card of its own")
        inside = np.flatnonzero((grids.ids >= first) & (grids.ids <= last))
        if not inside.size:
            raise card.error(f"no grid lies in {first} THRU {last}; correct the range")
        return inside[np.argsort(grids.ids[inside])].tolist()
    ids = [card.integer(i, "a grid") for i in range(start, len(card.fields)) if card.word(i)]
    if not ids:
        raise card.error("names no grids; add them, or is the file cut short?")
    return grids.numbers(card, ids).tolist()


def _components(card: BulkCard, word: str) -> str:
    if not word or len(set(word)) < len(word) or not set(word) <= set("123456"):
        raise card.error(f"components '{word}' are not some of 123456, each once; correct them")
    return "".join(sorted(word))
