"""Static equilibrium and steady rotation of machines with full bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra.bordered_factor import BorderedFactor, bordered_factor
from supple.equations.configuration import Configuration
from supple.equations.consistent_start import consistent_start, placed_configuration
from supple.equations.control_force import first_states, resting_control
from supple.equations.control_linearization import control_at_rest, unrest
from supple.equations.static_search import ROUND_OFF, EquilibriumResidual, StaticState, StaticStep
from supple.equations.station_body import MachineWithStations
from supple.equations.steady_motion import (
    SteadyEquations,
    SteadyRotation,
    turning_velocities,
    work_of_turning,
)
from supple.integrate import Solution, Statistics
from supple.methods.floating.full.full_solution import full_solution
from supple.methods.floating.full.full_state import Evaluation, FullState
from supple.methods.floating.full.full_system import FullSystem
from supple.methods.floating.full.linear_equations import (
    SparseEquations,
    full_linear_equations,
)

__all__ = ["FullStatics", "full_statics"]


@dataclass(frozen=True, eq=False)
class FullStatics(SteadyEquations):
    """`Equations` by sparse bordered steps.

    The tangent is that of `full_linear_equations`, which includes the derivative of the frames' velocities by
    their positions. Without it, the iteration would not converge above the first natural frequency.
    """

    machine: FullSystem
    begin: Configuration

    @property
    def is_discrete(self) -> bool:
        """Whether there are bodies with stations, whose forces and inertia refer to different velocities."""
        return bool(self.machine.lines)

    def start(self) -> StaticState:
        """The bodies as placed, with zero forces in joints and frames."""
        frames = tuple(np.zeros(6) for _ in self.machine.interiors)
        none = np.zeros(len(self.model.active))
        return StaticState(self.begin, none, frames, first_states(self.model))

    def residual(self, state: StaticState, time: float) -> np.ndarray:
        """Residual of all freedoms, (n,)."""
        terms, _ = self.unbalance(state, time).terms
        return self.machine.residual_of(terms)

    def unbalance(self, state: StaticState, time: float) -> EquilibriumResidual:
        """The residuals at rest or in steady rotation."""
        terms = self.machine.evaluate(self._still(state, time), 0.0)
        if isinstance(self.held, np.ndarray):
            terms = self.machine.without(terms, self.held)
        gaps = [terms.constraint_residual, *terms.frame_residuals]
        gap = float(np.max(abs(np.concatenate(gaps)), initial=0.0)) / float(self.machine.model.length)
        length = float(self.machine.model.length)
        works = np.array([length, 1.0, length])
        largest, left = (
            works * terms.largest_terms,
            works * self.machine.norms(self.machine.residual_of(terms)),
        )
        relative = left / np.maximum(largest, ROUND_OFF * largest.max())
        model, motion = self.machine.model, terms.border_motion
        control = control_at_rest(model, motion)
        scale = self.machine.border_scale
        restless = unrest(self.machine.system, control, scale, motion.velocity, state.control)
        size = float(largest.max())
        if self.turning is not None:
            size = max(size, ROUND_OFF * work_of_turning(model, self.turning))
        return EquilibriumResidual(relative, gap, (terms, control), size, restless)

    def linear_equations(self, state: StaticState, time: float) -> SparseEquations:
        """The equations of motion, linearised about a state."""
        terms, _ = self.unbalance(state, time).terms
        return self._linear(terms)

    def correction(
        self,
        state: StaticState,  # noqa: ARG002 - the terms include it
        time: float,  # noqa: ARG002
        unbalance: EquilibriumResidual,
        k: float,
    ) -> StaticStep:
        """One implicit step of length k."""
        return self.tangent(unbalance, k).correction(unbalance)

    def tangent(self, unbalance: EquilibriumResidual, k: float) -> StaticTangent:
        """The factored tangent of an implicit step of length k.

        Raises AccuracyError where it is singular.
        """
        equations = self._linear(unbalance.terms[0])
        matrix = equations.stiffness + equations.mass / k
        factor = bordered_factor(matrix, equations.constraint, equations.interior)
        pushed = equations.control.forces
        none = np.zeros((equations.constraint.shape[0], pushed.shape[1]))
        motions, forces = factor.solve_with_multipliers(pushed, none)
        return StaticTangent(self.machine, equations, factor, motions, forces, k)

    def constraint_rows(self, state: StaticState, time: float) -> np.ndarray:
        """Derivatives of the equations of joints, then of frames, (m, n)."""
        terms, _ = self.unbalance(state, time).terms
        rows = self._linear(terms).constraint.toarray()
        return _turned(self.machine, rows.T, terms.rotations).T

    def solution(self, state: StaticState, time: float, iterations: int) -> Solution:
        """The steady motion at one instant."""
        return full_solution(self.machine, [self._still(state, time)], Statistics(iterations=iterations))

    @property
    def position_scale(self) -> np.ndarray:
        """Size of a large change of each freedom, (n,)."""
        return self.machine.position_scale

    def _linear(self, terms: Evaluation) -> SparseEquations:
        still = SteadyRotation(np.zeros((len(self.machine.slices), 3)), np.zeros(3))
        return full_linear_equations(self.machine, self.turning or still, terms)

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


@dataclass(frozen=True, eq=False)
class StaticTangent:
    """`K + M / k` bordered by the joints, factored at one state, for corrections at this state and nearby.

    motions, forces : (n, c), (m, c)    response to each state of a controller
    """

    machine: FullSystem
    equations: SparseEquations
    factor: BorderedFactor
    motions: np.ndarray
    forces: np.ndarray
    k: float

    def correction(self, unbalance: EquilibriumResidual) -> StaticStep:
        """Correction towards equilibrium, by the linearised equations."""
        machine, linear, (terms, control) = self.machine, self.equations.control, unbalance.terms
        rotations = terms.rotations
        loads = _turned(machine, -machine.residual_of(terms), np.swapaxes(rotations, 1, 2))
        gaps = -np.concatenate([terms.constraint_residual, *terms.frame_residuals])
        motion, forces = (
            part[:, 0] for part in self.factor.solve_with_multipliers(loads[:, None], gaps[:, None])
        )
        moved = np.zeros(0)
        if linear.size:
            # Schur complement: the equations of the states, with the machine's response to each state.
            by_motion = linear.by_position + linear.by_velocity / np.sqrt(self.k)
            own = np.eye(linear.size) / np.sqrt(self.k) - linear.by_state - by_motion @ self.motions
            moved = np.linalg.solve(own, control.rates + by_motion @ motion)
            motion, forces = motion + self.motions @ moved, forces + self.forces @ moved
        joints, frames = np.split(forces, [len(terms.constraint_residual)])
        increment = _turned(machine, motion, rotations)
        climbs = self.factor.negative > self.equations.constraint.shape[0]
        return StaticStep(increment, joints, tuple(frames.reshape(-1, 6)), moved, climbs)


def _turned(machine: FullSystem, vector: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Vectors (n, ...) with the translations of their frames multiplied by rotations (b, 3, 3)."""
    turned = vector.copy()
    for part, rotation in zip(machine.slices, rotations, strict=True):
        turned[part.start : part.start + 3] = rotation @ vector[part.start : part.start + 3]
    return turned


def full_statics(
    machine: MachineWithStations,
    turning: SteadyRotation | None,
    time: float,
    known: tuple[int, ...] | None = None,
) -> FullStatics:
    """Equations of a machine with full bodies and closed joints.

    known : numbers of independent constraint equations, if the bodies are placed with closed joints
    """
    prepared = FullSystem(machine, known)
    if known is not None:
        return FullStatics(prepared, placed_configuration(prepared.system), turning)
    prepared, configuration, *_ = consistent_start(prepared, time)
    return FullStatics(prepared, configuration, turning)
