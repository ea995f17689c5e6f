"""Machines of rigid and reduced bodies at rest, or turning steadily."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra.kept_programs import KeptProgram
from supple.multibody.compiled.compiled_machine import CompiledMachine
from supple.multibody.compiled.elimination import solve_bordering_column
from supple.multibody.compiled.step_equations import kinds_of_rows
from supple.multibody.compiled.time_step import position_scale
from supple.multibody.equations.balance import Balance, balance
from supple.multibody.equations.compiler_options import STARTING
from supple.multibody.equations.configuration import Configuration, SystemMotion
from supple.multibody.equations.joint_force import constraint_rows
from supple.multibody.equations.model import Model
from supple.multibody.equations.static_search import (
    ROUND_OFF,
    StaticCorrection,
    StaticState,
    Unbalance,
)
from supple.multibody.equations.steady_motion import (
    Turning,
    in_turning_axes,
    linear_equations,
    steady_motion,
    step_matrix,
)

__all__ = ["CompiledStatics", "balanced"]


@dataclass(frozen=True, eq=False)
class CompiledStatics:
    """A `StaticMachine` whose steps are compiled."""

    machine: CompiledMachine
    turning: Turning | None = None
    """None for machines at rest"""

    def unbalance(self, state: StaticState, time: float) -> Unbalance:
        """The residuals at rest."""
        model = self.machine.model
        terms = balanced(model, self._motion(state, time))
        columns = (terms.residual, terms.inertia, terms.internal, terms.applied, terms.joint)
        works = self.position_scale[:, None] * np.stack(columns, axis=1)
        norms = np.sqrt(kinds_of_rows(model) @ works**2)
        scale = norms[:, 1:].max(axis=1)
        scale = np.maximum(scale, ROUND_OFF * scale.max())
        relative = norms[:, 0] / np.where(scale > 0, scale, 1.0)
        gap = float(np.max(abs(np.asarray(terms.constraint_residual)), initial=0.0)) / float(model.length)
        return Unbalance(relative, gap, terms)

    def correction(self, state: StaticState, time: float, unbalance: Unbalance, k: float) -> StaticCorrection:
        """One implicit step of length k."""
        model, terms = self.machine.model, unbalance.terms
        motion = self._motion(state, time)
        if self.turning is None:
            matrix = step_matrix(model, motion, terms, k, 0.0)
        else:
            steady = linear_equations(model, self.turning, motion, terms)
            axes = in_turning_axes(model, state.configuration)
            matrix = axes @ (steady.mass + k * steady.stiffness) @ axes.T
        rows = np.asarray(constraint_rows(model, terms.linearization.joints))
        n, m = len(matrix), len(rows)
        # Rows of one size: multipliers in parts of what the matrix holds.
        size = float(np.max(abs(np.diag(matrix))))
        bordered = np.block(
            [
                [matrix, size * rows.T, np.asarray(terms.residual)[:, None]],
                [size * rows, np.zeros((m, m)), (size / k * np.asarray(terms.constraint_residual))[:, None]],
            ]
        )
        change = -np.asarray(_solved(bordered))
        return StaticCorrection(k * change[:n], size * change[n:])

    def moved(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration after an increment (n,)."""
        return self.machine.moved(configuration, increment)

    @property
    def position_scale(self) -> np.ndarray:
        """What counts as a large change of each freedom, (n,)."""
        return np.asarray(position_scale(self.machine.model))

    def _motion(self, state: StaticState, time: float) -> SystemMotion:
        still = Turning(np.zeros((len(self.machine.model.sizes), 3)), np.zeros(3))
        motion = self.turning or still, time, state.configuration, state.multipliers
        return steady_motion(self.machine.model, *motion)


def _balanced(model: Model, motion: SystemMotion) -> Balance:
    """The terms of the equations of motion, by a program compiled quickly."""
    return balance(model, motion)


balanced = KeptProgram(_balanced, STARTING)
_solved = KeptProgram(solve_bordering_column, STARTING)
