"""Section tables in CSV, one line for each section."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.errors import ImportFormatError, ModelError
from supple.importers.csv_table import read_csv_table
from supple.importers.section_table import PAIRS, UPPER, SectionTable, check_sections, section_matrix

__all__ = ["read_section_csv", "write_section_csv"]

PLACE = ("x", "y", "z")
AXIS = ("axis_x", "axis_y", "axis_z")
DIAGONAL = [f"{of}{i}{i}" for of in "km" for i in range(1, 7)]


def read_section_csv(path: str | Path) -> SectionTable:
    """Section table of a file with a line for each section, from the root to the tip.

    Columns, in any order:
    x, y, z                     position in body axes
    axis_x, axis_y, axis_z      direction of the section's x axis, of any length; its component along the
                                curve is removed
    k11, k12 .. k66             upper triangle of the stiffness; axes, order and signs of `SectionTable`
    m11, m12 .. m66             upper triangle of the inertia
    Missing off-diagonal columns are zero. The z axis of an inner section is tangent to the parabola through
    this section and its neighbours, that of an end section to the parabola through the three sections there.

    Raises
    ------
    ImportFormatError   missing file or columns, words instead of numbers, fewer than two sections
    ModelError          sections that `SectionTable` rejects
    """
    known = [f"{of}{pair}" for of in "km" for pair in PAIRS]
    table = read_csv_table(
        path, required=(*PLACE, *AXIS, *DIAGONAL), optional=[name for name in known if name not in DIAGONAL]
    )
    n = len(table.lines)
    if n < 2:
        raise ImportFormatError(f"{table.path}: {n} sections; give two at least, the root and the tip")
    where = [f"{table.path}, line {line}" for line in table.lines]

    def columns(names: tuple[str, ...] | list[str]) -> np.ndarray:
        return np.column_stack([table.numbers(name) if name in table else np.zeros(n) for name in names])

    positions, towards = columns(PLACE), columns(AXIS)
    stiffness, inertia = (section_matrix(columns([f"{of}{pair}" for pair in PAIRS])) for of in "km")
    for values in (positions, towards, stiffness, inertia):
        bad = ~np.isfinite(values.reshape(n, -1)).all(axis=1)
        if bad.any():
            raise ImportFormatError(f"{where[int(np.argmax(bad))]}: a number is not finite; write another")
    check_sections(where, stiffness, inertia)
    lengths = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    if not (lengths > 0).all():
        raise ModelError(f"{where[int(np.argmin(lengths)) + 1]}: at the position of the section before it")
    z = np.gradient(positions, np.append(0.0, lengths.cumsum()), axis=0, edge_order=2 if n > 2 else 1)
    z /= np.linalg.norm(z, axis=1)[:, None]
    x = towards - np.einsum("ni,ni->n", towards, z)[:, None] * z
    size = np.linalg.norm(x, axis=1)
    flat = size <= 1e-6 * np.linalg.norm(towards, axis=1)
    if flat.any():
        raise ModelError(
            f"{where[int(np.argmax(flat))]}: its axis_x, axis_y, axis_z are along the curve; "
            "give a direction across it"
        )
    x /= size[:, None]
    return SectionTable(positions, np.stack([x, np.cross(z, x), z], axis=2), stiffness, inertia)


def write_section_csv(table: SectionTable, path: str | Path, *, about: str = "") -> None:
    """Write a section table for `read_section_csv`, with 8 digits and without off-diagonal columns of zeros.

    about : text above the table, such as its source
    """
    entries = {
        f"{of}{pair}": matrices[:, i, j]
        for of, matrices in (("k", table.stiffness), ("m", table.inertia))
        for pair, i, j in zip(PAIRS, *UPPER, strict=True)
    }
    columns = dict(zip((*PLACE, *AXIS), np.hstack([table.positions, table.axes[:, :, 0]]).T, strict=True))
    columns |= {name: values for name, values in entries.items() if name in DIAGONAL or values.any()}
    rows = [
        ",".join(columns),
        *(",".join(f"{value:.8g}" for value in row) for row in zip(*columns.values(), strict=True)),
    ]
    Path(path).write_text(
        "\n".join([*(f"# {line}" for line in about.splitlines()), *rows]) + "\n", encoding="utf-8"
    )
