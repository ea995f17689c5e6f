"""The mesh of a Nastran file, or its nodes only."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.errors import ImportFormatError, SuppleWarning
from supple.importers.cell_blocks import CellBlock, file_mesh
from supple.importers.deck import Deck, RigidTie
from supple.importers.file_mesh import FileMesh, UnusedNodes, joined
from supple.importers.nastran.bulk_data import BulkCard, read_bulk_data
from supple.importers.nastran.deck_file import (
    CARDS_NOT_READ,
    CELLS_NOT_READ,
    CONNECTIONS_NOT_READ,
    deck_of_cards,
    has_no_sections,
    start_reading,
    with_sections,
)
from supple.importers.nastran.retained_freedoms import modal_freedoms, retained_freedoms
from supple.importers.nastran.rigid import read_ties
from supple.importers.nastran.supports import read_supports
from supple.importers.node_table import Connection, NodeTable
from supple.mesh import Mesh

__all__ = ["NASTRAN_SUFFIXES", "read_nastran"]

NASTRAN_SUFFIXES = (".bdf", ".dat", ".nas", ".blk", ".pch")
"""Suffixes of Nastran bulk data files."""


@checked_arguments
def read_nastran(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of a Nastran file: the cells that `read_nastran_deck` reads, without properties and materials.

    Node sets are those of supports (spc1_123456: set 1, components 123456; spc_3: field PS), ASET (aset) and
    ties (rbe2_ID, rbe3_ID); cell sets those of properties (pshell_ID, psolid_ID). Masses, springs, dampers
    and missing files of case control are ignored.

    A file without property and material cards, as meshers write it, is read by its cells of the highest
    dimension. The property numbers of all its cells give node sets, also prod_ID of its lines.

    Parameters are those of `read_mesh`; unused reference grids of ties are dropped in any case.

    Raises
    ------
    ImportFormatError   as for `read_mesh` and `read_nastran_deck`; elements whose property or material is not
                        supported, or missing beside others; missing included files
    MeshError           nodes and cells that are not a usable mesh, such as flat elements
    Warns
    -----
    SuppleWarning       connections that are not read, such as spot welds
    """
    path = Path(path)
    absences: list[BulkCard] = []
    bulk = read_bulk_data(path, absences)
    only_mesh = has_no_sections(bulk.by_name) and not bulk.parts
    deck = deck_of_cards(with_sections(bulk) if only_mesh else bulk, absences)
    _refuse_holes(deck)
    if not deck.elements:
        raise ImportFormatError(f"{path}: no elements that are cells; is this a mesh file, and complete?")
    file = _of_highest_dimension(deck) if only_mesh else _of_all_cells(deck)
    shown = np.zeros(len(deck.nodes), dtype=bool)
    shown[[tie.reference for tie in (*deck.rigid, *deck.means)]] = True
    return file.without_unused(shown).to_mesh(only=only, unused_nodes=unused_nodes)


def _of_highest_dimension(deck: Deck) -> FileMesh:
    """The cells of a file without properties; meshers write faces and edges of solids as well, for sets."""
    blocks = [
        CellBlock(each.kind.meshio_name, each.nodes, each.ids, {each.property: np.ones(len(each.ids), bool)})
        for each in deck.elements
    ]
    return file_mesh(deck.path, deck.nodes, blocks, dict(deck.node_sets), deck.node_ids)


def _of_all_cells(deck: Deck) -> FileMesh:
    all_ids = joined((each.kind, each.ids) for each in deck.elements)
    sets = {
        name: {
            kind: inside for kind, own in all_ids.items() if len(inside := np.flatnonzero(np.isin(own, of)))
        }
        for name, of in deck.element_sets.items()
    }
    return FileMesh(
        deck.path,
        deck.nodes,
        joined((each.kind, each.nodes) for each in deck.elements),
        dict(deck.node_sets),
        sets,
        joined((each.kind, np.column_stack([each.lines, each.ids])) for each in deck.elements),
        deck.node_ids,
        all_ids,
        lambda line: f"{deck.path}, line {line}",
    )


def _refuse_holes(deck: Deck) -> None:
    """Raise ImportFormatError if cells are left out; warn of connections that are left out."""
    for each in deck.left_out:
        where = f"{deck.path}, line {each.line}: {each.card}: "
        if each.meaning.startswith("elements left out") or each.card in CELLS_NOT_READ:
            remedy = "correct them, or remove them"
            if "property" in each.meaning:
                remedy = "a mesh, too, needs property and material (PSHELL or PSOLID, MAT1): add the cards"
            raise ImportFormatError(
                f"{where}{each.count} {each.meaning}; without them the mesh has holes: {remedy}"
            )
        if each.meaning.endswith(CARDS_NOT_READ) or each.card == "SEBULK":
            raise ImportFormatError(
                f"{where}{each.meaning}; the mesh may have holes: add the file, or remove the card"
            )
        if each.card in CONNECTIONS_NOT_READ:
            warnings.warn(f"{where}{each.count} {each.meaning}", SuppleWarning, stacklevel=4)


def read_nastran_nodes(path: str | Path) -> NodeTable:
    """Grids, supports and ties of a Nastran file, for matrices that replace its elements.

    Elements and other cards may be of any kind, since the matrices contain them. Ties are ignored unless they
    tie all six components rigidly, or average the translations only.

    Raises
    ------
    ImportFormatError   as for `read_nastran_deck`, of grids and ties
    """
    file = read_bulk_data(path)
    reading = start_reading(file, file)
    grids = reading.grids
    if not len(grids.ids):
        raise ImportFormatError(
            f"{path}: its main bulk data have no GRID, only its superelements; give the file of one of them"
        )
    rigid, means = read_ties(reading, np.ones(len(grids.ids), dtype=bool))
    # Matrices contain no stiffness of the reference grid of a mean; they may contain that of other grids.
    averaged = {mean.reference for mean in means}
    connections = tuple(_connection(tie, averaged, grids.positions) for tie in rigid) + tuple(
        Connection(mean.name, mean.nodes, grids.positions[mean.reference], mean.weights) for mean in means
    )
    sets = read_supports(reading) | {tie.name: tie.nodes for tie in connections}
    axes = None if np.array_equal(grids.axes, np.broadcast_to(np.eye(3), grids.axes.shape)) else grids.axes
    return NodeTable(
        *(str(file.path), grids.ids, grids.positions, axes, sets, connections),
        retained=retained_freedoms(file, grids.ids),
        modal=modal_freedoms(file, grids.ids),
    )


def _connection(tie: RigidTie, averaged: set[int], positions: FloatArray) -> Connection:
    nodes = tie.nodes if tie.reference in averaged else np.append(tie.reference, tie.nodes)
    return Connection(tie.name, nodes, positions[tie.reference], None)
