"""Tables of one quantity over time, rows of two numbers in a CSV file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.errors import ImportFormatError


def read_time_table(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times (k,) and values (k,) of a CSV file with rows `time,value`; # begins a comment.

    Raises
    ------
    ImportFormatError   a file that does not hold two columns of finite numbers with times that increase
    """
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2)
    except ValueError as error:
        raise ImportFormatError(f"{path}: {error}; write rows of two numbers, time,value") from error
    if rows.shape[0] < 2 or rows.shape[1] != 2:
        raise ImportFormatError(
            f"{path} has {rows.shape[0]} rows of {rows.shape[1]} numbers; write two or more rows time,value"
        )
    if not np.isfinite(rows).all():
        raise ImportFormatError(f"{path} holds NaN or infinite numbers; remove these rows")
    backwards = np.flatnonzero(np.diff(rows[:, 0]) <= 0)
    if backwards.size:
        row = int(backwards[0]) + 1
        raise ImportFormatError(
            f"{path}: times must increase, but row {row + 1} has {rows[row, 0]:g} after {rows[row - 1, 0]:g}"
        )
    return rows[:, 0], rows[:, 1]
