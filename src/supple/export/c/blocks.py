"""Blocks of C: statements in order, and storage for the arrays that they compute."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from supple.export.c.separate_functions import LONGEST, TOKEN, SeparateFunctions, runs_of_statements
from supple.export.c.values import Buffer, BufferView, Index, UniformValue, Value, c_type, literal, row_major

_UNROLLED = 4
"""Largest number of elements for which a loop is unrolled."""


@dataclass
class Constants:
    """Tables of constants of a function; equal tables are written once.

    prefix : prefix of the names of the tables
    """

    prefix: str = ""
    tables: dict[bytes, tuple[str, np.ndarray]] = field(default_factory=dict)

    def view(self, values: np.ndarray) -> Value:
        """An array of constants as a value; a UniformValue if all are equal."""
        values = np.array(values, order="C")
        if not values.size:
            return UniformValue(values.shape, values.dtype, 0)
        first = values.reshape(-1)[:1]
        if values.tobytes() == first.tobytes() * values.size:
            return UniformValue(values.shape, values.dtype, first[0])
        key = values.dtype.str.encode() + values.tobytes()
        name = self.tables.setdefault(key, (f"{self.prefix}c{len(self.tables)}", values.reshape(-1)))[0]
        buffer = Buffer(-1, values.dtype, values.size, name=name)
        return BufferView(values.shape, values.dtype, buffer, row_major(values.shape), known=values)

    def text(self) -> str:
        """Definitions of all tables in C."""
        lines = []
        for name, values in self.tables.values():
            cells = [literal(value, values.dtype) for value in values]
            rows = [", ".join(cells[start : start + 8]) for start in range(0, len(cells), 8)]
            body = ",\n    ".join(rows)
            lines.append(f"static const {c_type(values.dtype)} {name}[{len(cells)}] = {{\n    {body}}};")
        return "\n".join(lines)


@dataclass
class CodeBlock:
    """Statements in order; arrays reuse the storage of arrays that are no longer read."""

    constants: Constants
    functions: SeparateFunctions
    numbers: Iterable[int]
    statements: list[str] = field(default_factory=list)
    buffers: dict[int, Buffer] = field(default_factory=dict)
    _leaving: set[int] = field(default_factory=set)

    def inner(self) -> CodeBlock:
        """An empty block within this one."""
        return CodeBlock(self.constants, self.functions, self.numbers)

    def add(self, text: str) -> None:
        """Append a statement."""
        self.statements.append(text)

    def leave_unless(self, condition: str) -> None:
        """Append a statement that ends the loop whose body is this block, unless a condition holds."""
        self._leaving.add(len(self.statements))
        self.add(f"if (!{condition}) break;")

    def known(self, values: np.ndarray) -> Value:
        """An array of constants as a value."""
        return self.constants.view(np.asarray(values))

    def array(self, shape: Sequence[int], dtype: np.dtype) -> BufferView:
        """New storage for an array; a scalar variable if it has one element."""
        shape = tuple(shape)
        size = int(np.prod(shape, dtype=int))
        buffer = Buffer(next(iter(self.numbers)), np.dtype(dtype), size, is_scalar=size == 1)
        self.buffers[buffer.number] = buffer
        return BufferView(shape, np.dtype(dtype), buffer, row_major(shape))

    def stored(self, value: Value) -> BufferView | UniformValue:
        """The value in storage, so that reading it twice does not compute it twice."""
        return value if isinstance(value, UniformValue) else self.view(value)

    def view(self, value: Value) -> BufferView:
        """The value in storage, also one of equal constants."""
        return value if isinstance(value, BufferView) else self.copied(value)

    def in_order(self, value: Value) -> BufferView:
        """The value stored without gaps, in row-major order."""
        view = self.view(value)
        return view if view.is_contiguous else self.copied(view)

    def copied(self, value: Value) -> BufferView:
        """A copy of the value in new storage."""
        target = self.array(value.shape, value.dtype)
        self.assign(target, value)
        return target

    def assign(self, target: BufferView, value: Value) -> None:
        """Write all elements of a value into a target of the same shape."""
        size = value.size
        if not size:
            return
        flat, own = value.flat("i"), target.flat("i")
        if flat is not None and own is not None and size > _UNROLLED:
            self.add(f"for (int i = 0; i < {size}; ++i) {own} = {flat};")
            return
        self.each(value.shape, lambda index: f"{target.at(index)} = {value.at(index)};")

    def each(self, shape: Sequence[int], statement: Callable[[Index], str]) -> None:
        """Append a statement for every index, by loops; unrolled if the indices are few."""
        if 0 in shape:
            return
        if int(np.prod(shape, dtype=int)) <= _UNROLLED:
            self.add(" ".join(statement([str(i) for i in index]) for index in np.ndindex(*shape)))
            return
        heads, index = loops(shape)
        self.add(f"{heads}{{ {statement(index)} }}")

    def text(self) -> str:
        """The declarations and statements in C; a long block calls functions for its parts."""
        first: dict[int, int] = {}
        last: dict[int, int] = {}
        for place, statement in enumerate(self.statements):
            for number in set(map(int, TOKEN.findall(statement))) & self.buffers.keys():
                first.setdefault(number, place)
                last[number] = place
        statements = self._divided(first, last)
        functions = self.functions
        shared = [each for each in first if each in functions.shared and each not in functions.names]
        names, declarations = self._named(shared, first, last)
        functions.names |= {number: f"shared->{name}" for number, name in names.items()}
        functions.members += declarations
        read = {int(number) for statement in statements for number in TOKEN.findall(statement)}
        own = [number for number in first if number in read and number not in functions.names]
        local, lines = self._named(own, first, last)
        local |= functions.names

        def named(match: re.Match[str]) -> str:
            return local.get(int(match[1]), match[0])

        return "\n".join(lines + [TOKEN.sub(named, statement) for statement in statements])

    def _divided(self, first: Mapping[int, int], last: Mapping[int, int]) -> list[str]:
        """The statements; a long block becomes calls of functions, each with a run of its statements.

        first, last : indices of the first and the last statement that use a variable
        """
        lengths = [statement.count("\n") + 1 for statement in self.statements]
        if len(lengths) == 1 or sum(lengths) <= LONGEST:
            return self.statements
        found = []
        for run in runs_of_statements(lengths, self._leaving):
            statements = self.statements[run.start : run.stop]
            if run.start not in self._leaving:
                own = {
                    number: buffer
                    for number, buffer in self.buffers.items()
                    if number in first and first[number] in run and last[number] in run
                }
                part = CodeBlock(self.constants, self.functions, self.numbers, statements, own)
                statements = [self.functions.call(part.text())]
            found += statements
        return found

    def _named(
        self, numbers: Sequence[int], first: Mapping[int, int], last: Mapping[int, int]
    ) -> tuple[dict[int, str], list[str]]:
        """Names of some variables, and their declarations; arrays share storage if their uses allow it."""
        is_scalar = {number: self.buffers[number].is_scalar for number in numbers}
        arrays = [number for number in numbers if not is_scalar[number]]
        names, slots = self._slots(arrays, first, last)
        lines = [f"{kind} {name}[{max(size, 1)}];" for name, (kind, size) in slots.items()]
        scalars: dict[str, list[str]] = {}
        for number in numbers:
            if is_scalar[number]:
                names[number] = f"v{number}"
                scalars.setdefault(c_type(self.buffers[number].dtype), []).append(names[number])
        return names, lines + [f"{kind} {', '.join(own)};" for kind, own in scalars.items()]

    def _slots(
        self, arrays: Sequence[int], first: Mapping[int, int], last: Mapping[int, int]
    ) -> tuple[dict[int, str], dict[str, tuple[str, int]]]:
        """Storage of each array by name: a free slot that is large enough or can grow, or a new slot."""
        names: dict[int, str] = {}
        slots: dict[str, tuple[str, int]] = {}
        busy: dict[str, int] = {}
        for number in sorted(arrays, key=lambda one: first[one]):
            buffer = self.buffers[number]
            kind = c_type(buffer.dtype)
            free = [
                (size, name)
                for name, (own, size) in slots.items()
                if own == kind and busy[name] < first[number]
            ]
            enough = sorted(entry for entry in free if entry[0] >= buffer.size)
            close = [entry for entry in enough if entry[0] <= 4 * buffer.size + 16]
            if close:
                name = close[0][1]
            elif smaller := [entry for entry in free if buffer.size / 2 <= entry[0] < buffer.size]:
                name = max(smaller)[1]
                slots[name] = kind, buffer.size
            else:
                name = f"a{number}"
                slots[name] = kind, buffer.size
            names[number], busy[name] = name, last[number]
        return names, slots


def loops(shape: Sequence[int], letter: str = "i") -> tuple[str, list[str]]:
    """Headers of nested loops over a shape, and the index; axes of one entry have no loop."""
    heads, index = "", []
    for axis, n in enumerate(shape):
        if n == 1:
            index.append("0")
            continue
        name = f"{letter}{axis}"
        heads += f"for (int {name} = 0; {name} < {n}; ++{name}) "
        index.append(name)
    return heads, index
