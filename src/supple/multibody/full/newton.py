"""Iterations that solve a step: modified Newton's on a kept tangent, and Newton's own behind it.

Each iteration evaluates the exact equations and solves for a correction with a tangent that may be old:

    x_1 = x_0 - T^-1 r(x_0),       rate = |r(x_1)| / |r(x_0)|

with `|r|` the largest relative residual in parts of its tolerance. `T` is first the symmetric part of the
tangent, L D L^T. It is kept over iterations and steps while an iteration gains tenfold (rate below 0.1), or
the next one reaches the tolerance; then it is made anew. Where a new symmetric one gains less, as at high
angular velocities, whose terms are skew, the unsymmetric tangent takes its place and is kept in the same way.
An iteration that gains nothing at all is taken back.

Where this does not converge, Newton's method with the exact tangent of every iterate does the step from its
start. A tangent decides on the iterations alone: a step ends where the exact equations hold to the tolerance.

Source: P. N. Brown, A. C. Hindmarsh and L. R. Petzold (1994) for keeping a factor by its rate.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from supple.errors import AccuracyError
from supple.multibody.full.implicit_step import ImplicitStep, Stepped
from supple.multibody.full.kept_tangent import KeptTangent, serves
from supple.multibody.full.predictor import Unknowns, unknowns_of

__all__ = ["SLOWEST", "NewtonIteration", "exact_newton", "modified_newton"]

SLOWEST = 0.1
"""Rate beyond which a kept tangent is renewed."""

NewtonIteration = Callable[[ImplicitStep, Unknowns, KeptTangent | None], Stepped]
"""Of a step, where the iteration starts, and the tangent of an earlier step."""


def modified_newton(step: ImplicitStep, predicted: Unknowns, kept: KeptTangent | None) -> Stepped:
    """The kept tangent as far as it goes, then Newton's own."""
    modified = _modified(step, predicted, kept)
    if modified.converged:
        return modified
    exact = exact_newton(step, predicted, None)
    return exact._replace(
        iterations=modified.iterations + exact.iterations,
        factorizations=modified.factorizations + exact.factorizations,
    )


def exact_newton(step: ImplicitStep, predicted: Unknowns, kept: KeptTangent | None) -> Stepped:  # noqa: ARG001
    """Newton's iteration with the exact tangent of every iterate, from the unknowns of the step's start."""
    at = step.at(unknowns_of(step.start), np.inf)
    began, iterations = at.distance, 0
    while not at.converged and np.isfinite(at.distance) and iterations < step.tolerances.max_iterations:
        at = step.corrected(at, None, proven=True)
        iterations += 1
    return step.ended(at, began, iterations, iterations)


def _modified(step: ImplicitStep, predicted: Unknowns, kept: KeptTangent | None) -> Stepped:
    """Modified Newton's iteration."""
    at = step.at(predicted, np.inf)
    began, iterations, made = at.distance, 0, 0
    symmetric, proven = kept is None or kept.symmetric, False
    if kept is not None and not serves(kept, step.rule.factors):
        kept = None
    while not at.converged and np.isfinite(at.distance) and iterations < step.tolerances.max_iterations:
        new = kept is None
        if kept is None:
            try:
                kept, proven = step.tangent(at, symmetric=symmetric), False
            except AccuracyError:  # of this tangent; Newton's own may be regular
                break
            made += 1
        tried = step.corrected(at, kept, proven=proven)
        iterations += 1
        rate = tried.distance / at.distance
        proven = proven or rate <= SLOWEST
        if not (tried.converged or rate <= SLOWEST or rate * tried.distance <= 1):
            last_resort = new and not kept.symmetric
            symmetric, kept = symmetric and not new, None
            if not (rate < 1 or last_resort):
                continue
        at = tried
    return step.ended(at, began, iterations, made)._replace(kept=kept)
