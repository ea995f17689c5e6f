"""DMIG: matrices that Nastran punches as bulk data cards (.pch), each entry with its grids and components."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.errors import ImportFormatError
from supple.importers.matrices.labelled_matrix import (
    SINGLE_PRECISION,
    LabelledMatrix,
    MatrixRole,
    chosen_name,
    from_labelled_entries,
    printed_resolution,
)
from supple.importers.nastran.bulk_data import BulkCard, BulkFile, read_bulk_data

_SQUARE, _SYMMETRIC = 1, 6
_REAL_SINGLE, _REAL_DOUBLE = 1, 2


def read_dmig(path: str | Path, role: MatrixRole, *, name: str | None = None) -> LabelledMatrix:
    """The stiffness, mass or damping among the DMIG cards of a file.

    Parameters
    ----------
    name : str or None   of the matrix on its cards; None: the only one whose name begins with K (stiffness),
        M (mass) or B (damping)
    Raises
    ------
    ImportFormatError   missing or cut file; no such matrix, or several; complex or rectangular matrices;
                        entries that are repeated or not numbers
    """
    file = read_bulk_data(path)
    names = dict.fromkeys(card.word(0) for card in file.named("DMIG"))
    chosen = chosen_name(file.path, names, role, name, one="DMIG", several="DMIG")
    cards = [card for card in file.named("DMIG") if card.word(0) == chosen]
    headers = [card for card in cards if card.word(1) == "0"]
    if len(headers) != 1:
        card = headers[1] if headers else cards[0]
        raise card.error(
            f"{len(headers)} header cards for {chosen}; a DMIG has one: DMIG, {chosen}, 0, form, type"
        )
    _check_header(headers[0], chosen)
    is_single = headers[0].integer(3, "the type TIN") == _REAL_SINGLE
    entries = [card for card in cards if card.word(1) != "0"]
    return _entries(file, headers[0], entries, SINGLE_PRECISION if is_single else 0.0)


def _check_header(card: BulkCard, name: str) -> None:
    form, kind = card.integer(2, "the form IFO"), card.integer(3, "the type TIN")
    if form not in (_SQUARE, _SYMMETRIC):
        raise card.error(f"{name} has form {form}; stiffness and mass are square (1) or symmetric (6)")
    if kind not in (_REAL_SINGLE, _REAL_DOUBLE):
        raise card.error(f"{name} has type {kind}, which is complex; export it as real (1 or 2)")


def _entries(file: BulkFile, header: BulkCard, cards: list[BulkCard], precision: float) -> LabelledMatrix:
    name = header.word(0)
    rows, columns, values = [], [], []
    resolution = 1.0
    for card in cards:
        column = (card.integer(1, "the grid of the column"), card.integer(2, "its component", 0))
        for place in range(4, len(card.fields), 4):
            if not any(card.fields[place : place + 4]):
                continue
            rows.append(
                (card.integer(place, "the grid of a row"), card.integer(place + 1, "its component", 0))
            )
            columns.append(column)
            values.append(card.real(place + 2, "an entry"))
            resolution = min(resolution, printed_resolution(card.word(place + 2)))
    if not values:
        raise ImportFormatError(f"{file.path}: DMIG {name} has no entries; is the file cut short?")
    beside = {pair for pair in zip(rows, columns, strict=True) if pair[0] != pair[1]}
    is_symmetric = header.integer(2, "the form IFO") == _SYMMETRIC
    if beside and not is_symmetric and not any((column, row) in beside for row, column in beside):
        raise header.error(
            f"{name} has form 1 (square), but entries on one side of its diagonal only, so it is not "
            "symmetric; a symmetric matrix given by one triangle has form 6"
        )
    return from_labelled_entries(
        f"{file.path}, DMIG {name}",
        np.array(rows),
        np.array(columns),
        np.array(values),
        max(resolution, precision),
    )
