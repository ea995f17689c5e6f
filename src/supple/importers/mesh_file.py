"""Mesh files: the reader for a file, chosen by its suffix."""

from __future__ import annotations

from pathlib import Path

from supple.errors import ImportFormatError
from supple.importers.abaqus import read_abaqus
from supple.importers.file_mesh import UnusedNodes
from supple.importers.gmsh import read_gmsh
from supple.mesh import Mesh

READERS = {".msh": read_gmsh, ".inp": read_abaqus}


def read_mesh(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of a Gmsh (.msh) or an Abaqus or CalculiX (.inp) file; see `read_gmsh` and `read_abaqus`.

    Raises
    ------
    ImportFormatError   a suffix that no reader knows; whatever the reader finds wrong
    MeshError           what the file describes is no usable mesh
    """
    reader = READERS.get(Path(path).suffix.lower())
    if reader is None:
        raise ImportFormatError(f"{path}: no reader for this suffix; mesh files end in {', '.join(READERS)}")
    return reader(path, only=only, unused_nodes=unused_nodes)
