"""Self-correcting reduction: a reduced run finds what its basis misses, mends it, and tells its own error."""

from __future__ import annotations

from collections.abc import Callable

from supple.body import FlexibleBody, Frame, RayleighDamping
from supple.body.full_body import FullBody
from supple.correction.correction_rounds import (
    ReductionStart,
    Round,
    SelfCorrected,
    SelfCorrection,
    SelfCorrectionError,
)
from supple.correction.round_archive import InMemoryArchive, RoundArchive
from supple.correction.system_correction import Announce, CorrectionProgress, Problem, RunOptions, correct
from supple.integrate import StepControl, TimeIntegrator, Tolerances
from supple.machine.system import System
from supple.multibody.checks.validity import Validity
from supple.reduction import (
    CompressedDerivatives,
    DerivativeChoice,
    LinearBasisRecipe,
    ReducedBody,
)

__all__ = ["Round", "SelfCorrected", "SelfCorrection", "SelfCorrectionError", "self_correct"]


def self_correct(
    system_of: Callable[[ReducedBody], System],
    body: FlexibleBody,
    frame: Frame,
    basis: LinearBasisRecipe,
    *,
    target: SelfCorrection,
    duration: float,
    output_step: float,
    derivatives: DerivativeChoice = CompressedDerivatives(5),  # noqa: B008 (it is immutable)
    damping: RayleighDamping | None = None,
    step: StepControl | None = None,
    method: TimeIntegrator | None = None,
    tolerances: Tolerances | None = None,
    validity: Validity | None = None,
    announce: Announce | None = None,
    progress: CorrectionProgress | None = None,
    archive: RoundArchive | None = None,
) -> SelfCorrected:
    """Reduce a body as far as an error allows, which the reduced runs themselves measure.

    Start small, run, find at a few instants the motion that the basis misses (`residual_corrections`), append
    its leading directions to the basis, run again. No full-order time integration is made. Run k is measured
    by run k + 1, with eps the largest RMS distance of the nodes over the run:

        d_k = eps(run k, run k+1),   e_k = d_k / sqrt(1 - rho^2),   rho = d_k / d_(k-1)

    which adds up what the runs to come will change, were each of them to gain as little as the last one did:
    as squares, for what a round adds to the basis is orthogonal to all before. A round gains one to three
    orders, so that e_k is d_k but for a per cent, and the rounds end where d_k does not shrink. So
    the run that meets the tolerance is the last but one. The size of the missing motion (`Round.indicator`)
    is a second opinion, asked for in the first round, where rho is unknown and taken as zero: sharp for slow
    motion, loose near a resonance of what the basis lacks. Modes inside the band in which the loads excite
    the body belong in the basis from the start (`load_spectrum` looks).

    Parameters
    ----------
    system_of : function    the system with a reduced body in it; other flexible bodies stay as they are, and
                            `self_correct_system` reduces several together
    body, frame, basis, derivatives, damping        the start, as for `reduce`
    target : SelfCorrection
    duration, output_step, step, method, tolerances, validity   of each run, as for `simulate`
    announce : function     called with every round as it is finished
    progress : function     called with the step at work, in words, and the completed fraction of it
    archive : RoundArchive  keeps what is computed, and is read first; none: all is in memory

    Returns
    -------
    SelfCorrected   .body, .solution, .estimated_error, .rounds

    Raises
    ------
    SelfCorrectionError     (an AccuracyError) the tolerance is not met; its `rounds` keep what was computed
    ModelError              the system does not hold the body; errors of `reduce`
    ConvergenceError        a run broke off before its first output time

    Warns
    -----
    LoadSpectrumWarning     the loads excite modes that the start lacks; and warnings of `simulate`
    """
    corrected = correct(
        Problem(
            system_of=lambda bodies, _: system_of(bodies[body.name]),
            fulls={body.name: FullBody(body, frame, damping)},
            starts={body.name: ReductionStart(target, basis, derivatives)},
            options=RunOptions(duration, output_step, step, method, tolerances, validity),
            announce=announce,
            progress=progress,
            archive=archive or InMemoryArchive(),
        )
    )
    return corrected.bodies[body.name]
