"""Machines with full bodies at rest, or turning steadily."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.integrate import StepFactors
from supple.multibody.equations.configuration import Configuration
from supple.multibody.equations.control_force import resting_control
from supple.multibody.equations.control_linearization import control_at_rest, unrest
from supple.multibody.equations.static_search import ROUND_OFF, StaticCorrection, StaticState, Unbalance
from supple.multibody.equations.steady_motion import Turning, turning_velocities
from supple.multibody.full.full_state import Evaluation, FullState, Targets
from supple.multibody.full.full_system import FullSystem
from supple.multibody.full.full_tangent import FullTangent

__all__ = ["FullStatics"]


@dataclass(frozen=True, eq=False)
class FullStatics:
    """A `StaticMachine` by sparse bordered steps.

    How the velocities of the frames follow their places is left out of the tangent: what a frame moves while
    the machine turns is found by iteration.
    """

    machine: FullSystem
    turning: Turning | None = None
    """None for machines at rest"""

    def unbalance(self, state: StaticState, time: float) -> Unbalance:
        """The residuals at rest."""
        terms = self.machine.evaluate(self._still(state, time), 0.0)
        gaps = [terms.constraint_residual, *terms.frame_residuals]
        gap = float(np.max(abs(np.concatenate(gaps)), initial=0.0)) / float(self.machine.model.length)
        length = float(self.machine.model.length)
        largest = terms.largest_terms * np.array([length, 1.0, length])
        left = terms.relative_residual[:3] * largest
        relative = left / np.maximum(largest, ROUND_OFF * largest.max())
        model, motion = self.machine.model, terms.border_motion
        control = control_at_rest(model, motion)
        scale = self.machine.border_scale
        restless = unrest(self.machine.system, control, scale, motion.velocity, state.control)
        return Unbalance(relative, gap, (terms, control), restless)

    def correction(
        self,
        state: StaticState,  # noqa: ARG002 - the terms say all
        time: float,  # noqa: ARG002
        unbalance: Unbalance,
        k: float,
    ) -> StaticCorrection:
        """One implicit step of length k."""
        machine, (terms, control) = self.machine, unbalance.terms
        still, factors = np.zeros(machine.n), StepFactors(k, 0.0)
        eliminations = machine.eliminated(
            terms.interior_states, machine.turns(still), factors, FullTangent.serving
        )

        def answered(to: Evaluation, targets: Targets) -> tuple[np.ndarray, ...]:
            change, multipliers, frames = machine.correction_behind(eliminations, to, targets, still, factors)
            return change, multipliers, np.ravel(frames)

        found = answered(terms, terms.closing(k))
        linear, moved = control.linear, np.zeros(0)
        if linear.size:
            # What the machine answers to each state closes the equations of the states.
            closed = np.zeros(len(machine.model.active)), tuple(np.zeros(6) for _ in machine.interiors)
            answers = [answered(machine.under(terms, own), closed) for own in linear.forces.T]
            by_motion = k * linear.by_position + np.sqrt(k) * linear.by_velocity
            motions = np.column_stack([machine.to_border(own[0]) for own in answers])
            left = control.rates + by_motion @ machine.to_border(found[0])
            own = np.eye(linear.size) / np.sqrt(k) - linear.by_state - by_motion @ motions
            moved = np.linalg.solve(own, left)
            found = tuple(part + moved @ np.array(more) for part, *more in zip(found, *answers, strict=True))
        change, multipliers, frames = found
        return StaticCorrection(k * change, multipliers, tuple(frames.reshape(-1, 6)), moved)

    def moved(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration after an increment (n,)."""
        return self.machine.moved(configuration, increment)

    @property
    def position_scale(self) -> np.ndarray:
        """What counts as a large change of each freedom, (n,)."""
        return self.machine.position_scale

    def _still(self, state: StaticState, time: float) -> FullState:
        velocity = acceleration = np.zeros(self.machine.n)
        if self.turning is not None:
            starts = [part.start for part in self.machine.slices]
            velocity, acceleration = turning_velocities(
                self.turning, state.configuration, starts, self.machine.n
            )
        multipliers = state.multipliers, state.frame_multipliers
        control = resting_control(self.machine.model, state.control)
        return FullState(
            time, state.configuration, velocity, acceleration, acceleration, *multipliers, control
        )
