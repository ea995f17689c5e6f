"""Content of values as bytes: values with equal content give equal results in a computation.

The content of a function contains everything on which its result depends, except its arguments. Comparison of
function objects is not enough: a function remains the same object if a number that it reads from its module
changes.
"""

from __future__ import annotations

import dis
import sys
import sysconfig
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cached_property, lru_cache, partial
from hashlib import sha256
from importlib.util import find_spec
from numbers import Number
from pathlib import Path
from types import CodeType, FunctionType, MethodType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np
from scipy import sparse

Parts = Callable[[object], object]
"""Returns the values that represent a value, or the value itself"""


_PLAIN = (bool, int, float, complex, str, bytes, tuple, np.ndarray, np.generic)
"""Types of closure variables that belong to the content of a library's function: `in_axes` of `jax.vmap`."""

Names = frozenset[str] | None
"""Names that code reads from a value; None: any name, because a library reads the value."""


def content_of(value: object, parts_of: Parts = lambda value: value) -> Iterator[bytes]:
    """The numbers, names and functions in a value.

    Function: its code and the values that the code reads, from closure, defaults and module, and the
    functions it calls. Object: its fields, without those excluded from comparison; for an object of a user's
    class also the values of the class and the methods that are used. User's module: the values that the code
    reads from it; a module that a function imports when it is called: the text of its file. Module or class
    of a library: its name. Function of a library: its name, and the functions and plain values of its
    closure.

    parts_of : returns the values that represent a value, where these are not all of its fields
    """
    return _Content(parts_of).of(value, (), None)


class _Content:
    """The content of one value; a function or object that is used in several places is described once."""

    def __init__(self, parts_of: Parts) -> None:
        self._parts_of = parts_of
        self._described: dict[object, tuple[int, object]] = {}
        """Number of each function and user's object, and the object itself, so that its id stays unique."""

    def of(self, value: object, around: tuple[object, ...], names: Names) -> Iterator[bytes]:
        """The content of a value.

        around : mappings and objects that contain the value; a value that contains itself is not repeated
        """
        if any(value is each for each in around):
            yield b"a value around this one"
            return
        inner = (*around, value)
        match value := self._parts_of(value):
            case None | bool() | str() | bytes() | Enum():
                yield repr(value).encode()
            case tuple() | list():
                yield f"{len(value)} items".encode()
                for item in value:
                    yield from self.of(item, inner, names)
            case set() | frozenset():
                yield repr(sorted(map(repr, value))).encode()
            case Mapping() | SimpleNamespace() | Namespace():
                for key, item in (value if isinstance(value, Mapping) else vars(value)).items():
                    yield str(key).encode()
                    yield from self.of(item, inner, names)
            case ModuleType() | type() | partial() | FunctionType() | MethodType():
                yield from self._of_callable(value, inner, names)
            case _ if sparse.issparse(value):
                own = sparse.csr_array(value)
                yield from self.of((own.shape, own.indptr, own.indices, own.data), inner, names)
            case _ if is_dataclass(value) or callable(value) or is_users(type(value)):
                yield from self._of_object(value, inner, names)
            case _:
                yield from self._of_numbers(value, inner, names)

    def _of_callable(self, value: object, inner: tuple[object, ...], names: Names) -> Iterator[bytes]:
        """The content of a function, a class or a module."""
        match value:
            case ModuleType():
                yield value.__name__.encode()
                for name in sorted(names or ()) if not _is_library(value.__name__) else ():
                    if name in vars(value):
                        yield name.encode()
                        yield from self.of(vars(value)[name], inner, names)
            case type():
                yield value.__qualname__.encode()
                for name, item in _members(value, names):
                    yield name.encode()
                    yield from self.of(item, inner, names)
            case partial():
                yield from self.of((value.func, value.args, value.keywords), inner, names)
            case FunctionType():
                yield from self._of_function(value, inner)
            case MethodType():
                function, owner = value.__func__, value.__self__
                known = isinstance(owner, type) or is_dataclass(owner) or is_users(type(owner))
                read = None
                if isinstance(function, FunctionType):
                    yield from self._of_function(function, inner)
                    read = _names_in(function.__code__)
                else:  # an object that is called as a method
                    yield from self.of(function, inner, names)
                yield from self.of(owner if known else _own(owner), inner, read)

    def _of_object(self, value: object, inner: tuple[object, ...], names: Names) -> Iterator[bytes]:
        """The fields of an object; the values and functions of a user's class."""
        kind = type(value)
        yield kind.__qualname__.encode()
        if is_users(kind):
            if (number := self._number(value, names)) is not None:
                yield number
                return
            if callable(value) and not is_dataclass(value):
                names = names or frozenset()  # a library only calls it
            own = _members(kind, names)
            if names is not None:
                names = names.union(
                    *(_names_in(item.__code__) for _, item in own if isinstance(item, FunctionType))
                )
        else:
            own = []
        if is_dataclass(value):
            own += [(item.name, getattr(value, item.name)) for item in fields(value) if item.compare]
        else:
            if name := getattr(value, "__name__", ""):  # the name of a library's function
                yield name.encode()
            own += _own(value).items()
        for name, item in own:
            yield name.encode()
            yield from self.of(item, inner, names)

    def _number(self, value: object, names: Names = None) -> bytes | None:
        """The number of an object that is described already; None for a new one, which gets a number."""
        key = id(value), names
        if key in self._described:
            return f"number {self._described[key][0]}".encode()
        self._described[key] = len(self._described), value
        return None

    def _of_numbers(self, value: object, inner: tuple[object, ...], names: Names) -> Iterator[bytes]:
        try:
            array = np.asarray(value)
        except TypeError:  # a number that JAX traces at present
            yield f"{type(value).__qualname__} {id(value)}".encode()
            return
        if array.dtype.kind in "biufc":
            yield f"{array.shape} {array.dtype.kind}".encode()
            yield array.tobytes()
        elif not array.dtype.hasobject:  # texts, times, records
            yield f"{array.shape} {array.dtype.descr}".encode()
            yield array.tobytes()
        elif array.ndim:
            yield from self.of(array.tolist(), inner, names)
        else:
            yield (repr(value) if isinstance(value, Number) else type(value).__qualname__).encode()

    def _of_function(self, function: FunctionType, inner: tuple[object, ...]) -> Iterator[bytes]:
        if (number := self._number(function)) is not None:
            yield number
            return
        yield function.__qualname__.encode()
        if not is_users(function):
            yield str(function.__module__).encode()
            for name, found in _closure(function):
                if callable(found) or isinstance(found, _PLAIN):  # by jax.vmap
                    yield name.encode()
                    yield from self.of(found, inner, frozenset())
            return
        yield from _of_code(function.__code__)
        names = _names_in(function.__code__)
        for item in ("__defaults__", "__kwdefaults__"):
            yield from self.of(getattr(function, item), inner, names)
        for name, found in _closure(function):
            yield name.encode()
            yield from self.of(found, inner, names)
        for name in _arguments_of("LOAD_GLOBAL", function.__code__):
            if name in function.__globals__:
                yield name.encode()
                yield from self.of(function.__globals__[name], inner, names)
        # Modules that the function imports when it is called.
        for name in _arguments_of("IMPORT_NAME", function.__code__):
            yield from _of_file(name)


def _own(value: object) -> dict[str, object]:
    """The attributes of an object: those of its slots, and those of its dictionary."""
    slots = {}
    for kind in type(value).__mro__:
        given = vars(kind).get("__slots__", ())
        for name in (given,) if isinstance(given, str) else given:
            if not name.startswith("__") and hasattr(value, name):
                slots[name] = getattr(value, name)
    return slots | getattr(value, "__dict__", {})


def _members(kind: type, names: Names) -> list[tuple[str, object]]:
    """Values of a user's class and of the user's classes it inherits from, and the methods that are used.

    Methods are used if they have one of the names, if Python calls them, such as `__call__`, or if the code
    of a used method contains their name.
    """
    if issubclass(kind, Enum):
        return []
    members = [
        (name, function)
        for each in kind.__mro__
        if is_users(each)
        for name, item in vars(each).items()
        for function in _functions_of(item) or (() if name.startswith("__") else (item,))
    ]
    used: set[str] = {name for name, _ in members} if names is None else set(names)
    found, before = list[tuple[str, object]](), -1
    while len(found) > before:
        before = len(found)
        found = [
            (name, item)
            for name, item in members
            if name in used or name.startswith("__") or not isinstance(item, FunctionType)
        ]
        used = used.union(*(_names_in(item.__code__) for _, item in found if isinstance(item, FunctionType)))
    return found


def _functions_of(item: object) -> tuple[FunctionType, ...]:
    """The function in a member of a class, as a tuple; empty for a value."""
    match item:
        case staticmethod() | classmethod():
            item = item.__func__
        case property():
            item = item.fget
        case cached_property():
            item = item.func
    return (item,) if isinstance(item, FunctionType) else ()


def _of_file(module: str) -> Iterator[bytes]:
    """The text of a user's module, which may not be imported yet."""
    if _is_library(module):
        return
    with suppress(Exception):  # of a package that fails to be imported, or a file that cannot be read
        found = find_spec(module)
        if found is not None and found.origin is not None and not _is_in_library(found.origin):
            yield module.encode()
            yield Path(found.origin).read_bytes()


def _closure(function: FunctionType) -> Iterator[tuple[str, object]]:
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


@lru_cache(maxsize=2048)
def _arguments_of(instruction: str, code: CodeType) -> tuple[str, ...]:
    """Names in instructions of one kind, also in the functions within a function."""
    names = {step.argval for step in dis.get_instructions(code) if step.opname == instruction}
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names.update(_arguments_of(instruction, constant))
    return tuple(sorted(names))


@lru_cache(maxsize=1024)
def _names_in(code: CodeType) -> frozenset[str]:
    """Names of globals and attributes in the code of a function and of the functions within it."""
    inner = [_names_in(each) for each in code.co_consts if isinstance(each, CodeType)]
    return frozenset(code.co_names).union(*inner)


def is_users(value: object) -> bool:
    """Whether a class or a function is neither part of a library nor of supple."""
    return not _is_library(getattr(value, "__module__", None) or "builtins")


@lru_cache(maxsize=1024)
def _is_library(module: str) -> bool:
    package = module.partition(".")[0]
    if package == "__main__":
        return False
    if package in sys.builtin_module_names or package == __package__:
        return True
    file = getattr(sys.modules.get(module), "__file__", None)
    if file is None:  # also a module of the standard library without a file
        return package in sys.stdlib_module_names
    return _is_in_library(file)


def _is_in_library(file: str) -> bool:
    """Whether a file belongs to an installed package or to Python.

    The path decides: a user's script may have the name of a library module, such as `profile.py`.
    """
    if any(folder in file for folder in ("site-packages", "dist-packages")):
        return True
    return any(file.startswith(sysconfig.get_path(each)) for each in ("stdlib", "platstdlib"))


class UserFunction:
    """A user's function or class as a fixed value of a compiled program; equality includes the content.

    JAX finds a compiled program by its fixed values. A plain function is equal to itself even after a number
    that it reads from its module has changed; JAX would then use the program with the old number.
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


def fixed_function(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function as a fixed value of a compiled program: a library's function itself, or a `UserFunction`."""
    return UserFunction(function) if is_users(function) else function
