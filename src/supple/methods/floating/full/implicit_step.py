"""Equations of one implicit step of the full engine: residuals at an iterate, and one correction."""

from __future__ import annotations

from typing import NamedTuple

import jax
import numpy as np

from supple.equations.step_size import position_rounding
from supple.integrate import StepRule, Tolerances
from supple.methods.floating.full.frozen_tangent import FrozenTangent, frozen_tangent
from supple.methods.floating.full.full_state import Evaluation, FullState, Unknowns
from supple.methods.floating.full.full_system import FullSystem
from supple.methods.floating.full.full_tangent import FullTangent


class Stepped(NamedTuple):
    """End of a step, with its counts of iterations and factorisations."""

    state: FullState
    relative_residual: np.ndarray
    converged: bool
    iterations: int
    factorizations: int
    decades: float
    """Reduction of the residual by all iterations, as a decimal logarithm"""
    kept: FrozenTangent | None
    """Frozen tangent for the next step; None if that step computes one"""


class Iterate(NamedTuple):
    """Unknowns of a step, and the residuals of the exact equations for them."""

    unknowns: Unknowns
    state: FullState
    increments: np.ndarray
    evaluation: Evaluation
    reached: bool
    """Whether the residual is below the tolerance, or cannot decrease because of rounding"""
    converged: bool
    """As `reached`, for the `share` of the tolerance at which the iteration ends"""
    distance: float
    """Largest relative residual divided by that share of the tolerance"""
    moved: float
    """Size of the last correction relative to the machine; infinite at the first iterate"""


class ImplicitStep(NamedTuple):
    """Equations of one step, with residuals and corrections."""

    machine: FullSystem
    start: FullState
    h: float
    rule: StepRule
    tolerances: Tolerances
    share: float = 1.0
    """Fraction of the tolerance at which the iteration ends"""

    def at(self, unknowns: Unknowns, moved: float = np.inf, *, trusted: bool = False) -> Iterate:
        """Residuals of the exact equations at an iterate; `moved` is the size of the last correction.

        trusted : whether the remaining error is no larger than that correction
        """
        machine, start, rule = self.machine, self.start, self.rule
        auxiliary = rule.auxiliary(unknowns.acceleration, start.acceleration, start.auxiliary)
        increments = rule.increment(start.velocity, start.auxiliary, auxiliary)
        state = FullState(
            start.time + self.h,
            machine.moved(start.configuration, increments),
            rule.new_velocity(start.velocity, start.auxiliary, auxiliary),
            unknowns.acceleration,
            auxiliary,
            unknowns.multipliers,
            unknowns.frame_multipliers,
            start.control and start.control._replace(size=np.asarray(self.h)),
        )
        evaluation = machine.evaluate(state, rule.factors.by_position)
        relative = evaluation.relative_residual
        rounding = position_rounding(machine.model.length, state.configuration.origins)
        stagnant = trusted and moved <= rounding and relative[3] <= 1e-6
        reached = bool(np.all(relative <= self.tolerances.residual) or stagnant)
        distance = float(np.max(relative)) / (self.share * self.tolerances.residual)
        converged = reached and (distance <= 1 or stagnant)
        return Iterate(unknowns, state, increments, evaluation, reached, converged, distance, moved)

    def corrected(self, iterate: Iterate, tangent: FrozenTangent | None, *, trusted: bool) -> Iterate:
        """The next iterate, by a frozen tangent or, if that is None, by the exact tangent of this iterate.

        trusted : as in `at`
        """
        machine, by_position = self.machine, self.rule.factors.by_position
        evaluation, increments = iterate.evaluation, iterate.increments
        if tangent is None:
            eliminations = machine.eliminated(
                evaluation.interior_states, machine.turns(increments), self.rule.factors, FullTangent.exact
            )
        else:
            eliminations = tangent.eliminations
        change = machine.correction_behind(
            eliminations, evaluation, evaluation.closing(by_position), increments, self.rule.factors
        )
        moved = float(by_position * np.max(abs(change.acceleration) / machine.position_scale))
        return self.at(jax.tree.map(np.add, iterate.unknowns, change), moved, trusted=trusted)

    def tangent(self, iterate: Iterate, *, symmetric: bool) -> FrozenTangent:
        """Factored tangent at an iterate, for use as a frozen tangent."""
        turns, states = self.machine.turns(iterate.increments), iterate.evaluation.interior_states
        return frozen_tangent(self.machine, states, turns, self.rule.factors, symmetric=symmetric)

    def ended(self, at: Iterate, began: float, iterations: int, factorizations: int) -> Stepped:
        """Outcome of an iteration whose first iterate had the distance `began`."""
        known = at.reached and at.distance > 0
        return Stepped(
            at.state,
            at.evaluation.relative_residual,
            at.reached,
            iterations,
            factorizations,
            float(np.log10(began / at.distance)) if known else 0.0,
            None,
        )
