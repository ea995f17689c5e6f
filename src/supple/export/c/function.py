"""A function of arrays, traced by JAX, as a C function."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.resources import files

import jax
import numpy as np
from numpy.typing import DTypeLike

from supple.arrays import Tree
from supple.export.c import array_reductions, branches, elementwise, indexing, linear_algebra, shapes
from supple.export.c.blocks import CodeBlock
from supple.export.c.branches import hand_on
from supple.export.c.operations import program_of
from supple.export.c.printer import Printed, print_program
from supple.export.c.separate_functions import SeparateFunctions
from supple.export.c.values import Buffer, BufferView, Value, c_type, row_major

_FAMILIES = (array_reductions, branches, elementwise, indexing, linear_algebra, shapes)
"""Modules whose import registers the rules."""

HEAD = "#include <math.h>\n#include <stdbool.h>\n#include <stdint.h>\n\n" + files("supple.export.c").joinpath(
    "assets", "support.h"
).read_text("utf-8")
"""First lines of every C file."""


def named_view(name: str, shape: Sequence[int], dtype: DTypeLike, *, is_scalar: bool = False) -> BufferView:
    """A view of an array that has a given name in C."""
    shape = tuple(shape)
    size = int(np.prod(shape, dtype=int))
    buffer = Buffer(-1, np.dtype(dtype), size, is_scalar=is_scalar, name=name)
    return BufferView(shape, np.dtype(dtype), buffer, row_major(shape))


def printed_function(
    function: Callable[..., Tree],
    arguments: Sequence[Tree],
    inputs: Sequence[BufferView],
    outputs: Sequence[BufferView],
    name: str,
    parameters: Sequence[tuple[str, str]],
) -> Printed:
    """The C statements that evaluate a function at `inputs` and store its results in `outputs`, leaf by leaf.

    arguments : arguments of the function, of which only shapes and types are used
    name : prefix of further names at file scope
    parameters : declaration and name of each parameter of the C function
    An output may also be an input: all inputs are read before any output is written.

    Raises ModelError for an operation without a translation to C.
    """
    program = program_of(jax.make_jaxpr(function)(*arguments))

    def store(block: CodeBlock, values: Sequence[Value]) -> None:
        hand_on(block, outputs, values, [True] * len(outputs))

    own = SeparateFunctions(name, parameters)
    return print_program(program, dict(zip(program.inputs, inputs, strict=True)), store, own)


def function_source(function: Callable[..., Tree], *arguments: Tree, name: str = "function") -> str:
    """A C file with `void name(const T *x0, .., T *y0, ..)`, one pointer per leaf."""
    given = jax.tree.leaves(arguments)
    results = jax.tree.leaves(jax.eval_shape(function, *arguments))
    ins, outs = (
        [named_view(f"{letter}{place}", np.shape(leaf), leaf.dtype) for place, leaf in enumerate(leaves)]
        for letter, leaves in (("x", [np.asarray(leaf) for leaf in given]), ("y", results))
    )
    parameters = [(f"const {c_type(view.dtype)} *{view.buffer.text}", view.buffer.text) for view in ins]
    parameters += [(f"{c_type(view.dtype)} *{view.buffer.text}", view.buffer.text) for view in outs]
    printed = printed_function(function, arguments, ins, outs, name, parameters)
    given = ", ".join(declaration for declaration, _ in parameters)
    return f"{HEAD}\n{printed.before}\n\nvoid {name}({given})\n{{\n{printed.body}\n}}\n"
