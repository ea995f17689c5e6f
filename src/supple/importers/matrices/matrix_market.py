"""Matrix Market files (.mtx): the stiffness and mass of a body reduced elsewhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.io import mmread
from scipy.sparse import coo_array, csc_array

from supple.errors import ImportFormatError


def read_matrix(path: str | Path) -> csc_array:
    """Real matrix of a Matrix Market file, coordinate or array format, symmetric storage filled in.

    Parameters
    ----------
    path : str or Path
    Returns
    -------
    csc_array (m, n)   float64
    Raises
    ------
    ImportFormatError   missing, unreadable or cut file; complex or infinite entries, or NaN; an entry
                        given twice
    """
    path = Path(path)
    if not path.is_file():
        raise ImportFormatError(f"{path}: no such file; check its name and folder")
    try:
        entries = coo_array(mmread(path))
    except (ValueError, OverflowError) as error:
        raise ImportFormatError(
            f"{path}: not readable as Matrix Market ({error}); write it anew, whole, as coordinate real"
        ) from error
    matrix = csc_array(entries)
    if matrix.nnz < entries.nnz:
        raise ImportFormatError(f"{path}: an entry is given twice; write the matrix anew, each entry once")
    if np.iscomplexobj(matrix.data):
        raise ImportFormatError(
            f"{path}: complex entries; stiffness and mass are real, so write their real part"
        )
    if not np.isfinite(matrix.data).all():
        raise ImportFormatError(f"{path}: entries that are infinite or not a number; write the matrix anew")
    return csc_array(matrix, dtype=np.float64)
