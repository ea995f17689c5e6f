"""Nastran bulk data (.bdf, .dat, .nas, .blk): mesh, properties, connections and sets of a model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.errors import ImportFormatError
from supple.importers.connection import Connection
from supple.importers.file_mesh import CellOrigin, FileMesh, UnusedNodes
from supple.importers.nastran.beams import of_beams, orientation_grid
from supple.importers.nastran.bulk_data import BulkFile, read_bulk_data
from supple.importers.nastran.connections import GridConnection, read_connections
from supple.importers.nastran.elements import ELEMENT_CARDS, ElementCells, read_cells
from supple.importers.nastran.grids import COORDINATE_CARDS, GridPoints, read_grids
from supple.importers.nastran.properties import PROPERTY_CARDS, Property, read_property
from supple.importers.nastran.retained_freedoms import modal_freedoms, retained_freedoms
from supple.importers.nastran.sets import SET_CARDS, node_sets
from supple.importers.node_table import NodeTable
from supple.importers.plain_number import is_plain_digits
from supple.mesh import CellType, Mesh

__all__ = ["NASTRAN_SUFFIXES", "NastranModel", "read_nastran"]

IntArray = NDArray[np.int64]

NASTRAN_SUFFIXES = (".bdf", ".dat", ".nas", ".blk")
"""Names of Nastran bulk data files end so."""


_READ = (
    "GRID", *COORDINATE_CARDS, *ELEMENT_CARDS, *PROPERTY_CARDS, "MAT1", "RBE2", "RBE3", *SET_CARDS, "PARAM",
)  # fmt: skip
# Loads, solution control, output and drawing: they change neither mesh, stiffness nor mass.
_PASSED_OVER = (
    "ACCEL", "ACCEL1", "ACMODL", "DAREA", "DELAY", "DLOAD", "DPHASE", "ECHOOFF", "ECHOON", "EIGB", "EIGC",
    "EIGR", "EIGRL", "FORCE", "FORCE1", "FORCE2", "FREQ", "FREQ1", "FREQ2", "FREQ3", "FREQ4", "FREQ5", "GRAV",
    "LOAD", "LSEQ", "MDLPRM", "MOMENT", "MOMENT1", "MOMENT2", "NLPARM", "PLOAD", "PLOAD1", "PLOAD2", "PLOAD4",
    "PLOTEL", "RANDPS", "RANDT1", "RFORCE", "RLOAD1", "RLOAD2", "SET1", "SET3", "SPCADD", "SUPORT", "SUPORT1",
    "TABDMP1", "TABLED1", "TABLED2", "TABLED3", "TABLED4", "TABRND1", "TEMP", "TEMPD", "TLOAD1", "TLOAD2",
    "TSTEP", "TSTEPNL",
)  # fmt: skip
# Factors of the whole stiffness and mass.
_FACTORS = ("CK1", "CM1")
_REMEDIES = {
    "BAROR": "write its fields on every CBAR",
    "BEAMOR": "write its fields on every CBEAM",
    "CBUSH": "make it a spring of the machine",
    "CELAS1": "make it a spring of the machine",
    "CELAS2": "make it a spring of the machine",
    "CONM2": "make it a rigid body of its own, fixed to an interface",
    "CROD": "write it as CBAR",
    "MPC": "make it a joint of the machine",
    "RBAR": "write it as RBE2",
    "CPENTA": "mesh with CTETRA or CHEXA",
    "CPYRAM": "mesh with CTETRA or CHEXA",
    "CQUADR": "write it as CQUAD4",
    "CTRIAR": "write it as CTRIA3",
    "DMIG": "a model of elements and matrices is not read: import the assembled matrices",
    "GRDSET": "write CP, CD and PS on every GRID",
    "NSM1": "write it as NSM of the property",
    "NSML1": "write it as NSM of the property",
    "CQUAD8": "mesh with CQUAD4",
    "CTRIA6": "mesh with CTRIA3",
    "PCOMP": "import the matrices (DMIG, OP4), or build a LaminateSection in Python",
    "MAT8": "import the matrices (DMIG, OP4), or build a LaminateSection in Python",
}


@dataclass(frozen=True, eq=False)
class NastranModel:
    """What a bulk data file describes, except its supports, loads and solution.

    mesh        : node sets of supports (spc1_123456: set 1, components 123456), ASET (aset) and connections
                  (rbe2_ID, rbe3_ID); one cell set per property (pshell_ID, psolid_ID), of beams one
                  per direction of their sections (pbar_ID, pbar_ID_2)
    node_ids    : (N,) grid ids, by node number
    properties  : {cell set: property}
    connections : RBE2 and RBE3
    """

    path: Path
    mesh: Mesh
    node_ids: IntArray
    properties: Mapping[str, Property]
    connections: tuple[Connection, ...]


@checked_arguments
def read_nastran(path: str | Path, *, unused_nodes: UnusedNodes = UnusedNodes.REFUSE) -> NastranModel:
    """Model of a Nastran bulk data file: everything that makes its stiffness and mass.

    Reads GRID in any coordinate system, CTETRA (4, 10), CHEXA (8, 20), CTRIA3, CQUAD4 (as two triangles),
    CBAR, CBEAM (constant sections), PSOLID, PSHELL, PBAR(L), PBEAM(L), MAT1, RBE2, RBE3; and SPC, SPC1, ASET,
    ASET1 as node sets: a body is free, joints hold it. Loads and solution cards are passed over; any other
    card is a mistake, as the model would be another one.

    Parameters
    ----------
    unused_nodes : UnusedNodes   REFUSE or DROP grids that neither an element nor a connection uses
    Raises
    ------
    ImportFormatError   missing, cut or binary file; a card that is not read; missing or repeated ids; fields
                        that are no numbers; options that our elements do not have: with file, line and card
    MeshError           what the file describes is no usable mesh; flat elements with their line
    """
    file = read_bulk_data(path)
    _refuse_what_is_not_read(file)
    grids = read_grids(file)
    cells = read_cells(file, grids)
    in_elements = np.zeros(len(grids.ids), dtype=bool)
    for found in cells:
        in_elements[found.nodes] = True
    turning = any(found.kind.dimension < 3 for found in cells)
    connections = read_connections(file, grids, in_elements, turning=turning)
    if unused_nodes is UnusedNodes.REFUSE:
        _refuse_unused(file, grids, in_elements, connections)

    kept = in_elements
    number = np.cumsum(kept) - 1
    tied = tuple(replace(c.connection, nodes=number[c.connection.nodes]) for c in connections)
    sets = {name: number[members[kept[members]]] for name, members in node_sets(file, grids).items()}
    sets = {name: members for name, members in sets.items() if members.size} | {c.name: c.nodes for c in tied}
    mesh = _file_mesh(file, grids, cells, kept, sets).to_mesh(only=None, unused_nodes=UnusedNodes.REFUSE)
    properties = {
        name: of_beams(read_property(made_of.card, file), made_of.orientation)
        for found in cells
        for name, made_of in found.sections.items()
    }
    return NastranModel(file.path, mesh, grids.ids[kept], MappingProxyType(properties), tied)


def read_nastran_mesh(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """The mesh of a Nastran file, or that of one of its cell sets; see `read_nastran`."""
    mesh = read_nastran(path, unused_nodes=unused_nodes).mesh
    if only is None:
        return mesh
    parts = {name: dict(members) for name, members in mesh.cell_sets.items()}
    whole = FileMesh(
        *(Path(path), mesh.nodes, dict(mesh.cells), dict(mesh.node_sets), parts),
        node_ids=mesh.node_ids,
        cell_ids=mesh.cell_ids,
    )
    return whole.to_mesh(only=only, unused_nodes=unused_nodes)


def read_nastran_nodes(path: str | Path) -> NodeTable:
    """Grids, supports and connections of a Nastran file, for matrices that replace its elements.

    Elements and other cards may be of any kind: the matrices hold what they mean.

    Raises
    ------
    ImportFormatError   as for `read_nastran`, except for cards that are not read
    """
    file = read_bulk_data(path)
    grids = read_grids(file)
    # Which grids carry stiffness is known only to the matrices; the reference of an RBE3 never should.
    averaged = [card.integer(2, "the reference grid") for card in file.named("RBE3")]
    in_elements = ~np.isin(grids.ids, np.array(averaged, dtype=np.int64))
    connections = tuple(c.connection for c in read_connections(file, grids, in_elements, turning=True))
    sets = dict(node_sets(file, grids)) | {c.name: c.nodes for c in connections}
    axes = None if np.array_equal(grids.axes, np.broadcast_to(np.eye(3), grids.axes.shape)) else grids.axes
    return NodeTable(
        *(str(file.path), grids.ids, grids.positions, axes, sets, connections),
        retained=retained_freedoms(file, grids.ids),
        modal=modal_freedoms(file, grids.ids),
    )


def _refuse_what_is_not_read(file: BulkFile) -> None:
    if file.parts:
        raise ImportFormatError(f"{file.path}: parts (BEGIN SUPER) are not read; export each as a file")
    for name, cards in file.by_name.items():
        if name not in _READ and name not in _PASSED_OVER:
            remedy = _REMEDIES.get(name, "remove it, or replace it by cards that are")
            raise cards[0].error(f"this card is not read; {remedy}. Read are {', '.join(_READ)}")
    for card in file.named("PARAM"):
        if card.word(0) in _FACTORS and card.real(1, card.word(0), 1.0) != 1.0:
            raise card.error(f"the factor {card.word(0)} is not read; scale the materials instead")


def _refuse_unused(
    file: BulkFile, grids: GridPoints, in_elements: NDArray[np.bool_], connections: list[GridConnection]
) -> None:
    """Every grid is in an element, or shows a place or direction: of a connection, a beam or a system."""
    shown = [orientation_grid(card) for card in file.named("CBAR", "CBEAM")]
    shown += [
        int(word)
        for card in file.named("CORD1R", "CORD1C", "CORD1S")
        for word in card.fields
        if is_plain_digits(word)
    ]
    used = in_elements | np.isin(grids.ids, np.array([i for i in shown if i is not None], dtype=np.int64))
    used[[connection.reference for connection in connections]] = True
    unused = np.flatnonzero(~used)
    if unused.size:
        raise grids.cards[unused[0]].error(
            f"grid {grids.ids[unused[0]]} (one of {unused.size}) is used by no element, so nothing holds it; "
            "remove it, or read with unused_nodes=UnusedNodes.DROP"
        )


def _file_mesh(
    file: BulkFile,
    grids: GridPoints,
    cells: list[ElementCells],
    kept: NDArray[np.bool_],
    sets: dict[str, IntArray],
) -> FileMesh:
    number = np.cumsum(kept) - 1
    arrays: dict[CellType, list[IntArray]] = {}
    origins: dict[CellType, list[CellOrigin]] = {}
    members: dict[str, dict[CellType, list[IntArray]]] = {}
    for found in cells:
        first = sum(len(part) for part in arrays.get(found.kind, []))
        arrays.setdefault(found.kind, []).append(number[found.nodes])
        places = [
            CellOrigin(c.path, c.line, int(c.fields[0])) for c in found.cards for _ in range(found.per_card)
        ]
        origins.setdefault(found.kind, []).extend(places)
        names = np.repeat(np.array(found.set_names), found.per_card)
        for name in found.sections:
            of_section = members.setdefault(name, {}).setdefault(found.kind, [])
            of_section.append(first + np.flatnonzero(names == name))
    return FileMesh(
        file.path,
        grids.positions[kept],
        {kind: np.vstack(parts) for kind, parts in arrays.items()},
        sets,
        {name: {k: np.concatenate(p) for k, p in by.items()} for name, by in members.items()},
        {kind: tuple(found) for kind, found in origins.items()},
        grids.ids[kept],
        {
            kind: np.array([origin.element for origin in found], dtype=np.int64)
            for kind, found in origins.items()
        },
    )
