"""Run a case file: build, simulate, keep every step on disk, and say what came out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import Progress, TaskID

from supple.cli.build_system import BuiltCase, build_case, build_run
from supple.cli.console import console, progress_bars, worded
from supple.cli.correct_case import correct_case, draw_correction
from supple.cli.correction_summary import correction_table
from supple.cli.kept_bodies import with_kept_bodies
from supple.cli.read_case import CaseFile, read_case
from supple.cli.summary import (
    body_table,
    cost_line,
    joint_loads,
    joint_table,
    place_table,
    summarize,
)
from supple.cli.tracked_motion import TrackedMotion, track
from supple.integrate import Solution
from supple.multibody import warn_of_missing_modes
from supple.reduction import ReducedBody
from supple.simulation import begin_recorded, continue_recorded
from supple.storage import write_json


def run_case(path: Path, folder: Path, *, resume: bool = False, strict: bool = False) -> None:
    """Run the case file at `path` and write its results, summary and pictures into `folder`.

    resume : continue the result file of a run that was cut off, instead of starting anew
    strict : a motion beyond what a body's kinematics can describe is an error

    Raises
    ------
    CaseError           mistakes in the case file, all of them
    ResultFileError     a result file that cannot be written or continued
    SuppleError         whatever the build and the simulation find wrong; what was computed is kept
    """
    case_file = read_case(path)
    console.print(f"[bold]{case_file.case.title}[/bold]", highlight=False)
    folder.mkdir(parents=True, exist_ok=True)
    result_path = folder / f"{path.stem}.h5"
    with progress_bars() as bars:
        built = _build(case_file, bars)
        look_at_loads(built)
        corrections: Sequence[Mapping[str, Any]] = ()
        if built.starts:
            corrected = correct_case(built, folder, bars, resume=resume, strict=strict)
            built, solution, corrections = corrected.built, corrected.solution, corrected.numbers
            draw_correction(built, corrections, folder)
        else:
            built = with_kept_bodies(built, folder, resume=resume)
            solution = _simulate(built, result_path, bars, resume=resume, strict=strict)
        tracked = [
            track(place, built.system, built.meshes, solution) for place in case_file.case.output.track
        ]
        _draw(built, solution, tracked, folder, bars)
    numbers = summarize(built.system, tracked, solution)
    tables = [correction_table(corrections)] if corrections else []
    tables += [body_table(numbers), joint_table(numbers)] + ([place_table(numbers)] if tracked else [])
    for table in tables:
        console.print(table)
    for name, body in numbers["bodies"].items():
        if "eigenvalues" in body:
            console.print(f"{name}: {body['eigenvalues']}", highlight=False)
    console.print(cost_line(solution), highlight=False)
    write_json(
        folder / f"{path.stem}.json",
        {"title": case_file.case.title, "self_correction": corrections, **numbers},
    )
    console.print(f"Results are in {folder}/", highlight=False)


def _build(case_file: CaseFile, bars: Progress) -> BuiltCase:
    steps = _Steps(bars)
    with steps.last_finished():
        return build_case(case_file, steps.show)


def look_at_loads(built: BuiltCase) -> None:
    """Warn of loads that excite modes which a reduction of fixed size lacks."""
    times = build_run(built.case_file.case.simulation).times
    for placed in built.system.bodies:
        # A body that was reduced before has left its elements behind.
        if isinstance(placed.body, ReducedBody) and placed.body.name in built.flexible:
            warn_of_missing_modes(built.system, times, built.flexible[placed.body.name], placed.body)


def _simulate(built: BuiltCase, result_path: Path, bars: Progress, *, resume: bool, strict: bool) -> Solution:
    case = built.case_file.case
    text = built.case_file.path.read_text(encoding="utf-8")
    task = bars.add_task("compiling and simulating", total=1.0)

    def progress(fraction: float) -> None:
        bars.update(task, completed=fraction)

    run = build_run(case.simulation, strict=strict)
    if resume:
        return continue_recorded(built.system, run, result_path, case=text, progress=progress)
    metadata = {"title": case.title}
    return begin_recorded(built.system, run, result_path, case=text, metadata=metadata, progress=progress)


def _draw(
    built: BuiltCase, solution: Solution, tracked: Sequence[TrackedMotion], folder: Path, bars: Progress
) -> None:
    output = built.case_file.case.output
    if not (output.pictures or output.animation):
        return
    # Imported here: a run without pictures does not wait for the drawing library.
    from supple.cli.pictures import draw_animation, draw_pictures

    if output.pictures:
        sizes = {
            name: {what: np.linalg.norm(part, axis=1) for what, part in loads.items()}
            for name, loads in joint_loads(built.system, solution).items()
        }
        steps = _Steps(bars)
        with steps.last_finished():
            steps.show("drawing pictures")
            draw_pictures(built, solution, tracked, sizes, folder)
    if output.animation:
        task = bars.add_task("drawing the animation", total=1.0)
        draw_animation(
            built, solution, folder / "motion.gif", lambda share: bars.update(task, completed=share)
        )


class _Steps:
    """Steps of unknown length, one spinner each; the next begins where the one before ends."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._step: str | None = None
        self._task = TaskID(0)

    def show(self, step: str, detail: str = "", /) -> None:
        if step != self._step:
            self._finish()
            self._step, self._task = step, self._bars.add_task(step, total=None)
        self._bars.update(self._task, description=worded(step, detail))

    @contextmanager
    def last_finished(self) -> Iterator[None]:
        yield
        self._finish()

    def _finish(self) -> None:
        if self._step is not None:
            self._bars.update(self._task, total=1.0, completed=1.0)
