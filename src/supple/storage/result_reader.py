"""Reading result files of runs that are complete, in progress or interrupted."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arguments import checked_arguments
from supple.errors import ResultFileError
from supple.integrate.solution import Solution
from supple.storage.file_errors import DAMAGE, file_errors
from supple.storage.hdf5_superblock import is_current_hdf5, is_marked, open_unmarked
from supple.storage.result_content import DamagedResultError, ResultContent, ResultHeader, damaged, not_ours

__all__ = ["ResultParts", "read_header", "read_last_instant", "read_solution", "read_sound_part"]

# A reader may come between two writes of a run in progress: it tries again, for half a second in total.
_PAUSES = (0.02, 0.08, 0.4)

_PART_BYTES = 2**26
"""Largest size of a part of `ResultParts`, bytes; a part has at least one output time."""

_T = TypeVar("_T")


def read_header(path: Path | str) -> ResultHeader:
    """The case, metadata and progress of a result file, also of a run in progress or interrupted.

    Raises
    ------
    ResultFileError     a missing file, not a result file, another version, truncated or damaged
    """
    return _read(Path(path), lambda content: content.header)


@checked_arguments
def read_solution(path: Path | str) -> Solution:
    """The simulation in a result file, as far as it is written.

    Raises
    ------
    ResultFileError     as for read_header; also a run that ended before its first output
    """
    return _read(Path(path), lambda content: content.solution())


def read_last_instant(path: Path | str) -> Solution:
    """The last output time alone, a Solution of one row: the state for a continuation.

    Raises
    ------
    ResultFileError     as for read_solution
    """
    return _read(Path(path), lambda content: content.last_instant())


def read_sound_part(path: Path | str) -> Solution:
    """The undamaged part of a damaged result file: the output times whose seals match.

    `stopped` of the solution names the damaged parts; times may be missing in between.

    Raises
    ------
    ResultFileError     as for read_header; no undamaged part
    """
    return _read(Path(path), lambda content: content.sound_part())


class ResultParts:
    """Output times of a file that need not fit in memory; a loop yields Solutions of some of the times.

        for part in ResultParts("blade.h5"): ...

    rows : indices (k,) of output times, ascending, each once; by default all

    Raises
    ------
    ResultFileError     as for `read_solution`; an index of an output time that does not exist; rows that are
                        not ascending indices
    """

    def __init__(self, path: Path | str, rows: ArrayLike | None = None) -> None:
        self.path = Path(path)
        times = _read(self.path, lambda content: content.times)
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
        checked: set[int] = set()
        parts = self.rows // max(1, _PART_BYTES // _read(self.path, lambda content: content.row_bytes))
        for number in np.unique(parts):
            rows = self.rows[parts == number]
            # Opened for each part, because a run in progress may write between two parts.
            yield _read(self.path, lambda content, rows=rows: content.part(rows, checked))


def _read(path: Path, wanted: Callable[[ResultContent], _T]) -> _T:
    if not path.is_file():
        raise ResultFileError(f"cannot read {path}: no such file; check the path")
    with file_errors("read", path):
        if not h5py.is_hdf5(path):
            raise ResultFileError(
                f"cannot read {path}: not an HDF5 file, so not a result of supple; check the path"
            )
        if not is_current_hdf5(path):
            raise not_ours(path)
        for pause in _PAUSES if is_marked(path) else ():
            try:
                return _read_once(path, wanted)
            except DamagedResultError:
                time.sleep(pause)
        return _read_once(path, wanted)


def _read_once(path: Path, wanted: Callable[[ResultContent], _T]) -> _T:
    try:
        with open_unmarked(path) as file:
            return wanted(ResultContent(path, file))
    except ResultFileError:
        raise
    except DAMAGE as error:
        raise damaged(path, error) from error
