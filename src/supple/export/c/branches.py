"""Loops and branches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from supple.export.c.blocks import CodeBlock
from supple.export.c.operations import ArrayOperation, Program, program_of
from supple.export.c.printer import Shapes, Values, constants_in, print_block, rule
from supple.export.c.values import BufferView, UniformValue, Value, joined


def _carried(block: CodeBlock, body: Program, n_before: int, first: Values) -> tuple[list[Value], list[bool]]:
    """The values that a loop carries, stored with their first values, and whether the loop changes each."""
    own = zip(first, body.inputs[n_before:], body.outputs, strict=False)
    changes = [not (isinstance(after, int) and after == before) for _, before, after in own]
    does = zip(first, changes, strict=True)
    return [block.copied(value) if each else block.stored(value) for value, each in does], changes


def hand_on(block: CodeBlock, carried: Values, after: Values, changes: Sequence[bool]) -> None:
    """Assign the results of an iteration to the carried values, as one simultaneous assignment."""
    moves = [(old, new) for old, new, does in zip(carried, after, changes, strict=True) if does]
    buffers = {id(old.buffer) for old, _ in moves if isinstance(old, BufferView)}
    ready = []
    for old, new in moves:
        is_own = isinstance(new, BufferView) and id(new.buffer) not in buffers
        ready.append((old, new if is_own or isinstance(new, UniformValue) else block.copied(new)))
    for old, new in ready:
        assert isinstance(old, BufferView)
        block.assign(old, new)


@rule("while")
def _while(block: CodeBlock, one: ArrayOperation, inputs: Values, _outputs: Shapes) -> Values:
    condition, body = program_of(one.params["cond_jaxpr"]), program_of(one.params["body_jaxpr"])
    n_condition, n_body = one.params["cond_nconsts"], one.params["body_nconsts"]
    held = [block.stored(value) for value in inputs[: n_condition + n_body]]
    of_condition, of_body = held[:n_condition], held[n_condition:]
    carried, changes = _carried(block, body, n_body, inputs[n_condition + n_body :])

    inner = block.inner()
    (continues,) = print_block(inner, condition, [*of_condition, *carried])
    inner.leave_unless(continues.at(()))
    after = print_block(inner, body, [*of_body, *carried])
    hand_on(inner, carried, after, changes)
    block.add(f"for (;;) {{\n{inner.text()}\n}}")
    return carried


@rule("scan")
def _scan(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    body, length = program_of(one.params["jaxpr"]), one.params["length"]
    n_held, n_carried = one.params["num_consts"], one.params["num_carry"]
    held = [block.stored(value) for value in inputs[:n_held]]
    carried, changes = _carried(block, body, n_held, inputs[n_held : n_held + n_carried])
    along = [block.stored(value) for value in inputs[n_held + n_carried :]]
    number = block.array((), np.dtype(np.int32)).at(())
    rows = [block.array(each.shape, each.dtype) for each in outputs[n_carried:]]

    inner = block.inner()
    place = f"({length - 1} - {number})" if one.params["reverse"] else number
    own = [_row(value, place) for value in along]
    after = print_block(inner, body, [*held, *carried, *own])
    for row, value in zip(rows, after[n_carried:], strict=True):
        inner.assign(_row_of(row, place), value)
    hand_on(inner, carried, after[:n_carried], changes)
    block.add(f"for ({number} = 0; {number} < {length}; ++{number}) {{\n{inner.text()}\n}}")
    return [*carried, *rows]


def _row(value: Value, place: str) -> Value:
    if isinstance(value, UniformValue):
        return replace(value, shape=value.shape[1:])
    assert isinstance(value, BufferView)
    return _row_of(value, place)


def _row_of(value: BufferView, place: str) -> BufferView:
    stride = value.strides[0]
    shift = "" if value.shape[0] == 1 or not stride else f"{stride} * {place}"
    whole = joined(value.shift, shift)
    return replace(value, shape=value.shape[1:], strides=value.strides[1:], shift=whole, known=None)


@rule("cond")
def _cond(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    branches = [program_of(branch) for branch in one.params["branches"]]
    which, operands = inputs[0], [block.stored(value) for value in inputs[1:]]
    known = constants_in([which]).get(0)
    if known is not None:
        return print_block(block, branches[int(np.clip(known, 0, len(branches) - 1))], operands)
    targets = [block.array(each.shape, each.dtype) for each in outputs]
    number = block.array((), np.dtype(np.int32)).at(())
    block.add(f"{number} = (int32_t)within_({which.at(())}, {len(branches) - 1});")
    text = ""
    for place, branch in enumerate(branches):
        inner = block.inner()
        for target, value in zip(targets, print_block(inner, branch, operands), strict=True):
            inner.assign(target, value)
        head = (
            "else"
            if place == len(branches) - 1 and place
            else f"{'else ' if place else ''}if ({number} == {place})"
        )
        text += f"{head} {{\n{inner.text()}\n}}\n"
    block.add(text)
    return list(targets)
