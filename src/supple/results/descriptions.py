"""Description of a reduced body or a result file in rows of two: name and value."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from supple.integrate import JOINT_COMPONENTS, FramedMotion, Motion
from supple.reduction import ReductionReport
from supple.storage import read_header, read_solution
from supple.storage.result_content import COLUMNS
from supple.units import UnitSystem, with_unit

Row = tuple[str, str]


def describe_reduction(report: ReductionReport) -> Iterator[Row]:
    """Columns of the basis, dropped columns, checks of eigenvalues and locking, and cost."""
    for what in ("linear", "derivatives", "corrections", "dropped"):
        labels = getattr(report, what)
        if labels:
            yield what, f"{len(labels)}: {', '.join(labels)}"
    if report.singular_values_dropped.size:
        yield "largest singular value dropped", f"{report.singular_values_dropped.max():.2g}"
    if report.certificate is not None:
        yield "eigenvalues", str(report.certificate)
    if report.locking is not None:
        yield "locking", str(report.locking)
    yield "seconds", ", ".join(f"{step} {time:.2f}" for step, time in report.seconds.items())


def describe_result(path: Path) -> Iterator[Row]:
    """Completeness, metadata, motions, joint forces and cost of a result file.

    Raises
    ------
    ResultFileError    as for `read_header`
    """
    header, unfinished = read_header(path), "interrupted, or running; supple run CASE --resume continues it"
    yield "what", "complete" if header.complete else unfinished
    units = UnitSystem.parsed(str(header.metadata.get("units", "")))
    for name, value in header.metadata.items():
        if name != COLUMNS:  # not for display
            yield name, str(value)
    if header.n_times:
        solution = read_solution(path)
        span = f"{header.n_times}, from {solution.times[0]:g} to {solution.times[-1]:g}"
        yield "times", with_unit(span, units.time)
        for name, motion in solution.bodies.items():
            yield f"body {name}", _described(motion)
        for name in solution.joint_forces:
            yield f"joint {name}", f"{', '.join(JOINT_COMPONENTS)} on its second end"
    cost = header.statistics
    yield "cost", f"{cost.steps} steps, {cost.iterations} iterations, {cost.seconds:.2f} s"


def _described(motion: Motion) -> str:
    """Number of coordinates of a motion, or name of its first array, and shape of one of its rows."""
    if isinstance(motion, FramedMotion):
        return f"{motion.coordinates.shape[1]} coordinates"
    first, values = next(iter(motion.arrays().items()))
    return f"{first} {' x '.join(str(n) for n in values.shape[1:])}"
