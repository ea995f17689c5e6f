"""Iterations that solve a step: modified Newton's on a frozen tangent, and Newton's own behind it.

Each iteration evaluates the exact equations and solves for a correction with a tangent that may be old:

    x_1 = x_0 - T^-1 r(x_0),       rate = |x_2 - x_1| / |x_1 - x_0|

`T` is first the symmetric part of the tangent, L D L^T. It is kept over iterations and steps while an
iteration gains tenfold (rate below 0.1), or the next one reaches the tolerance; then it is made anew. Where a
new symmetric one gains less, as at high angular velocities, whose terms are skew, the unsymmetric tangent
takes its place and is kept in the same way. Corrections that do not become smaller are taken back.

Where this does not converge, Newton's method with the exact tangent of every iterate does the step from its
start. A tangent decides on the iterations alone: a step ends where the exact equations hold to the tolerance,
with a frozen tangent to a tenth of it if rounding allows, or where a correction moves nothing. A tangent is
trusted to say the latter when it is new or has gained tenfold before: of a positive definite symmetric part
with a skew rest, the correction bounds the true one.

Source: [BrenanCampbellPetzold1996], section 5.2, for keeping a factor by its rate.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from supple.errors import AccuracyError
from supple.methods.floating.full.frozen_tangent import FrozenTangent, serves
from supple.methods.floating.full.implicit_step import ImplicitStep, Stepped
from supple.methods.floating.full.predictor import Unknowns, unknowns_of

__all__ = ["SLOWEST", "NewtonIteration", "exact_newton", "modified_newton"]

SLOWEST = 0.1
"""Rate beyond which a frozen tangent is renewed."""

SHARE = 0.1
"""Of the tolerance, which an old tangent has to reach.

What it leaves of the residual lies where it is wrong, in stiff directions of little mass among others;
Newton's own, which converges quadratically, leaves far less than the tolerance.
"""

NewtonIteration = Callable[[ImplicitStep, Unknowns, FrozenTangent | None], Stepped]
"""Of a step, where the iteration starts, and the tangent of an earlier step."""


def modified_newton(step: ImplicitStep, predicted: Unknowns, kept: FrozenTangent | None) -> Stepped:
    """The frozen tangent as far as it goes, then Newton's own."""
    modified = _modified(step, predicted, kept)
    if modified.converged:
        return modified
    exact = exact_newton(step, predicted, None)
    return exact._replace(
        iterations=modified.iterations + exact.iterations,
        factorizations=modified.factorizations + exact.factorizations,
    )


def exact_newton(step: ImplicitStep, predicted: Unknowns, kept: FrozenTangent | None) -> Stepped:  # noqa: ARG001
    """Newton's iteration with the exact tangent of every iterate, from the unknowns of the step's start."""
    at = step.at(unknowns_of(step.start))
    began, iterations = at.distance, 0
    while not at.converged and np.isfinite(at.distance) and iterations < step.tolerances.max_iterations:
        at = step.corrected(at, None, trusted=True)
        iterations += 1
    return step.ended(at, began, iterations, iterations)


def _modified(step: ImplicitStep, predicted: Unknowns, kept: FrozenTangent | None) -> Stepped:
    """Modified Newton's iteration."""
    step = step._replace(share=SHARE)
    at = first = step.at(predicted)
    iterations = made = 0
    symmetric = kept is None or kept.symmetric
    if kept is not None and not serves(kept, step.rule.factors):
        kept = None
    while not at.converged and np.isfinite(at.distance) and iterations < step.tolerances.max_iterations:
        new = kept is None
        if kept is None:
            try:
                kept = step.tangent(at, symmetric=symmetric)
            except AccuracyError:  # of this tangent; Newton's own may be regular
                break
            made += 1
        tried = step.corrected(at, kept, trusted=new or kept.proven)
        iterations += 1
        rate = tried.moved / at.moved  # 0 after the first, of which nothing is known yet
        if tried.converged or rate <= SLOWEST or rate * tried.distance <= 1:
            kept = kept._replace(proven=kept.proven or 0 < rate <= SLOWEST)
            at = tried
            continue
        of_this_step = made > 0
        if new and tried.reached:  # rounding is in the way of more
            at = tried
            break
        if rate < 1:
            symmetric, at = symmetric and not new, tried
        elif symmetric or not of_this_step:
            symmetric, at = symmetric and not of_this_step, first
        else:
            break
        kept = None
    return step.ended(at, first.distance, iterations, made)._replace(kept=kept)
