"""Error estimate of a finished run: the parts of the error in each body and quantity of interest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from supple.arguments import check_fields, check_members, checked_arguments
from supple.body.full_body import FullBody
from supple.equations.checks.strictness import warn_or_raise
from supple.error.basis_part import basis_parts
from supple.error.integration_error import integration_errors
from supple.error.line_parts import line_parts
from supple.error.model_error import model_errors
from supple.errors import ModelError, ValidityWarning
from supple.integrate import ErrorPart, ErrorStatement, Kinematic, Run, Solution, StepProgress
from supple.machine import System
from supple.methods.intrinsic import IntrinsicBody, with_chosen_step
from supple.progress import by_step, with_progress_bar
from supple.quantities.quantity_of_interest import QuantityOfInterest, WholeBody
from supple.reduction import ReductionBasis
from supple.simulation.engines import refuse_explicit
from supple.simulation.stored_basis import stored_bases

__all__ = ["ErrorStudy", "state_errors", "warn_of_model"]


@dataclass(frozen=True)
class ErrorStudy:
    """The parts of the error that are estimated, and the quantities of interest.

    basis : bool        error of the basis, from the error equation or from one more run with richer bases; it
                        is estimated for the reduced bodies whose full bodies are given
    integration : bool  errors of time step and Newton tolerance, from two more runs: the first has a tighter
                        tolerance, the second also half the step. False: no error of the step; for the
                        tolerance its smallest value: ten times tolerance times size of the quantity
    model : bool        error of the kinematics, from the element forces and one solution of the linearised
                        equations of the whole system, at each of six times
    quantities : sensors and bodies to assess besides every elastic body
    """

    basis: bool = True
    integration: bool = True
    model: bool = True
    quantities: tuple[QuantityOfInterest, ...] = ()

    def __post_init__(self) -> None:
        check_fields(self)
        for each in self.quantities:
            known = "the sensor of a position, a joint's force or a stress, or WholeBody(body)"
            check_members("ErrorStudy, quantities", each, ("at_points", "size"), known)


@checked_arguments
@with_progress_bar("estimating the error", by_step)
def state_errors(
    system: System,
    run: Run,
    solution: Solution,
    study: ErrorStudy | None = None,
    *,
    fulls: Mapping[str, FullBody] | Sequence[FullBody] = (),
    progress: StepProgress | None = None,
) -> Solution:
    """Estimate the error of a finished run: the solution with `solution.errors` and `motion.error` of bodies.

    The error has four parts: basis, time step, Newton tolerance and model. `ErrorStudy` describes how each is
    estimated. The solution of a kinematic run is returned unchanged, and that of a machine of rigid bodies
    without quantities in the study.

    Parameters
    ----------
    system, run, solution : the machine as simulated, the settings of the run, and its result
    study : ErrorStudy      by default all parts of the error, for every elastic body
    fulls : full bodies of the reduced bodies. Without a full body, or in a machine with intrinsic bodies, the
        error of the basis is not estimated, and the error of the model follows from the rotation limit. If
        the run stopped early, the error of the basis is not estimated
    progress : called with the name of the current step and its completed fraction

    Raises
    ------
    ModelError      a quantity of an unknown body or joint, a full body that does not belong to this machine,
        an explicit run

    Warns ValidityWarning if the error of the model of a body exceeds 5 % of its displacement; in a strict run
    this raises ValidityError.
    """
    if isinstance(run.method, Kinematic):  # no integration, and no body deforms
        return solution
    refuse_explicit(system, run, "an error estimate")
    study, run = study or ErrorStudy(), with_chosen_step(system, run)
    if not isinstance(fulls, Mapping):
        fulls = {full.name: full for full in fulls}
    # In a machine with an intrinsic body the error equation of floating bodies is not available.
    known = {} if system.bodies_of(IntrinsicBody) else _of_machine(system, fulls)
    quantities = quantities_of_interest(system, study)
    if not quantities:  # rigid bodies alone: the further runs would have nothing to compare
        return solution
    bases = stored_bases(system, known)
    of_basis: Mapping[str, ErrorPart] = {}
    if study.basis and bases and solution.stopped is None:
        of_basis = basis_parts(system, run, solution, known, bases, quantities, progress=progress)
    of_basis = {**of_basis, **line_parts(system, solution)}  # also without study.basis, as it costs little
    solution = solution.with_errors(
        statements(system, run, solution, study, known, bases, of_basis, progress=progress)
    )
    warn_of_model(system, run, solution)
    return solution


def warn_of_model(system: System, run: Run, solution: Solution) -> None:
    """Warn of elastic bodies whose error of the model is large; in a strict run raise ValidityError."""
    for name in (placed.body.name for placed in system.bodies if placed.body.n_coordinates):
        stated = solution.errors.get(name)
        if stated is not None and stated.model_warning:
            warn_or_raise(f"body '{name}': {stated.model_warning}", ValidityWarning, run.validity)


def quantities_of_interest(system: System, study: ErrorStudy) -> list[QuantityOfInterest]:
    """Every elastic body, and the quantities of the study."""
    elastic: list[QuantityOfInterest] = [
        WholeBody(placed.body.name) for placed in system.bodies if placed.body.n_coordinates
    ]
    return elastic + list(study.quantities)


def statements(
    system: System,
    run: Run,
    solution: Solution,
    study: ErrorStudy,
    fulls: Mapping[str, FullBody],
    bases: Mapping[str, ReductionBasis],
    of_basis: Mapping[str, ErrorPart],
    *,
    allowed: Mapping[str, float] | None = None,
    quantities: Sequence[QuantityOfInterest] | None = None,
    progress: StepProgress | None = None,
) -> dict[str, ErrorStatement]:
    """The error statements of a run, by name of the quantity.

    of_basis : error of the basis, by name of the quantity; not needed for full bodies, for which it is zero
    allowed : largest allowed sum of the parts, by name of the quantity
    """
    quantities = quantities_of_interest(system, study) if quantities is None else quantities
    integration = integration_errors(
        system, run, solution, quantities, measured=study.integration, progress=progress
    )
    model: Mapping[str, ErrorPart] = {}
    if study.model:
        step = "elements and ties at the largest rotations"
        share = None if progress is None else lambda fraction: progress(step, fraction)
        model = model_errors(system, fulls, bases, solution, quantities, progress=share)
    full_order = system.bodies_of(FullBody)
    no_basis = all(each.body.name in full_order for each in system.bodies if each.body.n_coordinates)
    return {
        each.name: ErrorStatement(
            of=each.words,
            size=each.size(system, solution),
            basis=ErrorPart(0.0, "no basis: all coordinates")
            if no_basis or each.body in full_order
            else of_basis.get(each.name),
            step=integration[each.name].step,
            newton=integration[each.name].newton,
            model=model.get(each.name),
            allowed=None if allowed is None else allowed.get(each.name),
            quantity=each.quantity.value,
        )
        for each in quantities
    }


def _of_machine(system: System, fulls: Mapping[str, FullBody]) -> dict[str, FullBody]:
    """Those of the full bodies that the machine has in another form.

    Raises ModelError if a full body has another number of nodes than the body in the machine.
    """
    for name, full in fulls.items():
        body = system.placed(name, "stated error").body
        if len(body.nodes) != len(full.nodes):
            raise ModelError(
                f"error study: full body '{name}' has {len(full.nodes)} nodes, and the body in the machine "
                f"{len(body.nodes)}; give the full body that was reduced"
            )
    in_full = system.bodies_of(FullBody)
    return {name: full for name, full in fulls.items() if name not in in_full}
