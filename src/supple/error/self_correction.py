"""Self-correcting reduction: a reduced run finds the motion outside its basis, and estimates its error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from supple.arguments import checked_arguments
from supple.body import FullBody
from supple.error.correction_rounds import CorrectedSystem, ReductionStart, SelfCorrection
from supple.error.error_study import ErrorStudy, quantities_of_interest
from supple.error.round_archive import InMemoryArchive, RoundArchive
from supple.error.system_correction import Accepted, Announce, Problem, correct
from supple.error.whole_correction import correct_wholly
from supple.errors import ModelError
from supple.integrate import Run, StepProgress
from supple.machine import System
from supple.progress import by_step, with_progress_bar

__all__ = ["self_correct"]


@checked_arguments
@with_progress_bar("correcting the basis", by_step)
def self_correct(
    system: System,
    run: Run,
    target: SelfCorrection | ReductionStart | Mapping[str, ReductionStart],
    *,
    announce: Announce | None = None,
    accepted: Accepted | None = None,
    progress: StepProgress | None = None,
    archive: RoundArchive | None = None,
    study: ErrorStudy | None = None,
) -> CorrectedSystem:
    """Reduce bodies of a system together, as far as an error allows that the reduced runs themselves measure.

    Start small, run, estimate the error and the motion outside the basis (`estimate_error`),
    append the leading directions of that to the bases, run again. No full-order time integration is made, and
    no finer run to measure by: the run's own residual at every step drives its linearised integrator. The
    motion that it would take to balance the residual at rest, at some instants (`system_corrections`), is
    among what is appended; its size (`Round.indicator`) is stated beside. Modes inside the band in which the
    loads excite the body belong in the basis from the start (`load_spectrum` looks).

    Every round runs all bodies reduced and enriches them all, until every body meets its error in the same
    round: through the joints each body has a share in the errors of the others, which only runs that differ
    in all bases can show.

    Parameters
    ----------
    system : System     each body to reduce is in it as a FullBody, which holds its frame and damping
    run : Run           of every round
    target : the error to reach, of every full body (SelfCorrection); with the basis to start from
        (ReductionStart); or such a start for each body that is named, the others staying as they are
    announce : function     called with every round as it is finished
    accepted : function     called with the run whose basis keeps to the error, in every pass, before the
        other parts that a study names are stated
    progress : function     called with the step at work, in words, and the completed fraction of it
    archive : RoundArchive  keeps what is computed, and is read first; none: all is in memory
    study : ErrorStudy      the error to reach is that of all parts which it names, added up: steps are cut
                            and tolerances tightened as well (`correct_wholly`); none: that of the basis
                            alone, at the steps of the run

    Returns
    -------
    CorrectedSystem     .system, .solution, .bodies

    Raises
    ------
    SelfCorrectionError     (an AccuracyError) an error is not met; its `rounds` keep what was computed
    ModelError              nothing to reduce, a body that is not full; errors of `reduce`
    ConvergenceError        a run broke off before its first output time

    Warns
    -----
    LoadSpectrumWarning     the loads excite modes that a start lacks; and warnings of `simulate`
    """
    starts = _starts(system, target)
    if not starts:
        raise ModelError("self-correction: name at least one body of the system to reduce")
    problem = Problem(
        system=system,
        fulls={name: _full(system, name) for name in starts},
        starts=starts,
        run=run,
        announce=announce,
        progress=progress,
        archive=archive or InMemoryArchive(),
        accepted=None if accepted is None else lambda corrected: accepted(_without_room(corrected)),
    )
    if study is None:
        return _without_room(correct(problem))
    problem = replace(problem, besides=tuple(quantities_of_interest(system, study)))
    corrected = correct_wholly(problem, study)
    return _without_room(corrected)


def _without_room(corrected: CorrectedSystem) -> CorrectedSystem:
    """The bodies as they are used from now on, with no coordinates but their own."""
    bodies = corrected.bodies
    placed = tuple(
        replace(each, body=bodies[each.body.name].body) if each.body.name in bodies else each
        for each in corrected.system.bodies
    )
    return replace(corrected, system=replace(corrected.system, bodies=placed))


def _starts(
    system: System, target: SelfCorrection | ReductionStart | Mapping[str, ReductionStart]
) -> Mapping[str, ReductionStart]:
    if isinstance(target, Mapping):
        return target
    start = ReductionStart(target) if isinstance(target, SelfCorrection) else target
    return dict.fromkeys(system.bodies_of(FullBody), start)


def _full(system: System, name: str) -> FullBody:
    body = system.placed(name, "self-correction").body
    fulls = system.bodies_of(FullBody)
    if name not in fulls:
        raise ModelError(
            f"self-correction: body '{name}' is in the system as a {type(body).__name__}; place it as a "
            "FullBody(flexible_body, frame, damping), which is then reduced"
        )
    return fulls[name]
