"""Content of an open result file with checked seals; `result_file` describes the format."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.errors import ResultFileError
from supple.integrate.error_statement import ErrorStatement
from supple.integrate.solution import Solution, Statistics, concatenate
from supple.storage.file_errors import DAMAGE
from supple.storage.hdf5_record import check_fits, dataset
from supple.storage.result_seals import (
    NO_END,
    SIZE,
    Rows,
    content_seal,
    end_seal,
    header_seal,
    row_seal,
)
from supple.storage.run_inputs import Inputs
from supple.storage.solution_arrays import from_arrays, statistics_from_rows, statistics_row

__all__ = ["DamagedResultError", "ResultHeader"]

FORMAT = "supple-result"
VERSION = 4

TEXTS = ("case", "metadata", "inputs", "layout")
"""Texts of the header, in the order of its seal."""

N_COLUMNS = 2 + len(statistics_row(Statistics()))
"""Columns of `commits`: first row, number of times, statistics."""

Metadata = Mapping[str, str | int | float | bool]

COLUMNS = "columns"
"""Name of the measures of the bases in the metadata, as JSON."""

ERRORS = "errors"
"""Name of the error statements in the metadata, as JSON."""


def errors_metadata(errors: Mapping[str, ErrorStatement]) -> Metadata:
    """Metadata that contain the error statements of a run; empty without statements."""
    return {ERRORS: json.dumps({name: each.plain() for name, each in errors.items()})} if errors else {}


_BLOCK_BYTES = 2**24
"""Bytes of an array that are read and hashed at a time."""


class DamagedResultError(ResultFileError):
    """A result file whose bytes have changed since it was written."""


@dataclass(frozen=True)
class ResultHeader:
    """Header of a result file: the case, its metadata, and the progress of the run.

    case : str          text of the case that was run
    inputs : Inputs     everything the motion depends on, by name
    """

    case: str
    metadata: Metadata
    complete: bool = False
    n_times: int = 0
    statistics: Statistics = field(default_factory=Statistics)
    inputs: Inputs = field(default_factory=lambda: MappingProxyType({}))

    @property
    def columns(self) -> Mapping[str, Mapping[str, list[float]]]:
        """By elastic body: numbers that identify the columns of its basis, see `recorded_columns`."""
        return json.loads(str(self.metadata.get(COLUMNS, "{}")))


@dataclass(frozen=True)
class Layout:
    """Layout of the rows of a result file: row shapes by path, kinds of motion, state of the engine."""

    arrays: Mapping[str, tuple[int, ...]]
    kinds: Mapping[str, str]
    engine_state: Mapping[str, tuple[int, ...]]


class ResultContent:
    """An open result file with checked format and header."""

    def __init__(self, path: Path, file: h5py.File) -> None:
        self._path, self._file = path, file
        self._check_format()
        try:
            texts = {name: self._text(name) for name in TEXTS}
            self._seal = header_seal(texts)
            if self._read_seal("seals/header") != self._seal:
                raise ValueError("its case, metadata or inputs have changed since it was written")
            self._texts = texts
            self._layout = layout_of(json.loads(texts["layout"]))
            self._rows, self._row_seals = self._read_rows()
            self._end = self._read_seal("seals/end")
            self._is_marked_complete = bool(self._checked("complete", (), np.int64)[()])
        except DAMAGE as error:
            raise damaged(path, error) from error

    @property
    def header(self) -> ResultHeader:
        """The header, after a check of all rows of `commits`."""
        broken = [number for number in range(len(self._rows)) if not self._is_row_sound(number)]
        if broken:
            raise self._chunks_damaged(
                {number: "its entry in `commits` has changed since it was written" for number in broken}
            )
        begins = np.concatenate([[0], np.cumsum(self._rows[:, 1])])
        if (begins[:-1] != self._rows[:, 0]).any():
            raise damaged(self._path, ValueError("its chunks are not contiguous"))
        complete = self._end != NO_END
        if complete and self._end != end_seal(self._seal, self._row_seals):
            raise damaged(self._path, ValueError("the seal of the complete run does not match"))
        if self._is_marked_complete and not complete:
            raise damaged(self._path, ValueError("it is marked complete but has no seal of its end"))
        return ResultHeader(
            case=self._texts["case"],
            metadata=MappingProxyType(json.loads(self._texts["metadata"])),
            complete=complete,
            n_times=int(begins[-1]),
            statistics=statistics_from_rows(self._rows[:, 2:]),
            inputs=MappingProxyType(json.loads(self._texts["inputs"])),
        )

    def solution(self) -> Solution:
        """The whole solution."""
        header = self.header
        self._check_not_empty()
        try:
            # Read at once where nothing is damaged, because reading chunk by chunk is slow.
            arrays, states = self._arrays(0, header.n_times), self._states(0, len(self._rows))
            state: dict[str, FloatArray] = {}
            for number, span in enumerate(self._spans()):
                state = {key: own[number].copy() for key, own in states.items()}
                self._check_content(
                    number, {path: array[slice(*span)] for path, array in arrays.items()}, state
                )
        except DAMAGE as error:
            broken = dict(self._broken())
            raise (self._chunks_damaged(broken) if broken else error) from error
        solution = from_arrays(arrays, header.statistics, self._layout.kinds, state)
        solution = replace(solution, columns=header.columns)
        errors = json.loads(str(header.metadata.get(ERRORS, "{}"))).items()
        return solution.with_errors({name: ErrorStatement.from_plain(numbers) for name, numbers in errors})

    def last_instant(self) -> Solution:
        """The solution at the last output time."""
        _ = self.header
        self._check_not_empty()
        try:
            return self._chunk(len(self._rows) - 1, last_only=True)
        except DAMAGE as error:
            raise self._chunks_damaged({len(self._rows) - 1: str(error)}) from error

    def part(self, rows: NDArray[np.int64], checked: set[int]) -> Solution:
        """The solution at some output times (k,), ascending; k at least one.

        Chunks of these times are checked by their seals, block by block, unless `checked` has their numbers;
        it receives them.
        """
        header = self.header
        begin, end = int(rows[0]), int(rows[-1]) + 1
        for number, span in enumerate(self._spans()):
            if number not in checked and span[0] < end and span[1] > begin:
                self._check_sound(number, span)
                checked.add(number)
        arrays = {path: array[rows - begin] for path, array in self._arrays(begin, end).items()}
        return from_arrays(arrays, header.statistics, self._layout.kinds)

    @property
    def row_bytes(self) -> int:
        """Number of bytes per output time."""
        return 8 * sum(math.prod(shape) for shape in self._layout.arrays.values())

    @property
    def times(self) -> FloatArray:
        """All output times, (t,); errors as for `solution`."""
        n_times = self.header.n_times
        self._check_not_empty()
        return self._checked("times", (), rows=n_times)[:n_times]

    def _check_sound(self, number: int, span: tuple[int, int]) -> None:
        """Check the seal of a chunk, block by block; DamagedResultError if it does not match."""
        try:
            rows = {
                path: ((span[1] - span[0], *shape), self._blocks(path, shape, *span))
                for path, shape in self._layout.arrays.items()
            }
            self._check_seal(number, rows, self._state(number))
        except DAMAGE as error:
            raise self._chunks_damaged({number: str(error)}) from error

    def _blocks(self, path: str, shape: tuple[int, ...], begin: int, end: int) -> Iterator[FloatArray]:
        """The rows of an array in a range, some at a time."""
        found = self._checked(path, shape, rows=end)
        n_rows = max(1, _BLOCK_BYTES // (8 * max(1, math.prod(shape))))
        for start in range(begin, end, n_rows):
            yield found[start : min(start + n_rows, end)]

    def sound_part(self) -> Solution:
        """The undamaged chunks, one after the other."""
        self._check_not_empty()
        broken = dict(self._broken())
        sound = [self._chunk(number) for number in range(len(self._rows)) if number not in broken]
        if not sound:
            raise self._chunks_damaged(broken)
        whole = concatenate(sound)
        return replace(whole, stopped=str(self._chunks_damaged(broken))) if broken else whole

    def _check_format(self) -> None:
        try:
            attributes = self._file.attrs
            if attributes.get("format") not in (FORMAT, FORMAT.encode()):
                raise not_ours(self._path)
            version = int(str(attributes.get("version", 0)))
        except DAMAGE as error:
            raise error if isinstance(error, ResultFileError) else damaged(self._path, error) from error
        if version != VERSION:
            raise ResultFileError(
                f"{self._path} has format version {version}, and this version of supple reads {VERSION}: "
                "use the version that wrote it, or run the case again"
            )

    def _check_not_empty(self) -> None:
        if not len(self._rows):
            raise ResultFileError(
                f"{self._path} contains no output times: its run ended before the first; run it again"
            )

    def _read_rows(self) -> tuple[FloatArray, list[bytes]]:
        """Rows of `commits` with their seals; an unfinished last row is zero."""
        rows = self._checked("commits", (N_COLUMNS,))[()]
        written = np.flatnonzero((rows != 0.0).any(axis=1))
        rows = rows[: written[-1] + 1 if len(written) else 0]
        seals = self._checked("seals/chunks", (2 * SIZE,), np.uint8)[: len(rows)]
        if len(seals) != len(rows):
            raise ValueError(f"{len(seals)} seals for {len(rows)} chunks")
        self._content_seals = [seal[:SIZE].tobytes() for seal in seals]
        return rows, [seal[SIZE:].tobytes() for seal in seals]

    def _is_row_sound(self, number: int) -> bool:
        sealed = row_seal(self._seal, number, self._rows[number], self._content_seals[number])
        return self._row_seals[number] == sealed

    def _spans(self) -> Iterator[tuple[int, int]]:
        for begin, n_times in self._rows[:, :2].astype(int).tolist():
            yield begin, begin + n_times

    def _check_content(
        self, number: int, arrays: Mapping[str, FloatArray], state: Mapping[str, FloatArray]
    ) -> None:
        self._check_seal(number, {path: (own.shape, [own]) for path, own in arrays.items()}, state)

    def _check_seal(self, number: int, rows: Mapping[str, Rows], state: Mapping[str, FloatArray]) -> None:
        if content_seal(rows, state) != self._content_seals[number]:
            raise ValueError("its numbers have changed")

    def _chunk(self, number: int, *, last_only: bool = False) -> Solution:
        """A chunk; ValueError, or an exception of HDF5, where it is damaged."""
        if not self._is_row_sound(number):
            raise ValueError("its entry in `commits` has changed since it was written")
        begin, n_times = self._rows[number, :2].astype(int)
        arrays = self._arrays(begin, begin + n_times)
        state = self._state(number)
        self._check_content(number, arrays, state)
        if last_only:
            arrays = {path: array[-1:].copy() for path, array in arrays.items()}
        statistics = statistics_from_rows(
            self._rows[: number + 1, 2:] if last_only else self._rows[[number], 2:]
        )
        return from_arrays(arrays, statistics, self._layout.kinds, state)

    def _broken(self) -> Iterator[tuple[int, str]]:
        for number in range(len(self._rows)):
            try:
                self._chunk(number)
            except DAMAGE as error:
                yield number, str(error)

    def _chunks_damaged(self, broken: Mapping[int, str]) -> DamagedResultError:
        named = [f"chunk {number + 1} of {len(self._rows)}: {why}" for number, why in broken.items()]
        more = f" and {len(named) - 3} more" if len(named) > 3 else ""
        rest = "the rest can be read (read_sound_part), or " if len(broken) < len(self._rows) else ""
        return DamagedResultError(
            f"{self._path} is damaged ({'; '.join(named[:3])}{more}): {rest}run the case again"
        )

    def _arrays(self, begin: int, end: int) -> dict[str, FloatArray]:
        """A range of rows of all arrays, by path."""
        return {
            path: self._checked(path, shape, rows=end)[begin:end]
            for path, shape in self._layout.arrays.items()
        }

    def _states(self, begin: int, end: int) -> dict[str, FloatArray]:
        """The states of the engine at the ends of a range of chunks, one per row."""
        return {
            key: self._checked(f"engine_state/{key}", shape, rows=end)[begin:end]
            for key, shape in self._layout.engine_state.items()
        }

    def _state(self, number: int) -> dict[str, FloatArray]:
        return {key: own[0] for key, own in self._states(number, number + 1).items()}

    def _text(self, name: str) -> str:
        found = dataset(self._file, name)
        if found.dtype.kind != "S" or found.shape:
            raise TypeError(f"{name} is not a text")
        check_fits(found)
        return bytes(found[()]).decode()

    def _read_seal(self, name: str) -> bytes:
        return self._checked(name, (), np.uint8)[()].tobytes()

    def _checked(
        self, name: str, row_shape: tuple[int, ...], kind: type = np.float64, rows: int | None = None
    ) -> h5py.Dataset:
        """The dataset with that name, with the expected type and shape of rows, not larger than the file."""
        found = dataset(self._file, name)
        shape = found.shape[1:] if found.ndim else ()
        if found.dtype != kind or shape != row_shape:
            raise TypeError(
                f"{name} has rows of {found.dtype} {shape} instead of {np.dtype(kind)} {row_shape}"
            )
        n_rows = found.shape[0] if found.ndim else 1
        if rows is not None and n_rows < rows:
            raise ValueError(f"{name} has {n_rows} rows instead of {rows}")
        check_fits(found, rows)
        return found


def layout_of(words: Any) -> Layout:
    """The layout in the header of a file; empty before the first chunk."""
    return Layout(
        arrays={path: tuple(shape) for path, shape in words.get("arrays", {}).items()},
        kinds=dict(words.get("kinds", {})),
        engine_state={key: tuple(shape) for key, shape in words.get("engine_state", {}).items()},
    )


def not_ours(path: Path) -> ResultFileError:
    """The error for an HDF5 file of another program."""
    return ResultFileError(f"{path} is an HDF5 file but not a result of supple: check the path")


def damaged(path: Path, error: Exception) -> DamagedResultError:
    """The error for a damaged file."""
    remedy = "copy it again, or run the case again" if "truncated" in str(error) else "run the case again"
    return DamagedResultError(f"{path} is damaged ({error}): {remedy}")
