"""Rigid and averaging elements of a Nastran file (RBE2, RBE3) as places where joints take hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.importers.connection import Connection
from supple.importers.nastran.bulk_data import BulkCard, BulkFile
from supple.importers.nastran.grids import GridPoints

IntArray = NDArray[np.int64]

TRANSLATIONS, ALL_SIX = "123", "123456"


@dataclass(frozen=True, eq=False)
class GridConnection:
    """A connection before unused grid points are dropped, with its card and reference grid."""

    connection: Connection
    reference: int
    card: BulkCard


def read_connections(
    file: BulkFile, grids: GridPoints, in_elements: NDArray[np.bool_], *, turning: bool
) -> list[GridConnection]:
    """RBE2 and RBE3 of a file.

    Parameters
    ----------
    in_elements : (N,) whether elements use a grid point
    turning     : whether nodes have rotations (shells, beams): an RBE2 must then tie them, too
    Raises
    ------
    ImportFormatError   an element id given twice; missing grids; components that our interfaces do not tie
    """
    found: list[GridConnection] = []
    taken: set[str] = set()
    for card in file.named("RBE2", "RBE3"):
        read = _rbe2 if card.name == "RBE2" else _rbe3
        made = read(card, grids, in_elements, turning)
        if made.connection.name in taken:
            raise card.error(f"element {card.word(0)} is defined a second time; renumber or remove it")
        taken.add(made.connection.name)
        found.append(made)
    return found


def _rbe2(card: BulkCard, grids: GridPoints, in_elements: NDArray[np.bool_], turning: bool) -> GridConnection:
    """EID GN CM GM1 .. [ALPHA]: the reference grid moves with the others if elements use it."""
    ties = "".join(sorted(card.word(2)))
    if ties != ALL_SIX and (turning or ties != TRANSLATIONS):
        allowed = ALL_SIX if turning else f"{TRANSLATIONS} or {ALL_SIX}"
        raise card.error(
            f"ties the components '{card.word(2)}'; a rigid interface ties all, so write {allowed}, or "
            "make it a joint of the machine"
        )
    words = [i for i in range(3, len(card.fields)) if card.fields[i]]
    if words and "." in card.fields[words[-1]]:  # ALPHA, thermal expansion, which nothing here heats
        words.pop()
    reference, *rest = grids.numbers(card, [card.integer(i, "a grid") for i in (1, *words)]).tolist()
    if in_elements[reference]:
        rest = [reference, *rest]
    nodes = _checked_nodes(card, grids, rest, in_elements)
    connection = Connection(f"rbe2_{card.word(0)}", nodes, grids.positions[reference], None)
    return GridConnection(connection, reference, card)


def _rbe3(card: BulkCard, grids: GridPoints, in_elements: NDArray[np.bool_], turning: bool) -> GridConnection:
    """EID - REFGRID REFC WT1 C1 G1,1 G1,2 .. WT2 C2 G2,1 .. [UM ..] [ALPHA ..]."""
    follows = "".join(sorted(card.word(3)))
    if follows not in (TRANSLATIONS, ALL_SIX):
        raise card.error(
            f"its reference grid follows in the components '{card.word(3)}'; write {ALL_SIX} or "
            f"{TRANSLATIONS}"
        )
    ids, weights = _weighted_grids(card, turning)
    reference, *nodes = grids.numbers(card, [card.integer(2, "the reference grid"), *ids]).tolist()
    if in_elements[reference]:
        raise card.error(
            f"elements use its reference grid {card.word(2)}, which would then hang on others; give the "
            "RBE3 a grid of its own"
        )
    numbers = _checked_nodes(card, grids, nodes, in_elements)
    connection = Connection(f"rbe3_{card.word(0)}", numbers, grids.positions[reference], np.array(weights))
    return GridConnection(connection, reference, card)


def _weighted_grids(card: BulkCard, turning: bool) -> tuple[list[int], list[float]]:
    """Grids in the order of the card, each with its weight: WT, C, then grids until the next weight."""
    ids: list[int] = []
    weights: list[float] = []
    weight, place = 0.0, 4
    while place < len(card.fields):
        word = card.word(place)
        if word in ("UM", "ALPHA"):
            if word == "UM":
                raise card.error("a choice of dependent freedoms (UM) is not read; leave it out")
            break
        if "." in word:
            weight = card.real(place, "a weight")
            if weight <= 0:
                raise card.error(f"a weight is {weight:g}; weights are positive")
            components = "".join(sorted(card.word(place + 1)))
            if components != TRANSLATIONS and (turning or components != ALL_SIX):
                raise card.error(
                    f"averages the components '{card.word(place + 1)}'; an averaging interface takes the "
                    f"mean of translations, so write {TRANSLATIONS}"
                )
            place += 2
            continue
        if word:
            if not weight:
                raise card.error(
                    f"'{word}' stands where a weight is expected; weights are written with a point"
                )
            ids.append(card.integer(place, "a grid"))
            weights.append(weight)
        place += 1
    return ids, weights


def _checked_nodes(
    card: BulkCard, grids: GridPoints, numbers: list[int], in_elements: NDArray[np.bool_]
) -> IntArray:
    nodes = np.array(numbers, dtype=np.int64)
    if not nodes.size:
        raise card.error("ties no grids; add them, or is the file cut short?")
    if np.unique(nodes).size < nodes.size:
        values, counts = np.unique(nodes, return_counts=True)
        raise card.error(f"names grid {grids.ids[values[counts > 1][0]]} more than once; name it once")
    loose = nodes[~in_elements[nodes]]
    if loose.size:
        raise card.error(
            f"ties grid {grids.ids[loose[0]]}, which no element uses; tie grids of elements only"
        )
    return nodes
