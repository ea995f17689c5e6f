"""Rotor tables (.csv): chord, twist and polar along the radius, with one file for each polar it names."""

from __future__ import annotations

from importlib.resources.abc import Traversable
from pathlib import Path

import numpy as np

from supple.aero import Polar, Rotor
from supple.importers.csv_table import named_csv_file, read_csv_table

__all__ = ["read_polar", "read_rotor"]


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
