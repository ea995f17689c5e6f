"""Run a case: simulate it, keep every step on disk, draw it, and say in numbers what came out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from supple.cases.case import Case
from supple.cases.correct_case import correct_case
from supple.cases.notify import Progress, silent
from supple.cases.report import write_report
from supple.correction import Round, correction_numbers
from supple.integrate import Solution, Validity
from supple.machine import System
from supple.multibody import warn_of_missing_modes
from supple.results import TrackedMotion, summarize
from supple.simulation import (
    begin_recorded,
    continue_recorded,
    keep_bodies,
    reduced_bodies,
    with_kept_bodies,
)


@dataclass(frozen=True, eq=False)
class CaseResult:
    """What the run of a case came to.

    system : System             with its bodies reduced as far as their accuracy allows
    rounds : of its self-correction in numbers, as `correction_numbers` gives them
    numbers : of the run, as `summarize` gives them
    """

    system: System
    solution: Solution
    rounds: Sequence[Mapping[str, Any]]
    numbers: Mapping[str, Any]


def run_case(
    case: Case,
    folder: Path,
    *,
    resume: bool = False,
    strict: bool = False,
    progress: Progress = silent,
    announce: Callable[[Round], None] = silent,
) -> CaseResult:
    """Run a case and write its results (HDF5, JSON) and, if it asks for them, its pictures into `folder`.

    Parameters
    ----------
    folder : made if it is not there
    resume : continue the result file of a run that was cut off, instead of starting anew
    strict : a motion beyond what a body's kinematics can describe is an error
    announce : hears of every round of a self-correction as it is finished

    Raises
    ------
    SelfCorrectionError     an error was not met: what was reached, and the file of the best round
    ResultFileError         a result file that cannot be written or continued
    SuppleError             whatever the build and the simulation find wrong; what was computed is kept
    """
    folder.mkdir(parents=True, exist_ok=True)
    _look_at_loads(case)
    rounds: Sequence[Round] = ()
    if case.starts:
        corrected, rounds = correct_case(
            case, folder, resume=resume, strict=strict, progress=progress, announce=announce
        )
        system, solution = corrected.system, corrected.solution
    else:
        system, solution = _simulated(case, folder, resume=resume, strict=strict, progress=progress)
    tracked = case.tables.output.tracked(system, case.meshes, solution)
    numbers = summarize(system, solution, tracked)
    write_report(case, folder, rounds, numbers)
    _draw(case, system, solution, tracked, folder, progress)
    return CaseResult(system, solution, correction_numbers(rounds), numbers)


def _look_at_loads(case: Case) -> None:
    """Warn of loads that excite modes which a reduction of fixed size lacks."""
    for body in reduced_bodies(case.system, case.flexible):
        warn_of_missing_modes(case.system, case.run.times, case.flexible[body.name], body)


def _simulated(
    case: Case, folder: Path, *, resume: bool, strict: bool, progress: Progress
) -> tuple[System, Solution]:
    path, run = folder / f"{case.path.stem}.h5", replace(case.run, validity=Validity(strict=strict))

    def simulating(fraction: float) -> None:
        progress("compiling and simulating", fraction)

    simulating(0.0)
    if resume:
        system = with_kept_bodies(case.system, case.made_here, folder)
        return system, continue_recorded(system, run, path, case=case.text, progress=simulating)
    keep_bodies(case.system, case.made_here, folder)
    metadata = {"title": case.title}
    return case.system, begin_recorded(
        case.system, run, path, case=case.text, metadata=metadata, progress=simulating
    )


def _draw(
    case: Case,
    system: System,
    solution: Solution,
    tracked: Mapping[str, TrackedMotion],
    folder: Path,
    progress: Progress,
) -> None:
    output = case.tables.output
    if not (output.pictures or output.animation):
        return
    # Imported here: a run without pictures does not wait for the drawing library.
    from supple.viz import animate_run, draw_run

    elements = case.elements if output.colour == "von-mises" else None
    if output.pictures:
        case.notify("drawing pictures")
        draw_run(folder, system, solution, case.drawn, tracked=tracked, elements=elements)
    if output.animation:
        animate_run(
            folder / "motion.gif",
            system,
            solution,
            case.drawn,
            elements=elements,
            progress=lambda share: progress("drawing the animation", share),
        )
