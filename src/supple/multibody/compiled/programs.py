"""Compiled marches that are at hand: runs of one machine that differ in numbers alone share a program."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import jax

from supple.multibody.compiled.time_step import march
from supple.multibody.equations.compiler_options import MARCHING

__all__ = ["compiled_march"]

_MOST = 8
_PROGRAMS: OrderedDict[Any, Any] = OrderedDict()
"""By the structure and the shapes of what a march takes, the one used last behind."""


def compiled_march(*arguments: Any) -> Any:
    """The march for arguments of these shapes, compiled unless one of the last few was."""
    leaves, structure = jax.tree.flatten(arguments)
    key = structure, tuple(jax.typeof(leaf) for leaf in leaves)
    if key not in _PROGRAMS:
        _PROGRAMS[key] = march.lower(*arguments).compile(compiler_options=MARCHING)
        if len(_PROGRAMS) > _MOST:
            _PROGRAMS.popitem(last=False)
    _PROGRAMS.move_to_end(key)
    return _PROGRAMS[key]
