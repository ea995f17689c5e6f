"""Arguments of functions and constructors, checked where they are given.

Each check returns nothing and raises ArgumentError: where, what is expected, what was given. What JAX puts
in the place of numbers passes.
"""

from __future__ import annotations

import reprlib
from typing import Any

import numpy as np

from supple.errors import ArgumentError

__all__ = [
    "check_instance",
    "check_members",
    "check_number",
    "check_numbers",
    "check_sequence",
    "check_text",
    "check_whole_number",
    "given",
]

_NUMBERS = "iuf"
"""Kinds of arrays that hold real numbers: integers and floats, no truth values, words or objects."""


def given(value: Any) -> str:
    """A value in a few words, for messages."""
    if isinstance(value, type):
        return f"the class {value.__name__} itself; make one: {value.__name__}(...)"
    if hasattr(value, "shape") and hasattr(value, "dtype") and getattr(value, "ndim", 0):
        return f"an array of shape {tuple(value.shape)} of {value.dtype}"
    if isinstance(value, str | bytes | bool | int | float | complex | list | tuple | dict | set | None):
        return f"{reprlib.repr(value)} ({type(value).__name__})"
    name = getattr(value, "name", None)
    return f"a {type(value).__name__}" + (f" named '{name}'" if isinstance(name, str) else "")


def check_instance(what: str, value: Any, kinds: type | tuple[type, ...], expected: str) -> None:
    """Raise unless the value is of one of the kinds; `expected` says which, and what to write."""
    if not isinstance(value, kinds):
        raise ArgumentError(f"{what}: expected {expected}, got {given(value)}")


def check_members(what: str, value: Any, members: tuple[str, ...], expected: str) -> None:
    """Raise unless the value, an object and no class, has all the members."""
    if isinstance(value, type) or not all(hasattr(value, member) for member in members):
        raise ArgumentError(f"{what}: expected {expected}, got {given(value)}")


def check_text(what: str, value: Any, expected: str = "a word in quotes") -> None:
    """Raise unless the value is a string that is not empty."""
    if not isinstance(value, str) or not value:
        raise ArgumentError(f"{what}: expected {expected}, got {given(value)}")


def check_number(what: str, value: Any) -> None:
    """Raise unless the value is one real number."""
    if not (
        _is_number(value) or (hasattr(value, "dtype") and value.dtype.kind in _NUMBERS and value.ndim == 0)
    ):
        raise ArgumentError(f"{what}: expected a number, got {given(value)}")


def check_whole_number(what: str, value: Any) -> None:
    """Raise unless the value is one whole number, which may be written as 3.0."""
    check_number(what, value)
    if not (np.isfinite(value) and value == int(value)):
        raise ArgumentError(f"{what}: expected a whole number, got {given(value)}")


def check_numbers(what: str, value: Any) -> None:
    """Raise unless the value is an array of real numbers, or nested lists of one shape that hold them."""
    if hasattr(value, "dtype"):
        kind = value.dtype.kind
    else:
        try:
            kind = (
                np.asarray(value).dtype.kind
                if value is not None and not isinstance(value, dict | set)
                else ""
            )
        except (ValueError, TypeError):
            raise ArgumentError(
                f"{what}: expected an array of numbers, got rows of different lengths"
            ) from None
    if kind not in _NUMBERS:
        raise ArgumentError(f"{what}: expected an array of numbers, got {given(value)}")


def check_sequence(what: str, value: Any, expected: str) -> None:
    """Raise unless the value is a list or another sequence, not a word or a single object."""
    if isinstance(value, str | bytes | dict) or not hasattr(value, "__iter__"):
        raise ArgumentError(f"{what}: expected {expected}, got {given(value)}")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
