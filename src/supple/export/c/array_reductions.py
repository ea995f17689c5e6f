"""C code for sums, products and extremes along axes, also cumulative, and for sorting."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from supple.errors import ModelError
from supple.export.c.blocks import CodeBlock, loops
from supple.export.c.operations import ArrayOperation
from supple.export.c.printer import RULES, Shapes, Values, rule
from supple.export.c.values import UniformValue, Value, c_type, literal

_FORMS: dict[str, tuple[float, Callable[[str, str], str]]] = {
    "sum": (0, lambda total, term: f"{total} + {term}"),
    "prod": (1, lambda total, term: f"{total} * {term}"),
    "and": (True, lambda total, term: f"{total} && {term}"),
    "or": (False, lambda total, term: f"{total} || {term}"),
    "max": (float("-inf"), lambda total, term: f"larger_({total}, {term})"),
    "min": (float("inf"), lambda total, term: f"smaller_({total}, {term})"),
}
_LOGICAL = {"max": "or", "min": "and"}


def _form(name: str, value: Value) -> tuple[str, Callable[[str, str], str]]:
    """The start of a reduction in C, and the form of its step, for the type of its numbers."""
    kind = value.dtype.kind
    first, form = _FORMS[_LOGICAL.get(name, name) if kind == "b" else name]
    if kind in "iu":
        limits = np.iinfo(value.dtype)
        whole = {
            "and": (-1 if kind == "i" else limits.max, lambda total, term: f"{total} & {term}"),
            "or": (0, lambda total, term: f"{total} | {term}"),
            "max": (limits.min, lambda total, term: f"larger_int_({total}, {term})"),
            "min": (limits.max, lambda total, term: f"smaller_int_({total}, {term})"),
        }
        first, form = whole.get(name, (first, form))
    return literal(first, value.dtype), form


def _reduced(name: str, block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, axes = inputs[0], set(one.params["axes"])
    start, form = _form(name, value)
    target = block.array(outputs[0].shape, outputs[0].dtype)
    heads, index = loops([n for axis, n in enumerate(value.shape) if axis not in axes], "i")
    inner, summed = loops([n for axis, n in enumerate(value.shape) if axis in axes], "k")
    own, along = iter(index), iter(summed)
    whole = [next(along) if axis in axes else next(own) for axis in range(len(value.shape))]
    kind = c_type(value.dtype)
    term = form("sum", value.at(whole)) if value.size else "sum"
    block.add(
        f"{heads}{{ {kind} sum = {start}; "
        + (f"{inner}sum = {term}; " if value.size else "")
        + f"{target.at(index)} = sum; }}"
    )
    return [target]


for _name in _FORMS:
    RULES[f"reduce_{_name}"] = partial(_reduced, _name)


@rule("argmax", "argmin")
def _extreme(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, axis = block.stored(inputs[0]), one.params["axes"][0]
    if value.shape[axis] == 1:
        return [UniformValue(tuple(outputs[0].shape), np.dtype(outputs[0].dtype), 0)]
    target = block.array(outputs[0].shape, outputs[0].dtype)
    heads, index = loops(outputs[0].shape, "i")
    first, at = (value.at([*index[:axis], place, *index[axis:]]) for place in ("0", "k"))
    kind, worse = c_type(value.dtype), "<=" if one.name == "argmax" else ">="
    block.add(
        f"{heads}{{ {kind} best = {first}; int where = 0; "
        f"for (int k = 1; k < {value.shape[axis]}; ++k) "
        # NaN counts as the extreme; the first NaN is taken.
        f"if (best == best && !({at} {worse} best)) {{ best = {at}; where = k; }} "
        f"{target.at(index)} = where; }}"
    )
    return [target]


def _running(name: str, block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    value, axis = block.stored(inputs[0]), one.params["axis"]
    start, form = _form(name, value)
    target = block.array(outputs[0].shape, outputs[0].dtype)
    n, backward = value.shape[axis], one.params["reverse"]
    heads, index = loops([1 if place == axis else m for place, m in enumerate(value.shape)], "i")
    index[axis] = "j" if n > 1 else "0"
    place = f"{n - 1} - k" if backward else "k"
    block.add(
        f"{heads}{{ {c_type(value.dtype)} sum = {start}; for (int k = 0; k < {n}; ++k) {{ "
        f"const int j = {place}; (void)j; "
        f"sum = {form('sum', value.at(index))}; {target.at(index)} = sum; }} }}"
    )
    return [target]


for _name, _form_name in {"cumsum": "sum", "cumprod": "prod", "cummax": "max", "cummin": "min"}.items():
    RULES[_name] = partial(_running, _form_name)


@rule("sort")
def _sort(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    if len(outputs[0].shape) != 1 or one.params["num_keys"] != 1:
        raise ModelError("C export can sort one-dimensional arrays by one key only: sort each row separately")
    arrays = [block.copied(value) for value in inputs]
    n = outputs[0].shape[0]
    if n < 2:
        return list(arrays)
    takes = " ".join(
        f"const {c_type(own.dtype)} own{place} = {own.at(('i',))};" for place, own in enumerate(arrays)
    )
    moves = " ".join(f"{own.at(('j',))} = {own.at(('j - 1',))};" for own in arrays)
    puts = " ".join(f"{own.at(('j',))} = own{place};" for place, own in enumerate(arrays))
    key = arrays[0].at(("j - 1",))
    # NaN is sorted last.
    after = f"({key} > own0 || ({key} != {key} && own0 == own0))"
    block.add(
        f"for (int i = 1; i < {n}; ++i) {{ {takes} int j = i; "
        f"for (; j > 0 && {after}; --j) {{ {moves} }} {puts} }}"
    )
    return list(arrays)
