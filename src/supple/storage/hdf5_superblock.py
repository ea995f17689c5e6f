"""Superblock: the first bytes of an HDF5 file, changed while reading so that the file opens at once.

A run in progress, or a killed one, leaves its file marked as being written. HDF5 opens such a file in a mode
in which it reads damaged parts repeatedly, for minutes. Here the mark is removed from the bytes passed to
HDF5, not from the file, and damage is reported at once.

Version 3 (HDF5 File Format Specification, II.A): signature (8), version, sizes of addresses and lengths,
mark; then base, extension, end of file and root group (8 each), and a checksum (4, Jenkins' lookup3) of all.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_VERSION = 3
_FORM = struct.Struct("<8s4B4Q")
_LENGTH = _FORM.size + 4
_MASK = 0xFFFFFFFF


_MARK, _END = 4, 7  # indices of the fields


def is_current_hdf5(path: Path) -> bool:
    """Whether a file starts with an HDF5 superblock of version 3, as result files do."""
    with path.open("rb") as file:
        return file.read(9) == _SIGNATURE + bytes([_VERSION])


@contextmanager
def open_unmarked(path: Path) -> Iterator[h5py.File]:
    """The file, opened for reading as if no process were writing it.

    Raises
    ------
    ValueError      its first bytes are damaged, or it is shorter than its superblock states
    OSError         other errors of HDF5
    """
    with _UnmarkedFile(path) as file, h5py.File(file, "r", driver="fileobj") as unmarked:
        yield unmarked


def is_marked(path: Path) -> bool:
    """Whether a file of version 3 is marked as being written: a run is in progress, or was killed."""
    return _fields(path)[_MARK] != 0


def written_size(path: Path) -> int:
    """Bytes of a file of version 3 in use by HDF5; more bytes may be reserved behind them."""
    return _fields(path)[_END]


def _fields(path: Path) -> tuple[Any, ...]:
    with path.open("rb") as file:
        return _FORM.unpack(file.read(_FORM.size))


class _UnmarkedFile(io.BufferedReader):
    """A file whose first bytes are replaced; reading beyond its end is an error."""

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))
        self._first = _without_mark(self)

    def readinto(self, buffer: WriteableBuffer, /) -> int:
        """The bytes of the file with the first ones replaced; OSError where it is truncated."""
        begin, wanted = self.tell(), memoryview(buffer).nbytes
        if super().readinto(buffer) < wanted:
            raise OSError(f"truncated: {wanted} bytes at {begin} are missing")
        first = self._first[begin : begin + wanted]
        memoryview(buffer).cast("B")[: len(first)] = first
        return wanted


def _without_mark(file: io.BufferedReader) -> bytes:
    """The first bytes of a file, without the mark, with the actual length; error if damaged or truncated."""
    first = file.read(_LENGTH)
    size = file.seek(0, io.SEEK_END)
    if len(first) < _LENGTH:
        raise ValueError("the file is truncated")
    signature, version, offsets, lengths, _, base, extension, end, root = _FORM.unpack(first[: _FORM.size])
    if int.from_bytes(first[_FORM.size :], "little") != lookup3(first[: _FORM.size]):
        raise ValueError("the checksum of its first bytes does not match")
    if end > size:
        raise ValueError(f"the file is truncated: {size} of {end} bytes are present")
    plain = _FORM.pack(signature, version, offsets, lengths, 0, base, extension, size, root)
    return plain + lookup3(plain).to_bytes(4, "little")


def lookup3(data: bytes) -> int:
    """Bob Jenkins' hash `hashlittle` (2006) of some bytes with initial value 0, 32 bits."""
    a = b = c = (0xDEADBEEF + len(data)) & _MASK
    if not data:
        return c
    padded = data + bytes(-len(data) % 12)
    triples = list(struct.iter_unpack("<3I", padded))
    for x, y, z in triples[:-1]:
        a, b, c = (a + x) & _MASK, (b + y) & _MASK, (c + z) & _MASK
        for shift in (4, 6, 8, 16, 19, 4):
            a = ((a - c) & _MASK) ^ _rotated(c, shift)
            c = (c + b) & _MASK
            a, b, c = b, c, a
    x, y, z = triples[-1]
    a, b, c = (a + x) & _MASK, (b + y) & _MASK, (c + z) & _MASK
    for shift in (14, 11, 25, 16, 4, 14, 24):
        c = ((c ^ b) - _rotated(b, shift)) & _MASK
        a, b, c = b, c, a
    # Seven rotations of the three numbers leave the last one written in b.
    return b


def _rotated(x: int, k: int) -> int:
    return ((x << k) | (x >> (32 - k))) & _MASK
