"""Error of a finished run caused by its bases, from the error equation or from a run with richer bases.

The error equation estimates the true motion to first order, and detects where first order is not enough
(`BodyError.second` above a third). In that case a run with much richer bases is made instead. Such a run is
also made if the estimate is doubtful (`BodyError.is_doubtful`): for a run that locks, the equation can
underestimate the error.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from supple.body.full_body import FullBody
from supple.error.basis_error import ENRICH
from supple.error.check_run import check_run
from supple.error.error_estimate import (
    INSTANTS,
    ErrorEstimate,
    ErrorEstimator,
    MissingMotionAlongRun,
    reduced_form,
)
from supple.error.stopping import locks
from supple.integrate import ErrorPart, FramedMotion, Run, Solution, StepProgress
from supple.machine import System
from supple.quantities.quantity_of_interest import QuantityOfInterest, largest_displacement, quantity_distance
from supple.reduction import ReductionBasis

NEGLIGIBLE = 1e-3
"""Ratio to the largest displacement below which quasi-static motion outside the basis is ignored."""


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
    """Error of a finished run caused by its bases, by name of the quantity of interest.

    fulls, bases : full bodies and bases of the assessed reduced bodies, by name
    """
    if system.controllers:  # the error equation does not contain them
        asked = stated_of(system, bases, quantities)
        return check_run(system, run, solution, fulls, bases, asked, progress=progress)[0]
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
) -> tuple[dict[str, ErrorPart], Mapping[str, np.ndarray]]:
    """The errors as from `basis_parts`, and the displacement fields (n, m) outside the basis of each body.

    whole : the machine with all coordinates of the assessed bodies, in its start configuration
    instants : as for `ErrorEstimator.assess`
    """
    asked = stated_of(system, bases, quantities)
    step = "the error equation"
    share = None if progress is None else lambda fraction: progress(step, fraction)
    estimator = ErrorEstimator(whole, run)
    missing = estimator.missing_motion(system, bases, solution, instants=instants, progress=share)
    fields: Mapping[str, np.ndarray] = missing.fields
    if not _is_surely_doubtful(system, missing):
        estimate = estimator.error_of(missing, system, bases, solution, progress=share)
        fields, found = estimate.missed, estimate.error.bodies
        doubtful = any(each.is_doubtful(_negligible(system, solution, name)) for name, each in found.items())
        if all(each.is_converged for each in found.values()) and not doubtful:
            return {
                name: ErrorPart(value, step, ENRICH)
                for name, value in distances(system, solution, estimate, asked).items()
            }, fields
    fulls = whole.bodies_of(FullBody)
    parts, shapes = check_run(
        system, run, solution, fulls, bases, asked, missed=missing.fields, progress=progress
    )
    for name, own in shapes.items():
        # The new fields together get the weight of all existing fields of this body.
        fields = {**fields, name: np.hstack([own * np.sqrt(fields[name].shape[1]), fields[name]])}
    return parts, fields


def _is_surely_doubtful(system: System, missing: MissingMotionAlongRun) -> bool:
    """Whether any estimate by the error equation would be doubtful (`BodyError.is_doubtful`)."""
    return any(
        locks(reduced_form(system, name)) or not np.isfinite(own.rms).all()
        for name, own in missing.corrections.items()
    )


def stated_of(
    system: System, names: Collection[str], quantities: Sequence[QuantityOfInterest]
) -> list[QuantityOfInterest]:
    """The quantities whose reduction error is known completely from the bases of the named bodies.

    names : bodies whose bases are assessed; quantities that depend on other elastic bodies are left out
    """
    elastic = {each.body.name for each in system.bodies if each.body.n_coordinates}
    is_whole = elastic <= set(names)
    return [each for each in quantities if is_whole or each.body in names]


def distances(
    system: System, solution: Solution, estimate: ErrorEstimate, quantities: Sequence[QuantityOfInterest]
) -> dict[str, float]:
    """Error caused by the bases, by name of the quantity; infinite where the equation has no solution."""
    if estimate.corrected is None:
        return {each.name: np.inf for each in quantities}
    # The part outside the error space is known per body only. All quantities are scaled by the largest ratio
    # of the total error to the part in the error space.
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
    """The machine with its reduced bodies in full, with the same initial deformation."""
    bodies = [
        placed.in_form(fulls[name], bases[name].vectors) if (name := placed.body.name) in bases else placed
        for placed in system.bodies
    ]
    return replace(system, bodies=tuple(bodies))
