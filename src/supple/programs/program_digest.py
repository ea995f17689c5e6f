"""Digest of everything that a compiled program depends on; equal in all processes.

It covers the structure of the arguments with all fixed values, shapes and types, the sources of this package
except `_ABOVE`, the version of JAX, the hardware, and the compiler options. Fixed values in a
structure must be objects of this package or plain values. A user's function is represented by its bytecode
and by all values that the bytecode takes from its surroundings. These values must be representable in the
same way or belong to `jax.numpy` or `math`; a program with any other function has no digest.
"""

from __future__ import annotations

import builtins
import dis
import hashlib
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache, partial
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import jax
import numpy as np
from jax.tree_util import PyTreeDef

from supple.algebra.jax_settings import this_machine
from supple.value_content import UserFunction

_PACKAGE = __name__.partition(".")[0]
_ABOVE = ("cases", "cli", "export", "report", "results", "sweeps", "viz")
"""Folders of this package that contain no traced code: traced code never imports them."""


_Compiled = type(jax.jit(lambda: None))
"""Type of functions that JAX traces once for all their calls."""


class _StrangerError(Exception):
    """A value that cannot be represented by its content."""


def program_digest(
    function: Callable[..., Any], options: Mapping[str, Any], structure: PyTreeDef, shapes: tuple[object, ...]
) -> str | None:
    """Digest of the program of a function for arguments of a structure (a PyTreeDef); None where it has none.

    shapes : shapes and types of the leaves
    """
    try:
        content = _described(function), sorted(options.items()), _of_structure(structure), shapes
    except (_StrangerError, RecursionError):  # includes a function that calls itself
        return None
    return _digest(content)


def text_digest(text: str, options: Mapping[str, Any]) -> str:
    """Digest of a program from its lowered text."""
    return _digest((text, sorted(options.items())))


def _digest(content: object) -> str:
    environment = [os.environ.get(name) for name in ("XLA_FLAGS", "NPROC")]
    return hashlib.sha256(repr((content, environment, this_machine())).encode()).hexdigest()


@lru_cache
def digest_of_sources() -> str:
    """Digest of all modules of this package that may contain traced code."""
    digest = hashlib.sha256()
    root = Path(__file__).parents[1]
    for path in sorted(root.rglob("*.py")):
        within = path.relative_to(root)
        if within.parts[0] in _ABOVE:
            continue
        digest.update(f"{within}\n".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _of_structure(structure: PyTreeDef) -> object:
    node = structure.node_data()
    if node is None:
        return "leaf"
    kind, fixed = node
    return _described(kind), _described(fixed), tuple(map(_of_structure, structure.children()))


def _described(value: Any) -> object:
    """A fixed value in a form that is equal in every process."""
    if isinstance(value, UserFunction):
        value = value.function
    if value is None or value is ... or isinstance(value, (bool, int, float, complex, str, bytes)):
        return repr(value)
    if isinstance(value, (tuple, list)):
        kind = type(value)
        return kind.__name__ if kind in (tuple, list) else _name(kind), tuple(map(_described, value))
    if isinstance(value, np.ndarray):
        return str(value.dtype), value.shape, value.tobytes()
    if isinstance(value, partial):
        return (
            "partial",
            _described(value.func),
            _described(value.args),
            _described([*value.keywords.items()]),
        )
    if isinstance(value, (type, FunctionType, _Compiled, PyTreeDef)):
        return _of_structure(value) if isinstance(value, PyTreeDef) else _found(value)
    if is_dataclass(value):
        return _name(type(value)), tuple(_described(getattr(value, each.name)) for each in fields(value))
    raise _StrangerError


def _found(value: Any) -> object:
    """The name of a class or a function; for a user's or a locally created function, its content."""
    try:
        return _name(value)
    except _StrangerError:
        if not isinstance(value, FunctionType):
            raise
        return _content(value)


def _name(value: Any) -> str:
    """Import path of a class or a function of this package, or of a Python class."""
    module, name = value.__module__, value.__qualname__
    if module == "builtins" and isinstance(value, type):
        return name
    package, *parts = module.split(".")
    if package != _PACKAGE or parts[:1] in [[part] for part in _ABOVE]:
        raise _StrangerError
    found: Any = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    if found is not value:  # created locally, or replaced
        raise _StrangerError
    return f"{module}.{name}"


_PURE = {
    each.__name__
    for each in (
        *(abs, all, any, bool, dict, enumerate, float, int, isinstance, len, list, map, max, min, pow),
        *(range, reversed, round, set, sorted, sum, tuple, zip),
    )
}
"""Python functions whose results depend on their arguments only."""
_OUTSIDE = ("IMPORT", "STORE_GLOBAL", "DELETE_GLOBAL", "LOAD_NAME", "LOAD_BUILD_CLASS")
"""Instructions that read from or write to places that are not examined here."""


def _content(function: FunctionType) -> object:
    """Content of a function: its code, and the values that it takes from closure, defaults and module."""
    if function.__dict__:
        raise _StrangerError
    try:
        closure = [_described(cell.cell_contents) for cell in function.__closure__ or ()]
    except ValueError:  # a cell that is still empty
        raise _StrangerError from None
    defaults = _described([function.__defaults__, sorted((function.__kwdefaults__ or {}).items())])
    return sys.version, _code(function.__code__, function.__globals__), closure, defaults


def _code(code: CodeType, around: Mapping[str, Any]) -> object:
    """Instructions and constants, also of inner functions, with the values they take from outside."""
    found = []
    steps = [step for step in dis.get_instructions(code) if step.opname != "EXTENDED_ARG"]
    for step, following in zip(steps, [*steps[1:], None], strict=True):
        if step.opname.startswith(_OUTSIDE):
            raise _StrangerError
        if step.opname == "LOAD_GLOBAL":
            found.append((step.argval, _taken(step.argval, following, around)))
    constants = [
        _code(each, around) if isinstance(each, CodeType) else _described(each) for each in code.co_consts
    ]
    signature = code.co_argcount, code.co_kwonlyargcount, code.co_flags, code.co_varnames, code.co_freevars
    return code.co_code, code.co_names, code.co_exceptiontable, signature, constants, found


def _taken(name: str, following: dis.Instruction | None, around: Mapping[str, Any]) -> object:
    """A global of a function; for a module, the attribute that is read from it."""
    if name not in around:
        if name not in _PURE:
            raise _StrangerError
        return getattr(builtins, name).__name__
    value = around[name]
    if not isinstance(value, ModuleType):
        return _described(value)
    if following is None or following.opname not in ("LOAD_ATTR", "LOAD_METHOD"):
        raise _StrangerError
    attribute = following.argval
    if value.__name__ == "numpy":  # constants only: its functions do not accept traced arrays
        return _described(getattr(value, attribute))
    # Functions that read files are excluded: the content of a file is not part of the digest.
    if value.__name__ not in ("jax.numpy", "math") or attribute.startswith(("load", "from")):
        raise _StrangerError
    return value.__name__
