"""Materials at the temperature selected by case control: MATT1 with TEMPD and TABLEM1."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from supple.importers.nastran.bulk_data import BulkCard, by_id
from supple.importers.nastran.deck_reading import DeckReading

_MATERIALS = ("MATT1", "MATT2", "MATT3", "MATT8", "MATT9", "MATT11")
_FIELDS = ("TEMP", "TEMPP1", "TEMPP3", "TEMPRB", "TEMPF", "TEMPG")
_OF_STIFFNESS_AND_MASS = range(1, 5)
"""Indices in `BulkCard.fields` of E, G, NU and RHO in a MAT1, and of their tables in a MATT1."""


def at_temperature(reading: DeckReading, cards: Mapping[int, BulkCard]) -> dict[int, BulkCard]:
    """{id: MAT1 card} with the values of MATT1 tables at the uniform temperature that case control selects.

    Empty if case control selects no temperatures. Other tables, and tables at temperatures that are not
    uniform or outside a table, are left out.
    """
    if not reading.case.temperature:
        return {}
    temperature = _uniform(reading)
    tables = by_id(reading.file.named("TABLEM1"), "table")
    found: dict[int, BulkCard] = {}
    for number, card in by_id(reading.file.named(*_MATERIALS), "material").items():
        if number not in cards or (card.name == "MATT1" and card.is_blank(1, 5)):
            continue  # tables of thermal expansion or damping only
        fields = [*cards[number].fields, *[""] * 5]
        known = card.name == "MATT1" and temperature is not None
        for place in _OF_STIFFNESS_AND_MASS if known else ():
            if card.word(place) in ("", "0"):
                continue
            value = _interpolated(tables.get(card.integer(place, "a table")), temperature or 0.0)
            known &= value is not None
            fields[place] = repr(value)
        if known:
            found[number] = cards[number]._replace(fields=tuple(fields))
        else:
            reading.leave_out(card, "its values at the temperatures of case control are not read")
    return found


def _uniform(reading: DeckReading) -> float | None:
    """The uniform temperature by TEMPD; None without TEMPD, or if cards give grids or elements others."""
    chosen = reading.case.temperature
    if any(card.word(0) == chosen for card in reading.file.named(*_FIELDS)):
        return None
    for card in reading.file.named("TEMPD"):
        for place in range(0, len(card.fields), 2):
            if card.word(place) == chosen:
                return card.real(place + 1, "the temperature")
    return None


def _interpolated(table: BulkCard | None, at: float) -> float | None:
    """Value of a TABLEM1, linear between its points, on an axis LOG linear in the logarithm.

    None outside the range of the points, without table or points, or for values without logarithm.
    """
    if table is None:
        return None
    words = [word.upper() for word in table.fields[8:]]
    pairs = zip(range(8, len(table.fields), 2), words[::2], words[1::2], strict=False)
    points = [
        (table.real(place, "x"), table.real(place + 1, "y"))
        for place, x, y in pairs
        if x and y and "ENDT" not in (x, y) and "SKIP" not in (x, y)
    ]
    if not points:
        return None
    x, y = np.array(sorted(points)).T
    log_x, log_y = (table.word(place) == "LOG" for place in (1, 2))
    if not x[0] <= at <= x[-1] or (log_x and x[0] <= 0) or (log_y and y.min() <= 0):
        return None
    if log_x:
        x, at = np.log(x), float(np.log(at))
    return float(np.exp(np.interp(at, x, np.log(y))) if log_y else np.interp(at, x, y))
