"""Run a case whose reductions correct themselves: round by round, each kept on disk."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.progress import Progress, TaskID

from supple.cli.build_system import BuiltCase, build_run
from supple.cli.console import console
from supple.cli.correction_summary import best_round, correction_numbers, correction_table
from supple.cli.kept_bodies import kept_path
from supple.correction import CorrectionFolder, Round, SelfCorrectionError, self_correct
from supple.errors import ValidityWarning
from supple.integrate import Solution, Validity
from supple.multibody.checks.validity import watch
from supple.reduction import ReducedBody
from supple.storage import ResultFile, write_json, write_reduced_body, write_solution

ROUNDS_FOLDER = "self_correction"
PICTURE = "self_correction.png"


@dataclass(frozen=True, eq=False)
class CorrectedCase:
    """The case with its bodies reduced as far as their accuracy allows, its run, its rounds in numbers."""

    built: BuiltCase
    solution: Solution
    numbers: Sequence[Mapping[str, Any]]


def correct_case(
    built: BuiltCase, folder: Path, bars: Progress, *, resume: bool, strict: bool
) -> CorrectedCase:
    """Correct all reductions of a case that are not of fixed size; one round runs all of its bodies.

    The rounds are kept in `folder`/self_correction as they are computed, the run that meets all errors in the
    case's result file.

    resume : go on with the rounds that a run left behind which was cut off
    strict : a motion beyond what a body's kinematics can describe is an error, in the run that is accepted

    Raises
    ------
    SelfCorrectionError     an error was not met: what was reached, and the file of the best round
    ResultFileError         rounds that cannot be written or continued
    SuppleError             whatever the reductions and the runs find wrong
    """
    case, text = built.case_file.case, built.case_file.path.read_text(encoding="utf-8")
    stem = built.case_file.path.stem
    result_path = folder / f"{stem}.h5"
    if resume and result_path.exists():
        ResultFile.resume(result_path, case=text).close()  # which says that there is nothing to continue
    begin = CorrectionFolder.resume if resume else CorrectionFolder.create
    archive = begin(folder / ROUNDS_FOLDER, case=text)
    rounds: list[Round] = []
    try:
        with warnings.catch_warnings():
            # Of the run that is accepted alone: a basis that is too small may well leave the valid range.
            warnings.simplefilter("ignore", ValidityWarning)
            corrected = self_correct(
                built.system,
                build_run(case.simulation),
                built.starts,
                announce=rounds.append,
                progress=_Steps(bars).show,
                archive=archive,
            )
    except SelfCorrectionError as error:
        numbers = correction_numbers(rounds)
        _report_failure(built, numbers, folder)
        best = archive.motion(best_round(numbers))
        raise SelfCorrectionError(f"{error}, and on disk: the best is {best}", error.rounds) from error
    numbers = correction_numbers(rounds)
    metadata = {"title": case.title, "self_correction": json.dumps(numbers)}
    write_solution(result_path, corrected.solution, case=text, metadata=metadata)
    for placed in corrected.system.bodies:
        if isinstance(placed.body, ReducedBody) and placed.body.name in built.starts:
            write_reduced_body(kept_path(folder, placed.body.name), placed.body)
    limits = watch(corrected.system, Validity(strict=strict))
    limits.report(limits.observe({}, corrected.solution))
    return CorrectedCase(replace(built, system=corrected.system), corrected.solution, numbers)


def _report_failure(built: BuiltCase, numbers: Sequence[Mapping[str, Any]], folder: Path) -> None:
    """Print, write and draw the rounds of a correction that did not reach its error."""
    console.print(correction_table(numbers))
    report = {"title": built.case_file.case.title, "self_correction": numbers}
    write_json(folder / f"{built.case_file.path.stem}.json", report)
    draw_correction(built, numbers, folder)


def draw_correction(built: BuiltCase, numbers: Sequence[Mapping[str, Any]], folder: Path) -> None:
    """Draw the rounds, if the case asks for pictures."""
    if not built.case_file.case.output.pictures:
        return
    # Imported here: a run without pictures does not wait for the drawing library.
    from supple.viz import RoundErrors, plot_self_correction

    keys = ("size", "estimated_error", "indicator", "allowed")
    errors = {
        name: RoundErrors(*([each[key] for each in numbers if each["body"] == name] for key in keys))
        for name in dict.fromkeys(each["body"] for each in numbers)
    }
    plot_self_correction(folder / PICTURE, errors)


class _Steps:
    """One bar for every step of the correction, in the order in which they come."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._tasks: dict[str, TaskID] = {}

    def show(self, step: str, fraction: float) -> None:
        if step not in self._tasks:
            self._tasks[step] = self._bars.add_task(step, total=1.0)
        self._bars.update(self._tasks[step], completed=fraction)
