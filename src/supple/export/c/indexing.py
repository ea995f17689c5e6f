"""Gather and scatter: elements read and written at indices that are computed at run time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from supple.export.c.blocks import CodeBlock
from supple.export.c.operations import ArrayOperation
from supple.export.c.printer import RULES, Shapes, Values, constants_in, rule
from supple.export.c.values import Computed, Index, UniformValue, Value, literal


def _sum(a: str, b: str) -> str:
    if a == "0":
        return b
    if b == "0":
        return a
    return str(int(a) + int(b)) if a.isdigit() and b.isdigit() else f"({a} + {b})"


class _Starts:
    """First indices of the windows of an operand, one window per row of `indices`."""

    def __init__(
        self, indices: Value, mapped: Sequence[int], room: Sequence[int], mode: object, *, writes: bool
    ) -> None:
        self._indices, self._mapped, self._room = indices, list(mapped), list(room)
        known = constants_in([indices]).get(0)
        rooms = np.array([self._room[axis] for axis in self._mapped])
        inside = known is not None and bool(((known >= 0) & (known <= rooms)).all())
        # PROMISE_IN_BOUNDS may be broken: XLA then reads the nearest element, and writes none.
        fills = "FILL" in str(mode) or (writes and "CLIP" not in str(mode))
        self._clips, self.drops = not inside and not fills, not inside and fills

    def start(self, row: Index, axis: int) -> str:
        """First index of a window along an axis of the operand, in C."""
        if axis not in self._mapped:
            return "0"
        number = self._indices.at([*row, str(self._mapped.index(axis))])
        return f"within_({number}, {self._room[axis]})" if self._clips else number

    def place(self, row: Index, batches: Mapping[int, int], offsets: Mapping[int, str], n: int) -> Index:
        """Index in the operand, of n axes, of an element of a window at `offsets` by axis.

        batches : the axis of `row` that gives the index along an axis of the operand
        """
        return [
            row[batches[axis]] if axis in batches else _sum(self.start(row, axis), offsets.get(axis, "0"))
            for axis in range(n)
        ]

    def outside(self, row: Index) -> str:
        """C condition that a window is outside the operand; "" if it never is."""
        if not self.drops:
            return ""
        tests = []
        for axis in self._mapped:
            number = self.start(row, axis)
            tests.append(f"{number} < 0 || {number} > {self._room[axis]}")
        return " || ".join(tests)


def _filling(dtype: np.dtype) -> float:
    """The value that JAX reads outside an array, if none is given."""
    if dtype.kind == "f":
        return np.nan
    return dtype.kind == "b" or (np.iinfo(dtype).min if dtype.kind == "i" else np.iinfo(dtype).max)


@rule("gather")
def _gather(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    operand, indices = block.stored(inputs[0]), block.stored(inputs[1])
    numbers, sizes = one.params["dimension_numbers"], one.params["slice_sizes"]
    shape, dtype = tuple(outputs[0].shape), outputs[0].dtype
    room = [n - own for n, own in zip(operand.shape, sizes, strict=True)]
    starts = _Starts(indices, numbers.start_index_map, room, one.params["mode"], writes=False)
    left_out = (*numbers.collapsed_slice_dims, *numbers.operand_batching_dims)
    windows = [axis for axis in range(len(operand.shape)) if axis not in left_out]
    batches = dict(zip(numbers.operand_batching_dims, numbers.start_indices_batching_dims, strict=True))
    filling = one.params["fill_value"]
    filling = filling if filling is not None else _filling(np.dtype(dtype))
    if isinstance(operand, UniformValue) and not starts.drops:
        return [UniformValue(shape, operand.dtype, operand.number)]

    def by_index(index: Index) -> str:
        row = [i for axis, i in enumerate(index) if axis not in numbers.offset_dims]
        offsets = dict(zip(windows, [index[axis] for axis in numbers.offset_dims], strict=True))
        place = starts.place(row, batches, offsets, len(operand.shape))
        element, outside = operand.at(place), starts.outside(row)
        return f"(({outside}) ? {literal(filling, dtype)} : {element})" if outside else element

    return [Computed(shape, np.dtype(dtype), by_index)]


def _scattered(
    change: Callable[[str, str], str], block: CodeBlock, one: ArrayOperation, inputs: Values, _outputs: Shapes
) -> Values:
    operand, indices, updates = inputs[0], block.stored(inputs[1]), block.stored(inputs[2])
    numbers = one.params["dimension_numbers"]
    target = block.copied(operand)
    left_out = (*numbers.inserted_window_dims, *numbers.operand_batching_dims)
    windows = [axis for axis in range(len(operand.shape)) if axis not in left_out]
    batches = dict(zip(numbers.operand_batching_dims, numbers.scatter_indices_batching_dims, strict=True))
    sizes = dict(zip(windows, [updates.shape[axis] for axis in numbers.update_window_dims], strict=True))
    room = [n - sizes.get(axis, 1) for axis, n in enumerate(operand.shape)]
    starts = _Starts(indices, numbers.scatter_dims_to_operand_dims, room, one.params["mode"], writes=True)

    def statement(index: Index) -> str:
        row = [i for axis, i in enumerate(index) if axis not in numbers.update_window_dims]
        offsets = dict(zip(windows, [index[axis] for axis in numbers.update_window_dims], strict=True))
        place = starts.place(row, batches, offsets, len(operand.shape))
        element, outside = target.at(place), starts.outside(row)
        own = f"{element} = {change(element, updates.at(index))};"
        return f"if (!({outside})) {own}" if outside else own

    block.each(updates.shape, statement)
    return [target]


for _name, _change in {
    "": lambda _, new: new,
    "-add": lambda old, new: f"{old} + {new}",
    "-sub": lambda old, new: f"{old} - {new}",
    "-mul": lambda old, new: f"{old} * {new}",
    "-max": lambda old, new: f"larger_({old}, {new})",
    "-min": lambda old, new: f"smaller_({old}, {new})",
}.items():
    RULES[f"scatter{_name}"] = RULES[f"scatter{_name.replace('-', '_')}"] = partial(_scattered, _change)
