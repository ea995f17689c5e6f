"""Result files: simulations on disk, written while they run.

Format "supple-result", version 4, an HDF5 file (any HDF5 reader opens it):

    attributes   format        "supple-result"
                 version       4
    case         text          text of the case that was run
    metadata     text          JSON object of further names and values
    inputs       text          JSON object of all that the motion depends on, by name: values, or digests
    layout       text          JSON object: row shapes of the arrays and of the engine's state, kinds of the
                               bodies' motions
    complete     scalar        1 after the end of the run, 0 during the run or after an interruption
    times        (t,)          output times
    bodies/<name>/<field>      (t, ...) the arrays of the body's motion: position, rotation, ...
    joint_forces/<name>        (t, 6) force and moment of each joint; its attributes `columns`, `acts_on`,
                               `axes` and `unit` give component, end acted on, axes and unit
    multipliers/<name>         (t, m) Lagrange multipliers of each joint, to continue the run
    series/<name>              (t, c) numbers of the whole machine: outputs of controllers; energies, steps,
                               obstacles and contacts of an explicit run
    commits      (k, 11)       one row per chunk written: its first row and its number of times, then its
                               steps, iterations, rejected steps, seconds, seconds of compilation, the
                               largest local error and rotation of a step, factorizations, and the decades by
                               which the residuals were reduced
    engine_state/<key>         (k, ...) engine state for an exact continuation, one row per chunk, or absent
    seals/header, chunks, end  (32,), (k, 64), (32,) digests of all of the above, see `result_seals`

All numbers but `complete` are 64-bit floats, stored unchanged; in names, % and / are written %25 and %2F. The
motion datasets appear with the first chunk. A chunk is valid once its row of `commits` is written. Rows
beyond the committed times belong to a chunk that was being written when the run ended.

During a run the file is in HDF5's single-writer mode, which orders every write so that the file can be read
at any time: by another process during the run, and after the run was killed. One process at a time writes it
(`exclusive_lock`).
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from types import MappingProxyType
from typing import Self

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ResultFileError
from supple.integrate.solution import Solution
from supple.storage.atomic_write import reserve_space
from supple.storage.exclusive_lock import ExclusiveLock, is_at
from supple.storage.file_errors import file_errors
from supple.storage.hdf5_superblock import written_size
from supple.storage.result_chunks import (
    ChunkWriter,
    layout_of_chunk,
    most_growth,
    open_single_writer,
    write_whole,
)
from supple.storage.result_content import Metadata, ResultContent, ResultHeader, errors_metadata
from supple.storage.result_reader import read_header, read_solution
from supple.storage.run_inputs import Inputs, changes
from supple.storage.solution_arrays import to_arrays

__all__ = ["ResultFile", "write_errors", "write_solution"]


class ResultFile:
    """A result file being written, chunk by chunk; use it as a context manager.

        with ResultFile.create(path, case=text) as file:
            simulate(system, ..., record=file.append)
            file.finish()

    header : the header of the file when it was opened
    last_time : the last output time written; minus infinity before the first

    Leaving the block without `finish` closes the file as an incomplete run, which `resume` continues. While
    the file is open, no other process can write it.
    """

    def __init__(
        self, path: Path, header: ResultHeader, lock: ExclusiveLock, written: Solution | None
    ) -> None:
        self.path = path
        self.header = header
        self._lock = lock
        self._writer: ChunkWriter | None = None
        self._place: os.stat_result | None = None
        self._closed = False
        self.last_time = -math.inf
        if written is not None:
            self._start(written)

    @classmethod
    def create(
        cls,
        path: Path | str,
        *,
        case: str,
        metadata: Metadata = MappingProxyType({}),
        inputs: Inputs = MappingProxyType({}),
        overwrite: bool = False,
    ) -> Self:
        """Start a result file.

        case, metadata, inputs : see ResultHeader
        overwrite : replace an existing file of any kind; otherwise only a run without output is replaced

        Raises
        ------
        ResultFileError     a file exists that may not be replaced; the file cannot be written; another run is
                            writing it
        """
        header = ResultHeader(case, dict(metadata), inputs=dict(inputs))
        lock = _locked(Path(path))
        try:
            if not overwrite:
                check_nothing_lost(Path(path))
            write_whole(Path(path), header, None)
            return cls(Path(path), header, lock, None)
        except BaseException:
            lock.release()
            raise

    @classmethod
    def resume(cls, path: Path | str, *, case: str, inputs: Inputs = MappingProxyType({})) -> Self:
        """Continue the file of an interrupted run, from the state of `read_last_instant`.

        inputs : the current inputs of the motion; if neither the file nor the call has inputs, the text of
            the case must equal that in the file

        Raises
        ------
        ResultFileError     the run is complete, or of another case or other inputs; another run is writing
                            the file; it cannot be read or written
        """
        path = Path(path)
        read_header(path)  # leaves no lock file beside a missing file
        lock = ExclusiveLock(path)
        try:
            header = read_header(path)
            if header.complete:
                raise ResultFileError(
                    f"cannot continue {path}: its run is complete; give another path for a new run"
                )
            check_same_run(path, header, case, inputs)
            return cls(path, header, lock, read_solution(path) if header.n_times else None)
        except BaseException:
            lock.release()
            raise

    def append(self, chunk: Solution) -> None:
        """Write the next output times of the run; on return they survive a kill of this process.

        Raises
        ------
        ResultFileError     times that do not follow the last ones; other bodies or joints than before; a
                            closed or removed file; a full disk. Chunks written before stay readable
        """
        self._check_open("append to")
        arrays = to_arrays(chunk)
        self._check(arrays, chunk)
        if self._writer is None:
            self._start(chunk)
            return
        self._check_in_place()
        kept = f" (the run up to t = {self.last_time:g} is stored and can be continued)"
        with file_errors("write", self.path, note=kept):
            reserve_space(self.path, written_size(self.path) + most_growth(arrays, chunk.engine_state))
            self._writer.append(arrays, chunk)
        self.last_time = float(chunk.times[-1])

    def solution(self) -> Solution:
        """The written part of the run, read from the open file and checked against its seals.

        Raises
        ------
        ResultFileError     no output times are written yet; a seal does not match
        """
        return self._content.solution()

    def last_instant(self) -> Solution:
        """The solution at the last output time; errors as for `solution`."""
        return self._content.last_instant()

    def _check_open(self, what: str) -> None:
        if self._closed:
            raise ResultFileError(
                f"cannot {what} {self.path}: it is closed; continue it with ResultFile.resume"
            )

    @property
    def _content(self) -> ResultContent:
        self._check_open("read the run being written in")
        if self._writer is None:
            raise ResultFileError(f"{self.path} contains no output times yet; append some first")
        return ResultContent(self.path, self._writer.file)

    def finish(self) -> None:
        """Mark the run complete and close the file; ResultFileError if it is closed already."""
        self._check_open("finish")
        if self._writer is not None:
            self._check_in_place()
            with file_errors("write", self.path):
                self._writer.finish()
        else:
            write_whole(self.path, replace(self.header, complete=True), None)
        self.close()

    def close(self) -> None:
        """Close the file as it is, and release its lock."""
        self._closed = True
        try:
            if self._writer is not None:
                with file_errors("close", self.path):
                    self._writer.file.close()
                    self._writer = None
                    if self._is_in_place():
                        os.truncate(self.path, written_size(self.path))  # release the unused reserved space
        finally:
            self._lock.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _start(self, written: Solution) -> None:
        # The datasets must exist before single-writer mode begins: they are created with the first chunk.
        writer = write_whole(self.path, self.header, written)
        with file_errors("open", self.path):
            writer.go_on_in(open_single_writer(self.path))
            self._place = self.path.stat()
        self._writer = writer
        self.last_time = float(written.times[-1])

    def _is_in_place(self) -> bool:
        return self._place is not None and is_at(self._place, self.path)

    def _check_in_place(self) -> None:
        """Stop a run whose file was removed or replaced: its results would be lost."""
        if not self._is_in_place():
            raise ResultFileError(
                f"{self.path} was removed or replaced during the run that writes it: run the case "
                "again, in a folder that no other program changes"
            )

    def _check(self, arrays: Mapping[str, FloatArray], chunk: Solution) -> None:
        times = arrays["times"]
        if not len(times) or times[0] <= self.last_time or not (np.diff(times) > 0.0).all():
            seen = f"{times[0]:g} to {times[-1]:g}" if len(times) else "none"
            raise ResultFileError(
                f"cannot append to {self.path}: its times end at {self.last_time:g} and the new ones "
                f"({seen}) do not increase from there: append chunks in order of time"
            )
        if self._writer is not None:
            begun, given = self._writer.layout, layout_of_chunk(arrays, chunk)
            # A file may begin with chunks without engine state; the reverse is not allowed.
            there = dict(begun.arrays) | {
                f"engine_state/{key}": shape for key, shape in begun.engine_state.items()
            }
            here = dict(given.arrays) | {
                f"engine_state/{key}": shape
                for key, shape in given.engine_state.items()
                if key in begun.engine_state
            }
            changed = sorted(key for key in there.keys() | here.keys() if there.get(key) != here.get(key))
            if changed:
                raise ResultFileError(
                    f"cannot append to {self.path}: {changed[0]} has row shape {here.get(changed[0])}, but "
                    f"{there.get(changed[0])} in the file: write each system to its own file"
                )
        for path, array in arrays.items():
            if len(array) != len(times):
                raise ResultFileError(
                    f"cannot append to {self.path}: {path} has {len(array)} rows for {len(times)} times"
                )


def check_nothing_lost(path: Path) -> None:
    """Raise ResultFileError where a new result would replace an existing one; the message names it."""
    if not path.exists():
        return
    try:
        header = read_header(path)
    except ResultFileError as error:
        seen = f"it cannot be read as a result ({error})"
    else:
        if not header.n_times and not header.complete:
            return
        seen = "it contains a finished run" if header.complete else "it contains an interrupted run"
    raise ResultFileError(f"cannot write {path}: {seen}; give overwrite=True to replace it, or another path")


def check_same_run(path: Path, header: ResultHeader, case: str, inputs: Inputs) -> None:
    """Raise ResultFileError, naming the changes, unless a file belongs to the requested run."""
    if header.inputs or inputs:
        changed = changes(header.inputs, inputs) if header.inputs else "it does not list its inputs"
    else:
        changed = _first_difference(header.case, case)
    if changed:
        raise ResultFileError(
            f"cannot continue {path}: it contains another case ({changed}); "
            "give another path, or run the case with which the file was started"
        )


def write_solution(
    path: Path | str,
    solution: Solution,
    *,
    case: str,
    metadata: Metadata = MappingProxyType({}),
    inputs: Inputs = MappingProxyType({}),
) -> Path:
    """Write a finished simulation as a complete result file, atomically.

    Raises
    ------
    ResultFileError     the file cannot be written, or a run is writing it
    """
    header = ResultHeader(case, dict(metadata), complete=True, inputs=dict(inputs))
    with _locked(Path(path)):
        write_whole(Path(path), header, solution)
    return Path(path)


def write_errors(path: Path | str, solution: Solution) -> Path:
    """Write the file of a finished run again with its error statements.

    Raises
    ------
    ResultFileError     the file cannot be read or written, or a run is writing it
    """
    header = read_header(path)
    metadata = {**header.metadata, **errors_metadata(solution.errors)}
    return write_solution(path, solution, case=header.case, metadata=metadata, inputs=header.inputs)


def _locked(path: Path) -> ExclusiveLock:
    with file_errors("write", path):
        path.parent.mkdir(parents=True, exist_ok=True)
    return ExclusiveLock(path)


def _first_difference(stored: str, given: str) -> str:
    """The first difference between two texts, in words; empty where they are equal."""
    if stored == given:
        return ""
    pairs = zip_longest(stored.splitlines(), given.splitlines())
    for number, (there, here) in enumerate(pairs, start=1):
        if there != here:
            return f"line {number}: {there!r} in the file, {here!r} now"
    return "they differ in line ends"
