"""File seal: a digest behind the last byte of a file, which detects damage before anything is parsed.

HDF5 files may be followed by other bytes. A file that another program changes loses its seal.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

_MARK = b"supple-sha256:"
_LENGTH = len(_MARK) + 2 * hashlib.sha256().digest_size
_BLOCK = 1 << 20


def sealed(content: bytes) -> bytes:
    """The content followed by its seal."""
    return content + _MARK + hashlib.sha256(content).hexdigest().encode()


def unsealed(path: Path) -> bytes:
    """The content of a sealed file; ValueError where the seal is missing or does not match."""
    found = path.read_bytes()
    content = found[:-_LENGTH]
    if sealed(content) != found:
        raise ValueError("its bytes have changed since it was written")
    return content


def seal_of(path: Path) -> bytes:
    """The last bytes of a file: sealed files with equal seals have equal contents."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - _LENGTH))
        return file.read()


def seal_matches(path: Path) -> bool | None:
    """Whether the seal of a file matches its content; None where it has no seal."""
    seal = seal_of(path)
    if not seal.startswith(_MARK):
        return None
    found, left = hashlib.sha256(), path.stat().st_size - _LENGTH
    with path.open("rb") as file:
        while left and (block := file.read(min(left, _BLOCK))):
            found.update(block)
            left -= len(block)
    return seal == _MARK + found.hexdigest().encode()
