"""OUTPUT4 text files (.op4): named matrices with 17 digits, for Nastran's INPUTT4.

Each column that is not zero has a record: the number of the column, the first row that is not zero, the
number of rows, and the values of these rows.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from supple.errors import ModelError
from supple.export.ascii_file import write_ascii

__all__ = ["write_output4"]

_SQUARE, _SYMMETRIC, _REAL_DOUBLE = 1, 6, 2
_PER_LINE = 3
_LONGEST_NAME = 8


def write_output4(path: Path | str, matrices: Mapping[str, ArrayLike]) -> Path:
    """Write square matrices (n, n) under their names in capitals; returns the path.

    Raises
    ------
    ModelError          no matrix; a name of over eight characters; a matrix that is not square or not finite
    ResultFileError     the file cannot be written
    """
    if not matrices:
        raise ModelError("an OUTPUT4 file needs a matrix: give one, such as {'KAA': stiffness}")
    lines = []
    for name, given in matrices.items():
        matrix = np.asarray(given, dtype=np.float64)
        if len(name) > _LONGEST_NAME or matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
            raise ModelError(
                f"{name} of shape {matrix.shape}: give square matrices with names of at most eight characters"
            )
        if not np.isfinite(matrix).all():
            raise ModelError(f"{name} has entries that are not finite; correct them")
        lines += _lines(name, matrix)
    return write_ascii(path, lines)


def _lines(name: str, matrix: np.ndarray) -> list[str]:
    n = len(matrix)
    form = _SYMMETRIC if np.array_equal(matrix, matrix.T) else _SQUARE
    lines = [f"{n:8d}{n:8d}{form:8d}{_REAL_DOUBLE:8d}{name.upper():<8}1P,{_PER_LINE}E24.16"]
    for j in np.flatnonzero(matrix.any(axis=0)):
        (rows,) = np.nonzero(matrix[:, j])
        column = matrix[rows[0] : rows[-1] + 1, j]
        lines.append(f"{j + 1:8d}{rows[0] + 1:8d}{len(column):8d}")
        words = [f"{value:24.16E}" for value in column]
        lines += ["".join(words[at : at + _PER_LINE]) for at in range(0, len(words), _PER_LINE)]
    return [*lines, f"{n + 1:8d}{1:8d}{1:8d}", f"{1.0:24.16E}"]
