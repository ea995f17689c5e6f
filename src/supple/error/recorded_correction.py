"""Self-correction with its files: the rounds, the accepted run and its reduced bodies."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from supple.equations.checks.validity import watch
from supple.error.correction_folder import CorrectionFolder
from supple.error.correction_rounds import CorrectedSystem, ReductionStart, Round, SelfCorrectionError
from supple.error.error_study import ErrorStudy, warn_of_model
from supple.error.round_table import best_round, correction_numbers
from supple.error.self_correction import self_correct
from supple.error.system_correction import Accepted, Announce
from supple.errors import ResolutionWarning, ResultFileError, StartWarning, ValidityWarning
from supple.integrate import Run, StepProgress, Validity
from supple.machine import System
from supple.simulation import store_bodies
from supple.simulation.recorded_run import motion_metadata
from supple.simulation.watched_run import report_resolution, warn_of_unseen_laws
from supple.storage import ResultFile, write_solution
from supple.storage.exclusive_lock import ExclusiveLock
from supple.storage.file_errors import file_errors
from supple.storage.result_content import Metadata, errors_metadata
from supple.storage.result_file import check_nothing_lost
from supple.storage.run_inputs import Inputs

__all__ = ["ROUNDS_FOLDER", "correct_recorded"]

ROUNDS_FOLDER = "self_correction"


def correct_recorded(
    system: System,
    run: Run,
    starts: Mapping[str, ReductionStart],
    path: Path | str,
    *,
    case: str,
    inputs: Inputs | None = None,
    metadata: Metadata = MappingProxyType({}),
    resume: bool = False,
    overwrite: bool = False,
    announce: Announce | None = None,
    accepted: Accepted | None = None,
    progress: StepProgress | None = None,
    study: ErrorStudy | None = None,
) -> CorrectedSystem:
    """`self_correct` that writes the rounds as they are computed, then the accepted run and its bodies.

    Parameters
    ----------
    system, run, starts, announce, accepted, progress, study : as for `self_correct`; the validity limits of
        the run apply to the accepted run only, because a run with too small a basis may violate them
    path : result file to write; the folder `self_correction/` and, for each body NAME, the file
        `NAME-reduced.h5` are written to the same folder
    case, metadata : stored in the file
    inputs : data on which the motion depends, as for `CorrectionFolder.create`
    resume : continue with the rounds of an interrupted run
    overwrite : start anew and replace existing files

    Raises
    ------
    SelfCorrectionError     a target error was not met; its message names the error reached and the file of
                            the best round; its `rounds` are in the order of completion
    ResultFileError         existing rounds or results would be lost; a file cannot be written or continued,
                            or another run is writing it; the run is complete
    errors of `self_correct`
    """
    path, folder = Path(path), Path(path).parent / ROUNDS_FOLDER
    with file_errors("write", folder):
        folder.mkdir(parents=True, exist_ok=True)
    with ExclusiveLock(folder):
        archive = _opened(path, folder, case, inputs, resume=resume, overwrite=overwrite)
        corrected, rounds = _corrected(system, run, starts, archive, announce, accepted, progress, study)
        metadata = {
            **metadata,
            **motion_metadata(corrected.system),
            "self_correction": json.dumps(correction_numbers(rounds)),
            **errors_metadata(corrected.solution.errors),
        }
        # The motion is written last: if its file exists, the files of the bodies exist.
        store_bodies(corrected.system, starts, path.parent)
        write_solution(
            path, corrected.solution, case=case, metadata=metadata, inputs=inputs or {"the case": case}
        )
    limits = watch(corrected.system, run.validity)
    limits.report(limits.observe({}, corrected.solution))
    warn_of_model(corrected.system, run, corrected.solution)
    stepped = replace(corrected.run or run, validity=run.validity)
    warn_of_unseen_laws(corrected.system, stepped)
    report_resolution(corrected.system, stepped, corrected.solution)
    return corrected


def _opened(
    path: Path, folder: Path, case: str, inputs: Inputs | None, *, resume: bool, overwrite: bool
) -> CorrectionFolder:
    if resume:
        if path.exists():
            # Raises an error if the run is complete or an input has changed.
            ResultFile.resume(path, case=case, inputs=inputs or {"the case": case}).close()
        return CorrectionFolder.resume(folder, case=case, inputs=inputs)
    if overwrite:
        # Deleted before the rounds and bodies are replaced, so that motion and bodies always belong together.
        with ExclusiveLock(path):
            path.unlink(missing_ok=True)
    else:
        check_nothing_lost(path)
        if CorrectionFolder(folder, case=case).is_begun:
            raise ResultFileError(
                f"cannot write {folder}: it holds the rounds of an interrupted run; give resume=True to "
                "continue it or overwrite=True to replace it, or choose another path"
            )
    return CorrectionFolder.create(folder, case=case, inputs=inputs)


def _corrected(
    system: System,
    run: Run,
    starts: Mapping[str, ReductionStart],
    archive: CorrectionFolder,
    announce: Announce | None,
    accepted: Accepted | None,
    progress: StepProgress | None,
    study: ErrorStudy | None,
) -> tuple[CorrectedSystem, list[Round]]:
    """The self-correction, and its rounds in the order of completion."""
    rounds: list[Round] = []

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
                system,
                lenient,
                starts,
                announce=finished,
                accepted=accepted,
                progress=progress,
                archive=archive,
                study=study,
            )
    except SelfCorrectionError as error:
        best = archive.motion(best_round(correction_numbers(rounds)) if rounds else 0)
        raise SelfCorrectionError(f"{error}; the best round is in {best}", tuple(rounds)) from error
    return corrected, rounds
