"""A few linear constraints D x = c as dense rows, in the form that all factors use."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from supple.arrays import Array
from supple.errors import ModelError


def dense_rows(constraint: Any, n: int) -> Array:
    """D as a dense, read-only (m, n) array; (0, n) without a constraint.

    Raises ModelError for a wrong shape, or numbers that are not finite.
    """
    if constraint is None:
        constraint = np.zeros((0, n))
    elif sparse.issparse(constraint):
        constraint = constraint.toarray()
    rows = np.array(constraint, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != n:
        raise ModelError(f"the constraint has shape {rows.shape}; give (m, n) with n = {n}")
    if not np.all(np.isfinite(rows)):
        raise ModelError("the constraint has NaN or infinite entries")
    rows.flags.writeable = False
    return rows
