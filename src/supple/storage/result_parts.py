"""Reading a result file in parts, so that the run need not fit in memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.errors import ResultFileError
from supple.integrate.solution import Solution
from supple.storage.file_errors import file_errors
from supple.storage.hdf5_superblock import open_unmarked
from supple.storage.result_content import ResultContent
from supple.storage.result_reader import read_times

__all__ = ["ResultParts"]

_PART_BYTES = 2**26
"""Largest size of a part, bytes; a part has at least one output time."""


class ResultParts:
    """Output times of a result file; a loop yields Solutions, each with some of these times.

        for part in ResultParts("blade.h5"): ...

    path : path of the result file
    rows : indices (k,) of output times, ascending, each once; by default all

    Raises
    ------
    ResultFileError     as for `read_solution`; an index of an output time that does not exist; rows that are
                        not ascending indices
    """

    def __init__(self, path: Path | str, rows: ArrayLike | None = None) -> None:
        self.path = Path(path)
        times = read_times(self.path)
        self.rows: NDArray[np.int64] = np.arange(len(times)) if rows is None else np.asarray(rows)
        if self.rows.ndim != 1 or self.rows.dtype.kind not in "iu" or (np.diff(self.rows) <= 0).any():
            raise ResultFileError(
                f"{self.path}: rows must be indices of output times, each once and ascending, such as "
                "[0, 5, 10]; for a mask give np.flatnonzero(mask)"
            )
        beyond = self.rows[(self.rows < 0) | (self.rows >= len(times))]
        if beyond.size:
            raise ResultFileError(
                f"{self.path} has {len(times)} output times, numbered from 0; there is no number {beyond[0]}"
            )
        self.times: NDArray[np.float64] = times[self.rows]

    def __iter__(self) -> Iterator[Solution]:
        with file_errors("read", self.path), open_unmarked(self.path) as file:
            content = ResultContent(self.path, file, self.path.stat().st_size)
            yield from content.parts(self.rows, max(1, _PART_BYTES // content.row_bytes))
