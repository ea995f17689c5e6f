"""What an open result file holds, as far as its seals agree; `result_file` describes the format."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from supple.errors import ResultFileError
from supple.integrate.error_statement import ErrorStatement
from supple.integrate.solution import Solution, Statistics, concatenate
from supple.storage.column_measures import KEY
from supple.storage.file_errors import DAMAGE
from supple.storage.result_seals import (
    NO_END,
    SIZE,
    SeriesRows,
    content_seal,
    end_seal,
    header_seal,
    row_seal,
)
from supple.storage.run_inputs import Inputs
from supple.storage.solution_arrays import Array, from_arrays, statistics_from_rows, statistics_row

__all__ = ["DamagedResultError", "ResultHeader"]

FORMAT = "supple-result"
VERSION = 4

TEXTS = ("case", "metadata", "inputs", "layout")
"""Of the header, in the order of its seal."""

N_COLUMNS = 2 + len(statistics_row(Statistics()))
"""Of `commits`: first row, number of times, statistics."""

Metadata = Mapping[str, str | int | float | bool]

ERRORS = "errors"
"""Name among the metadata of what is known of the error of the run, as JSON."""


def errors_metadata(errors: Mapping[str, ErrorStatement]) -> Metadata:
    """Metadata that keep what is known of the error of a run; none where nobody looked."""
    return {ERRORS: json.dumps({name: each.plain() for name, each in errors.items()})} if errors else {}


def _errors(text: str) -> dict[str, ErrorStatement]:
    return {name: ErrorStatement.from_plain(numbers) for name, numbers in json.loads(text).items()}


class DamagedResultError(ResultFileError):
    """A result file whose bytes are not those that were written."""


@dataclass(frozen=True)
class ResultHeader:
    """What a result file says about itself: the case, its metadata, and how far the run has come.

    case : str          what is run, for the record
    inputs : Inputs     all that the motion depends on, by name
    """

    case: str
    metadata: Metadata
    complete: bool
    n_times: int
    statistics: Statistics
    inputs: Inputs = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True)
class Layout:
    """What the rows of a result file are of: row shapes by path, kinds of motion, the engine's state."""

    arrays: Mapping[str, tuple[int, ...]]
    kinds: Mapping[str, str]
    engine_state: Mapping[str, tuple[int, ...]]


@dataclass(frozen=True)
class _RowsOf:
    """Rows of a dataset from one to before another, read as they are sliced."""

    dataset: h5py.Dataset
    begin: int
    end: int

    @property
    def shape(self) -> tuple[int, ...]:
        return self.end - self.begin, *self.dataset.shape[1:]

    def __getitem__(self, rows: slice) -> Array:
        begin, end, _ = rows.indices(self.end - self.begin)
        return self.dataset[self.begin + begin : self.begin + end]


class ResultContent:
    """An open result file whose format and header have been checked.

    size : int      of the file, bytes: nothing in it can be longer, for nothing is compressed
    """

    def __init__(self, path: Path, file: h5py.File, size: int) -> None:
        self._path, self._file, self._size = path, file, size
        self._check_format()
        try:
            texts = {name: self._text(name) for name in TEXTS}
            self._seal = header_seal(texts)
            if self._bytes("seals/header").tobytes() != self._seal:
                raise ValueError("its case, metadata or inputs are not those that were written")
            self._texts = texts
            self._layout = layout_of(json.loads(texts["layout"]))
            self._rows, self._row_seals = self._read_rows()
            self._end = self._bytes("seals/end").tobytes()
            self._is_marked_complete = bool(self._checked("complete", np.dtype(np.int64), ())[()])
        except DAMAGE as error:
            raise damaged(path, error) from error

    @property
    def header(self) -> ResultHeader:
        """What the file says about itself, once all rows of `commits` are found sound."""
        broken = [number for number in range(len(self._rows)) if not self._is_row_sound(number)]
        if broken:
            raise self._chunks_damaged({number: "its row of commits" for number in broken})
        begins = np.concatenate([[0], np.cumsum(self._rows[:, 1])])
        if (begins[:-1] != self._rows[:, 0]).any():
            raise damaged(self._path, ValueError("its chunks do not follow one another"))
        complete = self._end != NO_END
        if complete and self._end != end_seal(self._seal, self._row_seals):
            raise damaged(self._path, ValueError("the seal of its end"))
        if self._is_marked_complete and not complete:
            raise damaged(self._path, ValueError("it calls itself complete and has no seal of its end"))
        return ResultHeader(
            case=self._texts["case"],
            metadata=MappingProxyType(json.loads(self._texts["metadata"])),
            complete=complete,
            n_times=int(begins[-1]),
            statistics=statistics_from_rows(self._rows[:, 2:]),
            inputs=MappingProxyType(json.loads(self._texts["inputs"])),
        )

    def solution(self) -> Solution:
        """All of it."""
        header = self.header
        self._check_not_empty()
        try:
            # At once where nothing is wrong, for reading chunk by chunk takes long.
            arrays, states = self._arrays(0, header.n_times), self._states()
            state: dict[str, Array] = {}
            for number, (begin, end) in enumerate(self._spans()):
                state = {key: own[number].copy() for key, own in states.items()}
                own_rows = {path: array[begin:end] for path, array in arrays.items()}
                self._check_content(number, own_rows, state)
        except DAMAGE as error:
            broken = dict(self._broken())
            raise (self._chunks_damaged(broken) if broken else error) from error
        solution = from_arrays(arrays, header.statistics, self._layout.kinds, state)
        solution = replace(solution, columns=json.loads(str(header.metadata.get(KEY, "{}"))))
        stated = header.metadata.get(ERRORS)
        return solution if stated is None else solution.with_errors(_errors(str(stated)))

    def last_instant(self) -> Solution:
        """The last output time."""
        _ = self.header
        self._check_not_empty()
        try:
            return self._chunk(len(self._rows) - 1, last_only=True)
        except DAMAGE as error:
            raise self._chunks_damaged({len(self._rows) - 1: str(error)}) from error

    def parts(self, rows: NDArray[np.int64], n_rows: int) -> Iterator[Solution]:
        """Some output times (k,), ascending, in parts of at most n_rows of the file.

        Each chunk is checked by its seal, block by block, before the first part that it is in.
        """
        header = self.header
        self._check_not_empty()
        unchecked = deque(enumerate(self._spans()))
        for start in range(0, header.n_times, n_rows):
            end = min(start + n_rows, header.n_times)
            chosen = rows[(rows >= start) & (rows < end)]
            if not chosen.size:
                continue
            while unchecked and unchecked[0][1][0] < end:
                number, span = unchecked.popleft()
                if span[1] > start:
                    self._check_sound(number, span)
            arrays = {path: array[chosen - start] for path, array in self._arrays(start, end).items()}
            yield from_arrays(arrays, header.statistics, self._layout.kinds)

    @property
    def row_bytes(self) -> int:
        """Of an output time."""
        return 8 * sum(int(np.prod(shape)) for shape in self._layout.arrays.values())

    @property
    def times(self) -> Array:
        """All output times, (t,); errors as of `solution`."""
        n_times = self.header.n_times
        self._check_not_empty()
        return self._checked("times", np.dtype(np.float64), (), rows=n_times)[:n_times]

    def _check_sound(self, number: int, span: tuple[int, int]) -> None:
        """DamagedResultError where a chunk is not what was written; read block by block."""
        try:
            rows = {
                path: _RowsOf(self._checked(path, np.dtype(np.float64), shape, rows=span[1]), *span)
                for path, shape in self._layout.arrays.items()
            }
            self._check_content(number, rows, self._state(number))
        except DAMAGE as error:
            raise self._chunks_damaged({number: str(error)}) from error

    def sound_part(self) -> Solution:
        """The chunks that are sound, in a row."""
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
            if _plain(attributes.get("format")) != FORMAT:
                raise not_ours(self._path)
            version = int(str(attributes.get("version", 0)))
        except DAMAGE as error:
            raise error if isinstance(error, ResultFileError) else damaged(self._path, error) from error
        if version != VERSION:
            raise ResultFileError(
                f"{self._path} has format version {version}, and this supple reads version {VERSION}: "
                "use the supple that wrote it, or run the case again"
            )

    def _check_not_empty(self) -> None:
        if not len(self._rows):
            raise ResultFileError(
                f"{self._path} holds no output times: its run ended before the first; run it again"
            )

    def _read_rows(self) -> tuple[Array, list[bytes]]:
        """Rows of `commits` with their seals; the last may be one that was being written, which is zero."""
        rows = self._checked("commits", np.dtype(np.float64), (N_COLUMNS,))[()]
        written = np.flatnonzero((rows != 0.0).any(axis=1))
        rows = rows[: written[-1] + 1 if len(written) else 0]
        seals = self._checked("seals/chunks", np.dtype(np.uint8), (2 * SIZE,))[: len(rows)]
        if len(seals) != len(rows):
            raise ValueError(f"{len(seals)} seals of {len(rows)} chunks")
        self._content_seals = [seal[:SIZE].tobytes() for seal in seals]
        return rows, [seal[SIZE:].tobytes() for seal in seals]

    def _is_row_sound(self, number: int) -> bool:
        sealed = row_seal(self._seal, number, self._rows[number], self._content_seals[number])
        return self._row_seals[number] == sealed

    def _spans(self) -> Iterator[tuple[int, int]]:
        for begin, n_times in self._rows[:, :2].astype(int).tolist():
            yield begin, begin + n_times

    def _check_content(
        self, number: int, arrays: Mapping[str, SeriesRows], state: Mapping[str, Array]
    ) -> None:
        if content_seal(arrays, state) != self._content_seals[number]:
            raise ValueError("its numbers")

    def _chunk(self, number: int, *, last_only: bool = False) -> Solution:
        """A chunk; ValueError, or whatever HDF5 raises, where it is damaged."""
        if not self._is_row_sound(number):
            raise ValueError("its row of commits")
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

    def _arrays(self, begin: int, end: int) -> dict[str, Array]:
        """Rows of all arrays, by path."""
        return {
            path: self._checked(path, np.dtype(np.float64), shape, rows=end)[begin:end]
            for path, shape in self._layout.arrays.items()
        }

    def _state(self, number: int) -> dict[str, Array]:
        """The engine's state at the end of a chunk."""
        return {
            key: self._checked(f"engine_state/{key}", np.dtype(np.float64), shape, rows=number + 1)[number]
            for key, shape in self._layout.engine_state.items()
        }

    def _states(self) -> dict[str, Array]:
        """The same at the ends of all chunks, one by row."""
        n = len(self._rows)
        return {
            key: self._checked(f"engine_state/{key}", np.dtype(np.float64), shape, rows=n)[:n]
            for key, shape in self._layout.engine_state.items()
        }

    def _text(self, name: str) -> str:
        found = dataset(self._file, name)
        if found.dtype.kind != "S" or found.shape:
            raise TypeError(f"{name} is not a text")
        self._check_room(found, 1)
        return bytes(found[()]).decode()

    def _bytes(self, name: str) -> np.ndarray:
        return np.asarray(self._checked(name, np.dtype(np.uint8), (), rows=SIZE)[()])

    def _checked(
        self, name: str, kind: np.dtype, row_shape: tuple[int, ...], rows: int | None = None
    ) -> h5py.Dataset:
        """The dataset of that name, whose rows are of the kind and shape wanted, and fit into the file."""
        found = dataset(self._file, name)
        shape = found.shape[1:] if found.ndim else ()
        if found.dtype != kind or shape != row_shape:
            raise TypeError(f"{name} has rows of {found.dtype} {shape}; {kind} {row_shape} are expected")
        n_rows = found.shape[0] if found.ndim else 1
        if rows is not None and n_rows < rows:
            raise ValueError(f"{name} has {n_rows} rows and {rows} are needed")
        self._check_room(found, n_rows if rows is None else rows)
        return found

    def _check_room(self, found: h5py.Dataset, rows: int) -> None:
        """Before memory is taken for it: no array, and no block of one, is longer than the file."""
        itemsize = found.dtype.itemsize
        claims = [rows * int(np.prod(found.shape[1:], dtype=object)) * itemsize]
        if claims[0] and found.chunks is not None:
            claims.append(int(np.prod(found.chunks, dtype=object)) * itemsize)
        if max(claims) > self._size:
            raise ValueError(
                f"{found.name} claims {max(claims)} bytes, and the file has {self._size}, which is the limit"
            )


def layout_of(words: Mapping[str, Mapping[str, Any]]) -> Layout:
    """The layout in the header of a file; nothing before the first chunk."""
    return Layout(
        arrays={path: tuple(shape) for path, shape in words.get("arrays", {}).items()},
        kinds=dict(words.get("kinds", {})),
        engine_state={key: tuple(shape) for key, shape in words.get("engine_state", {}).items()},
    )


def dataset(file: h5py.File, name: str) -> h5py.Dataset:
    """The dataset of that name; KeyError where there is none."""
    found = file[name]
    if not isinstance(found, h5py.Dataset):
        raise KeyError(f"{name} is not a dataset")
    return found


def _plain(text: Any) -> Any:
    return text.decode(errors="replace") if isinstance(text, bytes) else text


def not_ours(path: Path) -> ResultFileError:
    """The error of an HDF5 file of another program."""
    return ResultFileError(f"{path} is an HDF5 file but not a result of supple: check the path")


def damaged(path: Path, error: Exception) -> DamagedResultError:
    """The error of a file in which something is wrong."""
    remedy = "copy it again, or run the case again" if "truncated" in str(error) else "run the case again"
    return DamagedResultError(f"{path} is damaged ({error}): {remedy}")
