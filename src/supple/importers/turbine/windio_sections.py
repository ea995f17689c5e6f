"""Sections of a blade in windIO files (.yaml): `six_x_six` of version 1, `elastic_properties` of 2."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ImportFormatError
from supple.importers.section_table import (
    PAIRS,
    SectionTable,
    check_sections,
    fine_grid,
    matrices_at,
    section_matrix,
    twisted_axes,
)
from supple.importers.turbine.windio_file import WindioFile

__all__ = ["read_windio_sections"]

BLADE = ("components", "blade")
FIRST = (*BLADE, "elastic_properties_mb", "six_x_six")
SECOND = (*BLADE, "structure", "elastic_properties")
STIFFNESS = ("grid", *(f"K{pair}" for pair in PAIRS))
INERTIA = ("grid", "mass", "cm_x", "cm_y", "i_edge", "i_flap", "i_plr", "i_cp")


def read_windio_sections(path: str | Path) -> SectionTable:
    """Section table of the blade of a turbine file, such as those of the IEA 15 and 22 MW reference turbines.

    Over the position 0 .. 1, the reference axis and the twist are monotone cubics (PCHIP), matrices linear.
    Section axes are x to the suction side, y to the trailing edge, z along the axis; the twist is about -z.
    Public files of both versions use these axes; the text of schema 2 exchanges x and y. A file of version 2
    with x and y exchanged is rejected.

    Raises
    ------
    ImportFormatError   missing file or entries, no YAML, lists of different lengths, point masses, matrices
                        with x and y exchanged
    ModelError          sections that `SectionTable` rejects
    Source: windIO turbine schema, versions 1 and 2.
    """
    file = WindioFile.read(path)
    blade = file.entry(*BLADE)
    second = isinstance(blade, dict) and "outer_shape" in blade
    if second:
        axis, twist = (*BLADE, "reference_axis"), (*BLADE, "outer_shape", "twist")
        known = _second(file)
    else:
        axis, twist = (*FIRST, "reference_axis"), (*FIRST, "twist")
        known = _first(file, "stiff_matrix"), _first(file, "inertia_matrix")
    (grid, stiffness), (own, inertia) = known
    union = np.union1d(grid, own)
    stiffness, inertia = matrices_at(union, grid, stiffness), matrices_at(union, own, inertia)
    check_sections([f"{path}: blade, section at {place:.4g}" for place in union], stiffness, inertia)
    fine = fine_grid(union)
    curves = [file.covering(fine, *axis, name) for name in "xyz"] + [file.covering(fine, *twist)]
    points = np.column_stack([curve(fine) for curve in curves[:3]])
    tangents = np.column_stack([curve(fine, 1) for curve in curves[:3]])
    turn = curves[3](fine)
    axes = twisted_axes(tangents, np.radians(turn) if second else turn)
    return SectionTable(points, axes, matrices_at(fine, union, stiffness), matrices_at(fine, union, inertia))


def _grid(file: WindioFile, *keys: str) -> FloatArray:
    grid = file.numbers(*keys, "grid")
    if grid.size < 2 or (np.diff(grid) <= 0).any():
        raise ImportFormatError(
            f"{file.path}: the grid of {'.'.join(keys)} needs at least two numbers, ascending"
        )
    return grid


def _first(file: WindioFile, name: str) -> tuple[FloatArray, FloatArray]:
    """Grid (n,) and matrices (n, 6, 6) of version 1, which lists upper triangles."""
    grid, rows = _grid(file, *FIRST, name), file.listed(*FIRST, name, "values")
    values = [file.as_numbers(row, ".".join((*FIRST, name, "values"))) for row in rows]
    if len(rows) != grid.size or any(row.size != len(PAIRS) for row in values):
        raise ImportFormatError(
            f"{file.path}: {'.'.join((*FIRST, name))} has {grid.size} grid points and {len(rows)} rows; give "
            "as many rows, each the upper triangle of a matrix, 21 numbers"
        )
    return grid, section_matrix(values)


def _second(file: WindioFile) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Grids and matrices, of stiffness and of inertia, of version 2: entries without a list are zero."""
    if file.has(*SECOND, "point_mass"):
        raise ImportFormatError(
            f"{file.path}: {'.'.join(SECOND)} has a point_mass, which is not read; remove it, and join "
            "a rigid body to the blade there"
        )
    grids = [_grid(file, *SECOND, name) for name in ("stiffness_matrix", "inertia_matrix")]
    for name, known in (("stiffness_matrix", STIFFNESS), ("inertia_matrix", INERTIA)):
        for key in file.entry(*SECOND, name):
            if key not in known:
                raise ImportFormatError(
                    f"{file.path}: unknown entry {'.'.join((*SECOND, name))}.{key}; it takes "
                    f"{', '.join(known)}"
                )

    def values(which: int, name: str) -> FloatArray:
        matrix = ("stiffness_matrix", "inertia_matrix")[which]
        if not file.has(*SECOND, matrix, name):
            return np.zeros(grids[which].size)
        found = file.numbers(*SECOND, matrix, name)
        if found.size != grids[which].size:
            raise ImportFormatError(
                f"{file.path}: {'.'.join((*SECOND, matrix, name))} has {found.size} values on "
                f"{grids[which].size} grid points; give as many"
            )
        return found

    stiffness = section_matrix(np.column_stack([values(0, f"K{pair}") for pair in PAIRS]))
    m, x, y = (values(1, name) for name in ("mass", "cm_x", "cm_y"))
    edge, flap, polar, cross = (values(1, f"i_{name}") for name in ("edge", "flap", "plr", "cp"))
    entries = {"11": m, "22": m, "33": m, "16": -m * y, "26": m * x, "34": m * y, "35": -m * x}
    entries |= {"44": edge, "45": -cross, "55": flap, "66": polar}
    none = np.zeros(grids[1].size)
    inertia = section_matrix(np.column_stack([entries.get(pair, none) for pair in PAIRS]))
    bending = matrices_at(grids[1], grids[0], stiffness)
    if ((bending[:, 3, 3] - bending[:, 4, 4]) * (edge - flap) < 0).mean() > 0.5:
        raise ImportFormatError(
            f"{file.path}: K44 and K55 of {'.'.join(SECOND)} are in the opposite order of i_edge and i_flap, "
            "as if x pointed to the trailing edge. Give matrices with x to the suction side and y to the "
            "trailing edge, K44 edgewise, as in the files of published turbines"
        )
    return (grids[0], stiffness), (grids[1], inertia)
