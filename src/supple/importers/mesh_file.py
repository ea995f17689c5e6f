"""Mesh files and decks: the reader is selected by the suffix."""

from __future__ import annotations

from pathlib import Path

from supple.arguments import checked_arguments
from supple.errors import ImportFormatError
from supple.importers.abaqus.abaqus_deck import read_abaqus_deck
from supple.importers.abaqus.mesh_view import read_abaqus
from supple.importers.ansys import read_ansys
from supple.importers.deck import Deck
from supple.importers.exodus import EXODUS_SUFFIXES, read_exodus
from supple.importers.file_mesh import UnusedNodes
from supple.importers.gmsh import read_gmsh
from supple.importers.nastran.deck_file import read_nastran_deck
from supple.importers.nastran.mesh_view import NASTRAN_SUFFIXES, read_nastran
from supple.importers.vtu import read_vtu
from supple.mesh import Mesh

__all__ = ["DECK_SUFFIXES", "MESH_SUFFIXES", "read_deck", "read_mesh"]

READERS = {
    ".inp": read_abaqus,
    ".msh": read_gmsh,
    ".vtu": read_vtu,
    ".cdb": read_ansys,
    **dict.fromkeys(EXODUS_SUFFIXES, read_exodus),
    **dict.fromkeys(NASTRAN_SUFFIXES, read_nastran),
}

MESH_SUFFIXES = tuple(READERS)
"""Suffixes of the files that `read_mesh` reads."""


@checked_arguments
def read_mesh(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of a Gmsh, Abaqus, CalculiX, Nastran, VTU, Exodus or Ansys file, by its suffix.

    .msh, .inp, .bdf .dat .nas .blk, .vtu, .exo .e .ex2 .g, .cdb: see `read_gmsh`, `read_abaqus`,
    `read_nastran`, `read_vtu`, `read_exodus` and `read_ansys`.

    Parameters
    ----------
    only : str or None            a cell set: read only its cells and nodes; None reads everything
    unused_nodes : UnusedNodes    REFUSE or DROP nodes that no cell uses, such as reference points
    Raises
    ------
    ImportFormatError   a suffix without a reader; a missing, cut or foreign file; cells of a type that is not
                        read; cells or sets with missing nodes
    MeshError           nodes and cells that are not a usable mesh
    """
    reader = READERS.get(Path(path).suffix.lower())
    if reader is None:
        raise ImportFormatError(
            f"{path}: no reader for this suffix; mesh files end in {', '.join(READERS)}. Gmsh and meshio "
            "convert other formats (.unv, .med, .vtk, ..)"
        )
    return reader(path, only=only, unused_nodes=unused_nodes)


_DECK_READERS = {".inp": read_abaqus_deck} | dict.fromkeys(NASTRAN_SUFFIXES, read_nastran_deck)

DECK_SUFFIXES = tuple(_DECK_READERS)


def read_deck(path: str | Path) -> Deck:
    """The finite-element model in a file; ImportFormatError lists the supported suffixes."""
    suffix = Path(path).suffix.lower()
    if suffix not in _DECK_READERS:
        raise ImportFormatError(f"{path}: not a deck file; give one that ends in {', '.join(DECK_SUFFIXES)}")
    return _DECK_READERS[suffix](path)
