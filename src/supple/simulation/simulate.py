"""Simulation of a machine, with the result in memory or in a file."""

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
    """Simulate a machine: its motion from the initial state over the time span of a run.

    The method of the run and the forms of the bodies determine the solver. By default, one compiled program
    integrates a machine of rigid and reduced bodies; sparse Newton steps integrate one with full bodies.

    Parameters
    ----------
    system : System
    run : Run               time span, output times, steps, tolerances
    file : path             result file, written during the run. If it already contains this run, a complete
                            run is read, and an interrupted one is continued
    overwrite : bool        start a new run in `file`, whatever the file contains
    resume : Solution       continue from the end of this earlier part of the same run
    progress : function     called during the run with its completed fraction
    record : function       called with the solution of each completed part of the run
    check : bool            if the run ends early, True: raise the error; False: `Solution.stopped` has it

    Returns
    -------
    Solution    at the output times; with `resume`, only at those after the earlier part

    Raises
    ------
    ModelError          a joint open at the start, a table of a law that does not cover the run
    ConvergenceError    a step fails at the smallest size; the message has time, residual and remedy. The
                        earlier results are in the file, or were passed to `record`
    ValidityError       with `Validity(strict=True)`: in place of ValidityWarning, StartWarning and
                        ResolutionWarning, except a ResolutionWarning about output times
    ValueError          `overwrite` without `file`; `resume` or `record` with `file`
    ResultFileError     the file contains another run, is being written by another run, or cannot be read or
                        written
    KeyboardInterrupt   after Ctrl-C; `Terminated`, a SystemExit, after SIGTERM. With `file`, both have a note
                        of the last time in it

    Warns
    -----
    ValidityWarning             a motion beyond the limits of the kinematics, or an angle of a force element
                                beyond half a revolution
    StartWarning                initial positions or velocities that the joints do not allow
    ResolutionWarning           time steps or output times that do not resolve loads or motions
    StepCutWarning              fixed steps that did not converge and were shortened
    RedundantConstraintWarning  redundant constraints of joints
    """
    if file is None:
        if overwrite:
            raise ValueError("overwrite=True without a file; give file=PATH")
        return watched_run(system, run, resume=resume, progress=progress, record=record, check=check)
    if resume is not None or record is not None:
        raise ValueError("`file` resumes and records the run: leave out resume and record")
    return simulate_recorded(
        system,
        run,
        file,
        case=description(system, run),
        overwrite=overwrite,
        progress=progress,
        check=check,
    )
