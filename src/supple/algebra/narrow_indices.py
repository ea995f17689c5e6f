"""Indices of sparse matrices with the fewest bytes."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array


def narrow_indices(matrix: csc_array) -> csc_array:
    """The matrix with 32-bit indices if these suffice, otherwise the given one.

    Matrices with 32-bit indices take a quarter less memory and memory traffic than with 64-bit indices.

    SciPy keeps the width of the given indices, also in all products.
    """
    if max(int(matrix.indices.max(initial=0)), matrix.nnz) > np.iinfo(np.int32).max:
        return matrix
    narrow = matrix.indices.astype(np.int32), matrix.indptr.astype(np.int32)
    return csc_array((matrix.data, *narrow), shape=matrix.shape)
