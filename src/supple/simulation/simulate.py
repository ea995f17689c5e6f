"""Simulation of a machine, in memory or recorded in a file."""

from __future__ import annotations

from pathlib import Path

from supple.arguments import checked_arguments
from supple.integrate import Progress, Recorder, Run, Solution
from supple.machine import System
from supple.progress import by_fraction, with_progress_bar
from supple.simulation.description import description
from supple.simulation.recorded_run import simulate_recorded
from supple.simulation.watched_run import watched_run

__all__ = ["simulate"]


@checked_arguments
@with_progress_bar("simulating", by_fraction)
def simulate(
    system: System,
    run: Run,
    *,
    file: Path | str | None = None,
    overwrite: bool = False,
    resume: Solution | None = None,
    progress: Progress | None = None,
    record: Recorder | None = None,
    check: bool = True,
) -> Solution:
    """Motion of a system from its initial state over a run.

    The method of the run and the form of the bodies determine the engine. By default, rigid and reduced
    bodies are integrated by one compiled program, and machines with full bodies by sparse Newton steps.

    Parameters
    ----------
    system : System
    run : Run               span, output times, steps, tolerances
    file : path             record the motion in this result file as it is computed; an existing complete run
                            is read, an interrupted one is continued
    overwrite : bool        start a new run in `file`, whatever the file contains
    resume : Solution       continue from the end of an earlier part of the same run
    progress, record : called during the run; `record` receives every completed leg
    check : bool            raise if the run ends early; if False, `Solution.stopped` states the cause

    Returns
    -------
    Solution    at the output times; with `resume`, only at those after the recorded part

    Raises
    ------
    ModelError          a joint open at the start, a table that begins too late or ends too early
    ConvergenceError    a step fails at the smallest size; the message states time, residual and remedy. The
                        results until then were passed to `record` or are in the file
    ValidityError       with `Validity(strict=True)`, in place of the warnings below on validity, start and
                        resolution, except those on output times
    ValueError          `overwrite` without `file`; `resume` or `record` with `file`
    ResultFileError     the file has another run, another run is writing it, or it cannot be read or written
    KeyboardInterrupt   (Ctrl-C; on SIGTERM `Terminated`) with a note of the last time in the file

    Warns
    -----
    ValidityWarning             a motion beyond the range of the kinematics, or of the angle of an element
    StartWarning                initial positions or velocities that the joints do not allow
    ResolutionWarning           steps, or output times, too far apart for loads and motions
    StepCutWarning              fixed steps that were shortened
    RedundantConstraintWarning  redundant constraints of joints
    """
    if file is None:
        if overwrite:
            raise ValueError("overwrite: there is no file to overwrite; give it, file=PATH")
        return watched_run(system, run, resume=resume, progress=progress, record=record, check=check)
    if resume is not None or record is not None:
        raise ValueError("a run with a file is resumed and recorded there: leave out resume and record")
    return simulate_recorded(
        system,
        run,
        file,
        case=description(system, run),
        overwrite=overwrite,
        progress=progress,
        check=check,
    )
