"""What a compiled program depends on, as a digest that two processes agree about.

Of the arguments: their structure with all that is fixed in it, shapes and types. Of everything else: the
sources of this package, the versions of JAX and of the machine, and the options of the compiler. What
is fixed in a structure counts if it is this package's own or a plain value. Of a stranger's function nothing
is known but its name, and a program with one has no digest.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache, partial
from pathlib import Path
from types import FunctionType
from typing import Any

import jax
import numpy as np

from supple.algebra.jax_settings import this_machine

__all__ = ["digest_of_sources", "program_digest", "text_digest"]

_PACKAGE = __name__.partition(".")[0]


_Compiled = type(jax.jit(lambda: None))
"""Of functions that JAX traces once for all their uses."""


class _StrangerError(Exception):
    """Something that is not known by its content."""


def program_digest(
    function: Callable[..., Any], options: Mapping[str, Any], structure: Any, shapes: Any
) -> str | None:
    """Digest of the program of a function for arguments of a structure (a PyTreeDef); None without one.

    shapes : of the leaves, with their types
    """
    try:
        content = _described(function), sorted(options.items()), _of_structure(structure), shapes
    except _StrangerError:
        return None
    return _digest(content)


def text_digest(text: str, options: Mapping[str, Any]) -> str:
    """Digest of the program of a lowered text."""
    return _digest((text, sorted(options.items())))


def _digest(content: Any) -> str:
    environment = [os.environ.get(name) for name in ("XLA_FLAGS", "NPROC")]
    return hashlib.sha256(repr((content, environment, this_machine())).encode()).hexdigest()


@lru_cache
def digest_of_sources() -> str:
    """Of all modules of this package."""
    digest = hashlib.sha256()
    root = Path(__file__).parents[1]
    for path in sorted(root.rglob("*.py")):
        digest.update(f"{path.relative_to(root)}\n".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _of_structure(structure: Any) -> Any:
    node = structure.node_data()
    if node is None:
        return "leaf"
    kind, fixed = node
    return _described(kind), _described(fixed), tuple(map(_of_structure, structure.children()))


def _described(value: Any) -> Any:
    """What a fixed part is, in words that are the same in every process."""
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
        return repr(value)
    if isinstance(value, (tuple, list)):
        return type(value).__name__, tuple(map(_described, value))
    if isinstance(value, np.ndarray):
        return str(value.dtype), value.shape, value.tobytes()
    if isinstance(value, partial):
        return (
            "partial",
            _described(value.func),
            _described(value.args),
            _described([*value.keywords.items()]),
        )
    if isinstance(value, (type, FunctionType, _Compiled)):
        return _name(value)
    if is_dataclass(value):
        return _name(type(value)), tuple(_described(getattr(value, each.name)) for each in fields(value))
    raise _StrangerError


def _name(value: Any) -> str:
    """Where a class or a function of this package, or a class of Python, is found."""
    module, name = value.__module__, value.__qualname__
    if module == "builtins" and isinstance(value, type):
        return name
    if module != _PACKAGE and not module.startswith(f"{_PACKAGE}."):
        raise _StrangerError
    found: Any = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    if found is not value:  # made by a function, or replaced
        raise _StrangerError
    return f"{module}.{name}"
