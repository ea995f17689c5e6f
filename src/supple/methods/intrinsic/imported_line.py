"""Condensed line from files of another program: Nastran's analysis set (ASET), or any labelled matrices."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arguments import checked_arguments
from supple.arrays import IntArray
from supple.body.labelled_superelement import NodalMatrices, nodal_matrices
from supple.errors import ModelError
from supple.importers import (
    LabelledMatrix,
    MatrixRole,
    NodeTable,
    freedom_name,
    positions_of_ids,
    read_labelled_matrix,
    read_nodes,
)
from supple.methods.intrinsic.condensed_line import CondensedLine, clamped_line, condensed_line
from supple.methods.intrinsic.load_path_tree import ROOT

__all__ = ["read_condensed_line"]


COMPONENTS = np.arange(1, 7)


@checked_arguments
def read_condensed_line(
    name: str,
    *,
    nodes: str | Path,
    stiffness: str | Path,
    mass: str | Path,
    paths: Sequence[Sequence[int]] | None = None,
    stiffness_name: str | None = None,
    mass_name: str | None = None,
    root_mass: ArrayLike | None = None,
) -> CondensedLine:
    """Line whose stations are the grids of a condensation by another program.

    Nastran condenses on the ASET and writes the result by EXTSEOUT, as DMIG (KAAX, MAAX), or by OUTPUT4 (KAA,
    MAA). Displacements in the grids' own systems (CD) are rotated to the global axes.

    Parameters
    ----------
    nodes : bulk data file with GRID and ASET (.bdf ..), Abaqus .inp, or HDF5
    stiffness, mass : DMIG .pch, OUTPUT4 .op4, HDF5, Abaqus .mtx, CalculiX .sti and .mas
    paths : grid ids from the root outwards; each later path begins at a grid of an earlier one. None: all
        grids of the matrices in the order of their cards, in one chain
    stiffness_name, mass_name : names of the matrices in files with several (DMIG, OUTPUT4)
    root_mass : (6, 6)  mass of a root grid that was clamped and is not in the matrices; default zero

    Raises
    ------
    ImportFormatError   files that cannot be read, matrices that are not symmetric
    ModelError          a grid of the matrices on no path; a grid of a path in no matrix, except a clamped
                        root; a root_mass for a root in the matrices; a grid with fewer than six freedoms;
                        paths that are not connected; and as `condensed_line`
    Source: [Wang2015] (20); [Guyan1965].
    """
    table = read_nodes(nodes)
    K = read_labelled_matrix(stiffness, MatrixRole.STIFFNESS, table, name=stiffness_name)
    M = read_labelled_matrix(mass, MatrixRole.MASS, table, name=mass_name)
    _check_freedoms(name, K, M)
    matrices = nodal_matrices(table, K, M)
    stations, parents = _tree(name, [matrices.node_ids.tolist()] if paths is None else paths)
    points = _points(name, table, stations)
    held = int(stations[0]) not in matrices.node_ids
    rows = _rows(name, matrices, stations[1:] if held else stations)
    stiff, inert = (each.toarray()[np.ix_(rows, rows)] for each in (matrices.stiffness, matrices.mass))
    try:
        if held:
            return clamped_line(name, points, stiff, inert, parents=parents, root_mass=root_mass)
        if root_mass is not None:
            raise ModelError(
                f"line '{name}': the matrices include grid {stations[0]}, the root, and its mass: leave out "
                "root_mass"
            )
        return condensed_line(name, points, stiff, inert, parents=parents)
    except ModelError as error:
        clamped = "" if held else "; start paths at the grid of a clamped root, which is in no matrix"
        raise ModelError(f"{error} (read from {K.source}{clamped})") from error


def _check_freedoms(name: str, stiffness: LabelledMatrix, mass: LabelledMatrix) -> None:
    """ModelError unless the stiffness has all six freedoms of each grid, and the mass no further grid."""
    grids = np.unique(stiffness.freedoms[:, 0])
    known = np.isin(COMPONENTS + 10 * grids[:, None], stiffness.freedoms @ [10, 1])
    short = np.flatnonzero(~known.all(axis=1))
    if short.size:
        has = "".join(map(str, COMPONENTS[known[short[0]]]))
        raise ModelError(
            f"line '{name}': grid {grids[short[0]]} has freedoms {has} in {stiffness.source}; a station "
            "needs all six: put components 123456 of all stations into the ASET, with rotational stiffness"
        )
    strange = ~np.isin(mass.freedoms[:, 0], grids)
    if strange.any():
        place = freedom_name(*mass.freedoms[strange][0])
        raise ModelError(
            f"line '{name}': {mass.source} has a mass for {place}, which is not in {stiffness.source}: "
            "export both from one condensation"
        )


def _tree(name: str, paths: Sequence[Sequence[int]]) -> tuple[IntArray, IntArray]:
    """Grid ids of the stations, the root first, and the number of each station's parent."""
    if not len(paths):
        raise ModelError(
            f"line '{name}': no load path is given: list the grids of each path, or leave out paths for one "
            "chain of all grids"
        )
    number: dict[int, int] = {}
    parents: list[int] = []
    for rank, path in enumerate(paths):
        if len(path) < 2:
            raise ModelError(f"line '{name}': a load path needs at least two grids, not {path}")
        if rank and path[0] not in number:
            raise ModelError(
                f"line '{name}': a load path begins at grid {path[0]}, which is on no earlier path: "
                "begin it where it branches off"
            )
        for before, grid in zip([None, *path], path, strict=False):
            if before is None and rank:
                continue
            if grid in number:
                raise ModelError(
                    f"line '{name}': grid {grid} occurs twice: load paths form a tree; cut the loop"
                )
            parents.append(ROOT if before is None else number[before])
            number[grid] = len(number)
    return np.array(list(number), dtype=np.int64), np.array(parents)


def _points(name: str, table: NodeTable, stations: IntArray) -> NDArray[np.float64]:
    number, known = positions_of_ids(table.ids, stations)
    if not known.all():
        raise ModelError(
            f"line '{name}': grid {stations[~known][0]} of its path is not defined in {table.source}: "
            "correct the path, or read the file with this grid"
        )
    return table.positions[number]


def _rows(name: str, matrices: NodalMatrices, stations: IntArray) -> IntArray:
    """Rows of the stations' freedoms in the matrices."""
    missing = stations[~np.isin(stations, matrices.node_ids)]
    if missing.size:
        raise ModelError(
            f"line '{name}': grid {missing[0]} of its path is in no matrix of {matrices.source}: put it into "
            "the ASET; only a clamped root may be missing"
        )
    beside = matrices.node_ids[~np.isin(matrices.node_ids, stations)]
    if beside.size:
        raise ModelError(
            f"line '{name}': grid {beside[0]} of {matrices.source} is on no load path ({beside.size} such "
            "grids): add it to a path, or leave it out of the ASET, so that it is condensed"
        )
    number, _ = positions_of_ids(matrices.node_ids, stations)
    return (6 * number[:, None] + np.arange(6)).ravel()
