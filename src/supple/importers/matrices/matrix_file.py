"""Matrix files: the readers for a labelled matrix and its nodes are selected by suffix."""

from __future__ import annotations

from pathlib import Path

from supple.errors import ImportFormatError
from supple.importers.abaqus.mesh_view import read_abaqus_nodes
from supple.importers.matrices.coordinate_matrices import read_abaqus_matrix, read_calculix_matrix
from supple.importers.matrices.dmig import read_dmig
from supple.importers.matrices.hdf5_matrices import read_hdf5_matrix, read_hdf5_nodes
from supple.importers.matrices.labelled_matrix import LabelledMatrix, MatrixRole
from supple.importers.matrices.output4 import read_output4
from supple.importers.nastran.mesh_view import NASTRAN_SUFFIXES, read_nastran_nodes
from supple.importers.node_table import NodeTable

__all__ = ["HDF5_SUFFIXES", "NODE_SUFFIXES", "read_labelled_matrix", "read_nodes"]

OUTPUT_SUFFIXES = (".op4", ".op2")
HDF5_SUFFIXES = (".h5", ".hdf5")
"""Suffixes of HDF5 files."""
MATRIX_SUFFIXES = (*NASTRAN_SUFFIXES, *OUTPUT_SUFFIXES, *HDF5_SUFFIXES, ".mtx", ".sti", ".mas")
NODE_SUFFIXES = (".inp", *NASTRAN_SUFFIXES, *HDF5_SUFFIXES)
"""Suffixes of the files that `read_nodes` reads."""


def read_nodes(path: str | Path) -> NodeTable:
    """Labelled nodes of an Abaqus or CalculiX (.inp), Nastran (.bdf ..) or HDF5 file; elements are ignored.

    Raises
    ------
    ImportFormatError   a suffix without a reader; errors of the reader
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".inp":
        return read_abaqus_nodes(path)
    if suffix in NASTRAN_SUFFIXES:
        return read_nastran_nodes(path)
    if suffix in HDF5_SUFFIXES:
        return read_hdf5_nodes(path)
    raise ImportFormatError(
        f"{path}: no reader of labelled nodes for this suffix; give a file that ends in "
        f"{', '.join(NODE_SUFFIXES)}"
    )


def read_labelled_matrix(
    path: str | Path, role: MatrixRole, nodes: NodeTable, *, name: str | None = None
) -> LabelledMatrix:
    """Matrix from DMIG (.pch, .bdf ..), OUTPUT4, OUTPUT2, HDF5, Abaqus .mtx or CalculiX .sti, .mas.

    Parameters
    ----------
    nodes : NodeTable     nodes of the model; they define the rows of OUTPUT4 and Abaqus COORDINATE files
    name : str or None    name of the matrix, for formats with several (DMIG, OUTPUT4, OUTPUT2)
    Raises
    ------
    ImportFormatError   a suffix without a reader; a name for another format; errors of the reader
    """
    suffix = Path(path).suffix.lower()
    if suffix in NASTRAN_SUFFIXES:
        return read_dmig(path, role, name=name)
    if suffix in OUTPUT_SUFFIXES:
        return read_output4(path, role, nodes, name=name)
    if name is not None:
        raise ImportFormatError(
            f"{path}: a {suffix} file holds no named matrices; leave the name '{name}' out"
        )
    if suffix in HDF5_SUFFIXES:
        return read_hdf5_matrix(path, role)
    if suffix == ".mtx":
        return read_abaqus_matrix(path, nodes)
    if suffix in (".sti", ".mas"):
        return read_calculix_matrix(path)
    raise ImportFormatError(
        f"{path}: no reader of matrices for this suffix; give a file that ends in "
        f"{', '.join(MATRIX_SUFFIXES)}"
    )
