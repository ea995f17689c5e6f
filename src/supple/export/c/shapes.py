"""Primitives that rearrange elements, as views of stored arrays where possible, otherwise as copies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from supple.export.c.blocks import CodeBlock
from supple.export.c.operations import ArrayOperation
from supple.export.c.printer import Rule, Shapes, Values, rule
from supple.export.c.values import (
    BufferView,
    Computed,
    Index,
    UniformValue,
    Value,
    joined,
    literal,
    row_major,
)


def _viewed(value: BufferView, shape: Sequence[int], strides: Sequence[int], offset: int = 0) -> BufferView:
    return replace(
        value, shape=tuple(shape), strides=tuple(strides), offset=value.offset + offset, known=None
    )


def _rearranges(*names: str) -> Callable[[Rule], Rule]:
    """Decorator as `rule`, of primitives whose result from equal constants has the same constants."""

    def registered(function: Rule) -> Rule:
        @rule(*names)
        def ruled(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
            value = inputs[0]
            if isinstance(value, UniformValue):
                return [replace(value, shape=tuple(each.shape)) for each in outputs]
            return function(block, one, inputs, outputs)

        return ruled

    return registered


def _moved(value: Value, shape: tuple[int, ...], axes: Mapping[int, int], *, in_order: bool = True) -> Value:
    """The value with its axes at other places.

    axes : axis of the value at each place of the new shape; along all others the elements are the same
    in_order : the elements keep their row-major order
    """
    if isinstance(value, BufferView):
        strides = [0] * len(shape)
        for place, axis in axes.items():
            strides[place] = value.strides[axis]
        return _viewed(value, shape, strides)

    def by_index(index: Index) -> str:
        own = ["0"] * len(value.shape)
        for place, axis in axes.items():
            own[axis] = index[place]
        return value.at(own)

    return Computed(shape, value.dtype, by_index, *([value.flat] if in_order else []))


@_rearranges("broadcast_in_dim")
def _broadcast(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, shape, places = inputs[0], tuple(outputs[0].shape), one.params["broadcast_dimensions"]
    if not (isinstance(value, Computed) and value.size == int(np.prod(shape, dtype=int))):
        value = block.view(value)
    return [_moved(value, shape, {places[axis]: axis for axis, n in enumerate(value.shape) if n > 1})]


@_rearranges("transpose")
def _transpose(_block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    axes = dict(enumerate(one.params["permutation"]))
    return [_moved(inputs[0], tuple(outputs[0].shape), axes, in_order=False)]


@_rearranges("slice")
def _slice(_block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, shape = inputs[0], tuple(outputs[0].shape)
    starts = one.params["start_indices"]
    steps = one.params["strides"] or (1,) * len(starts)
    if isinstance(value, BufferView):
        strides = [a * b for a, b in zip(value.strides, steps, strict=True)]
        return [
            _viewed(value, shape, strides, sum(a * b for a, b in zip(starts, value.strides, strict=True)))
        ]

    def by_index(index: Index) -> str:
        return value.at([placed(i, start, step) for i, start, step in zip(index, starts, steps, strict=True)])

    return [Computed(shape, value.dtype, by_index)]


def placed(index: str, start: int, step: int = 1) -> str:
    """`start + step index` in C."""
    if index.isdigit():
        return str(start + step * int(index))
    scaled = index if step == 1 else f"{step} * {index}"
    return f"({start} + {scaled})" if start else scaled


@_rearranges("squeeze", "expand_dims", "reshape")
def _reshape(block: CodeBlock, _one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, shape = inputs[0], tuple(outputs[0].shape)
    if value.shape == shape:
        return [value]
    long = [axis for axis, n in enumerate(value.shape) if n > 1]
    places = [place for place, n in enumerate(shape) if n > 1]
    if [value.shape[axis] for axis in long] == [shape[place] for place in places]:
        return [_moved(value, shape, dict(zip(places, long, strict=True)))]
    if isinstance(value, Computed) and value.flat("0") is None:
        value = block.copied(value)
    if isinstance(value, Computed):
        of_number = value

        def by_index(index: Index) -> str:
            strides = row_major(shape)
            terms = [
                placed(i, 0, stride) for i, stride, n in zip(index, strides, shape, strict=True) if n > 1
            ]
            return str(of_number.flat(f"({' + '.join(terms) or '0'})"))

        return [Computed(shape, value.dtype, by_index, value.by_number)]
    return [_viewed(block.in_order(value), shape, row_major(shape))]


@_rearranges("rev")
def _reverse(block: CodeBlock, one: ArrayOperation, inputs: Values, _outputs: Shapes) -> Values:
    value = block.view(inputs[0])
    axes = one.params["dimensions"]
    strides = [-s if axis in axes else s for axis, s in enumerate(value.strides)]
    offset = sum((value.shape[axis] - 1) * value.strides[axis] for axis in axes)
    return [_viewed(value, value.shape, strides, offset)]


@rule("iota")
def _iota(_block: CodeBlock, one: ArrayOperation, _inputs: Values, outputs: Shapes) -> Values:
    axis, dtype = one.params["dimension"], np.dtype(outputs[0].dtype)
    cast = "(double)" if dtype.kind == "f" else ""
    return [Computed(tuple(outputs[0].shape), dtype, lambda index: f"({cast}{index[axis]})")]


@rule("concatenate")
def _concatenate(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    axis = one.params["dimension"]
    target = block.array(outputs[0].shape, outputs[0].dtype)
    if target.size == 1:
        return [value for value in inputs if value.size][:1]
    start = 0
    for value in inputs:
        block.assign(_viewed(target, value.shape, target.strides, start * target.strides[axis]), value)
        start += value.shape[axis]
    return [target]


@rule("stack")
def _stack(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    axis = one.params.get("axis", one.params.get("dimension", 0))
    target = block.array(outputs[0].shape, outputs[0].dtype)
    strides = [s for place, s in enumerate(target.strides) if place != axis]
    for number, value in enumerate(inputs):
        block.assign(_viewed(target, value.shape, strides, number * target.strides[axis]), value)
    return [target]


@_rearranges("split")
def _split(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, axis, start, parts = block.view(inputs[0]), one.params["axis"], 0, []
    for each in outputs:
        parts.append(_viewed(value, each.shape, value.strides, start * value.strides[axis]))
        start += each.shape[axis]
    return parts


@_rearranges("unstack")
def _unstack(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, axis = block.view(inputs[0]), one.params["axis"]
    strides = (*value.strides[:axis], *value.strides[axis + 1 :])
    return [
        _viewed(value, each.shape, strides, place * value.strides[axis]) for place, each in enumerate(outputs)
    ]


@rule("pad")
def _pad(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, filling = inputs
    target = block.array(outputs[0].shape, outputs[0].dtype)
    number = filling.at(())
    size = target.size
    if target.buffer.is_scalar:
        block.add(f"{target.at(('0',))} = {number};")
    else:
        block.add(f"for (int i = 0; i < {size}; ++i) {target.flat('i')} = {number};")
    low = [config[0] for config in one.params["padding_config"]]
    step = [config[2] + 1 for config in one.params["padding_config"]]
    shape, first = [], []
    for n, lo, by, room in zip(value.shape, low, step, target.shape, strict=True):
        skipped = max(0, -(lo // by) if lo < 0 else 0)
        first.append(skipped)
        shape.append(max(0, min(n - skipped, (room - lo - skipped * by + by - 1) // by)))
    offset = sum((lo + f * by) * s for lo, f, by, s in zip(low, first, step, target.strides, strict=True))
    strides = [s * by for s, by in zip(target.strides, step, strict=True)]
    inner = Computed(
        tuple(shape),
        value.dtype,
        lambda index: value.at([placed(i, f) for i, f in zip(index, first, strict=True)]),
    )
    if inner.size:
        block.assign(_viewed(target, shape, strides, offset), inner)
    return [target]


@_rearranges("dynamic_slice")
def _dynamic_slice(block: CodeBlock, _one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, shape = block.view(inputs[0]), tuple(outputs[0].shape)
    shift = _shift(block, value, shape, inputs[1:])
    return [replace(_viewed(value, shape, value.strides), shift=joined(value.shift, shift))]


@rule("dynamic_update_slice")
def _update(block: CodeBlock, _one: ArrayOperation, inputs: Values, _outputs: Shapes) -> Values:
    target, part = block.copied(inputs[0]), inputs[1]
    if target.buffer.is_scalar:
        return [part]
    shift = _shift(block, target, part.shape, inputs[2:])
    block.assign(replace(_viewed(target, part.shape, target.strides), shift=shift), part)
    return [target]


def _shift(block: CodeBlock, value: BufferView, shape: Sequence[int], starts: Sequence[Value]) -> str:
    """Offset of a slice whose start is computed at run time, clipped so that the slice lies inside."""
    terms = []
    for start, stride, n, own in zip(starts, value.strides, value.shape, shape, strict=True):
        if n == own:
            continue
        place = block.array((), np.dtype(np.int32))
        block.add(f"{place.at(())} = (int32_t)within_({start.at(())}, {literal(n - own, np.int64)});")
        terms.append(placed(place.at(()), 0, stride))
    return " + ".join(terms)
