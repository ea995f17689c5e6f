"""Run a case: simulate it, keep every step on disk, draw it, and say in numbers what came out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from supple.cases.case import Case
from supple.cases.notify import Progress, silent
from supple.correction import Round, SelfCorrectionError, correct_recorded, correction_numbers
from supple.integrate import Run, Solution, Validity
from supple.machine import System
from supple.multibody import warn_of_missing_modes
from supple.results import TrackedMotion, summarize, tracked_motion
from supple.simulation import (
    begin_recorded,
    continue_recorded,
    keep_bodies,
    reduced_bodies,
    with_kept_bodies,
)
from supple.storage import write_json


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
    path, run = folder / f"{case.path.stem}.h5", replace(case.run, validity=Validity(strict=strict))
    folder.mkdir(parents=True, exist_ok=True)
    _look_at_loads(case)
    rounds: list[Round] = []

    def finished(each: Round) -> None:
        rounds.append(each)
        announce(each)

    if case.starts:
        try:
            corrected = correct_recorded(
                case.system,
                run,
                case.starts,
                path,
                case=case.text,
                title=case.title,
                resume=resume,
                announce=finished,
                progress=progress,
            )
        except SelfCorrectionError:
            _write_report(case, folder, correction_numbers(rounds), {})
            raise
        system, solution = corrected.system, corrected.solution
    else:
        system, solution = _simulated(case, run, path, resume=resume, progress=progress)
    tracked = {}
    for place in case.tables.output.track:
        name, at = case.place(place)
        body = system.bodies[system.body_index(name)].body
        tracked[place] = tracked_motion(body, solution.bodies[name], at)
    result = CaseResult(system, solution, correction_numbers(rounds), summarize(system, solution, tracked))
    _write_report(case, folder, result.rounds, result.numbers)
    _draw(case, result, tracked, folder, progress)
    return result


def _look_at_loads(case: Case) -> None:
    """Warn of loads that excite modes which a reduction of fixed size lacks."""
    for body in reduced_bodies(case.system, case.flexible):
        warn_of_missing_modes(case.system, case.run.times, case.flexible[body.name], body)


def _simulated(
    case: Case, run: Run, path: Path, *, resume: bool, progress: Progress
) -> tuple[System, Solution]:
    def simulating(fraction: float) -> None:
        progress("compiling and simulating", fraction)

    simulating(0.0)
    if resume:
        system = with_kept_bodies(case.system, case.made_here, path.parent)
        return system, continue_recorded(system, run, path, case=case.text, progress=simulating)
    keep_bodies(case.system, case.made_here, path.parent)
    metadata = {"title": case.title}
    return case.system, begin_recorded(
        case.system, run, path, case=case.text, metadata=metadata, progress=simulating
    )


def _write_report(
    case: Case, folder: Path, rounds: Sequence[Mapping[str, Any]], numbers: Mapping[str, Any]
) -> None:
    """Write the numbers of a run; draw the rounds, if there are any and the case asks for pictures."""
    report = {"title": case.title, "self_correction": rounds, **numbers}
    write_json(folder / f"{case.path.stem}.json", report)
    if rounds and case.tables.output.pictures:
        # Imported here: a run without pictures does not wait for the drawing library.
        from supple.viz import plot_rounds

        plot_rounds(folder / "self_correction.png", rounds)


def _draw(
    case: Case,
    result: CaseResult,
    tracked: Mapping[str, TrackedMotion],
    folder: Path,
    progress: Progress,
) -> None:
    output = case.tables.output
    if not (output.pictures or output.animation):
        return
    from supple.viz import animate_run, draw_run

    run = (result.system, result.solution, case.drawn)
    elements = case.elements if output.colour == "von-mises" else None
    if output.pictures:
        case.notify("drawing pictures")
        draw_run(folder, *run, tracked=tracked, elements=elements)
    if output.animation:
        animate_run(
            folder / "motion.gif",
            *run,
            elements=elements,
            progress=lambda share: progress("drawing the animation", share),
        )
