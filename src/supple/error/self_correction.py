"""Self-correcting reduction: enrich the bases by the motion outside them until the error is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from supple.arguments import checked_arguments
from supple.body import FullBody
from supple.error.correction_rounds import (
    CorrectedSystem,
    ReductionStart,
    SelfCorrection,
    warn_of_fixed_sizes,
)
from supple.error.error_study import ErrorStudy, quantities_of_interest, warn_of_model
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
    """Reduce bodies of a system together until the estimated error of their run is allowed.

    Start with small bases and run. Estimate the error and the motion outside the bases (`estimate_error`).
    Append the leading directions of that motion to the bases, and run again. The estimate needs neither a
    full-order time integration nor a run with a finer basis: it integrates the equations linearised about the
    run, driven by the residual of the run at every step. If the estimate is doubtful, a second run must
    confirm it (`stopping`). The error of a first round that cannot be accepted is not estimated. The appended
    directions include the quasi-static motion that balances the residual at some sample times
    (`system_corrections`); its size is reported as `Round.indicator`. Modes within the frequency band of the
    loads belong in the basis from the start (`load_spectrum` warns of missing modes).

    Every round simulates all reduced bodies together and enriches all their bases, until every body meets its
    target in the same round: through the joints, each body contributes to the errors of the others.

    Parameters
    ----------
    system : System     contains each body to reduce as a FullBody, with its frame and damping
    run : Run           settings of every round
    target : the target error of every full body (SelfCorrection), or also its start basis (ReductionStart);
        or a ReductionStart for each named body, with all other bodies unchanged
    announce : function     called with every round as it is finished
    accepted : function     called in every pass with the CorrectedSystem whose bases meet the target, before
        the other parts of the error in the study are estimated; not called without a study
    progress : function     called with the name of the current step and its completed fraction
    archive : RoundArchive  stores the results, and is read first; None: results are in memory only
    study : ErrorStudy      if given, the target limits the sum of all parts in the study: steps are shortened
                            and tolerances tightened as well (`correct_wholly`); None: the target limits the
                            error of the basis alone, and the steps stay unchanged

    Returns
    -------
    CorrectedSystem     .system, .solution, .bodies

    Raises
    ------
    SelfCorrectionError     (an AccuracyError) a target is not met; its `rounds` hold the completed rounds
    ModelError              nothing to reduce, a body that is not full, a machine with controllers or
                            intrinsic bodies; errors of `reduce`
    ConvergenceError        a run stopped before its first output time after the start

    Warns
    -----
    LoadSpectrumWarning     the loads excite modes outside a start basis; and warnings of `simulate`
    BasisWarning            a reduced body that is not corrected; no estimated error contains its error
    ValidityWarning         an error of the model above 5 % of a body's displacement
    """
    starts = _starts(system, target)
    if not starts:
        raise ModelError("self-correction: name at least one body of the system to reduce")
    warn_of_fixed_sizes(system, starts)
    problem = Problem(
        system=system,
        fulls={name: _full(system, name) for name in starts},
        starts=starts,
        run=run,
        announce=announce,
        progress=progress,
        archive=archive or InMemoryArchive(),
        accepted=None if accepted is None else lambda corrected: accepted(_without_padding(corrected)),
    )
    if study is None:
        return _without_padding(correct(problem))
    problem = replace(problem, besides=tuple(quantities_of_interest(system, study)))
    corrected = correct_wholly(problem, study)
    warn_of_model(corrected.system, run, corrected.solution)
    return _without_padding(corrected)


def _without_padding(corrected: CorrectedSystem) -> CorrectedSystem:
    """The corrected system, with the reduced bodies without padding coordinates."""
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
