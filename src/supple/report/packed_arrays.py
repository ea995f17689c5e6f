"""Arrays of a page as one compressed text, with the layout of each."""

from __future__ import annotations

import base64
import zlib
from typing import Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from supple.errors import ModelError

Kind = Literal["f4", "f8", "i2", "i4"]

_LEVEL = 6
"""Compression level of zlib: level 9 takes four times as long for a file that is 1 % smaller."""


class Packing(TypedDict):
    """Position of an array in the block, and its type, as JSON values for the script."""

    start: int
    shape: list[int]
    kind: Kind


class PackedArrays:
    """Arrays one after the other, little-endian.

    An array is written byte plane by byte plane: the first bytes of all numbers, then the second bytes, and
    so on. Integers are written as differences along the last axis, modulo their range. Both make slowly
    varying numbers repetitive, for better compression.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, values: ArrayLike, kind: Kind) -> Packing:
        """Append an array and return its layout; ModelError for integers out of the range of `kind`."""
        array = np.ascontiguousarray(values, dtype=f"<{kind}")
        if kind[0] == "i" and not np.array_equal(array, values):
            raise ModelError(
                f"cannot write whole numbers up to {np.abs(values).max():.0f} in {8 * array.itemsize} bits: "
                "use smaller node ids"
            )
        numbers = array
        if kind[0] == "i" and array.size:
            numbers = array.copy()
            numbers[..., 1:] -= array[..., :-1]
        planes = numbers.reshape(-1, 1).view(np.uint8).T
        packing = Packing(start=self._size, shape=list(array.shape), kind=kind)
        self._parts.append(planes.tobytes())
        self._size += array.nbytes
        return packing

    def text(self) -> str:
        """All arrays, deflated (zlib), in base 64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), _LEVEL)).decode("ascii")


def unpacked(text: str, packing: Packing) -> np.ndarray:
    """One array of the text from `PackedArrays.text`, unpacked as by the script of the page."""
    block = np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype=np.uint8)
    start, shape, kind = packing["start"], packing["shape"], packing["kind"]
    number, width = int(np.prod(shape)), np.dtype(kind).itemsize
    planes = block[start : start + number * width].reshape(width, number)
    array = np.ascontiguousarray(planes.T).view(f"<{kind}").reshape(shape)
    return array if kind[0] == "f" or not number else np.cumsum(array, axis=-1, dtype=array.dtype)
