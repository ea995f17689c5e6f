"""Traced programs as lists of operations: calls inlined, unused values removed, constants computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import jax
import numpy as np
from jax.extend import core
from numpy.typing import ArrayLike

from supple.equations.compiler_options import STARTING

_CALLS = {
    "jit": "jaxpr",
    "pjit": "jaxpr",
    "closed_call": "call_jaxpr",
    "core_call": "call_jaxpr",
    "remat": "jaxpr",
    "checkpoint": "jaxpr",
    "custom_jvp_call": "call_jaxpr",
    "custom_vjp_call": "call_jaxpr",
    "custom_vmap_call": "call",
}
"""For each primitive that only calls a program, the name of the parameter that contains the program."""

_CONTROL = {"while", "cond", "scan"}

Atom = int | np.ndarray
"""The number of a value of the program, or a constant."""


@dataclass(frozen=True)
class ArrayOperation:
    """One JAX primitive with its operands and results."""

    primitive: core.Primitive
    inputs: tuple[Atom, ...]
    outputs: tuple[int, ...]
    params: dict[str, Any]

    @property
    def name(self) -> str:
        """Name of the primitive."""
        return str(self.primitive.name)


@dataclass(frozen=True)
class Program:
    """Operations in order, on numbered values with known shapes."""

    inputs: tuple[int, ...]
    outputs: tuple[Atom, ...]
    operations: tuple[ArrayOperation, ...]
    shapes: dict[int, jax.ShapeDtypeStruct]

    def uses(self) -> dict[int, int]:
        """How often each value is read."""
        found: dict[int, int] = {}
        for atom in [a for each in self.operations for a in each.inputs] + list(self.outputs):
            if isinstance(atom, int):
                found[atom] = found.get(atom, 0) + 1
        return found


def program_of(closed: core.ClosedJaxpr) -> Program:
    """The operations of a traced program that its outputs depend on, with calls inlined."""
    numbers, shapes = count(), {}
    operations: list[ArrayOperation] = []

    def numbered(variable: Any) -> int:
        number = next(numbers)
        shapes[number] = jax.ShapeDtypeStruct(variable.aval.shape, variable.aval.dtype)
        return number

    def written_out(inner: core.Jaxpr, constants: Sequence[ArrayLike], inputs: Sequence[Atom]) -> list[Atom]:
        known: dict[core.Var, Atom] = {
            variable: np.asarray(value) for variable, value in zip(inner.constvars, constants, strict=True)
        }
        known |= dict(zip(inner.invars, inputs, strict=True))

        def atom(variable: Any) -> Atom:
            if isinstance(variable, core.Literal):
                return np.asarray(variable.val, dtype=variable.aval.dtype)
            return known[variable]

        for equation in inner.eqns:
            own = [atom(variable) for variable in equation.invars]
            name = equation.primitive.name
            if name in _CALLS:
                called = equation.params[_CALLS[name]]
                results = written_out(called.jaxpr, called.consts, own)
                known.update(zip(equation.outvars, results, strict=True))
                continue
            if name == "custom_linear_solve":
                solve, lengths = equation.params["jaxprs"].solve, equation.params["const_lengths"]
                begin = lengths.matvec + lengths.vecmat
                held = own[begin : begin + lengths.solve]
                results = written_out(solve.jaxpr, solve.consts, [*held, *own[sum(lengths) :]])
                known.update(zip(equation.outvars, results, strict=True))
                continue
            outputs = tuple(numbered(variable) for variable in equation.outvars)
            known.update(zip(equation.outvars, outputs, strict=True))
            operations.append(ArrayOperation(equation.primitive, tuple(own), outputs, dict(equation.params)))
        return [atom(variable) for variable in inner.outvars]

    inputs = tuple(numbered(variable) for variable in closed.jaxpr.invars)
    outputs = tuple(written_out(closed.jaxpr, closed.consts, inputs))
    return Program(inputs, outputs, _needed(operations, outputs), shapes)


def _needed(operations: Sequence[ArrayOperation], outputs: Sequence[Atom]) -> tuple[ArrayOperation, ...]:
    wanted = {atom for atom in outputs if isinstance(atom, int)}
    kept = []
    for each in reversed(operations):
        if wanted.intersection(each.outputs):
            kept.append(each)
            wanted |= {atom for atom in each.inputs if isinstance(atom, int)}
    return tuple(reversed(kept))


def with_known(program: Program, known: dict[int, np.ndarray]) -> Program:
    """The program with some inputs replaced by constants; operations on constants are replaced by results."""
    found: set[int] = set(known)
    first, rest = [], []
    for each in program.operations:
        is_known = all(not isinstance(atom, int) or atom in found for atom in each.inputs)
        if is_known and each.name not in _CONTROL:
            first.append(each)
            found.update(each.outputs)
        else:
            rest.append(each)
    values = known | _computed(first, known)

    def atom(one: Atom) -> Atom:
        return values.get(one, one) if isinstance(one, int) else one

    left = [
        ArrayOperation(each.primitive, tuple(atom(one) for one in each.inputs), each.outputs, each.params)
        for each in rest
    ]
    outputs = tuple(atom(one) for one in program.outputs)
    return Program(program.inputs, outputs, _needed(left, outputs), program.shapes)


def _computed(operations: Sequence[ArrayOperation], known: dict[int, np.ndarray]) -> dict[int, np.ndarray]:
    if not operations:
        return {}
    wanted = [number for each in operations for number in each.outputs]
    atoms = [atom for each in operations for atom in each.inputs]
    given = {atom: known[atom] for atom in atoms if isinstance(atom, int) and atom in known}
    literals = [atom for atom in atoms if not isinstance(atom, int)]

    def evaluate(start: dict[int, Any], constants: list[Any]) -> list[Any]:
        values, rest = dict(start), iter(constants)
        for each in operations:
            own = [values[atom] if isinstance(atom, int) else next(rest) for atom in each.inputs]
            result = each.primitive.bind(*own, **each.params)
            results = result if each.primitive.multiple_results else [result]
            values.update(zip(each.outputs, results, strict=True))
        return [values[number] for number in wanted]

    program = jax.jit(evaluate).lower(given, literals).compile(STARTING)
    found = jax.device_get(program(given, literals))
    return dict(zip(wanted, map(np.asarray, found), strict=True))
