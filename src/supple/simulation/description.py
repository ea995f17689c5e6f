"""A machine and its run in a line, and all that its motion depends on, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from types import CodeType
from typing import Any

import numpy as np

from supple.body import FullBody, RigidBody
from supple.integrate import Run
from supple.intrinsic import IntrinsicBody
from supple.machine import Placed, System
from supple.storage.run_inputs import Inputs, digest_of

__all__ = ["description", "inputs_of"]

_MOST_CALLS = 8
"""Functions that call functions, as deep as they are looked into."""


def description(system: System, run: Run) -> str:
    """Names of bodies and joints, and the span of the run."""
    bodies = ", ".join(f"{placed.body.name} ({placed.body.kind})" for placed in system.bodies)
    joints = ", ".join(joint.name for joint in system.joints) or "none"
    span = f"{run.duration:g} from {run.start:g}, every {run.output_step:g}"
    return f"bodies {bodies}; joints {joints}; {span}"


def inputs_of(system: System, run: Run, case: str) -> Inputs:
    """What a motion depends on: the run in words; digests of bodies, joints, loads, controllers and gravity.

    Of elastic bodies only their form, where they stand and how they move at first, for reducing again moves
    the last digits and signs of their numbers: result files know these otherwise (`recorded_columns`). A
    function of time counts by its code, the numbers it has from around it, and the functions it calls.
    """
    found = {"the case": case, "the run": _words(run)}
    found["the order of the bodies"] = ", ".join(placed.body.name for placed in system.bodies)
    found |= {f"body '{placed.body.name}'": _digest(_of_body(placed)) for placed in system.bodies}
    found |= {f"joint '{joint.name}'": _digest(_of(joint)) for joint in system.joints}
    found |= {f"load {i + 1}, {load.label}": _digest(_of(load)) for i, load in enumerate(system.loads)}
    found |= {f"controller '{own.name}'": _digest(_of(own)) for own in system.controllers}
    return found | {"gravity": _digest(_of(system.gravity))}


def _words(run: Run) -> str:
    return (
        f"{run.duration!r} from {run.start!r}, every {run.output_step!r}, {run.step_control}, {run.method}, "
        f"{run.tolerances}"
    )


def _digest(parts: Iterator[bytes]) -> str:
    # Each part with its length, so that no two lists of parts are one text.
    return digest_of(b"".join(b"%d:%b" % (len(part), part) for part in parts))


def _of_body(placed: Placed) -> Iterator[bytes]:
    body = placed.body
    yield f"{body.kind} {body.n_coordinates}".encode()
    for item in ("position", "rotation", "velocity", "angular_velocity"):
        yield from _of(getattr(placed, item))
    match body:
        case RigidBody():
            yield from _of((body.mass, body.centre, body.inertia, body.points))
        case FullBody():
            yield from _of((body.frame, body.damping, body.body.is_linear))
        case IntrinsicBody():
            yield from _of((body.support, body.damping))
        case _:
            yield from _of((body.frame, body.is_linear))


def _of(value: Any, depth: int = 0) -> Iterator[bytes]:
    """The numbers, words and functions of a joint, a load, a law, whatever holds them."""
    match value:
        case None | bool() | str():
            yield repr(value).encode()
        case tuple() | list():
            yield f"{len(value)} items".encode()
            for item in value:
                yield from _of(item, depth)
        case Mapping():
            for key, item in value.items():
                yield str(key).encode()
                yield from _of(item, depth)
        case partial():
            yield from _of((value.func, value.args, value.keywords), depth)
        case _ if is_dataclass(value) and not isinstance(value, type):
            yield type(value).__qualname__.encode()
            for item in fields(value):
                yield item.name.encode()
                yield from _of(getattr(value, item.name), depth)
        case type():
            yield value.__qualname__.encode()
        case _ if hasattr(value, "__code__"):
            yield from _of_function(value, depth)
        case _ if callable(value):
            yield type(value).__qualname__.encode()
            own = getattr(value, "__dict__", {})
            yield from _of({key: item for key, item in own.items() if not callable(item)}, depth)
        case _:
            yield from _of_numbers(value)


def _of_numbers(value: Any) -> Iterator[bytes]:
    array = np.asarray(value)
    if array.dtype.kind in "biufc":
        yield f"{array.shape} {array.dtype.kind}".encode()
        yield array.tobytes()
    else:
        yield type(value).__qualname__.encode()


def _of_function(function: Callable[..., Any], depth: int) -> Iterator[bytes]:
    code, around = getattr(function, "__code__"), getattr(function, "__globals__")  # noqa: B009
    yield function.__qualname__.encode()
    yield from _of_code(code)
    if depth >= _MOST_CALLS:
        return
    for item in ("__defaults__", "__kwdefaults__"):
        yield from _of(getattr(function, item, None), depth)
    if (owner := getattr(function, "__self__", None)) is not None:
        yield from _of(getattr(owner, "__dict__", {}), depth + 1)
    for cell in getattr(function, "__closure__", None) or ():
        yield from _of(cell.cell_contents, depth + 1)
    for name in code.co_names:
        value = around.get(name)
        # What a library defines is what it is called.
        ours = callable(value) and getattr(value, "__globals__", None) is around
        if ours or isinstance(value, int | float | complex | str | tuple | list | np.ndarray):
            yield name.encode()
            yield from _of(value, depth + 1)


def _of_code(code: CodeType) -> Iterator[bytes]:
    yield code.co_code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _of_code(constant)
        else:
            yield repr(constant).encode()
