"""Iterations that solve a step: modified Newton with a frozen tangent, then Newton's method if that fails.

Each iteration evaluates the exact equations and solves for a correction with a possibly older tangent:

    x_1 = x_0 - T^-1 r(x_0),       rate = |x_2 - x_1| / |x_1 - x_0|

`T` is first the symmetric part of the tangent, L D L^T. It is reused over iterations and steps as long as the
rate is below 0.1 or the next iteration is predicted to reach the tolerance; otherwise it is renewed. At high
angular velocities, skew-symmetric terms are large, and a new symmetric tangent may converge more slowly. Then
the unsymmetric tangent replaces it and is reused in the same way. Corrections that do not become smaller are
undone.

If the modified iteration does not converge, Newton's method with the exact tangent of every iterate solves
the step from its start. The tangent affects the iterations alone: a step ends where the exact equations hold
to the tolerance, or where a correction changes nothing. With a frozen tangent the limit is a tenth of the
tolerance, if rounding allows. The second criterion requires a tangent that is new, or whose rate was below
0.1 before: with a positive definite symmetric part and a skew-symmetric remainder, the correction bounds the
exact one.

Source: [BrenanCampbellPetzold1996], section 5.2, for renewal of factors according to the convergence rate.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from supple.errors import AccuracyError
from supple.methods.floating.full.frozen_tangent import SIMILAR, FrozenTangent
from supple.methods.floating.full.full_state import Unknowns
from supple.methods.floating.full.implicit_step import ImplicitStep, Stepped

SLOWEST = 0.1
"""Ratio of successive corrections above which a frozen tangent is renewed."""

SHARE = 0.1
"""Part of the tolerance that an iteration with a frozen tangent must reach.

The remaining residual lies in the directions of the tangent's error, among them stiff directions of little
mass. Newton's method converges quadratically, so its residual ends far below the tolerance.
"""

NewtonIteration = Callable[[ImplicitStep, Unknowns, FrozenTangent | None], Stepped]
"""Iteration of a step from a first guess, with the tangent of an earlier step or None."""


def modified_newton(step: ImplicitStep, predicted: Unknowns, kept: FrozenTangent | None) -> Stepped:
    """Solution of a step by a frozen tangent; by Newton's method if that does not converge."""
    modified = _modified(step, predicted, kept)
    if modified.converged:
        return modified
    exact = exact_newton(step, predicted, None)
    return exact._replace(
        iterations=modified.iterations + exact.iterations,
        factorizations=modified.factorizations + exact.factorizations,
    )


def exact_newton(step: ImplicitStep, predicted: Unknowns, kept: FrozenTangent | None) -> Stepped:  # noqa: ARG001
    """Newton's method with the exact tangent of every iterate, from the unknowns at the step's start."""
    at = step.at(step.start.unknowns)
    began, iterations = at.distance, 0
    while not at.converged and np.isfinite(at.distance) and iterations < step.tolerances.max_iterations:
        at = step.corrected(at, None, trusted=True)
        iterations += 1
    return step.ended(at, began, iterations, iterations)


def _modified(step: ImplicitStep, predicted: Unknowns, kept: FrozenTangent | None) -> Stepped:
    """Modified Newton iteration."""
    step = step._replace(share=SHARE)
    at = first = step.at(predicted)
    iterations = made = 0
    symmetric = kept is None or kept.symmetric
    if kept is not None and not np.allclose(step.rule.factors, kept.factors, rtol=SIMILAR, atol=0.0):
        kept = None
    while not at.converged and np.isfinite(at.distance) and iterations < step.tolerances.max_iterations:
        new = kept is None
        if kept is None:
            try:
                kept = step.tangent(at, symmetric=symmetric)
            except AccuracyError:  # singular; the exact tangents of Newton's method may be regular
                break
            made += 1
        tried = step.corrected(at, kept, trusted=new or kept.proven)
        iterations += 1
        rate = tried.moved / at.moved  # 0 after the first iteration, whose rate is unknown
        if tried.converged or rate <= SLOWEST or rate * tried.distance <= 1:
            kept = kept._replace(proven=kept.proven or 0 < rate <= SLOWEST)
            at = tried
            continue
        of_this_step = made > 0
        if new and tried.reached:  # rounding prevents a smaller residual
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
