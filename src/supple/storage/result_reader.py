"""Reading result files; `storage` describes their format."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Self

import h5py
import numpy as np

from supple.errors import ResultFileError
from supple.integrate.solution import Solution, Statistics
from supple.storage.file_errors import file_errors
from supple.storage.solution_arrays import Array, from_arrays, statistics_from_rows

FORMAT = "supple-result"
VERSION = 2

Metadata = Mapping[str, str | int | float | bool]


@dataclass(frozen=True)
class ResultHeader:
    """What a result file says about itself: the case, its metadata, and how far the run has come."""

    case: str
    metadata: Metadata
    complete: bool
    n_times: int
    statistics: Statistics
    n_commits: int = 0


def read_header(path: Path | str) -> ResultHeader:
    """The case, metadata and progress of a result file, also of a run that goes on or was cut off.

    Raises
    ------
    ResultFileError     no such file, not a result file, of another version, truncated or damaged
    """
    with _Reader(Path(path)) as reader:
        return reader.header


def read_solution(path: Path | str) -> Solution:
    """The simulation in a result file, as far as it was written.

    Raises
    ------
    ResultFileError     as for read_header; also a run that ended before its first output
    """
    with _Reader(Path(path)) as reader:
        return reader.solution(slice(0, reader.header.n_times))


def read_last_instant(path: Path | str) -> Solution:
    """The last output time alone, a Solution of one row: the state from which to resume.

    Raises
    ------
    ResultFileError     as for read_solution
    """
    with _Reader(Path(path)) as reader:
        return reader.solution(slice(reader.header.n_times - 1, reader.header.n_times))


@dataclass
class _Reader:
    """An open result file whose format has been checked."""

    path: Path
    header: ResultHeader = field(init=False)
    _file: h5py.File = field(init=False)

    def __enter__(self) -> Self:
        with file_errors("read", self.path):
            self._file = _open_to_read(self.path)
        try:
            self.header = self._read_header()
        except BaseException:
            self._file.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def solution(self, rows: slice) -> Solution:
        if self.header.n_times == 0:
            raise ResultFileError(
                f"{self.path} holds no output times: its run ended before the first; run it again"
            )
        arrays: dict[str, Array] = {}
        kinds: dict[str, str] = {}
        engine_state: dict[str, Array] = {}

        def collect(name: str, item: h5py.Dataset | h5py.Group) -> None:
            if isinstance(item, h5py.Group):
                if "kind" in item.attrs:
                    kinds[name] = str(item.attrs["kind"])
            elif name.startswith("engine_state/"):
                engine_state[name.partition("/")[2]] = item[self.header.n_commits - 1]
            elif name not in {"complete", "commits"}:
                arrays[name] = item[rows]

        with file_errors("read", self.path):
            try:
                self._file.visititems(collect)
                return from_arrays(arrays, self.header.statistics, kinds, engine_state)
            except (KeyError, TypeError) as error:
                raise self._damaged(error) from error

    def _read_header(self) -> ResultHeader:
        attributes = self._file.attrs
        if attributes.get("format") != FORMAT:
            raise ResultFileError(f"{self.path} is an HDF5 file but not a result of supple: check the path")
        version = int(str(attributes.get("version", 0)))
        if version != VERSION:
            raise ResultFileError(
                f"{self.path} has format version {version}, and this supple reads version {VERSION}: "
                "use the supple that wrote it, or run the case again"
            )
        with file_errors("read", self.path):
            try:
                rows = dataset(self._file, "commits")[()]
                # A row that was being written when the run was killed reads as zeros.
                rows = rows[: int(np.argmin(np.append(rows[:, 0], 0.0) > 0.0))]
                return ResultHeader(
                    case=str(attributes["case"]),
                    metadata=MappingProxyType(json.loads(str(attributes["metadata"]))),
                    complete=bool(dataset(self._file, "complete")[()]),
                    n_times=int(rows[:, 0].sum()),
                    statistics=statistics_from_rows(rows[:, 1:]),
                    n_commits=len(rows),
                )
            except (KeyError, ValueError) as error:
                raise self._damaged(error) from error

    def _damaged(self, error: Exception) -> ResultFileError:
        return ResultFileError(f"{self.path} is damaged ({error}): run the case again")


def dataset(file: h5py.File, name: str) -> h5py.Dataset:
    """The dataset of that name; KeyError where there is none."""
    found = file[name]
    if not isinstance(found, h5py.Dataset):
        raise KeyError(f"{name} is not a dataset")
    return found


def _open_to_read(path: Path) -> h5py.File:
    if not path.is_file():
        raise ResultFileError(f"cannot read {path}: no such file; check the path")
    if not h5py.is_hdf5(path):
        raise ResultFileError(
            f"cannot read {path}: not an HDF5 file, so not a result of supple; check the path"
        )
    try:
        return h5py.File(path, "r")
    except OSError as error:
        if "truncated" in str(error):
            raise ResultFileError(
                f"cannot read {path}: the file is truncated, as by an interrupted copy; copy it again"
            ) from error
        # A run that goes on, or was killed, leaves the file in single-writer mode.
        return h5py.File(path, "r", libver="latest", swmr=True)
