"""Superelements for Nastran as DMIG or OUTPUT4: grids at interfaces, scalar points for modal coordinates.

Grids are numbered from 1 in the order of the interfaces, scalar points after them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from supple.errors import ModelError
from supple.export.ascii_file import check_not_foreign, write_ascii
from supple.export.dmig_punch import dmig_cards
from supple.export.superelements.interface_form import InterfaceForm
from supple.importers.plain_number import in_sixteen_columns

__all__ = ["write_dmig_superelement", "write_output4", "write_output4_superelement"]

_SQUARE, _SYMMETRIC, _REAL_DOUBLE = 1, 6, 2
_PER_LINE = 3
_LONGEST_NAME = 8

_TO_RUN = (
    "to run: SOL 103 / CEND / K2GG = KAAX / M2GG = MAAX{damped} / METHOD = 1",
    "        BEGIN BULK / EIGRL,1,,,10 / INCLUDE 'this file' / your own cards / ENDDATA",
)


def write_dmig_superelement(path: Path | str, form: InterfaceForm) -> Path:
    """Write one bulk data file: GRID, SPOINT, ASET1, QSET1, DMIG KAAX, MAAX (BAAX); returns the path.

    Entries have ten digits, which fit a field of 16 columns; OUTPUT4 has 17 digits.

    Raises ResultFileError: the file cannot be written.
    """
    matrices = form.matrices("KAAX", "MAAX", "BAAX")
    run = [line.format(damped=" / B2GG = BAAX" if "BAAX" in matrices else "") for line in _TO_RUN]
    cards = [*_bulk_data(form, run), *dmig_cards(form.freedoms(of_modal=0), matrices)]
    return write_ascii(path, cards)


def write_output4_superelement(path: Path | str, form: InterfaceForm) -> tuple[Path, Path]:
    """Write KAA, MAA (BAA) as OUTPUT4, and the grids and sets of their rows as a .bdf file beside it.

    Rows are the analysis set in the order of the cards: six rows per grid, then the scalar points.

    Returns (path of the matrices, path of the cards). Raises ResultFileError: a file cannot be written, or
    the .bdf file exists and is another one.
    """
    target = Path(path)
    matrices = form.matrices("KAA", "MAA", "BAA")
    of_rows = [f"rows of {', '.join(matrices)} in {target.name}: six of each grid, then the scalar points"]
    beside = target.with_suffix(".bdf")
    check_not_foreign(beside, "linear superelement")
    write_ascii(beside, _bulk_data(form, of_rows))
    return write_output4(target, matrices), beside


def _bulk_data(form: InterfaceForm, further: Sequence[str]) -> list[str]:
    """Comments, then the cards of grids, scalar points and sets."""
    n, last = len(form.interfaces), len(form.interfaces) + form.n_modal
    lines = [f"$ {line}" for line in (*form.comment(), *further)]
    for number, (name, place) in enumerate(zip(form.interfaces, form.positions, strict=True), 1):
        x, y, z = map(in_sixteen_columns, place)
        lines += [f"$ {name}", f"GRID*   {number:<16d}{'':16}{x}{y}", f"*       {z}"]
    lines.append(f"ASET1   123456  1       THRU    {n}" if n > 1 else "ASET1   123456  1")
    if form.n_modal:
        points = f"{n + 1:<8d}THRU    {last}" if form.n_modal > 1 else f"{last}"
        lines += [f"SPOINT  {points}", f"QSET1   0       {points}"]
    return lines


def write_output4(path: Path | str, matrices: Mapping[str, ArrayLike]) -> Path:
    """Write square matrices (n, n) under their names in capitals, for Nastran's INPUTT4; returns the path.

    Numbers have 17 digits. Each column that is not zero has a record: the number of the column, the first row
    that is not zero, the number of rows, and the values of these rows.

    Raises
    ------
    ModelError          no matrix; a name of over eight characters; a matrix that is not square or not finite
    ResultFileError     the file cannot be written
    """
    if not matrices:
        raise ModelError("an OUTPUT4 file needs a matrix: give one, such as {'KAA': stiffness}")
    lines = []
    for name, given in matrices.items():
        matrix = np.asarray(given, dtype=np.float64)
        if len(name) > _LONGEST_NAME or matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
            raise ModelError(
                f"{name} of shape {matrix.shape}: give square matrices with names of at most eight characters"
            )
        if not np.isfinite(matrix).all():
            raise ModelError(f"{name} has entries that are not finite; correct them")
        lines += _lines(name, matrix)
    return write_ascii(path, lines)


def _lines(name: str, matrix: np.ndarray) -> list[str]:
    n = len(matrix)
    form = _SYMMETRIC if np.array_equal(matrix, matrix.T) else _SQUARE
    lines = [f"{n:8d}{n:8d}{form:8d}{_REAL_DOUBLE:8d}{name.upper():<8}1P,{_PER_LINE}E24.16"]
    for j in np.flatnonzero(matrix.any(axis=0)):
        (rows,) = np.nonzero(matrix[:, j])
        column = matrix[rows[0] : rows[-1] + 1, j]
        lines.append(f"{j + 1:8d}{rows[0] + 1:8d}{len(column):8d}")
        words = [f"{value:24.16E}" for value in column]
        lines += ["".join(words[at : at + _PER_LINE]) for at in range(0, len(words), _PER_LINE)]
    return [*lines, f"{n + 1:8d}{1:8d}{1:8d}", f"{1.0:24.16E}"]
