"""Seals of a result file: digests (SHA-256) of all that is read from it, chunk by chunk.

header          of the case, the metadata, the inputs and the layout
content[k]      of the arrays of chunk k and the engine's state at its end
row[k]          of the header's seal, k, the row of `commits` and content[k]
end             of the header's seal and all rows: a run that is complete has it, one that goes on has zeros

Each part is hashed with its name and shape before it, so that no two files share a digest.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Protocol

import numpy as np

from supple.storage.solution_arrays import Array

SIZE = hashlib.sha256().digest_size
"""Bytes of a seal."""

NO_END = bytes(SIZE)
"""In place of the last seal while a run goes on."""


_BLOCK_BYTES = 2**24
"""Of an array, hashed at a time."""


class SeriesRows(Protocol):
    """64-bit numbers (t, ...): an array, or rows of a dataset, which are read as they are sliced."""

    @property
    def shape(self) -> tuple[int, ...]:
        """(t, ...)"""
        ...

    def __getitem__(self, rows: Any, /) -> Array: ...


def header_seal(texts: Mapping[str, str]) -> bytes:
    """Of what a file says before its first chunk."""
    return _digest(_whole(name, text.encode()) for name, text in texts.items())


def content_seal(arrays: Mapping[str, SeriesRows], engine_state: Mapping[str, Array]) -> bytes:
    """Of the rows that a chunk adds to the arrays, by path, and the engine's state at its end, by key."""
    parts: list[tuple[str, SeriesRows]] = [(f"array {path}", array) for path, array in sorted(arrays.items())]
    parts += [(f"state {key}", value) for key, value in sorted(engine_state.items())]
    return _digest(
        (f"{name} {rows.shape}", 8 * int(np.prod(rows.shape)), _blocks(rows)) for name, rows in parts
    )


def row_seal(header: bytes, number: int, row: Array, content: bytes) -> bytes:
    """Of the row of `commits` by which a chunk counts."""
    return _digest(
        [_whole("header", header), _whole(f"row {number}", row.tobytes()), _whole("content", content)]
    )


def end_seal(header: bytes, rows: Iterable[bytes]) -> bytes:
    """Of a complete run."""
    return _digest([_whole("header", header), _whole("rows", b"".join(rows))])


def _blocks(rows: SeriesRows) -> Iterator[memoryview]:
    """The bytes of the rows, some rows after the others."""
    if not rows.shape:
        yield _bytes(rows[()])
        return
    n_rows = max(1, _BLOCK_BYTES // (8 * max(1, int(np.prod(rows.shape[1:])))))
    for start in range(0, rows.shape[0], n_rows):
        yield _bytes(rows[start : start + n_rows])


def _bytes(array: Array) -> memoryview:
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8).data


def _whole(name: str, content: bytes) -> tuple[str, int, tuple[bytes]]:
    return name, len(content), (content,)


def _digest(parts: Iterable[tuple[str, int, Iterable[bytes | memoryview]]]) -> bytes:
    """Of parts, each by its name, size and blocks."""
    digest = hashlib.sha256()
    for name, size, blocks in parts:
        digest.update(f"{name} {size}\n".encode())
        for block in blocks:
            digest.update(block)
    return digest.digest()
