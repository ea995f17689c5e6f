"""Seals of a result file: digests (SHA-256) of all that is read from it, chunk by chunk.

header          of the case, the metadata, the inputs and the layout
content[k]      of the arrays of chunk k and the engine's state at its end
row[k]          of the header's seal, k, the row of `commits` and content[k]
end             of the header's seal and all rows: a run that is complete has it, one that goes on has zeros

Each part is hashed with its name and shape before it, so that no two files share a digest.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping

import numpy as np

from supple.storage.solution_arrays import Array

SIZE = hashlib.sha256().digest_size
"""Bytes of a seal."""

NO_END = bytes(SIZE)
"""In place of the last seal while a run goes on."""


def header_seal(texts: Mapping[str, str]) -> bytes:
    """Of what a file says before its first chunk."""
    return _digest((name, text.encode()) for name, text in texts.items())


def content_seal(arrays: Mapping[str, Array], engine_state: Mapping[str, Array]) -> bytes:
    """Of the rows that a chunk adds to the arrays, by path, and the engine's state at its end, by key."""
    parts = [(f"array {path}", array) for path, array in sorted(arrays.items())]
    parts += [(f"state {key}", value) for key, value in sorted(engine_state.items())]
    return _digest((f"{name} {array.shape}", _bytes(array)) for name, array in parts)


def row_seal(header: bytes, number: int, row: Array, content: bytes) -> bytes:
    """Of the row of `commits` by which a chunk counts."""
    return _digest([("header", header), (f"row {number}", row.tobytes()), ("content", content)])


def end_seal(header: bytes, rows: Iterable[bytes]) -> bytes:
    """Of a complete run."""
    return _digest([("header", header), ("rows", b"".join(rows))])


def _bytes(array: Array) -> memoryview:
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8).data


def _digest(parts: Iterable[tuple[str, bytes | memoryview]]) -> bytes:
    digest = hashlib.sha256()
    for name, content in parts:
        digest.update(f"{name} {len(content)}\n".encode())
        digest.update(content)
    return digest.digest()
