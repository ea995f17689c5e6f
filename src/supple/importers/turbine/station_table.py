"""Station tables (.csv): the outer shape of a blade, with one file for each section it names."""

from __future__ import annotations

from importlib.resources.abc import Traversable
from pathlib import Path

import numpy as np

from supple.errors import ImportFormatError, MeshError
from supple.importers.csv_table import CsvTable, named_csv_file, read_csv_table
from supple.mesh import AirfoilSection, BladeStations, TrailingEdge

__all__ = ["read_stations"]

_TRAILING_EDGES = {
    "round": TrailingEdge.ROUND,
    "flat": TrailingEdge.AIRFOIL,
    "sharp": TrailingEdge.AIRFOIL,
}


def read_stations(path: str | Path | Traversable, *, sections: str | Path | Traversable) -> BladeStations:
    """Blade stations of a table and of a folder of section outlines.

    Columns of the table: span_m, section, chord_m, twist_deg, pitch_axis_x_over_c; optional: trailing_edge
    (round, flat or sharp; default: sharp), prebend_m, sweep_m. Section `name` is the file `name.csv` of the
    folder, with columns x_over_c, y_over_c.

    Raises
    ------
    ImportFormatError   missing files, folder or columns, unknown sections or trailing edges, words instead of
                        numbers
    MeshError           a section or table that describes no blade (out of order, crossing itself, ...)
    """
    table = read_csv_table(
        path,
        required=("span_m", "section", "chord_m", "twist_deg", "pitch_axis_x_over_c"),
        optional=("trailing_edge", "prebend_m", "sweep_m"),
    )
    folder = Path(sections) if isinstance(sections, str) else sections
    names = table.columns["section"]
    pairs = list(zip(names, table.columns.get("trailing_edge", ("sharp",) * len(names)), strict=True))
    known = {pair: _read_section(table, row, folder, *pair) for row, pair in reversed(list(enumerate(pairs)))}
    try:
        return BladeStations(
            span=table.numbers("span_m"),
            sections=tuple(known[pair] for pair in pairs),
            chord=table.numbers("chord_m"),
            twist=np.radians(table.numbers("twist_deg")),
            pitch_axis=table.numbers("pitch_axis_x_over_c"),
            prebend=table.numbers("prebend_m") if "prebend_m" in table else 0.0,
            sweep=table.numbers("sweep_m") if "sweep_m" in table else 0.0,
        )
    except MeshError as error:
        raise MeshError(f"{table.path}: {error}") from error


def _read_section(
    table: CsvTable, row: int, folder: Path | Traversable, name: str, edge: str
) -> AirfoilSection:
    if edge not in _TRAILING_EDGES:
        raise ImportFormatError(
            f"{table.path}, line {table.lines[row]}: trailing edge '{edge}'; write one of "
            f"{', '.join(_TRAILING_EDGES)}"
        )
    file = named_csv_file(folder, name, table, row, "section")
    outline = read_csv_table(file, required=("x_over_c", "y_over_c"))
    points = np.column_stack([outline.numbers("x_over_c"), outline.numbers("y_over_c")])
    return AirfoilSection(name, points, _TRAILING_EDGES[edge])
