"""Rotor tables (.csv): chord, twist and polar along the radius, with one file for each polar it names."""

from __future__ import annotations

from importlib.resources.abc import Traversable
from pathlib import Path

import numpy as np

from supple.aero import Polar, Rotor
from supple.errors import ImportFormatError
from supple.importers.csv_table import read_csv_table
from supple.importers.text_file import is_file

__all__ = ["read_polar", "read_rotor"]


def read_rotor(path: str | Path | Traversable, *, polars: str | Path | Traversable, n_blades: int) -> Rotor:
    """Rotor of a table with columns radius_m, chord_m, twist_deg, polar, and of a folder of polars.

    The polar `name` is the file `name.csv` of the folder, with columns alpha_deg, cl, cd; a column cm is
    ignored. The radius of the tip is the last radius.

    Parameters
    ----------
    path : str, Path or package resource
    polars : folder of the polars; types as for `path`
    n_blades : int
    Returns
    -------
    Rotor   angles in rad
    Raises
    ------
    ImportFormatError   missing files or columns, unknown polars, words instead of numbers
    ModelError          tables that describe no rotor or polar
    """
    table = read_csv_table(path, required=("radius_m", "chord_m", "twist_deg", "polar"))
    folder = Path(polars) if isinstance(polars, str) else polars
    names = table.words("polar")
    for line, name in zip(table.lines, names, strict=True):
        if "/" in name or not is_file(folder / f"{name}.csv"):
            there = sorted(entry.name[:-4] for entry in folder.iterdir() if entry.name.endswith(".csv"))
            raise ImportFormatError(
                f"{table.path}, line {line}: unknown polar '{name}'; {folder} has "
                f"{', '.join(there) or 'no .csv files'}"
            )
    known = {name: read_polar(folder / f"{name}.csv", name=name) for name in dict.fromkeys(names)}
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
