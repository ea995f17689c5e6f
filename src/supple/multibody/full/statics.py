"""Machines with full bodies at rest, or turning steadily."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.integrate import StepFactors
from supple.multibody.equations.configuration import Configuration
from supple.multibody.equations.static_search import ROUND_OFF, StaticCorrection, StaticState, Unbalance
from supple.multibody.equations.steady_motion import Turning, turning_velocities
from supple.multibody.full.full_system import FullState, FullSystem

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
        return Unbalance(left / np.maximum(largest, ROUND_OFF * largest.max()), gap, terms)

    def correction(
        self,
        state: StaticState,  # noqa: ARG002 - the terms say all
        time: float,  # noqa: ARG002
        unbalance: Unbalance,
        k: float,
    ) -> StaticCorrection:
        """One implicit step of length k."""
        terms = unbalance.terms
        change, multipliers, frame_multipliers = self.machine.correction(
            terms, terms.closing(k), np.zeros(self.machine.n), StepFactors(k, 0.0)
        )
        return StaticCorrection(k * change, multipliers, frame_multipliers)

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
        return FullState(time, state.configuration, velocity, acceleration, acceleration, *multipliers)
