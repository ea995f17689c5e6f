"""A self-correction that lives on disk: its rounds, the motion that is accepted, and the bodies it means."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from supple.correction.correction_folder import CorrectionFolder
from supple.correction.correction_rounds import CorrectedSystem, ReductionStart, Round, SelfCorrectionError
from supple.correction.round_table import best_round, correction_numbers
from supple.correction.self_correction import self_correct
from supple.correction.system_correction import Announce, CorrectionProgress
from supple.errors import ResolutionWarning, StartWarning, ValidityWarning
from supple.integrate import Run, Validity
from supple.machine import System
from supple.multibody.checks.validity import watch
from supple.simulation import keep_bodies
from supple.simulation.recorded_run import joint_ends
from supple.simulation.watched_run import report_resolution, warn_of_unseen_laws
from supple.storage import ResultFile, write_solution
from supple.storage.result_reader import Metadata

ROUNDS_FOLDER = "self_correction"


def correct_recorded(
    system: System,
    run: Run,
    starts: Mapping[str, ReductionStart],
    path: Path | str,
    *,
    case: str,
    metadata: Metadata = MappingProxyType({}),
    resume: bool = False,
    announce: Announce | None = None,
    progress: CorrectionProgress | None = None,
) -> CorrectedSystem:
    """`self_correct`, keeping the rounds as they are computed, then the accepted run and its bodies.

    Parameters
    ----------
    system, run, starts, announce, progress : as for `self_correct`; the validity of the run is that of the
        run that is accepted alone, for a basis that is too small may well leave it
    path : result file to write; `self_correction/` and `NAME-reduced.h5` lie beside it
    case, metadata  kept in the file, to continue it and for the record
    resume : go on with the rounds that a run left behind which was cut off

    Raises
    ------
    SelfCorrectionError     an error was not met: what was reached, and the file of the best round; the
                            rounds in the order in which they were finished
    ResultFileError         rounds that cannot be written or continued; a run that is complete
    errors of `self_correct`
    """
    path, rounds = Path(path), []
    if resume and path.exists():
        ResultFile.resume(path, case=case).close()  # which says that there is nothing to continue
    begin = CorrectionFolder.resume if resume else CorrectionFolder.create
    archive = begin(path.parent / ROUNDS_FOLDER, case=case)

    def finished(each: Round) -> None:
        rounds.append(each)
        if announce is not None:
            announce(each)

    lenient = replace(run, validity=Validity())
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)
            warnings.simplefilter("ignore", ResolutionWarning)
            warnings.simplefilter("once", StartWarning)
            corrected = self_correct(
                system, lenient, starts, announce=finished, progress=progress, archive=archive
            )
    except SelfCorrectionError as error:
        best = archive.motion(best_round(correction_numbers(rounds)))
        raise SelfCorrectionError(f"{error}, and on disk: the best is {best}", tuple(rounds)) from error
    metadata = {**metadata, **joint_ends(system), "self_correction": json.dumps(correction_numbers(rounds))}
    write_solution(path, corrected.solution, case=case, metadata=metadata)
    keep_bodies(corrected.system, starts, path.parent)
    limits = watch(corrected.system, run.validity)
    limits.report(limits.observe({}, corrected.solution))
    warn_of_unseen_laws(corrected.system, run)
    report_resolution(corrected.system, run, corrected.solution)
    return corrected
