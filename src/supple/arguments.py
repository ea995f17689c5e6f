"""Checks of the arguments of functions and constructors.

A failed check raises ArgumentError; `check_ranges` raises ModelError. The message contains the name of the
argument, the expected kind of value and the given value. `check_number` accepts JAX tracers.
"""

from __future__ import annotations

import inspect
import os
import reprlib
from collections import abc
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from supple.errors import ArgumentError, ModelError

Positive = Annotated[float, "positive"]
NotNegative = Annotated[float, "not negative"]
_F = TypeVar("_F", bound=Callable[..., Any])

_NUMBERS = frozenset("iuf")
"""Kinds of arrays of real numbers: integers and floats, not Booleans, text or objects."""


def given(value: Any) -> str:
    """Short description of a value for messages, with the text `used_with` of its class, if any."""
    if isinstance(value, type):
        return f"the class {value.__name__} itself; give an object: {value.__name__}(...)"
    if hasattr(value, "shape") and hasattr(value, "dtype") and getattr(value, "ndim", 0):
        return f"an array of shape {tuple(value.shape)} of {value.dtype}"
    if isinstance(value, str | bytes | bool | int | float | complex | list | tuple | dict | set | None):
        return f"{reprlib.repr(value)} ({type(value).__name__})"
    name, use = getattr(value, "name", None), getattr(type(value), "used_with", None)
    called = f" named '{name}'" if isinstance(name, str) else ""
    return f"a {type(value).__name__}{called}" + (f", {use}" if isinstance(use, str) else "")


def check_instance(what: str, value: object, kinds: type | tuple[type, ...], expected: str) -> None:
    """Raise unless the value is of one of the types `kinds`; `expected` describes them, with an example."""
    if not isinstance(value, kinds):
        raise ArgumentError(f"{what}: expected {expected}, got {given(value)}")


def check_members(what: str, value: object, members: tuple[str, ...], expected: str) -> None:
    """Raise unless the value is an object, not a class, and has all the members."""
    if isinstance(value, type) or not all(hasattr(value, member) for member in members):
        raise ArgumentError(f"{what}: expected {expected}, got {given(value)}")


def check_text(what: str, value: object, expected: str = "a string") -> None:
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
    """Raise unless the value is an array of real numbers, or nested lists of one shape with real numbers."""
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


def check_sequence(what: str, value: object, expected: str) -> None:
    """Raise unless the value is a list or another sequence, not text or a single object."""
    if isinstance(value, str | bytes | dict) or not hasattr(value, "__iter__"):
        raise ArgumentError(f"{what}: expected {expected}, got {given(value)}")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def check_fields(record: Any) -> None:
    """Raise unless every field of a dataclass fits its annotation; to be called in `__post_init__`.

    Whole numbers written as 3.0 become integers.
    """
    kind = type(record)
    for name, hint in _hints(kind).items():
        if name in kind.__dataclass_fields__:
            value = getattr(record, name, None)
            checked = _checked(f"{kind.__name__}, {name}", value, hint)
            if checked is not value:
                object.__setattr__(record, name, checked)


def check_ranges(label: str, record: Any) -> None:
    """Raise ModelError unless `Positive` and `NotNegative` fields of a dataclass are finite and in range."""
    for name, expected in _ranges(type(record)).items():
        value = getattr(record, name)
        if value is not None and not (
            np.isfinite(value) and (value > 0 or (value == 0 and expected == "not negative"))
        ):
            raise ModelError(f"{label}: {name} must be finite and {expected}, got {value}")


@cache
def _ranges(kind: type) -> dict[str, str]:
    hints = get_type_hints(kind, include_extras=True)
    options = {
        name: get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
        for name, hint in hints.items()
    }
    return {
        name: each.__metadata__[0]
        for name, found in options.items()
        for each in found
        if each in (Positive, NotNegative)
    }


def checked_arguments(function: _F) -> _F:
    """Decorator that checks the arguments of each call against their annotations.

    Whole numbers written as 3.0 become integers.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def with_checks(*args: Any, **kwargs: Any) -> Any:
        hints, bound = _hints(function), signature.bind(*args, **kwargs)
        for name, value in bound.arguments.items():
            if name in hints:
                what = f"{function.__name__}, {name}"  # ty: ignore[missing-attribute]
                bound.arguments[name] = _checked(what, value, hints[name])
        return function(*bound.args, **bound.kwargs)

    return cast(_F, with_checks)


@cache
def _hints(of: Any) -> dict[str, Any]:
    return get_type_hints(of)


def _checked(what: str, value: Any, hint: Any) -> Any:
    """Return the value, as an integer if the annotation is `int`: `range` and NumPy do not accept 3.0.

    Raise unless the value fits the annotation; an annotation without a known check allows all values.
    """
    options = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    if value is None and NoneType in options:
        return value
    options = [option for option in options if option is not NoneType]
    tests = [_test_of(option) for option in options]
    if None in tests:
        return value
    found = [test for test in tests if test is not None]
    for option, (is_right, _) in zip(options, found, strict=True):
        if is_right(value):
            return int(value) if option is int else value
    raise ArgumentError(f"{what}: expected {' or '.join(name for _, name in found)}, got {given(value)}")


def _test_of(hint: Any) -> tuple[Callable[[Any], bool], str] | None:
    """Check and description of an annotation; None if unknown."""
    origin = get_origin(hint)
    if hint in _PLAIN or origin in _GENERIC:
        return _PLAIN.get(hint) or _GENERIC[origin]
    if origin is tuple and set(get_args(hint)) == {float}:
        return _passes(check_numbers), f"{len(get_args(hint))} numbers"  # the class checks their number
    if hint is Any or not isinstance(hint, type):
        return None
    called = f"an object of the kind {hint.__name__}"
    if not getattr(hint, "_is_protocol", False):
        return (lambda value: isinstance(value, hint)), called
    members = [name for name in vars(hint) if not name.startswith("_")]
    if not members:
        return None
    return (
        lambda value: not isinstance(value, type) and all(hasattr(value, name) for name in members)
    ), called


def _passes(check: Callable[..., None], *further: Any) -> Callable[[Any], bool]:
    def is_right(value: Any) -> bool:
        try:
            check("", value, *further)
        except ArgumentError:
            return False
        return True

    return is_right


_PLAIN: dict[Any, tuple[Callable[[Any], bool], str]] = {
    float: (_passes(check_number), "a number"),
    int: (_passes(check_whole_number), "a whole number"),
    bool: (lambda value: isinstance(value, bool | np.bool_), "True or False"),
    str: (lambda value: isinstance(value, str), "a string"),
    np.ndarray: (_passes(check_numbers), "an array of numbers"),
    Path: (lambda value: isinstance(value, os.PathLike), "a path"),
}
_GENERIC: dict[Any, tuple[Callable[[Any], bool], str]] = {
    np.ndarray: (_passes(check_numbers), "an array of numbers"),
    abc.Sequence: (_passes(check_sequence, ""), "a list"),
    abc.Mapping: (lambda value: isinstance(value, abc.Mapping), "a dictionary"),
}
