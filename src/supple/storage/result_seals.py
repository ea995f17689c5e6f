"""Seals of a result file: digests (SHA-256) of all that is read from it, chunk by chunk.

header          of the case, the metadata, the inputs and the layout
content[k]      of the arrays of chunk k and the engine's state at its end
row[k]          of the header's seal, k, the row of `commits` and content[k]
end             of the header's seal and all rows; zeros until the run is complete

Each part is hashed together with its name and shape, so that different files have different digests.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping

import numpy as np

from supple.arrays import FloatArray

SIZE = hashlib.sha256().digest_size
"""Bytes per seal."""

NO_END = bytes(SIZE)
"""Seal of the end until the run is complete."""

Rows = tuple[tuple[int, ...], Iterable[FloatArray]]
"""Shape (t, ...) of rows of 64-bit numbers, and the rows, some at a time."""


def header_seal(texts: Mapping[str, str]) -> bytes:
    """Seal of the header."""
    return _digest(_whole(name, text.encode()) for name, text in texts.items())


def content_seal(arrays: Mapping[str, Rows], engine_state: Mapping[str, FloatArray]) -> bytes:
    """Seal of a chunk: the rows of its arrays, by path, and the engine's state at its end, by key."""
    parts = [(f"array {path}", *rows) for path, rows in sorted(arrays.items())]
    parts += [(f"state {key}", value.shape, [value]) for key, value in sorted(engine_state.items())]
    return _digest(
        (f"{name} {shape}", 8 * math.prod(shape), map(_bytes, blocks)) for name, shape, blocks in parts
    )


def row_seal(header: bytes, number: int, row: FloatArray, content: bytes) -> bytes:
    """Seal of a row of `commits`, with which a chunk becomes valid."""
    return _digest(
        [_whole("header", header), _whole(f"row {number}", row.tobytes()), _whole("content", content)]
    )


def end_seal(header: bytes, rows: Iterable[bytes]) -> bytes:
    """Seal of a complete run."""
    return _digest([_whole("header", header), _whole("rows", b"".join(rows))])


def _bytes(array: FloatArray) -> memoryview:
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
