"""Simulate a model that may fail to converge, such as a basis without the necessary derivatives."""

from __future__ import annotations

from supple.integrate import Run, Solution
from supple.machine import System
from supple.simulation import simulate
from supple_benchmarks.progress import Progress


def until_early_end(system: System, run: Run, *, progress: Progress) -> tuple[Solution, float | None]:
    """The motion, and the last time of a run that ended early; None for a complete run."""
    solution = simulate(system, run, progress=progress, check=False)
    progress(1.0)
    return solution, None if solution.stopped is None else float(solution.times[-1])
