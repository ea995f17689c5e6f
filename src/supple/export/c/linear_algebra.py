"""Matrix products, LU factors and triangular solutions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import jax
import numpy as np

from supple.errors import ModelError
from supple.export.c.blocks import CodeBlock, loops
from supple.export.c.operations import ArrayOperation
from supple.export.c.printer import Shapes, Values, rule
from supple.export.c.values import BufferView, UniformValue, Value, c_type, joined, row_major


@rule("dot_general")
def _dot(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    """`out[b, m, n] = sum over k of left[b, m, k] right[b, n, k]`; each letter is any number of axes."""
    (left_sum, right_sum), (left_batch, right_batch) = one.params["dimension_numbers"]
    if not all(value.size for value in inputs):
        return [UniformValue(tuple(outputs[0].shape), np.dtype(outputs[0].dtype), 0)]
    left, right = (block.view(value) for value in inputs)
    left_free = [axis for axis in range(len(left.shape)) if axis not in (*left_sum, *left_batch)]
    right_free = [axis for axis in range(len(right.shape)) if axis not in (*right_sum, *right_batch)]
    target = block.array(outputs[0].shape, outputs[0].dtype)
    if not target.size:
        return [target]
    summed = [left.shape[axis] for axis in left_sum]
    left, right = _streamed(block, left, left_free), _streamed(block, right, right_free)

    batch, of_batch = loops(outputs[0].shape[: len(left_batch)], "b")
    rows, of_rows = loops([left.shape[axis] for axis in left_free], "m")
    columns, of_columns = loops([right.shape[axis] for axis in right_free], "n")
    inner, of_sum = loops(summed, "k")

    def at(value: BufferView, parts: Sequence[tuple[Sequence[int], Sequence[str]]]) -> str:
        index = ["0"] * len(value.shape)
        for axes, own in parts:
            for axis, name in zip(axes, own, strict=True):
                index[axis] = name
        return value.at(index)

    a = at(left, [(left_batch, of_batch), (left_free, of_rows), (left_sum, of_sum)])
    b = at(right, [(right_batch, of_batch), (right_free, of_columns), (right_sum, of_sum)])
    out, kind = target.at([*of_batch, *of_rows, *of_columns]), c_type(target.dtype)
    if not inner:  # one term
        block.add(f"{batch}{rows}{columns}{out} = {a} * {b};")
    elif (columns and _runs_on(right, right_free)) or (rows and not columns and _runs_on(left, left_free)):
        # The innermost loop runs over independent sums, so that compilers vectorise it. They must not reorder
        # the terms of a single sum.
        head, after = (batch + rows, columns) if columns else (batch, rows)
        block.add(f"{head}{{ {after}{out} = 0; {inner}{after}{out} += {a} * {b}; }}")
    else:
        block.add(f"{batch}{rows}{columns}{{ {kind} sum = 0; {inner}sum += {a} * {b}; {out} = sum; }}")
    return [target]


def _runs_on(value: BufferView, free: Sequence[int]) -> bool:
    """Whether elements are contiguous along the last free axis that has more than one entry."""
    long = [axis for axis in free if value.shape[axis] > 1]
    return bool(long) and value.strides[long[-1]] == 1


def _streamed(block: CodeBlock, value: BufferView, free: Sequence[int]) -> BufferView:
    """Constants reordered so that their last free axis is contiguous; other values are not changed."""
    if value.known is None or _runs_on(value, free) or not any(value.shape[axis] > 1 for axis in free):
        return value
    order = [*(axis for axis in range(len(value.shape)) if axis not in free), *free]
    again = block.known(np.ascontiguousarray(np.transpose(value.known, order)))
    if not isinstance(again, BufferView):
        return value
    strides = [0] * len(order)
    for place, axis in enumerate(order):
        strides[axis] = row_major(again.shape)[place]
    return replace(again, shape=value.shape, strides=tuple(strides), known=None)


@rule("lu")
def _lu(block: CodeBlock, _one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    factors = _array(block, outputs[0])
    block.assign(factors, inputs[0])
    pivots, order = (_array(block, each) for each in outputs[1:])
    *batch, n, m = factors.shape
    for number in range(int(np.prod(batch, dtype=int))):
        least = min(n, m)
        block.add(
            f"lu_({_pointer(factors, number * n * m)}, {n}, {m}, {_pointer(pivots, number * least)}, "
            f"{_pointer(order, number * n)});"
        )
    return [factors, pivots, order]


def _array(block: CodeBlock, one: jax.ShapeDtypeStruct | Value) -> BufferView:
    """Storage for a C function that takes its address: an array, also for a single element."""
    view = block.array(one.shape, one.dtype)
    view.buffer.is_scalar = False
    return view


def _pointer(view: BufferView, offset: int) -> str:
    place = view.offset + offset
    return joined(view.buffer.text, view.shift, str(place) if place else "")


@rule("triangular_solve")
def _triangular(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    if one.params["conjugate_a"]:
        raise ModelError("C export has no complex numbers: write the law or controller with real numbers")
    matrix = block.in_order(inputs[0])
    if matrix.buffer.is_scalar:
        source, matrix = matrix, _array(block, matrix)
        block.assign(matrix, source)
    solution = _array(block, outputs[0])
    block.assign(solution, inputs[1])
    left = one.params["left_side"]
    *batch, rows, columns = solution.shape
    n, many = (rows, columns) if left else (columns, rows)
    steps = (columns, 1) if left else (1, columns)
    # With the unknown on the left, x A = b is solved as A^T x^T = b^T.
    turned = bool(one.params["transpose_a"]) == bool(left)
    lower = bool(one.params["lower"]) != turned
    across, along = (1, n) if turned else (n, 1)
    for number in range(int(np.prod(batch, dtype=int))):
        block.add(
            f"triangular_({_pointer(matrix, number * n * n)}, {across}, {along}, "
            f"{_pointer(solution, number * rows * columns)}, {steps[0]}, {steps[1]}, {n}, {many}, "
            f"{int(lower)}, {int(bool(one.params['unit_diagonal']))});"
        )
    return [solution]
