"""OUTPUT4 and OUTPUT2 files (.op4, .op2): matrices by row number; the mesh file defines their freedoms."""

from __future__ import annotations

import re
import struct
import warnings
from pathlib import Path

import numpy as np
from scipy.sparse import csc_array

from supple.arrays import IntArray
from supple.errors import ImportFormatError
from supple.importers.matrices.labelled_matrix import (
    SINGLE_PRECISION,
    LabelledMatrix,
    MatrixRole,
    chosen_name,
)
from supple.importers.node_table import NodeTable
from supple.importers.text_file import file_content, unreadable

_TEXT_FORMAT = re.compile(rb"[0-9]E[0-9]+\.([0-9]+)")
_REAL_SINGLE = 1
_HEADER_BYTES = 24
# Length of the first record, of a matrix with keys of 4 or 8 bytes, in both orders of bytes.
_HEADERS = tuple(struct.pack(form, 24 * n) for form in ("<i", ">i") for n in (1, 2))


def read_output4(
    path: str | Path, role: MatrixRole, nodes: NodeTable, *, name: str | None = None
) -> LabelledMatrix:
    """The stiffness, mass or damping of an OUTPUT4 or OUTPUT2 file, by pyyeti (install `supple[nastran]`).

    The files have no labels. If the number of rows fits, the rows are the analysis set (ASET, BSET, QSET) of
    the mesh file. Otherwise they are all six freedoms of all its grids (the g-set), sorted by id.

    Parameters
    ----------
    nodes : NodeTable     of the bulk data file the matrices come from
    name : str or None    of the matrix in the file; None: the only one whose name begins with K (stiffness),
        M (mass) or B (damping)
    Raises
    ------
    ImportFormatError   pyyeti missing; missing, cut or unreadable file; no such matrix, or several; complex
                        entries; a number of rows that fits neither set
    """
    path = Path(path)
    source, matrix, kind = _chosen(path, role, name)
    freedoms = _row_freedoms(source, matrix.shape[0], nodes)
    if matrix.shape[1] != matrix.shape[0]:  # before arrays of that size are made
        raise ImportFormatError(
            f"{source}: the matrix has shape {matrix.shape}; stiffness and mass are square"
        )
    return LabelledMatrix(source, csc_array(matrix, dtype=np.float64), freedoms, _resolution(path, kind))


def named_matrix(path: Path, name: str) -> tuple[str, csc_array]:
    """Label of a matrix for messages, and the matrix (m, n); reading errors of `read_output4`."""
    return _chosen(path, MatrixRole.STIFFNESS, name)[:2]


def _chosen(path: Path, role: MatrixRole, name: str | None) -> tuple[str, csc_array, int]:
    """Label for messages, matrix and type of the matrix of that name, or of the role."""
    matrices = _load(path)
    chosen = chosen_name(path, matrices, role, name, one="matrix", several="matrices")
    matrix, kind = matrices[chosen]
    source = f"{path}, matrix {chosen}"
    if np.iscomplexobj(matrix.data):
        raise ImportFormatError(
            f"{source}: complex entries; stiffness and mass are real, so export them as real"
        )
    return source, matrix, kind


def _load(path: Path) -> dict[str, tuple[csc_array, int]]:
    """Matrices of a file with their types, by name in upper case."""
    try:
        from pyyeti.nastran import op2, op4
    except ImportError as error:
        raise ImportFormatError(
            f"{path}: OUTPUT4 and OUTPUT2 files are read by the library pyyeti; pip install "
            "'supple[nastran]', or punch the matrices as DMIG"
        ) from error
    content = file_content(path)
    form = "OUTPUT2" if path.suffix.lower() == ".op2" else "OUTPUT4"
    if form == "OUTPUT4" and content[:4] in _HEADERS:
        _check_records(path, content)
    elif form == "OUTPUT4" and (not content.isascii() or b"_" in b"".join(content.split(b"\n")[1:])):
        raise ImportFormatError(
            f"{path}: characters that are part of no number; is it OUTPUT4, and complete? Write it again"
        )
    try:
        if form == "OUTPUT2":
            return {key.upper(): (csc_array(each), 0) for key, each in op2.rdmats(str(path)).items()}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            names, matrices, _, kinds = op4.read(str(path), into="list", sparse=True)
    except Exception as error:  # the library raises any error on a damaged file
        raise unreadable(path, form, error) from error
    if not names:
        raise ImportFormatError(f"{path}: no matrix in this file; is it OUTPUT4, and complete?")
    return {
        name.upper(): (csc_array(each), kind) for name, each, kind in zip(names, matrices, kinds, strict=True)
    }


def _check_records(path: Path, content: bytes) -> None:
    """Raise ImportFormatError if the records of a binary file do not fill the file, or are inconsistent.

    The library allocates as much memory as a column states. A record is enclosed by two copies of its length
    in bytes. A matrix is a record of its size, then one for each column: number, row, words, and these words.
    """
    order = "<" if content[:4] in _HEADERS[:2] else ">"
    key = 4 if struct.unpack(f"{order}i", content[:4])[0] == _HEADER_BYTES else 8
    place, columns_left = 0, False
    n_columns = 0
    while place < len(content):
        length = struct.unpack_from(f"{order}i", content, place)[0] if place + 4 <= len(content) else -1
        end = place + 4 + length
        if length < 3 * key or content[end : end + 4] != content[place : place + 4]:
            raise ImportFormatError(
                f"{path}: not readable as OUTPUT4 (the record at byte {place} is broken); is it cut short? "
                "Write it again"
            )
        first, _, words = struct.unpack_from(f"{order}3{'i' if key == 4 else 'q'}", content, place + 4)
        if not columns_left:
            n_columns, columns_left = first, True
        elif 3 * key + words * key != length:
            raise ImportFormatError(
                f"{path}: not readable as OUTPUT4 (column {first} states {words} words in a record of "
                f"{length} bytes); write it again"
            )
        else:
            columns_left = first <= n_columns
        place = end + 4


def _resolution(path: Path, kind: int) -> float:
    """Relative error of an entry, by its type or the number of printed digits (as in 1P,5E16.9)."""
    with path.open("rb") as file:
        printed = _TEXT_FORMAT.search(file.readline(200))
    digits = 0.0 if printed is None else 5.0 * 10.0 ** -(int(printed[1]) + 1)
    return max(digits, SINGLE_PRECISION if kind == _REAL_SINGLE else float(np.finfo(float).eps))


def _row_freedoms(source: str, n: int, nodes: NodeTable) -> IntArray:
    if nodes.retained is not None and len(nodes.retained) == n:
        return nodes.retained
    if n != 6 * len(nodes.ids):
        retained = 0 if nodes.retained is None else len(nodes.retained)
        aset = f"an ASET of {retained}" if retained else "no ASET"
        if retained and not len(nodes.modal) and n > retained:
            aset += (
                f" without modal coordinates: if the {n - retained} further rows are modal coordinates, name "
                "them by QSET1 and SPOINT cards in the mesh file"
            )
        raise ImportFormatError(
            f"{source}: {n} rows, but {nodes.source} has {len(nodes.ids)} grids, so {6 * len(nodes.ids)} "
            f"freedoms, and {aset}; export the matrix of all grids (KGG, MGG) or of the ASET written "
            "there, from the same model"
        )
    ids = np.sort(nodes.ids)
    return np.column_stack([np.repeat(ids, 6), np.tile(np.arange(1, 7), len(ids))])
