"""Static equilibrium and steady rotation of machines of rigid and reduced bodies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import jax
import numpy as np

from supple.equations.balance import balance
from supple.equations.build_model import build_model
from supple.equations.compiled_machine import CompiledMachine
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration, SystemMotion
from supple.equations.consistent_start import consistent_start, placed_configuration
from supple.equations.control_force import first_states
from supple.equations.control_linearization import LinearControl, control_at_rest, unrest
from supple.equations.coordinate_scales import kinds_of_rows, known_position_scale
from supple.equations.floating_solution import floating_solution
from supple.equations.joint_force import joint_rows
from supple.equations.static_search import (
    ROUND_OFF,
    EquilibriumResidual,
    StaticState,
    StaticStep,
)
from supple.equations.steady_motion import (
    LinearEquations,
    SteadyEquations,
    SteadyRotation,
    dynamic_stiffness,
    in_turning_axes,
    linear_equations,
    steady_motion,
    work_of_turning,
)
from supple.integrate import Solution, Statistics
from supple.machine import System
from supple.methods.floating.compiled.elimination import solve_bordering_column
from supple.programs.program_cache import CachedProgram

__all__ = ["CompiledStatics", "compiled_statics"]


@dataclass(frozen=True, eq=False)
class CompiledStatics(SteadyEquations):
    """`Equations` with compiled residuals and corrections."""

    machine: CompiledMachine
    begin: Configuration

    is_discrete: ClassVar[bool] = False
    """False: forces and inertia refer to the same velocities."""

    def start(self) -> StaticState:
        """The bodies as placed, with zero joint forces."""
        return StaticState(self.begin, np.zeros(len(self.model.active)), control=first_states(self.model))

    def residual(self, state: StaticState, time: float) -> np.ndarray:
        """Residual of all freedoms, (n,)."""
        terms, _ = self.unbalance(state, time).terms
        return np.asarray(terms.residual)

    def unbalance(self, state: StaticState, time: float) -> EquilibriumResidual:
        """The residuals at rest or in steady rotation."""
        model, motion = self.machine.model, self._motion(state, time)
        terms, control = balanced(model, motion), control_at_rest(model, motion)
        terms = terms._replace(applied=terms.applied - self.held)
        columns = (terms.residual, terms.inertia, terms.internal, terms.applied, terms.joint)
        works = self.position_scale[:, None] * np.stack(columns, axis=1)
        norms = np.sqrt(kinds_of_rows(model) @ works**2)
        scale = norms[:, 1:].max(axis=1)
        of_turning = 0.0 if self.turning is None else work_of_turning(model, self.turning)
        scale = np.maximum(scale, ROUND_OFF * max(scale.max(), of_turning))
        relative = norms[:, 0] / np.where(scale > 0, scale, 1.0)
        gap = float(np.max(abs(np.asarray(terms.constraint_residual)), initial=0.0)) / float(model.length)
        left = unrest(self.machine.system, control, self.position_scale, motion.velocity, state.control)
        return EquilibriumResidual(relative, gap, (terms, control), float(scale.max()), left)

    def correction(
        self, state: StaticState, time: float, unbalance: EquilibriumResidual, k: float
    ) -> StaticStep:
        """One implicit step of length k."""
        model, (terms, control) = self.machine.model, unbalance.terms
        motion, linear = self._motion(state, time), control.linear
        if self.turning is None:
            matrix = dynamic_stiffness(model, motion, terms, k, 0.0)
        else:
            steady = linear_equations(model, self.turning, motion, terms)
            axes = in_turning_axes(model, state.configuration)
            matrix = axes @ (steady.mass + k * steady.stiffness) @ axes.T
            linear = steady.control.along(axes.T)
        rows = np.asarray(joint_rows(model, terms.linearization.joints))
        n, m = len(matrix), len(rows)
        # Rows of equal scale: multipliers are relative to the entries of the matrix.
        size = float(np.max(abs(np.diag(matrix))))
        gap = (size / k * np.asarray(terms.constraint_residual))[:, None]
        bordered = np.block(
            [
                [matrix, size * rows.T, np.asarray(terms.residual)[:, None]],
                [size * rows, np.zeros((m, m)), gap],
            ]
        )
        bordered, states = _with_states(bordered, linear, control.rates, k, size)
        change = -np.asarray(_solved(bordered))
        return StaticStep(k * change[:n], size * change[n : n + m], control=states * change[n + m :])

    def linear_equations(self, state: StaticState, time: float) -> LinearEquations:
        """The equations of motion, linearised about a state."""
        model, motion = self.machine.model, self._motion(state, time)
        return linear_equations(model, self.turning or self._still, motion, balanced(model, motion))

    def constraint_rows(self, state: StaticState, time: float) -> np.ndarray:
        """Derivatives of the joints' equations, (m, n)."""
        terms = balanced(self.model, self._motion(state, time))
        return np.asarray(joint_rows(self.model, terms.linearization.joints))

    def solution(self, state: StaticState, time: float, iterations: int) -> Solution:
        """The steady motion at one instant."""
        motion = self._motion(state, time)._replace(control=None)
        one = jax.tree.map(lambda leaf: np.asarray(leaf)[None], motion)
        system, slices = self.machine.system, self.slices
        return floating_solution(system, slices, self.model.active, one, Statistics(iterations=iterations))

    @cached_property
    def position_scale(self) -> np.ndarray:
        """Size of a large change of each freedom, (n,)."""
        return np.asarray(known_position_scale(self.machine.model))

    @property
    def _still(self) -> SteadyRotation:
        return SteadyRotation(np.zeros((len(self.machine.model.sizes), 3)), np.zeros(3))

    def _motion(self, state: StaticState, time: float) -> SystemMotion:
        motion = self.turning or self._still, time, state.configuration, state.multipliers, state.control
        return steady_motion(self.machine.model, *motion)


def compiled_statics(
    system: System, turning: SteadyRotation | None, time: float, known: tuple[int, ...] | None = None
) -> CompiledStatics:
    """Equations of a machine of rigid and reduced bodies with closed joints.

    known : numbers of independent constraint equations, if the bodies are placed with closed joints
    """
    machine = CompiledMachine(system, build_model(system, known))
    if known is not None:
        return CompiledStatics(machine, placed_configuration(system), turning)
    machine, configuration, *_ = consistent_start(machine, time)
    return CompiledStatics(machine, configuration, turning)


def _with_states(
    bordered: np.ndarray, control: LinearControl, rates: np.ndarray, k: float, size: float
) -> tuple[np.ndarray, np.ndarray]:
    """An augmented matrix extended by the states of controllers, and the scale of each state.

    The new rows and columns are scaled to the size of the entries of the matrix.
    """
    if not control.size:
        return bordered, np.zeros(0)
    n, known = len(control.forces), len(bordered)
    own = np.eye(control.size) / np.sqrt(k) - control.by_state
    by_motion = -k * control.by_position - np.sqrt(k) * control.by_velocity
    pushing, keeping = np.max(abs(control.forces), axis=0), np.max(abs(own), axis=0)
    scale = size / np.where(pushing > 0, pushing, np.where(keeping > 0, keeping, 1.0))
    largest = np.max(abs(np.hstack([by_motion, own * scale])), axis=1)
    rows = (size / np.where(largest > 0, largest, 1.0))[:, None]
    whole = np.zeros((known + control.size, known + control.size + 1))
    whole[:known, :known], whole[:known, -1] = bordered[:, :-1], bordered[:, -1]
    whole[:n, known:-1] = -control.forces * scale
    whole[known:, :n] = rows * by_motion
    whole[known:, known:-1] = rows * own * scale
    whole[known:, -1] = -rows[:, 0] * rates
    return whole, scale


balanced = CachedProgram(balance, STARTING)
"""The terms of the equations of motion, by a program compiled quickly."""
_solved = CachedProgram(solve_bordering_column, STARTING)
