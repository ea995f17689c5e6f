"""Compiled time integration: runs of one machine that differ in numbers alone share a program.

There are two programs. The quick one compiles in a third of the time, but its steps take ten times as long.
It is used for runs that end before the other one would be compiled. The results of the two programs differ in
the last bits. The length of the run alone selects the program, so results are bitwise equal in every process.
A resumed run uses the program with which it was started.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from supple.equations.compiler_options import MARCHING, STARTING
from supple.equations.machine_model import Model
from supple.methods.floating.compiled.elimination import ByLapack, ByLoops
from supple.methods.floating.compiled.time_step import march
from supple.programs.program_cache import CachedProgram


def program_pair(function: Callable[..., object]) -> tuple[CachedProgram, CachedProgram]:
    """Two programs of a function whose first argument is an elimination: fast steps, and fast compilation."""
    well = CachedProgram(partial(function, ByLoops()), MARCHING)
    return well, CachedProgram(partial(function, ByLapack()), STARTING)


COMPILED_MARCH, QUICK_MARCH = program_pair(march)
STOPS_AT_ONCE = 128
"""Output times of a call; fewer are padded with the last one at no cost, more take several calls."""

_QUICK = 250_000
"""Steps times velocities of a run up to which the quick program is used: its slower steps then cost three of
the four seconds that its compilation saves (12 us for each velocity and step of a blade)."""
_BRIEF = 10_000
"""Steps times velocities that the quick program takes in 0.1 s, ten times the cost of recording a leg."""


def march_for(model: Model, steps: float) -> CachedProgram:
    """The program for a run of so many steps."""
    return QUICK_MARCH if ends_before_compiling(steps, model.n_velocities) else COMPILED_MARCH


def brief_steps(model: Model, program: CachedProgram) -> int:
    """Number of steps in about 0.1 s."""
    return _BRIEF * (1 if program is QUICK_MARCH else 10) // model.n_velocities


def ends_before_compiling(steps: float, n_velocities: int) -> bool:
    """Whether so many steps take less time than the compilation of the fast program."""
    return steps * n_velocities <= _QUICK
