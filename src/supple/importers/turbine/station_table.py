"""Tables of blades and rotors (.csv), with one file for each section or polar that they name."""

from __future__ import annotations

from importlib.resources.abc import Traversable
from pathlib import Path

import numpy as np

from supple.aero import Polar, Rotor
from supple.errors import ImportFormatError, MeshError
from supple.importers.csv_table import CsvTable, named_csv_file, read_csv_table
from supple.mesh import AirfoilSection, BladeStations, TrailingEdge

__all__ = ["read_polar", "read_rotor", "read_stations"]

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


def read_rotor(path: str | Path | Traversable, *, polars: str | Path | Traversable, n_blades: int) -> Rotor:
    """Rotor of a table with columns radius_m, chord_m, twist_deg, polar, and of a folder of polars.

    The polar `name` is the file `name.csv` of the folder, with columns alpha_deg, cl, cd; a column cm is
    ignored. The radius of the tip is the last radius.

    Raises
    ------
    ImportFormatError   missing files, folder or columns, unknown polars, words instead of numbers
    ModelError          tables that describe no rotor or polar
    """
    table = read_csv_table(path, required=("radius_m", "chord_m", "twist_deg", "polar"))
    folder = Path(polars) if isinstance(polars, str) else polars
    names = table.columns["polar"]
    files = {name: named_csv_file(folder, name, table, row, "polar") for row, name in enumerate(names)}
    known = {name: read_polar(file, name=name) for name, file in files.items()}
    return Rotor(
        radius=table.numbers("radius_m"),
        chord=table.numbers("chord_m"),
        twist=np.radians(table.numbers("twist_deg")),
        polars=tuple(known[name] for name in names),
        n_blades=n_blades,
    )


def read_polar(path: str | Path | Traversable, *, name: str) -> Polar:
    """Polar of a table with columns alpha_deg, cl, cd; a column cm is ignored.

    Raises
    ------
    ImportFormatError   missing file or columns, words instead of numbers
    ModelError          angles out of order, NaN, fewer than two rows
    """
    table = read_csv_table(path, required=("alpha_deg", "cl", "cd"), optional=("cm",))
    return Polar(name, np.radians(table.numbers("alpha_deg")), table.numbers("cl"), table.numbers("cd"))
