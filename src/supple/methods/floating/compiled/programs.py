"""The compiled march: runs of one machine that differ in numbers alone share a program, however long.

It is compiled twice as occasion arises. A quick program is compiled in a third of the time, and its steps
take ten times as long; it is for runs that are over before the other would have been compiled. The two differ
in the last bits, so the length of a run decides between them, and nothing that the process did before: the
same run has the same bits in every process. A run that goes on does so by the program it was begun with.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from supple.equations.compiler_options import MARCHING, STARTING
from supple.equations.machine_model import Model
from supple.methods.floating.compiled.elimination import ByLapack, ByLoops
from supple.methods.floating.compiled.time_step import march
from supple.programs.kept_programs import KeptProgram

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


def march_for(model: Model, steps: float) -> KeptProgram:
    """The program for a run of so many steps."""
    return QUICK_MARCH if is_over_soon(steps, model.n_velocities) else COMPILED_MARCH


def is_over_soon(steps: float, n_velocities: int) -> bool:
    """Whether a run of so many steps takes less than what a well compiled program costs."""
    return steps * n_velocities <= _QUICK
