"""Contents of values as bytes: values of equal content are interchangeable in a computation.

A function has the content of everything that its result depends on besides its arguments. A user may change a
number that a function reads from its module, and the function is still the same object.
"""

from __future__ import annotations

import dis
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache, partial
from hashlib import sha256
from types import CodeType, FunctionType, MethodType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np

__all__ = ["UserFunction", "content_of"]

Parts = Callable[[Any], Any]
"""Returns the values that represent a value, or the value itself"""


def _itself(value: Any) -> Any:
    return value


def content_of(value: Any, parts_of: Parts = _itself, around: tuple[Any, ...] = ()) -> Iterator[bytes]:
    """The numbers, names and functions in a value.

    A function is represented by its code and by the values that the code reads: those of its closure, its
    defaults and its module, and the functions it calls. Modules and functions of libraries are represented by
    their names. Fields that are excluded from comparison are left out.

    parts_of : the values that represent a value, where these are not all of its fields
    around : the functions, mappings and objects that contain the value; a value within itself is not repeated
    """
    if any(value is each for each in around):
        yield b"a value around this one"
        return
    inner = (*around, value)
    match value := parts_of(value):
        case None | bool() | str() | bytes() | Enum():
            yield repr(value).encode()
        case tuple() | list():
            yield f"{len(value)} items".encode()
            for item in value:
                yield from content_of(item, parts_of, inner)
        case set() | frozenset():
            yield repr(sorted(map(repr, value))).encode()
        case Mapping() | SimpleNamespace():
            for key, item in (value if isinstance(value, Mapping) else vars(value)).items():
                yield str(key).encode()
                yield from content_of(item, parts_of, inner)
        case type() | ModuleType():
            yield getattr(value, "__qualname__", value.__name__).encode()
        case partial():
            yield from content_of((value.func, value.args, value.keywords), parts_of, inner)
        case FunctionType() | MethodType():
            yield from _of_function(value, parts_of, inner)
        case _ if is_dataclass(value) or callable(value) or _is_users(type(value)):
            yield from _of_object(value, parts_of, inner)
        case _:
            yield from _of_numbers(value)


def _of_object(value: Any, parts_of: Parts, inner: tuple[Any, ...]) -> Iterator[bytes]:
    """The fields of an object, and what it does when it is called."""
    yield type(value).__qualname__.encode()
    if is_dataclass(value):
        for item in fields(value):
            if item.compare:
                yield item.name.encode()
                yield from content_of(getattr(value, item.name), parts_of, inner)
    else:
        if name := getattr(value, "__name__", ""):  # of a library's function
            yield name.encode()
        if isinstance(within := getattr(value, "__wrapped__", None), FunctionType):  # by jax.jit
            yield from content_of(within, parts_of, inner)
        yield from content_of(_own(value), parts_of, inner)
    call = getattr(type(value), "__call__", None)  # noqa: B004
    if _is_users(type(value)) and isinstance(call, FunctionType):
        yield from content_of(call, parts_of, inner)


def _own(value: Any) -> dict[str, Any]:
    return {key: item for key, item in getattr(value, "__dict__", {}).items() if not callable(item)}


def _of_numbers(value: Any) -> Iterator[bytes]:
    try:
        array = np.asarray(value)
    except TypeError:  # a number that JAX traces at present
        yield f"{type(value).__qualname__} {id(value)}".encode()
        return
    if array.dtype.kind in "biufc":
        yield f"{array.shape} {array.dtype.kind}".encode()
        yield array.tobytes()
    else:
        yield type(value).__qualname__.encode()


def _of_function(function: Any, parts_of: Parts, inner: tuple[Any, ...]) -> Iterator[bytes]:
    yield function.__qualname__.encode()
    if (owner := getattr(function, "__self__", None)) is not None:
        yield from content_of(owner if is_dataclass(owner) else _own(owner), parts_of, inner)
    if not _is_users(function):
        yield str(function.__module__).encode()
        for name, found in _closure(function):
            if isinstance(found, FunctionType):  # by jax.vmap
                yield name.encode()
                yield from content_of(found, parts_of, inner)
        return
    yield from _of_code(function.__code__)
    for item in ("__defaults__", "__kwdefaults__"):
        yield from content_of(getattr(function, item), parts_of, inner)
    for name, found in _closure(function):
        yield name.encode()
        yield from content_of(found, parts_of, inner)
    for name in _names_read(function.__code__):
        if name in function.__globals__:
            yield name.encode()
            yield from content_of(function.__globals__[name], parts_of, inner)


def _closure(function: Any) -> Iterator[tuple[str, Any]]:
    """Names and values of the variables that a function takes from the functions around it."""
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        with suppress(ValueError):  # a variable without a value yet
            yield name, cell.cell_contents


def _of_code(code: CodeType) -> Iterator[bytes]:
    yield code.co_code
    yield repr(code.co_names).encode()
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _of_code(constant)
        else:
            yield from content_of(constant)


@lru_cache(maxsize=1024)
def _names_read(code: CodeType) -> tuple[str, ...]:
    """Names that a function and the functions within it read from their module."""
    names = {step.argval for step in dis.get_instructions(code) if step.opname == "LOAD_GLOBAL"}
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names.update(_names_read(constant))
    return tuple(sorted(names))


def _is_users(value: Any) -> bool:
    """Whether a class or a function is neither part of a library nor of supple."""
    return not _is_library(getattr(value, "__module__", None) or "builtins")


@lru_cache(maxsize=1024)
def _is_library(module: str) -> bool:
    package = module.partition(".")[0]
    if package == "__main__":
        return False
    if package in sys.stdlib_module_names or package in sys.builtin_module_names or package == __package__:
        return True
    file = getattr(sys.modules.get(module), "__file__", None) or ""
    return any(folder in file for folder in ("site-packages", "dist-packages"))


class UserFunction:
    """A user's function as a fixed value of a compiled program: equal only if its content is equal as well.

    JAX compares the fixed values of a program to find it again. A function alone would be equal to itself
    after a number that it reads from its module has changed, and the old number would be used.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        self.content = sha256(b"\n".join(content_of(function))).digest()

    def __call__(self, *arguments: Any) -> Any:
        """The function's value."""
        return self.function(*arguments)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, UserFunction)
            and self.function == other.function
            and self.content == other.content
        )

    def __hash__(self) -> int:
        return hash((self.function, self.content))
