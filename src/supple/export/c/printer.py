"""Translation of a traced program to C: one rule per primitive, by its name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count

import jax
import numpy as np

from supple.errors import ModelError
from supple.export.c.blocks import CodeBlock, Constants
from supple.export.c.operations import ArrayOperation, Atom, Program, with_known
from supple.export.c.separate_functions import SeparateFunctions
from supple.export.c.values import BufferView, Computed, UniformValue, Value

Values = Sequence[Value]
Shapes = Sequence[jax.ShapeDtypeStruct]
Rule = Callable[[CodeBlock, ArrayOperation, Values, Shapes], Values]
"""Function (block, operation, inputs, shapes and types of the outputs) -> outputs."""

RULES: dict[str, Rule] = {}
"""Rules by the name of the primitive."""

_DEEPEST = 24
"""Largest depth of an expression; deeper values are stored, because compilers limit nested parentheses."""


def rule(*names: str) -> Callable[[Rule], Rule]:
    """Decorator that registers the rule of some primitives."""

    def registered(function: Rule) -> Rule:
        RULES.update(dict.fromkeys(names, function))
        return function

    return registered


def constants_in(values: Values) -> dict[int, np.ndarray]:
    """The constants among some values, by their position."""
    found = {}
    for place, value in enumerate(values):
        if isinstance(value, UniformValue):
            found[place] = np.full(value.shape, value.number, dtype=value.dtype)
        elif isinstance(value, BufferView) and value.known is not None:
            found[place] = value.known
    return found


def print_block(block: CodeBlock, program: Program, inputs: Values) -> list[Value]:
    """Append the statements of a program to a block; returns the outputs of the program.

    Operations on constants are evaluated now, not in C.

    Raises ModelError for a primitive without a rule.
    """
    known = {program.inputs[place]: value for place, value in constants_in(inputs).items()}
    program = with_known(program, known)
    uses = program.uses()
    values: dict[int, Value] = dict(zip(program.inputs, inputs, strict=True))
    depths: dict[int, int] = {}

    def value(atom: Atom) -> Value:
        return values[atom] if isinstance(atom, int) else block.known(atom)

    for each in program.operations:
        if each.name not in RULES:
            raise ModelError(
                f"the machine's equations use the operation '{each.name}', which has no translation to "
                "C yet, usually in a law, a load or a controller of your own: write this function with "
                "arithmetic, comparisons, jnp.where, sums and products"
            )
        shapes = [program.shapes[number] for number in each.outputs]
        found = RULES[each.name](block, each, [value(atom) for atom in each.inputs], shapes)
        deep = 1 + max((depths.get(atom, 0) for atom in each.inputs if isinstance(atom, int)), default=0)
        for number, own in zip(each.outputs, found, strict=True):
            if isinstance(own, Computed) and (uses.get(number, 0) > 1 or deep > _DEEPEST):
                values[number] = block.stored(own)
            else:
                values[number] = own
            depths[number] = deep if isinstance(values[number], Computed) else 0
    return [value(atom) for atom in program.outputs]


@dataclass(frozen=True)
class Printed:
    """A program as C text."""

    body: str
    """Declarations and statements of the function"""
    before: str
    """Tables of constants and functions for parts of a long body, at file scope before the function"""


def print_program(
    program: Program,
    inputs: Mapping[int, Value],
    store: Callable[[CodeBlock, Values], None],
    functions: SeparateFunctions,
) -> Printed:
    """The C text of a program.

    inputs : values in C by the number of the input;   store : appends the statements that store the outputs
    functions : empty, with the name and the parameters of the C function
    """
    constants = Constants(f"{functions.name}_")
    block = CodeBlock(constants, functions, count())
    store(block, print_block(block, program, [inputs[number] for number in program.inputs]))
    body = block.text()
    parts = [constants.text(), functions.text()]
    return Printed(functions.storage() + body, "\n\n".join(part for part in parts if part))
