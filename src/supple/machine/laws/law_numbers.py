"""Bases of laws of time, and their numbers: checked at construction, except when JAX traces them."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from supple.algebra import read_only
from supple.arguments import check_number, check_numbers, given
from supple.errors import ArgumentError, ModelError

Numbers = Any
"""A number or array of a law: a leaf of its JAX pytree, which may be a tracer."""


def are_numbers(*values: Numbers) -> bool:
    """Whether all values are Python or NumPy numbers, lists, tuples or NumPy arrays; False for JAX arrays.

    Raises ArgumentError for text, dictionaries and classes.
    """
    for value in values:
        if isinstance(value, (str, bytes, dict, type)):
            raise ArgumentError(f"the numbers of a law: expected numbers, got {given(value)}")
    return all(isinstance(value, (int, float, list, tuple, np.ndarray, np.generic)) for value in values)


def finite(what: str, value: Numbers) -> Numbers:
    """The number as a float, or the numbers as a read-only array; ModelError unless all are finite."""
    check_numbers(what, value)
    array = np.asarray(value, dtype=float)
    if not np.isfinite(array).all():
        raise ModelError(f"{what} must be finite, got {value}")
    return read_only(array) if array.ndim else float(array)


def finite_and_positive(what: str, value: Numbers) -> float:
    """The number as a float; ModelError unless it is finite and positive."""
    check_number(what, value)
    number = float(value)
    if not (np.isfinite(number) and number > 0.0):
        raise ModelError(f"{what} must be finite and positive, got {value}")
    return number


def increasing_rows(times: Numbers, values: Numbers) -> tuple[np.ndarray, np.ndarray]:
    """Times (k,) and values (k, ...) of a table; ModelError unless they are finite and the times increase."""
    check_numbers("the times of a table", times)
    check_numbers("the values of a table", values)
    times, values = read_only(times), read_only(values)
    if times.ndim != 1 or times.size < 2 or len(values) != times.size:
        raise ModelError(
            f"a table needs at least two times and one row of values for each, got times of shape "
            f"{times.shape} and values of shape {values.shape}"
        )
    if not (np.isfinite(times).all() and np.isfinite(values).all()):
        raise ModelError("a table of a quantity over time has NaN or infinite entries")
    if (np.diff(times) <= 0).any():
        row = int(np.argmax(np.diff(times) <= 0)) + 1
        raise ModelError(f"times of a table must increase: row {row} has {times[row]} after {times[row - 1]}")
    return times, values


class UnboundedLaw:
    """Base of laws that are defined from minus to plus infinity."""

    begin: ClassVar[float] = float("-inf")
    """First time at which the law is defined."""

    end: ClassVar[float] = float("inf")
    """Last time at which the law is defined."""


class SmoothLaw(UnboundedLaw):
    """Base of laws without kinks, and without a time scale unless they define one."""

    def instants(self, begin: float, end: float) -> np.ndarray:  # noqa: ARG002 - no kinks
        """An empty array: the law has no kinks."""
        return np.zeros(0)

    def shortest_scale(self, begin: float, end: float) -> float:  # noqa: ARG002
        """Infinity: the law has no time scale."""
        return float("inf")


class OfRows:
    """Base of laws given by rows at increasing `times`."""

    times: Numbers

    @property
    def begin(self) -> float:
        """First time at which the law is defined."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """Last time at which the law is defined."""
        return float(self.times[-1])

    def shortest_scale(self, begin: float, end: float) -> float:  # noqa: ARG002 - of the whole table
        """The smallest spacing of rows."""
        return float(np.diff(self.times).min())
