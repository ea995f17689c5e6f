"""Result files: simulations on disk, kept as they run.

Format "supple-result", version 1, an HDF5 file (any HDF5 reader opens it):

    attributes   format        "supple-result"
                 version       1
                 case          the text of the case that was run, for the record and for continuing it
                 metadata      JSON object of further names and values
    complete     scalar        1 once the run has ended, 0 while it runs or where it was cut off
    times        (t,)          output times
    bodies/<name>/<field>      (t, ...) the fields of BodyMotion: position, rotation, coordinates, ...
    joint_forces/<name>        (t, m) Lagrange multipliers of each joint
    commits      (k, 6)        one row per chunk written: its number of times, then its steps, iterations, cuts,
                               seconds and seconds of compilation

All numbers are 64-bit floats, stored bit for bit; in names, % and / are written %25 and %2F. The motion datasets
appear with the first chunk. A chunk counts once its row of `commits` is there: whatever lies beyond the
committed times was being written when the run ended.

While a run goes on the file is in HDF5's single-writer mode, which orders every write so that the file can be
read at any moment: by another process during the run, and after the run was killed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Self

import h5py
import numpy as np

from supple.errors import ResultFileError
from supple.integrate.solution import Solution, Statistics
from supple.results.atomic_write import replacing
from supple.results.file_errors import file_errors
from supple.results.solution_arrays import (
    Array,
    from_arrays,
    statistics_from_rows,
    statistics_row,
    to_arrays,
)

FORMAT = "supple-result"
VERSION = 1

# HDF5 stores and caches a dataset in blocks of this many bytes, or one row where a row is longer.
_BLOCK_BYTES = 65536

Metadata = Mapping[str, str | int | float | bool]


@dataclass(frozen=True)
class ResultHeader:
    """What a result file says about itself: the case, its metadata, and how far the run has come."""

    case: str
    metadata: Metadata
    complete: bool
    n_times: int
    statistics: Statistics


class ResultFile:
    """A result file being written, chunk by chunk; use it as a context manager.

        with ResultFile.create(path, case=text) as file:
            simulate(system, ..., record=file.append)
            file.finish()

    Leaving the block without `finish` closes the file as an incomplete run, which `resume` continues.
    """

    def __init__(self, path: Path, header: ResultHeader, written: Solution | None) -> None:
        self.path = path
        self._header = header
        self._file: h5py.File | None = None
        self._layout: dict[str, tuple[int, ...]] = {}
        self._last_time = -np.inf
        if written is not None:
            self._start(written)

    @classmethod
    def create(cls, path: Path | str, *, case: str, metadata: Metadata = MappingProxyType({})) -> Self:
        """Start a result file, replacing one that is there.

        Raises
        ------
        ResultFileError     the file cannot be written
        """
        header = ResultHeader(case, dict(metadata), complete=False, n_times=0, statistics=Statistics())
        _write_whole(Path(path), header, None)
        return cls(Path(path), header, None)

    @classmethod
    def resume(cls, path: Path | str, *, case: str) -> Self:
        """Continue the result file of a run that was cut off; `read_last_instant` gives the state to start from.

        Raises
        ------
        ResultFileError     the run is complete, or of another case, or the file cannot be read or written
        """
        path = Path(path)
        header = read_header(path)
        if header.complete:
            raise ResultFileError(f"cannot continue {path}: its run is complete; write to another file")
        if header.case != case:
            raise ResultFileError(
                f"cannot continue {path}: it holds another case ({_first_difference(header.case, case)}); "
                "write to another file, or run the case it was started with"
            )
        return cls(path, header, read_solution(path) if header.n_times else None)

    @property
    def last_time(self) -> float:
        """The last output time written; minus infinity before the first."""
        return self._last_time

    def append(self, chunk: Solution) -> None:
        """Write the next output times of the run; they are safe on disk when this returns.

        Raises
        ------
        ResultFileError     times that do not follow the last ones, other bodies or joints than before,
                            the disk is full; what was appended before stays readable
        """
        arrays = to_arrays(chunk)
        self._check(arrays)
        if self._file is None:
            self._start(chunk)
        else:
            kept = f" (the run up to t = {self._last_time:g} is kept and can be continued)"
            with file_errors("write", self.path, note=kept):
                try:
                    _extend(self._file, arrays, chunk.statistics)
                except OSError:
                    self._abandon()
                    raise
        self._last_time = float(arrays["times"][-1])

    def finish(self) -> None:
        """Mark the run complete and close the file."""
        if self._file is not None:
            with file_errors("write", self.path):
                self._file["complete"][()] = 1
                self._file.flush()
        else:
            _write_whole(self.path, _completed(self._header), None)
        self.close()

    def close(self) -> None:
        """Close the file as it is."""
        if self._file is not None:
            with file_errors("close", self.path):
                self._file.close()
            self._file = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _start(self, written: Solution) -> None:
        # The datasets must exist before the single-writer mode begins, so they come with the first chunk.
        _write_whole(self.path, self._header, written)
        with file_errors("open", self.path):
            self._file = _open_single_writer(self.path)
        arrays = to_arrays(written)
        self._layout = {path: array.shape[1:] for path, array in arrays.items()}
        self._last_time = float(arrays["times"][-1])

    def _check(self, arrays: Mapping[str, Array]) -> None:
        times = arrays["times"]
        if not len(times) or times[0] <= self._last_time or not (np.diff(times) > 0.0).all():
            seen = f"{times[0]:g} to {times[-1]:g}" if len(times) else "none"
            raise ResultFileError(
                f"cannot append to {self.path}: its times end at {self._last_time:g} and the new ones ({seen}) "
                "do not rise from there"
            )
        layout = {path: array.shape[1:] for path, array in arrays.items()}
        if self._layout and layout != self._layout:
            changed = sorted(
                path for path in layout.keys() | self._layout.keys() if layout.get(path) != self._layout.get(path)
            )
            raise ResultFileError(
                f"cannot append to {self.path}: {changed[0]} has row shape {layout.get(changed[0])}, "
                f"{self._layout.get(changed[0])} so far; a file holds one system"
            )
        for path, array in arrays.items():
            if len(array) != len(times):
                raise ResultFileError(
                    f"cannot append to {self.path}: {path} has {len(array)} rows for {len(times)} times"
                )

    def _abandon(self) -> None:
        """Close after a failed write, whose left-overs HDF5 may fail to flush once more."""
        if self._file is not None:
            with suppress(OSError, RuntimeError):
                self._file.close()
            self._file = None


def write_solution(
    path: Path | str, solution: Solution, *, case: str, metadata: Metadata = MappingProxyType({})
) -> Path:
    """Write a finished simulation as a complete result file, atomically.

    Raises
    ------
    ResultFileError     the file cannot be written
    """
    header = ResultHeader(case, dict(metadata), True, len(solution.times), solution.statistics)
    _write_whole(Path(path), header, solution)
    return Path(path)


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
            raise ResultFileError(f"{self.path} holds no output times: its run ended before the first; run it again")
        arrays: dict[str, Array] = {}

        def collect(name: str, item: h5py.Dataset | h5py.Group) -> None:
            if isinstance(item, h5py.Dataset) and name not in {"complete", "commits"}:
                arrays[name] = item[rows]

        with file_errors("read", self.path):
            try:
                self._file.visititems(collect)
                return from_arrays(arrays, self.header.statistics)
            except (KeyError, TypeError) as error:
                raise self._damaged(error) from error

    def _read_header(self) -> ResultHeader:
        attributes = self._file.attrs
        if attributes.get("format") != FORMAT:
            raise ResultFileError(f"{self.path} is an HDF5 file but not a result of supple: check the path")
        version = int(attributes.get("version", 0))
        if version != VERSION:
            raise ResultFileError(
                f"{self.path} has format version {version}, and this supple reads version {VERSION}: "
                "use the supple that wrote it, or run the case again"
            )
        with file_errors("read", self.path):
            try:
                rows = np.asarray(self._file["commits"][()])
                # A row that was being written when the run was killed reads as zeros.
                rows = rows[: int(np.argmin(np.append(rows[:, 0], 0.0) > 0.0))]
                return ResultHeader(
                    case=str(attributes["case"]),
                    metadata=MappingProxyType(json.loads(attributes["metadata"])),
                    complete=bool(self._file["complete"][()]),
                    n_times=int(rows[:, 0].sum()),
                    statistics=statistics_from_rows(rows[:, 1:]),
                )
            except (KeyError, ValueError) as error:
                raise self._damaged(error) from error

    def _damaged(self, error: Exception) -> ResultFileError:
        return ResultFileError(f"{self.path} is damaged ({error}): run the case again")


def _write_whole(path: Path, header: ResultHeader, solution: Solution | None) -> None:
    with replacing(path) as temporary, h5py.File(temporary, "w", libver="latest") as file:
        file.attrs["format"] = FORMAT
        file.attrs["version"] = VERSION
        file.attrs["case"] = header.case
        file.attrs["metadata"] = json.dumps(dict(header.metadata))
        file.create_dataset("complete", data=int(header.complete))
        n_columns = 1 + len(statistics_row(Statistics()))
        _create_growing(file, "commits", np.empty((0, n_columns)))
        if solution is not None:
            for name, array in to_arrays(solution).items():
                _create_growing(file, name, array)
            _commit(file, len(solution.times), solution.statistics)


def _create_growing(file: h5py.File, name: str, array: Array) -> None:
    width = array.shape[1:]
    row_bytes = 8 * max(1, int(np.prod(width)))
    # A block has no side of length zero, not even for a rigid body's zero coordinates.
    blocks = (max(1, _BLOCK_BYTES // row_bytes), *(max(1, n) for n in width))
    file.create_dataset(name, data=array, maxshape=(None,) * array.ndim, chunks=blocks)


def _extend(file: h5py.File, arrays: Mapping[str, Array], statistics: Statistics) -> None:
    n_written = file["times"].shape[0]
    for name, array in arrays.items():
        dataset = file[name]
        dataset.resize(n_written + len(array), axis=0)
        if array.size:
            dataset[n_written:] = array
    file.flush()
    _commit(file, len(arrays["times"]), statistics)


def _commit(file: h5py.File, n_times: int, statistics: Statistics) -> None:
    commits = file["commits"]
    commits.resize(commits.shape[0] + 1, axis=0)
    commits[-1] = np.concatenate([[n_times], statistics_row(statistics)])
    file.flush()


def _open_single_writer(path: Path) -> h5py.File:
    # The high-level constructor opens for writing first and switches then; killed in between, it leaves a file
    # that only a repair tool opens. The low-level call enters the mode in one step.
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_libver_bounds(h5py.h5f.LIBVER_LATEST, h5py.h5f.LIBVER_LATEST)
    access.set_fclose_degree(h5py.h5f.CLOSE_STRONG)
    flags = h5py.h5f.ACC_RDWR | h5py.h5f.ACC_SWMR_WRITE
    return h5py.File(h5py.h5f.open(str(path).encode(), flags, access))


def _open_to_read(path: Path) -> h5py.File:
    if not path.is_file():
        raise ResultFileError(f"cannot read {path}: no such file; check the path")
    if not h5py.is_hdf5(path):
        raise ResultFileError(f"cannot read {path}: not an HDF5 file, so not a result of supple; check the path")
    try:
        return h5py.File(path, "r")
    except OSError as error:
        if "truncated" in str(error):
            raise ResultFileError(
                f"cannot read {path}: the file is truncated, as by an interrupted copy; copy it again"
            ) from error
        # A run that goes on, or was killed, leaves the file in single-writer mode.
        return h5py.File(path, "r", libver="latest", swmr=True)


def _completed(header: ResultHeader) -> ResultHeader:
    return ResultHeader(header.case, header.metadata, True, header.n_times, header.statistics)


def _first_difference(stored: str, given: str) -> str:
    pairs = zip_longest(stored.splitlines(), given.splitlines())
    for number, (there, here) in enumerate(pairs, start=1):
        if there != here:
            return f"line {number}: {there!r} there, {here!r} here"
    return "they differ in line ends"
