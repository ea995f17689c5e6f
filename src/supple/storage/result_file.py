"""Result files: simulations on disk, kept as they run.

Format "supple-result", version 2, an HDF5 file (any HDF5 reader opens it):

    attributes   format        "supple-result"
                 version       2
                 case          the text of the case that was run, for the record and for continuing it
                 metadata      JSON object of further names and values
    complete     scalar        1 once the run has ended, 0 while it runs or where it was cut off
    times        (t,)          output times
    bodies/<name>/<field>      (t, ...) the arrays of the body's motion, of the kind that the attribute `kind`
                               of the group names; floating where it is missing: position, rotation, ...
    joint_forces/<name>        (t, 6) force and moment of each joint; its attributes `columns`, `acts_on`,
                               `axes` and `unit` say which component, on which end, along which axes
    multipliers/<name>         (t, m) Lagrange multipliers of each joint, to continue the run
    commits      (k, 8)        one row per chunk written: its number of times, then its steps, iterations,
                               rejected steps, seconds, seconds of compilation, and the largest local error
                               and turn of a step (6 columns in older files)

    engine_state/<key>         (k, ...) what the engine needs to go on exactly, one row per chunk, or absent

All numbers are 64-bit floats, stored bit for bit; in names, % and / are written %25 and %2F. The motion
datasets appear with the first chunk. A chunk counts once its row of `commits` is there: whatever lies beyond
the committed times was being written when the run ended.

While a run goes on the file is in HDF5's single-writer mode, which orders every write so that the file can be
read at any moment: by another process during the run, and after the run was killed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Self

import h5py
import numpy as np

from supple.errors import ResultFileError
from supple.integrate.solution import Solution, Statistics
from supple.storage.atomic_write import replacing
from supple.storage.dataset_labels import dataset_labels
from supple.storage.disk_space import reserve_space
from supple.storage.file_errors import file_errors
from supple.storage.result_reader import (
    FORMAT,
    VERSION,
    Metadata,
    ResultHeader,
    dataset,
    read_header,
    read_solution,
)
from supple.storage.solution_arrays import Array, motion_kinds, statistics_row, to_arrays

# HDF5 stores and caches a dataset in blocks of this many bytes, or one row where a row is longer.
_BLOCK_BYTES = 16384

# Room for the indices of blocks, which grow by pages.
_INDEX_BYTES = 2**20


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
        self._closed = False
        self._layout: dict[str, tuple[int, ...]] = {}
        self._n_times = 0
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
        """Continue the file of a run that was cut off; `read_last_instant` gives the state to start from.

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
        """Write the next output times of the run; once this returns, they outlive the process.

        Raises
        ------
        ResultFileError     times that do not follow the last ones, other bodies or joints than before, a
                            closed file, a full disk; what was appended before stays readable
        """
        if self._closed:
            raise ResultFileError(
                f"cannot append to {self.path}: it is closed; continue it with ResultFile.resume"
            )
        arrays = to_arrays(chunk)
        self._check(arrays)
        if self._file is None:
            self._start(chunk)
        else:
            kept = f" (the run up to t = {self._last_time:g} is kept and can be continued)"
            with file_errors("write", self.path, note=kept):
                reserve_space(self.path, self._file.id.get_filesize() + _most_growth(arrays))
                _extend(self._file, self._n_times, arrays, chunk)
            self._n_times += len(chunk.times)
            self._last_time = float(chunk.times[-1])

    def finish(self) -> None:
        """Mark the run complete and close the file."""
        if self._file is not None:
            with file_errors("write", self.path):
                dataset(self._file, "complete")[()] = 1
                self._file.flush()
        else:
            _write_whole(self.path, replace(self._header, complete=True), None)
        self.close()

    def close(self) -> None:
        """Close the file as it is."""
        self._closed = True
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
        self._layout = {path: array.shape[1:] for path, array in to_arrays(written).items()}
        self._n_times = len(written.times)
        self._last_time = float(written.times[-1])

    def _check(self, arrays: Mapping[str, Array]) -> None:
        times = arrays["times"]
        if not len(times) or times[0] <= self._last_time or not (np.diff(times) > 0.0).all():
            seen = f"{times[0]:g} to {times[-1]:g}" if len(times) else "none"
            raise ResultFileError(
                f"cannot append to {self.path}: its times end at {self._last_time:g} and the new ones "
                f"({seen}) do not rise from there"
            )
        layout = {path: array.shape[1:] for path, array in arrays.items()}
        if self._layout and layout != self._layout:
            changed = sorted(
                path
                for path in layout.keys() | self._layout.keys()
                if layout.get(path) != self._layout.get(path)
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


def _write_whole(path: Path, header: ResultHeader, solution: Solution | None) -> None:
    # Built in memory, because HDF5 does not survive a write that fails: see disk_space.
    with h5py.File("image", "w", driver="core", backing_store=False, libver="latest") as file:
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
                for key, value in dataset_labels(name, header.metadata).items():
                    file[name].attrs[key] = value
            for group, kind in motion_kinds(solution).items():
                file[group].attrs["kind"] = kind
            for key, value in solution.engine_state.items():
                _create_growing(file, f"engine_state/{key}", np.asarray(value, dtype=float)[None])
            _commit(file, len(solution.times), solution.statistics)
        file.flush()
        image = file.id.get_file_image()
    with replacing(path) as temporary:
        temporary.write_bytes(image)


def _create_growing(file: h5py.File, name: str, array: Array) -> None:
    width = array.shape[1:]
    row_bytes = 8 * max(1, int(np.prod(width)))
    # A block has no side of length zero, not even for a rigid body's zero coordinates.
    blocks = (max(1, _BLOCK_BYTES // row_bytes), *(max(1, n) for n in width))
    file.create_dataset(name, data=array, maxshape=(None,) * array.ndim, chunks=blocks)


def _most_growth(arrays: Mapping[str, Array]) -> int:
    """Bytes by which the file grows at most: the rows, a begun block at either end, and their index."""
    rows = sum(array.nbytes + 2 * max(_BLOCK_BYTES, array[:1].nbytes) for array in arrays.values())
    return rows + rows // 8 + _INDEX_BYTES


def _extend(file: h5py.File, n_written: int, arrays: Mapping[str, Array], chunk: Solution) -> None:
    for name, array in arrays.items():
        target = dataset(file, name)
        target.resize(n_written + len(array), axis=0)
        if array.size:
            target[n_written:] = array
    for key, value in chunk.engine_state.items():
        if f"engine_state/{key}" not in file:
            continue  # a run begun by an engine that did not keep it
        rows = dataset(file, f"engine_state/{key}")
        rows.resize(rows.shape[0] + 1, axis=0)
        if rows.size:
            rows[-1] = value
    file.flush()
    _commit(file, len(arrays["times"]), chunk.statistics)


def _commit(file: h5py.File, n_times: int, statistics: Statistics) -> None:
    commits = dataset(file, "commits")
    commits.resize(commits.shape[0] + 1, axis=0)
    commits[-1] = np.concatenate([[n_times], statistics_row(statistics)])[: commits.shape[1]]
    file.flush()


def _open_single_writer(path: Path) -> h5py.File:
    # The high-level constructor opens for writing first and switches then; killed in between, it leaves a
    # file that only a repair tool opens. The low-level call enters the mode in one step.
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_libver_bounds(h5py.h5f.LIBVER_LATEST, h5py.h5f.LIBVER_LATEST)
    access.set_fclose_degree(h5py.h5f.CLOSE_STRONG)
    flags = h5py.h5f.ACC_RDWR | h5py.h5f.ACC_SWMR_WRITE
    return h5py.File(h5py.h5f.open(str(path).encode(), flags, access))


def _first_difference(stored: str, given: str) -> str:
    pairs = zip_longest(stored.splitlines(), given.splitlines())
    for number, (there, here) in enumerate(pairs, start=1):
        if there != here:
            return f"line {number}: {there!r} there, {here!r} here"
    return "they differ in line ends"
