"""Seals of a result file: digests (SHA-256) of all that is read from it, chunk by chunk.

header          of the case, the metadata, the inputs and the layout
content[k]      of the arrays of chunk k and the engine's state at its end
row[k]          of the header's seal, k, the row of `commits` and content[k]
end             of the header's seal and all rows; zeros until the run is complete

Each part is hashed together with its name and shape, so that different files have different digests.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Protocol

import numpy as np

from supple.storage.solution_arrays import Array

SIZE = hashlib.sha256().digest_size
"""Bytes per seal."""

NO_END = bytes(SIZE)
"""Seal of the end until the run is complete."""


_BLOCK_BYTES = 2**24
"""Bytes of an array that are hashed at a time."""


class SeriesRows(Protocol):
    """64-bit numbers (t, ...): an array, or rows of a dataset, which are read when sliced."""

    @property
    def shape(self) -> tuple[int, ...]:
        """(t, ...)"""
        ...

    def __getitem__(self, rows: Any, /) -> Array: ...


def header_seal(texts: Mapping[str, str]) -> bytes:
    """Seal of the header."""
    return _digest(_whole(name, text.encode()) for name, text in texts.items())


def content_seal(arrays: Mapping[str, SeriesRows], engine_state: Mapping[str, Array]) -> bytes:
    """Seal of a chunk: the rows of its arrays, by path, and the engine's state at its end, by key."""
    parts: list[tuple[str, SeriesRows]] = [(f"array {path}", array) for path, array in sorted(arrays.items())]
    parts += [(f"state {key}", value) for key, value in sorted(engine_state.items())]
    return _digest(
        (f"{name} {rows.shape}", 8 * int(np.prod(rows.shape)), _blocks(rows)) for name, rows in parts
    )


def row_seal(header: bytes, number: int, row: Array, content: bytes) -> bytes:
    """Seal of a row of `commits`, with which a chunk becomes valid."""
    return _digest(
        [_whole("header", header), _whole(f"row {number}", row.tobytes()), _whole("content", content)]
    )


def end_seal(header: bytes, rows: Iterable[bytes]) -> bytes:
    """Seal of a complete run."""
    return _digest([_whole("header", header), _whole("rows", b"".join(rows))])


def _blocks(rows: SeriesRows) -> Iterator[memoryview]:
    """The bytes of the rows, some rows at a time."""
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
    """Digest of parts, each given by name, size and blocks."""
    digest = hashlib.sha256()
    for name, size, blocks in parts:
        digest.update(f"{name} {size}\n".encode())
        for block in blocks:
            digest.update(block)
    return digest.digest()
