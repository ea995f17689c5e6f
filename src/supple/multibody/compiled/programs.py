"""The compiled march: runs of one machine that differ in numbers alone share a program, however long.

It is compiled twice as occasion arises. A quick program is compiled in a third of the time, and its steps
take ten times as long; it is for runs that are over before the other would have been compiled. A machine that
is run again and again has earned the other after some of them. A run that goes on does so by the program that
it was begun with, so that it ends in the same digits.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from supple.algebra.jax_settings import when_given_back
from supple.algebra.kept_programs import KeptProgram
from supple.multibody.compiled.elimination import ByLapack, ByLoops
from supple.multibody.compiled.state import State
from supple.multibody.compiled.time_step import march
from supple.multibody.equations.compiler_options import MARCHING, STARTING
from supple.multibody.equations.model import Model

__all__ = ["COMPILED_MARCH", "QUICK_MARCH", "STOPS_AT_ONCE", "is_over_soon", "march_for", "well_and_quickly"]


def well_and_quickly(function: Callable[..., Any]) -> tuple[KeptProgram, KeptProgram]:
    """Programs of a function of an elimination and of arrays: of fast steps, and compiled fast."""
    well = KeptProgram(partial(function, ByLoops()), MARCHING)
    return well, KeptProgram(partial(function, ByLapack()), STARTING)


COMPILED_MARCH, QUICK_MARCH = well_and_quickly(march)
STOPS_AT_ONCE = 128
"""Output times of a call: fewer repeat the last one, which costs nothing; more take several calls."""

_QUICK = 500_000
"""Steps times velocities of a run: by then a quick program loses three seconds, of four that it saves."""
_QUICK_IN_ALL = 1_500_000
"""The same of all runs of a machine in a process: about what the other program costs."""

_DONE: dict[Any, float] = {}
when_given_back(_DONE.clear)


def march_for(model: Model, start: State, steps: float) -> KeptProgram:
    """The program for a run of so many steps."""
    machine = COMPILED_MARCH.signature(model, start)
    _DONE[machine] = _DONE.get(machine, 0.0) + steps * model.n_velocities
    earned = _DONE[machine] > _QUICK_IN_ALL
    return QUICK_MARCH if is_over_soon(steps, model.n_velocities) and not earned else COMPILED_MARCH


def is_over_soon(steps: float, n_velocities: int) -> bool:
    """Whether a run of so many steps takes less than what a well compiled program costs."""
    return steps * n_velocities <= _QUICK
