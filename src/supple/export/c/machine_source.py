"""The C files of a machine: header, source, derivatives, a test with recorded values, and a Makefile."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template

import jax
import numpy as np

from supple.arrays import AnyArray
from supple.export.ascii_file import check_not_foreign
from supple.export.c.function import HEAD, named_view, printed_function
from supple.export.c.values import BufferView, c_type, literal
from supple.stepping import StepProgram, StepState
from supple.stepping.variables import Variable
from supple.storage.atomic_write import replacing

_RECORDED = 20
"""Number of times at which the test compares outputs."""
_STEPS = 200
"""Largest number of steps of the test."""
_AGREEMENT = 1e-8
"""Difference between compilers that the test accepts, as a fraction of a sensor's size."""


@dataclass(frozen=True)
class _Field:
    """A leaf of the state as a member of the C struct."""

    name: str
    start: np.ndarray

    @property
    def declaration(self) -> str:
        """Declaration of the member in C."""
        size = f"[{self.start.size}]" if self.start.shape else ""
        return f"{c_type(self.start.dtype)} {self.name}{size};"

    @property
    def initializer(self) -> str:
        """C initializer with the value at the start."""
        cells = [literal(value, self.start.dtype) for value in self.start.reshape(-1)]
        if not self.start.shape:
            return f".{self.name} = {cells[0]}"
        rows = [", ".join(cells[first : first + 6]) for first in range(0, len(cells), 6)]
        return f".{self.name} = {{{(',' + chr(10) + '        ').join(rows)}}}"

    @property
    def view(self) -> BufferView:
        """View of the member, for the printer."""
        return named_view(
            f"m->{self.name}", self.start.shape, self.start.dtype, is_scalar=not self.start.shape
        )


def machine_sources(step: StepProgram, title: str) -> dict[str, str]:
    """The texts of `machine.h` and `machine.c` by file name.

    Raises ModelError for an operation of the equations without a translation to C.
    """
    fields = _struct_fields(step.start)
    return {"machine.h": _header(step, fields, title), "machine.c": _source(step, fields)}


def write_machine(folder: Path, step: StepProgram, title: str) -> tuple[Path, ...]:
    """Write `machine.c`, `machine.h`, `test.c` and `Makefile`, in place of old files; returns their paths.

    Raises
    ------
    ModelError          an operation of the equations without a translation to C
    ResultFileError     the folder cannot be written, or has another file of one of these names
    """
    for name in ("machine.c", "machine.h", "test.c", "Makefile"):
        check_not_foreign(folder / name, "machine")
    files = machine_sources(step, title) | {"test.c": _test(step), "Makefile": _filled("Makefile")}
    for name, text in files.items():
        with replacing(folder / name) as temporary:
            temporary.write_text(text, "utf-8")
    return tuple(folder / name for name in files)


def _struct_fields(start: StepState) -> list[_Field]:
    """Members of the C struct, also empty ones, in the order of the leaves of the state."""
    found = []
    for path, leaf in jax.tree_util.tree_flatten_with_path(start)[0]:
        words = re.findall(r"\w+", jax.tree_util.keystr(path))
        name = "_".join(words[1:] if words[0] == "state" else words)
        found.append(_Field(name, np.asarray(leaf)))
    return found


def _table(name: str, variables: Sequence[Variable]) -> str:
    rows = [
        f"    {{{_text(each.name)}, {_text(each.unit)}, {_text(each.description)}, "
        f"{literal(each.start, np.float64)}}}"
        for each in variables
    ]
    body = ",\n".join(rows) if rows else '    {"", "", "", 0.0}'
    return f"const machine_variable {name}[] = {{\n{body}\n}};"


def _text(words: str) -> str:
    escaped = words.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _listed(variables: Sequence[Variable]) -> str:
    lines = [
        f" *   [{place}] {each.name}{f' ({each.unit})' if each.unit else ''}: {each.description}"
        for place, each in enumerate(variables)
    ]
    return "\n".join(lines).replace("*/", "* /") or " *   none"


def _filled(name: str, **parts: object) -> str:
    """The text of a file of the folder `assets`, with its placeholders substituted."""
    text = files("supple.export.c").joinpath("assets", name).read_text("utf-8")
    return Template(text).substitute(parts)


def _header(step: StepProgram, fields: Sequence[_Field], title: str) -> str:
    return _filled(
        "machine.h",
        title=title.replace("*/", "* /"),
        version=version("supple"),
        parameters=_listed(step.parameters),
        inputs=_listed(step.inputs.variables),
        outputs=_listed(step.outputs.variables),
        n_parameters=len(step.parameters),
        n_inputs=len(step.inputs.variables),
        n_outputs=len(step.outputs.variables),
        n_contacts=len(step.start.touching),
        step=literal(step.size, np.float64),
        duration=literal(step.duration, np.float64),
        members="\n".join(f"    {each.declaration}" for each in fields if each.start.size),
    )


def _source(step: StepProgram, fields: Sequence[_Field]) -> str:
    views = [each.view for each in fields]
    end = named_view("end", (), np.float64, is_scalar=True)
    given = (step.start, np.float64(0.0))
    parameters = [("machine *m", "m"), ("double end", "end")]
    printed = printed_function(step.advanced, given, [*views, end], views, "advance", parameters)
    return _filled(
        "machine.c",
        head=HEAD,
        before=printed.before,
        parameters=_table("machine_parameters", step.parameters),
        inputs=_table("machine_inputs", step.inputs.variables),
        outputs=_table("machine_outputs", step.outputs.variables),
        start=",\n    ".join(each.initializer for each in fields if each.start.size),
        begin=_begin(step, views),
        body=printed.body,
    )


def _begin(step: StepProgram, views: Sequence[BufferView]) -> str:
    """The C function `machine_start`: the initial state for the parameters; without parameters, no change."""
    before, body = "", "    (void)m;"
    if step.parameters:
        given = (step.start.parameter, step.start.input)
        own = views[: len(given)]
        printed = printed_function(step.started, given, own, views, "start", [("machine *m", "m")])
        before, body = f"{printed.before}\n\n", printed.body
    return f"{before}int machine_start(machine *m)\n{{\n{body}\n    return m->failed ? 1 : 0;\n}}"


def derivative_source(step: StepProgram) -> str:
    """The text of `derivative.c`: derivatives of the outputs along a direction of the inputs.

    The function computes `d output(end)/d input . direction` of the discrete time step, with inputs constant
    until `end`, by JAX's forward mode.

    Raises ModelError for an operation of the derivative without a translation to C.
    """

    def rates(now: StepState, end: AnyArray, direction: AnyArray) -> AnyArray:
        def outputs(given: AnyArray) -> AnyArray:
            return step.advanced(now._replace(input=given), end).output

        return jax.jvp(outputs, (now.input,), (direction,))[1]

    views = [each.view for each in _struct_fields(step.start)]
    end = named_view("end", (), np.float64, is_scalar=True)
    direction = named_view("direction", step.start.input.shape, np.float64)
    result = named_view("rates", step.start.output.shape, np.float64)
    arguments = (step.start, np.float64(0.0), np.zeros_like(step.start.input))
    parameters = [
        ("const machine *m", "m"),
        ("double end", "end"),
        ("const double *direction", "direction"),
        ("double *rates", "rates"),
    ]
    inputs = [*views, end, direction]
    printed = printed_function(rates, arguments, inputs, [result], "derivative", parameters)
    return (
        f'#include "machine.h"\n\n{HEAD}\n{printed.before}\n\n'
        f"void machine_derivative({', '.join(own for own, _ in parameters)})\n"
        f"{{\n{printed.body}\n}}\n"
    )


def _recorded(step: StepProgram) -> tuple[np.ndarray, np.ndarray]:
    """Times (k,) and outputs at them (k, o), computed by the program that JAX compiles."""
    total = max(1, min(_STEPS, round(step.duration / step.size)))
    every = max(1, total // _RECORDED)
    times = float(step.start.state.time) + step.size * np.arange(every, total + 1, every)
    now = step.start
    rows = []
    for time in times:
        now = step.compiled(now, time)
        rows.append(np.asarray(now.output))
    return times, np.array(rows)


def sensor_sizes(variables: Sequence[Variable], outputs: np.ndarray) -> np.ndarray:
    """Size (o,) of each output: the largest magnitude of outputs with the same sensor, unit and quantity."""
    kinds = [
        (each.name.rpartition(".")[0], each.unit, each.description.partition(",")[0]) for each in variables
    ]
    largest: dict[tuple[str, str, str], float] = {}
    for kind, value in zip(kinds, np.abs(outputs).max(axis=0, initial=0.0), strict=True):
        largest[kind] = max(largest.get(kind, 0.0), float(value))
    # A size that is rounding error, such as the slide of a hinge, is not used as a scale.
    least = 1e-6 * max(largest.values(), default=0.0) or 1.0
    return np.array([max(largest[kind], least) for kind in kinds])


def _test(step: StepProgram) -> str:
    times, outputs = _recorded(step)
    rows = ",\n".join(
        "    {" + ", ".join(literal(value, np.float64) for value in (time, *row)) + "}"
        for time, row in zip(times, outputs, strict=True)
    )
    sizes = ", ".join(literal(value, np.float64) for value in sensor_sizes(step.outputs.variables, outputs))
    return _filled("test.c", rows=rows, sizes=sizes, agreement=literal(_AGREEMENT, np.float64))
