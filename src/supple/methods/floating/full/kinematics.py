"""Kinematic runs of machines with full bodies and lines, treated as rigid in their placed shape.

    g(q, t) = 0,      G v = -g_t,      G vdot = -d2g/dt2 at constant v,      G^T lambda = -r

for the motions of the frames alone; r is the residual of their equations without joint forces.
"""

from __future__ import annotations

import time as clock
from typing import NamedTuple

import numpy as np

from supple.equations.checks.start_report import report_start
from supple.equations.configuration import Configuration
from supple.equations.consistent_start import consistent_start
from supple.equations.floating_solution import last_instant
from supple.equations.starting_machine import JointTerms, converged_reactions
from supple.equations.station_body import MachineWithStations
from supple.equations.step_size import at_rounding
from supple.errors import ConvergenceError, ModelError
from supple.integrate import Leg, Run, Solution, Statistics
from supple.methods.floating.compiled.kinematics import (
    DEAD_POINT,
    MOST_ITERATIONS,
    check_determined,
    check_held,
    instants_between,
    not_closed,
    of_frames,
)
from supple.methods.floating.full.full_solution import full_solution
from supple.methods.floating.full.full_state import FullState
from supple.methods.floating.full.full_system import FullSystem

__all__ = ["FullKinematicEngine"]


class KinematicInstant(NamedTuple):
    """State of a machine; iterations and largest rotation of a body between instants since the start."""

    state: FullState
    iterations: int = 0
    largest_turn: float = 0.0


class _ConstrainedSystem(FullSystem):
    """Full system whose redundant constraints are found for rigid bodies."""

    def joint_terms(self, time: float, configuration: Configuration, velocity: np.ndarray) -> JointTerms:
        """Constraint terms of bodies that keep their shape."""
        return of_frames(super().joint_terms(time, configuration, velocity), self.joint_slices)


class FullKinematicEngine:
    """`Engine` that solves the joints' equations for the frames of the bodies at each instant."""

    least_leg = 1

    def __init__(self, machine: MachineWithStations, run: Run) -> None:
        check_held(machine.system, run)
        self._every = self._machine = _ConstrainedSystem(machine)
        self._run, self._step = run, run.step_control.largest

    def start(self, time: float) -> KinematicInstant:
        """Initial instant with closed joints; ModelError where they leave a degree of freedom."""
        self._machine, configuration, _, change = consistent_start(self._every, time)
        report_start(change, self._run.validity)
        check_determined(self._machine.system, self._machine.model.active)
        placed = self._machine.state_at(time, configuration, np.zeros(self._machine.n))
        begun = self._next(KinematicInstant(placed), time)
        if begun is None:
            raise ModelError(not_closed(time))
        return begun

    def resumed(self, last: Solution) -> KinematicInstant:
        """The state at the end of a recorded part."""
        known = last.engine_state
        self._machine = self._every.restricted(tuple(int(index) for index in known["active"]))
        instant = last_instant(self._machine.system, last)
        state = self._machine.state_at(instant.time, instant.configuration, instant.velocity)
        return KinematicInstant(
            state._replace(
                acceleration=instant.acceleration,
                multipliers=instant.multipliers[list(self._machine.model.active)],
            )
        )

    def march(self, state: KinematicInstant, times: np.ndarray) -> Leg[KinematicInstant]:
        """Solve at each of the output times, with intermediate instants at most one step apart."""
        began, reached, before, stopped = clock.perf_counter(), [], state, None
        every, outputs = instants_between(float(state.state.time), times, self._step)
        number = -1
        for number, time in enumerate(every):
            after = self._next(state, float(time))
            if after is None:
                stopped = not_closed(float(time))
                break
            state = after
            if number in outputs:
                reached.append(state.state)
        statistics = Statistics(
            steps=number + (stopped is None),
            iterations=state.iterations - before.iterations,
            seconds=clock.perf_counter() - began,
            largest_turn=state.largest_turn,
        )
        return Leg((reached, state), len(reached), state, statistics, stopped)

    def solution(self, leg: Leg[KinematicInstant]) -> Solution:
        """The motion of a leg."""
        states, last = leg.states
        kept = {"active": np.array(self._machine.model.active, dtype=float)}
        if self._machine.lines:
            kept |= {"velocity": last.state.velocity, "acceleration": last.state.acceleration}
        return full_solution(self._machine, states, leg.statistics, kept)

    def _next(self, before: KinematicInstant, time: float) -> KinematicInstant | None:
        """The machine at a new time, from the previous instant; None if the joints cannot be closed."""
        machine, start = self._machine, before.state
        h, none = time - start.time, np.zeros(machine.n)
        foreseen = machine.moved(start.configuration, h * start.velocity + h**2 / 2 * start.acceleration)
        try:
            configuration, iterations = self._closed(foreseen, time)
            at_rest = machine.joint_terms(time, configuration, none)
            jacobian = self._of_frames(at_rest.jacobian)
            lengths = np.tile([1.0, 1.0, 1.0, *[float(machine.model.length)] * 3], len(machine.slices))
            sizes = np.linalg.svd(jacobian / lengths, compute_uv=False)
            if not sizes[-1] > DEAD_POINT * sizes[0]:
                return None
            velocity = self._to_all(np.linalg.solve(jacobian, -at_rest.rate))
            bias = machine.joint_terms(time, configuration, velocity).acceleration_bias
            acceleration = self._to_all(np.linalg.solve(jacobian, -bias))
            state = machine.state_at(time, configuration, velocity)
            state = state._replace(acceleration=acceleration)
            state = state._replace(multipliers=self._carried(state, jacobian))
        except (np.linalg.LinAlgError, ConvergenceError):
            return None
        turned = np.swapaxes(start.configuration.rotations, 1, 2) @ configuration.rotations
        cosine = np.clip((np.trace(turned, axis1=1, axis2=2) - 1) / 2, -1.0, 1.0)
        turn = max(before.largest_turn, float(np.arccos(cosine).max()))
        return KinematicInstant(state, before.iterations + iterations, turn)

    def _closed(self, configuration: Configuration, time: float) -> tuple[Configuration, int]:
        """Newton's method on g(q, t) = 0 down to rounding error; the configuration, and the iterations."""
        machine, none, before = self._machine, np.zeros(self._machine.n), np.inf
        for iteration in range(MOST_ITERATIONS + 1):
            terms = machine.joint_terms(time, configuration, none)
            gap = float(np.max(abs(machine.model.as_lengths(np.asarray(terms.residual)))))
            if at_rounding(machine.model.length, configuration.origins, gap, before):
                return configuration, iteration
            before = gap
            change = np.linalg.solve(self._of_frames(terms.jacobian), -terms.residual)
            configuration = machine.moved(configuration, self._to_all(change))
        raise ConvergenceError(not_closed(time))

    def _carried(self, state: FullState, jacobian: np.ndarray) -> np.ndarray:
        """Multipliers that balance the forces on the frames."""
        machine = self._machine

        def solved(multipliers: np.ndarray) -> tuple[None, np.ndarray]:
            at = machine.evaluate(state._replace(multipliers=multipliers), 0.0)
            left = machine.residual_of(at)[self._frames]
            return None, multipliers - np.linalg.solve(jacobian.T, left)

        found = solved(np.zeros(len(machine.model.active)))
        return (converged_reactions(solved, found) if machine.model.reads_reactions else found)[1]

    @property
    def _frames(self) -> np.ndarray:
        """Numbers of the frames' velocities among all velocities."""
        return np.concatenate([np.arange(part.start, part.start + 6) for part in self._machine.slices])

    def _of_frames(self, jacobian: np.ndarray) -> np.ndarray:
        return np.hstack([jacobian[:, part][:, :6] for part in self._machine.joint_slices])

    def _to_all(self, frames: np.ndarray) -> np.ndarray:
        found = np.zeros(self._machine.n)
        found[self._frames] = frames
        return found
