"""Run a case whose reductions correct themselves: round by round, each kept on disk."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from pathlib import Path

from supple.cases.case import Case
from supple.cases.notify import Progress
from supple.cases.report import write_report
from supple.correction import (
    CorrectedSystem,
    CorrectionFolder,
    Round,
    SelfCorrectionError,
    best_round,
    correction_numbers,
    self_correct,
)
from supple.errors import ValidityWarning
from supple.integrate import Validity
from supple.multibody.checks.validity import watch
from supple.simulation import keep_bodies
from supple.storage import ResultFile, write_solution

ROUNDS_FOLDER = "self_correction"


def correct_case(
    case: Case,
    folder: Path,
    *,
    resume: bool,
    strict: bool,
    progress: Progress,
    announce: Callable[[Round], None],
) -> tuple[CorrectedSystem, list[Round]]:
    """Correct all reductions of a case that are not of fixed size; one round runs all of its bodies.

    The rounds are kept in `folder`/self_correction as they are computed, the run that meets all errors in the
    case's result file. Parameters and errors as for `run_case`. Returns the system and all rounds.
    """
    result_path = folder / f"{case.path.stem}.h5"
    if resume and result_path.exists():
        ResultFile.resume(result_path, case=case.text).close()  # which says that there is nothing to continue
    begin = CorrectionFolder.resume if resume else CorrectionFolder.create
    archive = begin(folder / ROUNDS_FOLDER, case=case.text)
    rounds: list[Round] = []

    def finished(each: Round) -> None:
        rounds.append(each)
        announce(each)

    try:
        with warnings.catch_warnings():
            # Of the run that is accepted alone: a basis that is too small may well leave the valid range.
            warnings.simplefilter("ignore", ValidityWarning)
            corrected = self_correct(
                case.system, case.run, case.starts, announce=finished, progress=progress, archive=archive
            )
    except SelfCorrectionError as error:
        write_report(case, folder, rounds, {})
        best = archive.motion(best_round(correction_numbers(rounds)))
        raise SelfCorrectionError(f"{error}, and on disk: the best is {best}", error.rounds) from error
    metadata = {"title": case.title, "self_correction": json.dumps(correction_numbers(rounds))}
    write_solution(result_path, corrected.solution, case=case.text, metadata=metadata)
    keep_bodies(corrected.system, case.starts, folder)
    limits = watch(corrected.system, Validity(strict=strict))
    limits.report(limits.observe({}, corrected.solution))
    return corrected, rounds
