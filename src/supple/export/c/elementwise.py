"""Elementwise primitives, computed where their result is read."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from supple.errors import ModelError
from supple.export.c.blocks import CodeBlock
from supple.export.c.operations import ArrayOperation
from supple.export.c.printer import RULES, Shapes, Values, rule
from supple.export.c.values import Computed, c_type


def _elementwise(block: CodeBlock, inputs: Values, outputs: Shapes, form: Callable[..., str]) -> Values:
    """The output with elements `form(*elements of the inputs)`; axes of one entry are broadcast."""
    shape, dtype = tuple(outputs[0].shape), np.dtype(outputs[0].dtype)
    size = math.prod(shape)
    # Broadcast operands are computed once.
    operands = [block.stored(own) if own.size < size else own for own in inputs]

    def by_index(index: Sequence[str]) -> str:
        return form(
            *(
                own.at(
                    [
                        i if n > 1 else "0"
                        for i, n in zip(index[len(index) - len(own.shape) :], own.shape, strict=True)
                    ]
                )
                for own in operands
            )
        )

    def by_number(number: str) -> str | None:
        parts = [
            own.flat(number)
            if own.size == size
            else own.at(("0",) * len(own.shape))
            if own.size == 1
            else None
            for own in operands
        ]
        return None if any(part is None for part in parts) else form(*parts)

    return [Computed(shape, dtype, by_index, by_number)]


def _register(name: str, form: Callable[..., str]) -> None:
    RULES[name] = lambda block, _one, inputs, outputs: _elementwise(block, inputs, outputs, form)


def _by_kind(name: str, **forms: Callable[..., str]) -> None:
    """Register a primitive whose form depends on the first operand: float, integer or boolean."""

    @rule(name)
    def _(block: CodeBlock, _one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
        kind = {"f": "real", "i": "whole", "u": "whole", "b": "logical"}[inputs[0].dtype.kind]
        if kind not in forms:
            raise ModelError(
                f"the machine's equations use the operation '{name}' of {inputs[0].dtype} numbers, which has "
                "no translation to C: convert them to floats first"
            )
        return _elementwise(block, inputs, outputs, forms[kind])


def _operator(sign: str) -> Callable[[str, str], str]:
    return lambda a, b: f"({a} {sign} {b})"


def _function(name: str) -> Callable[..., str]:
    return lambda *arguments: f"{name}({', '.join(arguments)})"


for _name, _sign in {"add": "+", "add_any": "+", "sub": "-", "mul": "*"}.items():
    _by_kind(
        _name, real=_operator(_sign), whole=_operator(_sign), logical=_operator({"+": "||"}.get(_sign, "&&"))
    )
for _name, _sign in {
    "eq": "==",
    "ne": "!=",
    "lt": "<",
    "le": "<=",
    "gt": ">",
    "ge": ">=",
    "lt_to": "<",
    "le_to": "<=",
}.items():
    _register(_name, _operator(_sign))
_register("div", _operator("/"))
_by_kind("rem", real=_function("fmod"), whole=_operator("%"))
_by_kind("neg", real=lambda a: f"(-{a})", whole=lambda a: f"(-{a})")
_by_kind("and", logical=_operator("&&"), whole=_operator("&"))
_by_kind("or", logical=_operator("||"), whole=_operator("|"))
_by_kind("xor", logical=_operator("!="), whole=_operator("^"))
_by_kind("not", logical=lambda a: f"(!{a})", whole=lambda a: f"(~{a})")
_by_kind("max", real=_function("larger_"), whole=_function("larger_int_"), logical=_operator("||"))
_by_kind("min", real=_function("smaller_"), whole=_function("smaller_int_"), logical=_operator("&&"))
_by_kind("abs", real=_function("fabs"), whole=_function("abs_int_"))
_by_kind("sign", real=_function("sign_"), whole=_function("sign_int_"))
_by_kind("square", real=_function("square_"), whole=_function("square_int_"))
_by_kind("pow", real=_function("pow"))
for _name in (
    *(
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "atan2",
        "sinh",
        "cosh",
        "tanh",
        "asinh",
        "acosh",
        "atanh",
    ),
    *("exp", "exp2", "log", "expm1", "log1p", "sqrt", "cbrt", "floor", "ceil", "erf", "erfc", "nextafter"),
):
    _register(_name, _function(_name))
_register("rsqrt", lambda a: f"(1.0 / sqrt({a}))")
_register("logistic", lambda a: f"(1.0 / (1.0 + exp(-{a})))")
_register("is_finite", lambda a: f"(isfinite({a}) != 0)")
_by_kind(
    "clamp",
    real=_function("clamp_"),
    whole=lambda low, a, high: f"smaller_int_(larger_int_({a}, {low}), {high})",
)
for _name in ("copy", "copy_p", "stop_gradient", "reduce_precision"):
    _register(_name, lambda a: a)


@rule("optimization_barrier")
def _same(_block: CodeBlock, _one: ArrayOperation, inputs: Values, _outputs: Shapes) -> Values:
    return list(inputs)


@rule("round")
def _round(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    function = "rint" if int(one.params["rounding_method"]) == 1 else "round"
    return _elementwise(block, inputs, outputs, _function(function))


@rule("integer_pow")
def _integer_pow(block: CodeBlock, one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    power = int(one.params["y"])
    name = "integer_pow_" if inputs[0].dtype.kind == "f" else "whole_pow_"
    return _elementwise(block, inputs, outputs, lambda a: f"{name}({a}, {power})")


@rule("convert_element_type")
def _convert(block: CodeBlock, _one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    before, after = c_type(inputs[0].dtype), c_type(outputs[0].dtype)
    if before == after:
        return list(inputs)

    def form(a: str) -> str:
        return f"({a} != 0)" if after == "bool" else f"(({after}){a})"

    return _elementwise(block, inputs, outputs, form)


@rule("select_n")
def _select(block: CodeBlock, _one: ArrayOperation, inputs: Values, outputs: Shapes) -> Values:
    def form(which: str, *cases: str) -> str:
        if len(cases) == 2:
            return f"({which} ? {cases[1]} : {cases[0]})"
        return (
            f"({which} == 0 ? {cases[0]} : {form(f'({which} - 1)', *cases[1:])})" if cases[1:] else cases[0]
        )

    return _elementwise(block, inputs, outputs, form)
