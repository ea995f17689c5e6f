"""Contents of values as bytes, for digests: result files of different runs have different digests."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import partial
from types import CodeType
from typing import Any

import numpy as np
from scipy import sparse

from supple.body import FlexibleBody
from supple.fem import FiniteElementModel
from supple.storage.run_inputs import digest_of

__all__ = ["bytes_of", "digest_of_parts"]

_MOST_CALLS = 8
"""Largest depth of function calls that are followed."""


def digest_of_parts(parts: Iterable[bytes]) -> str:
    """A digest of parts, each with its length, so that different lists of parts have different digests."""
    return digest_of(b"".join(b"%d:%b" % (len(part), part) for part in parts))


def bytes_of(value: Any, depth: int = 0) -> Iterator[bytes]:
    """The numbers, names and functions of a value, such as a joint, a load, a body or a law.

    A function is represented by its code, the values in its closure, and the functions it calls. A finite
    element model is represented by its input, because another number of threads changes the last digits of
    its matrices. Fields that are excluded from comparison are left out.
    """
    match value := _made_of(value):
        case None | bool() | str() | Enum():
            yield repr(value).encode()
        case tuple() | list():
            yield f"{len(value)} items".encode()
            for item in value:
                yield from bytes_of(item, depth)
        case Mapping():
            for key, item in value.items():
                yield str(key).encode()
                yield from bytes_of(item, depth)
        case _ if is_dataclass(value) and not isinstance(value, type):
            yield type(value).__qualname__.encode()
            for item in fields(value):
                if not item.compare:
                    continue
                yield item.name.encode()
                yield from bytes_of(getattr(value, item.name), depth)
        case type():
            yield value.__qualname__.encode()
        case _ if hasattr(value, "__code__"):
            yield from _of_function(value, depth)
        case _ if callable(value):
            yield type(value).__qualname__.encode()
            own = getattr(value, "__dict__", {})
            yield from bytes_of({key: item for key, item in own.items() if not callable(item)}, depth)
        case _:
            yield from _of_numbers(value)


def _made_of(value: Any) -> Any:
    """The parts that represent a value, or the value itself."""
    match value:
        case partial():
            return value.func, value.args, value.keywords
        case FiniteElementModel():
            return value.mesh, value.sections, value.kinematics, value.attached, value.dofs_per_node
        case FlexibleBody() if value.model is not None:
            ends = [
                (own.name, own.position, own.node_ids, own.cubic_turn, own.tied_nodes)
                for own in value.interfaces
            ]
            return value.name, value.model, value.is_linear, ends
        case _ if sparse.issparse(value):
            own = sparse.csr_array(value)
            return own.shape, own.indptr, own.indices, own.data
        case _:
            return value


def _of_numbers(value: Any) -> Iterator[bytes]:
    array = np.asarray(value)
    if array.dtype.kind in "biufc":
        yield f"{array.shape} {array.dtype.kind}".encode()
        yield array.tobytes()
    else:
        yield type(value).__qualname__.encode()


def _of_function(function: Callable[..., Any], depth: int) -> Iterator[bytes]:
    code, around = getattr(function, "__code__"), getattr(function, "__globals__")  # noqa: B009
    yield function.__qualname__.encode()  # ty: ignore[missing-attribute]
    yield from _of_code(code)
    if depth >= _MOST_CALLS:
        return
    for item in ("__defaults__", "__kwdefaults__"):
        yield from bytes_of(getattr(function, item, None), depth)
    if (owner := getattr(function, "__self__", None)) is not None:
        yield from bytes_of(getattr(owner, "__dict__", {}), depth + 1)
    for cell in getattr(function, "__closure__", None) or ():
        yield from bytes_of(cell.cell_contents, depth + 1)
    for name in code.co_names:
        value = around.get(name)
        # A library function is represented by its name.
        ours = callable(value) and getattr(value, "__globals__", None) is around
        if ours or isinstance(value, int | float | complex | str | tuple | list | np.ndarray):
            yield name.encode()
            yield from bytes_of(value, depth + 1)


def _of_code(code: CodeType) -> Iterator[bytes]:
    yield code.co_code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _of_code(constant)
        else:
            yield repr(constant).encode()
