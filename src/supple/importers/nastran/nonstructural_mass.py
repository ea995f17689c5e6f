"""Non-structural mass of a Nastran deck by NSM, NSM1, NSML, NSML1 and NSMADD, as mass of its elements."""

from __future__ import annotations

import numpy as np

from supple.importers.nastran.bulk_data import BulkCard
from supple.importers.nastran.deck_reading import DeckReading

NSM_CARDS = ("NSM", "NSM1", "NSML", "NSML1", "NSMADD")

_SHELLS = ("CQUAD4", "CQUADR", "CQUAD8", "CTRIA3", "CTRIAR", "CTRIA6")
# Elements of each type of property that the cards may name.
_ELEMENTS = {
    "PSHELL": _SHELLS,
    "PCOMP": _SHELLS,
    "PBAR": ("CBAR",),
    "PBARL": ("CBAR",),
    "PBEAM": ("CBEAM",),
    "PBEAML": ("CBEAM",),
    "PROD": ("CROD",),
    "PTUBE": ("CTUBE",),
    "CONROD": ("CONROD",),
}
_BY_ELEMENT = (*_SHELLS, "CBAR", "CBEAM", "CROD", "CTUBE", "CONROD")


def read_added_mass(reading: DeckReading) -> dict[int, float]:
    """Added mass of elements by element id, kg/m^2 or kg/m, without PARAM,WTMASS.

    NSM and NSM1 give the mass per area or length; NSML and NSML1 give a total mass, which is distributed over
    the area or length of their elements. The sets are those of `DeckReading.chosen_sets`.
    """
    cards = reading.file.named("NSM", "NSM1", "NSML", "NSML1")
    chosen = reading.chosen_sets("NSM", "NSMADD", cards)
    found: dict[int, float] = {}
    for card in (each for each in cards if each.integer(0, "the set id") in chosen):
        for of, ids, value in _entries(card, reading):
            elements = _members(card, of, ids, reading)
            share = value
            if card.name.startswith("NSML"):
                total = sum(_extent(element, reading) for element in elements)
                share = value / total if total else 0.0
            for element in elements:
                number = element.integer(0, "the element id")
                found[number] = found.get(number, 0.0) + share
    return found


def _entries(card: BulkCard, reading: DeckReading) -> list[tuple[str, list[range] | None, float]]:
    """Type, ids (None: all) and value of each entry: TYPE ID VALUE ID VALUE .., or TYPE VALUE ID ID ..

    A list with EXCEPT gives no entries, with a record.
    """
    of = card.word(1)
    if card.name in ("NSM", "NSML"):
        return [
            (of, card.ranges([i]), card.real(i + 1, "the value", 0.0))
            for i in range(2, len(card.fields), 2)
            if card.word(i)
        ]
    value = card.real(2, "the value", 0.0)
    places = range(3, len(card.fields))
    words = {card.word(i) for i in places}
    if "ALL" in words:
        return [(of, None, value)]
    if "EXCEPT" in words:
        reading.leave_out(card, "left out: its list has EXCEPT")
        return []
    return [(of, card.ranges(places), value)]


def _members(card: BulkCard, of: str, ids: list[range] | None, reading: DeckReading) -> list[BulkCard]:
    there: set[int] | None = None
    if of in ("ELEMENT", "CONROD"):
        field, names = 0, _ELEMENTS.get(of, _BY_ELEMENT)
    elif of in _ELEMENTS:
        field, names = 1, _ELEMENTS[of]
        of_type = reading.file.named(of, "PCOMPG" if of == "PCOMP" else of)
        there = {known.integer(0, "the property id") for known in of_type}
    else:
        reading.leave_out(card, f"left out: mass of {of or 'no type'} is not read")
        return []
    numbers = (
        (element, element.property_id() if field else element.integer(0, "the element id"))
        for element in reading.file.named(*names)
    )
    return [
        element
        for element, number in numbers
        if (there is None or number in there) and (ids is None or any(number in each for each in ids))
    ]


def _extent(element: BulkCard, reading: DeckReading) -> float:
    """Area of a shell from its corners; length of a beam or rod."""
    start, count = (1 if element.name == "CONROD" else 2), 2
    if element.name in _SHELLS:
        count = 4 if "QUAD" in element.name else 3
    x = reading.grids.positions[[reading.node(element, start + i, "a grid") for i in range(count)]]
    if count == 2:
        return float(np.linalg.norm(x[1] - x[0]))
    across = (x[2] - x[0], x[3] - x[1]) if count == 4 else (x[1] - x[0], x[2] - x[0])
    return float(np.linalg.norm(np.cross(*across)) / 2)
