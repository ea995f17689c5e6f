"""Simulate a machine, in memory or kept in a file."""

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

    The form of the bodies chooses the method: rigid and reduced ones are marched by one compiled program,
    full ones by sparse Newton steps.

    Parameters
    ----------
    system : System
    run : Run               span, output times, steps, tolerances
    file : path             keep the motion in this result file as it is computed, and go on with what is
                            there: a finished run is read, one that was cut off is continued
    overwrite : bool        begin anew, whatever the file holds
    resume : Solution       go on from the end of an earlier part of the same run
    progress, record : called as the run goes on; `record` receives every completed leg
    check : bool            raise where the run ends early; otherwise `Solution.stopped` is the reason

    Returns
    -------
    Solution    at the output times; with `resume`, only the new ones

    Raises
    ------
    ModelError          a joint open at the start, a table that begins too late or ends too early
    ConvergenceError    a step that fails at the smallest size: time, residual and remedy; what was computed
                        until then has been handed to `record` and is kept in the file
    ValidityError       what is warned of below under Validity, Start and Resolution, save output times, under
                        `Validity(strict=True)`
    ResultFileError     the file holds another run, another run is writing it, or it cannot be read or written
    KeyboardInterrupt   (Ctrl-C; on SIGTERM `Terminated`) with a note up to which time the file keeps the run

    Warns
    -----
    ValidityWarning             a motion beyond what the kinematics can describe
    StartWarning                initial positions or velocities that the joints do not allow
    ResolutionWarning           steps, or output times, too far apart for loads and motions
    StepCutWarning, RedundantConstraintWarning
    """
    if file is None:
        if overwrite:
            raise ValueError("overwrite: there is no file to overwrite; name it, file=PATH")
        return watched_run(system, run, resume=resume, progress=progress, record=record, check=check)
    if resume is not None or record is not None:
        raise ValueError("a run that is kept in a file is resumed and recorded there: leave these out")
    return simulate_recorded(
        system,
        run,
        file,
        case=description(system, run),
        overwrite=overwrite,
        progress=progress,
        check=check,
    )
