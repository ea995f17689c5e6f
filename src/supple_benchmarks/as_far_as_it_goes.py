"""Simulate although the model may break down: a basis without the derivatives it needs does, as a result."""

from __future__ import annotations

from supple.errors import ConvergenceError
from supple.integrate import Progress, Run, Solution, concatenate
from supple.machine import System
from supple.simulation import simulate
from supple_benchmarks.progress import Progress


def as_far_as_it_goes(system: System, run: Run, *, progress: Progress) -> tuple[Solution, float | None]:
    """The motion, and the time at which it broke off, or None."""
    parts: list[Solution] = []
    try:
        simulate(system, run, progress=progress, record=parts.append)
    except ConvergenceError:
        progress(1.0)
        return concatenate(parts), float(parts[-1].times[-1])
    return concatenate(parts), None
