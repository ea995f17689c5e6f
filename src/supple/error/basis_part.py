"""The part of the bases in the error of a finished run: by the error equation, or by a run with richer bases.

The error equation estimates the true motion, to first order, and shows where that is not enough
(`BodyError.second` above a third). There a run with much richer bases is made instead. So it is where the
estimate is doubtful (`BodyError.is_doubtful`): about a run that locks the equation can find too little.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from supple.body.full_body import FullBody
from supple.error.basis_error import ENRICH
from supple.error.check_run import check_run
from supple.error.error_estimate import INSTANTS, ErrorEstimate, ErrorEstimator
from supple.integrate import ErrorPart, FramedMotion, Run, Solution, StepProgress
from supple.machine import System
from supple.quantities.quantity_of_interest import QuantityOfInterest, largest_displacement, quantity_distance
from supple.reduction import ReductionBasis

__all__ = ["assessed_basis", "basis_parts", "distances", "in_full", "stated_of"]

NEGLIGIBLE = 1e-3
"""Of the largest displacement: motion missed at rest that is less raises no doubt."""


def basis_parts(
    system: System,
    run: Run,
    solution: Solution,
    fulls: Mapping[str, FullBody],
    bases: Mapping[str, ReductionBasis],
    quantities: Sequence[QuantityOfInterest],
    *,
    progress: StepProgress | None = None,
) -> dict[str, ErrorPart]:
    """The part of the bases in some quantities of a finished run, by their names.

    fulls, bases : of the reduced bodies whose bases are assessed, by name
    """
    if system.controllers:  # they have no part in the error equation
        asked = stated_of(system, bases, quantities)
        return check_run(system, run, solution, fulls, bases, asked, progress=progress)
    whole = in_full(system, fulls, bases)
    return assessed_basis(whole, system, run, solution, bases, quantities, progress=progress)[0]


def assessed_basis(
    whole: System,
    system: System,
    run: Run,
    solution: Solution,
    bases: Mapping[str, ReductionBasis],
    quantities: Sequence[QuantityOfInterest],
    *,
    instants: int = INSTANTS,
    progress: StepProgress | None = None,
) -> tuple[dict[str, ErrorPart], ErrorEstimate]:
    """The same, and the estimate by the error equation, whatever it is worth.

    whole : the machine with all coordinates of the bodies that are assessed, as it should start
    instants : as for `ErrorEstimator.assess`
    """
    asked = stated_of(system, bases, quantities)
    step = "the error equation"
    share = None if progress is None else lambda fraction: progress(step, fraction)
    estimate = ErrorEstimator(whole, run).assess(system, bases, solution, instants=instants, progress=share)
    found = estimate.error.bodies
    doubtful = any(each.is_doubtful(_negligible(system, solution, name)) for name, each in found.items())
    if all(each.is_converged for each in found.values()) and not doubtful:
        parts = {
            name: ErrorPart(value, step, ENRICH)
            for name, value in distances(system, solution, estimate, asked).items()
        }
    else:
        fulls = whole.bodies_of(FullBody)
        missed = {name: own.deformation for name, own in estimate.corrections.items()}
        parts = check_run(system, run, solution, fulls, bases, asked, missed=missed, progress=progress)
    return parts, estimate


def stated_of(
    system: System, names: Collection[str], quantities: Sequence[QuantityOfInterest]
) -> list[QuantityOfInterest]:
    """Those quantities of which the bases of some bodies are all that is missing.

    names : of the bodies whose bases are assessed; what moves with others as well is not known from these
    """
    elastic = {each.body.name for each in system.bodies if each.body.n_coordinates}
    is_whole = elastic <= set(names)
    return [each for each in quantities if is_whole or each.body in names]


def distances(
    system: System, solution: Solution, estimate: ErrorEstimate, quantities: Sequence[QuantityOfInterest]
) -> dict[str, float]:
    """Error of a run in some quantities, by their names; infinite where the equation has no solution."""
    if estimate.corrected is None:
        return {each.name: np.inf for each in quantities}
    # What the space of the error lacks is known of whole bodies: of others in the same proportion.
    bodies = estimate.error.bodies.values()
    lack = max(each.estimate / each.rms if each.rms else 1.0 for each in bodies)
    return {
        each.name: lack * quantity_distance(each, system, solution, *estimate.corrected)
        for each in quantities
    }


def _negligible(system: System, solution: Solution, name: str) -> float:
    body = system.placed(name).body
    return NEGLIGIBLE * largest_displacement(body, solution.motion(name, FramedMotion).coordinates)


def in_full(system: System, fulls: Mapping[str, FullBody], bases: Mapping[str, ReductionBasis]) -> System:
    """The machine with its reduced bodies in full, as deformed at the start as they were."""
    bodies = [
        placed.in_form(fulls[name], bases[name].vectors) if (name := placed.body.name) in bases else placed
        for placed in system.bodies
    ]
    return replace(system, bodies=tuple(bodies))
