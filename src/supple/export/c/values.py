"""Arrays of a traced program in C: expressions for their elements, stored or computed where they are read."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import DTypeLike

Index = Sequence[str]
"""One C expression per axis; "0" where the axis has one entry."""


@dataclass(eq=False)
class Buffer:
    """Storage of `size` numbers: a local array, a scalar variable, or a table of constants."""

    number: int
    dtype: np.dtype
    size: int
    is_scalar: bool = False
    name: str | None = None
    """Name in C, if known from the start; other buffers are named when their block is complete"""

    @property
    def text(self) -> str:
        """Name in C, or a placeholder."""
        return self.name or f"@{self.number}@"


@dataclass(eq=False)
class Value:
    """An array of known shape, read element by element."""

    shape: tuple[int, ...]
    dtype: np.dtype

    @property
    def size(self) -> int:
        """Number of elements."""
        return math.prod(self.shape)

    def at(self, index: Index) -> str:
        """The element at an index, as a C expression."""
        raise NotImplementedError

    def flat(self, number: str) -> str | None:
        """The element with a row-major number; None if there is no simple expression for it."""
        raise NotImplementedError


@dataclass(eq=False)
class UniformValue(Value):
    """An array of equal constants."""

    number: float

    def at(self, index: Index) -> str:  # noqa: ARG002
        """The number."""
        return literal(self.number, self.dtype)

    def flat(self, number: str) -> str | None:  # noqa: ARG002
        """The number."""
        return literal(self.number, self.dtype)


@dataclass(eq=False)
class BufferView(Value):
    """Elements of a buffer at `offset + shift + strides . index`; `shift` is known only at run time."""

    buffer: Buffer
    strides: tuple[int, ...]
    offset: int = 0
    shift: str = ""
    known: np.ndarray | None = None
    """The elements, if they are constants"""

    @cached_property
    def is_contiguous(self) -> bool:
        """Whether the elements are contiguous, in row-major order."""
        expected = row_major(self.shape)
        return all(n == 1 or a == b for n, a, b in zip(self.shape, self.strides, expected, strict=True))

    def at(self, index: Index) -> str:
        """An element of the buffer."""
        if self.buffer.is_scalar:
            return self.buffer.text
        place = self.offset
        terms = [self.shift] if self.shift else []
        for i, stride, n in zip(index, self.strides, self.shape, strict=True):
            if n == 1 or stride == 0:
                continue
            if i.isdigit():
                place += stride * int(i)
            else:
                terms.append(i if stride == 1 else f"{stride} * {i}")
        if place or not terms:
            terms.append(str(place))
        return f"{self.buffer.text}[{' + '.join(terms)}]"

    def flat(self, number: str) -> str | None:
        """An element of the buffer; None if the view is not contiguous."""
        if self.size == 1:
            return self.at(("0",) * len(self.shape))
        if not self.is_contiguous:
            return None
        return BufferView((self.size,), self.dtype, self.buffer, (1,), self.offset, self.shift).at((number,))


@dataclass(eq=False)
class Computed(Value):
    """An array whose elements are computed where they are read."""

    by_index: Callable[[Index], str]
    by_number: Callable[[str], str | None] = lambda _: None

    def at(self, index: Index) -> str:
        """The C expression of an element."""
        return self.by_index(index)

    def flat(self, number: str) -> str | None:
        """The C expression of an element; None if an operand is not contiguous."""
        return self.by_number(number)


def row_major(shape: Sequence[int]) -> tuple[int, ...]:
    """Strides of an array without gaps, in elements."""
    return tuple(math.prod(shape[axis + 1 :]) for axis in range(len(shape)))


def joined(*terms: str) -> str:
    """The sum of C expressions, without empty ones."""
    return " + ".join(term for term in terms if term)


def c_type(dtype: DTypeLike) -> str:
    """The C type of the elements of an array."""
    kind = np.dtype(dtype)
    return "bool" if kind.kind == "b" else f"{kind.name}_t" if kind.kind in "iu" else "double"


def _whole(number: int) -> str:
    if number == -(2**63):  # 2^63 is no number of C, a minus sign before it is an operation
        return f"({number + 1} - 1)"
    return f"({number})" if number < 0 else str(number)


def literal(number: float, dtype: DTypeLike) -> str:
    """A number in C, with enough digits to be read back exactly."""
    kind = np.dtype(dtype).kind
    if kind == "b":
        return "1" if number else "0"
    if kind in "iu":
        return _whole(int(number)) + ("u" if kind == "u" else "")
    if math.isnan(number):
        return "((double)NAN)"
    if math.isinf(number):
        return "((double)INFINITY)" if number > 0 else "(-(double)INFINITY)"
    text = repr(float(number))
    text = text if any(c in text for c in ".e") else text + ".0"
    return f"({text})" if text.startswith("-") else text
