"""Full-order engine for machines with bodies that keep all finite-element freedoms.

The loop over time steps is in Python, because each iteration solves with sparse factors.
"""

from __future__ import annotations

import time as clock
from dataclasses import replace
from typing import NamedTuple

import jax
import numpy as np

from supple.equations.checks.start_report import report_start
from supple.equations.consistent_start import consistent_start
from supple.equations.control_start import kept_control, resumed_control
from supple.equations.floating_solution import (
    failure_message,
    last_instant,
)
from supple.equations.sampling import sampling_of
from supple.equations.station_body import MachineWithStations
from supple.equations.step_size import next_step
from supple.equations.stops import Stops, stepping_instants
from supple.integrate import Leg, Run, Solution, Statistics, StepRule
from supple.machine import System
from supple.methods.floating.full.frozen_tangent import FrozenTangent, tangent_numbers, tangent_of
from supple.methods.floating.full.full_solution import full_solution
from supple.methods.floating.full.full_state import FullState, Unknowns
from supple.methods.floating.full.full_system import FullSystem
from supple.methods.floating.full.implicit_step import ImplicitStep
from supple.methods.floating.full.newton import NewtonIteration, modified_newton

__all__ = ["FullEngine"]


class Earlier(NamedTuple):
    """Unknowns at the start of the last step, and its size."""

    unknowns: Unknowns
    step: float


class March(NamedTuple):
    """A state, the size of the next step to try, and the counts since the start of a leg."""

    state: FullState
    step: float
    statistics: Statistics = Statistics()
    earlier: Earlier | None = None
    """None before the first step"""
    kept: FrozenTangent | None = None


class FullEngine:
    """An `Engine` of sparse bordered Newton steps; `March` is its state."""

    least_leg = 1

    def __init__(
        self, machine: System | MachineWithStations, run: Run, iteration: NewtonIteration = modified_newton
    ) -> None:
        self._run = run
        self._iteration = iteration
        self._every = FullSystem(machine)
        """The machine with all constraint equations"""
        system = self._every.system
        self._machine = self._every
        self._sampling = sampling_of(system, run)
        instants = stepping_instants([system], run)
        if self._sampling is not None:
            instants = np.setdiff1d(np.union1d(instants, self._sampling.every), run.times)
        self._stops = Stops(run.times, instants)

    @property
    def machine(self) -> FullSystem:
        """The equations; after the start, with the independent constraints only."""
        return self._machine

    def start(self, time: float) -> March:
        """Consistent positions and velocities for joints and frames, and the first accelerations."""
        self._machine, configuration, velocity, change = consistent_start(self._every, time)
        report_start(change, self._run.validity)
        self._machine.check_frames(configuration)
        begun = self._machine.ended(self._machine.state_at(time, configuration, velocity))
        state = self._machine.accelerated(begun)
        return March(state, self._run.step_control.first)

    def resumed(self, last: Solution) -> March:
        """The state at the end of a recorded part.

        Without `engine_state` the auxiliary acceleration of the integrator is set to the true acceleration.
        This keeps the order of accuracy but not the last digits.
        """
        known = last.engine_state
        machine = self._every
        instant = last_instant(machine.system, last)
        if "active" in known:
            machine = machine.restricted(tuple(int(index) for index in known["active"]))
        else:
            machine = consistent_start(machine, self._run.start).machine
        self._machine = machine
        fresh = machine.state_at(instant.time, instant.configuration, instant.velocity)
        control = resumed_control(machine.system, known)
        state = fresh._replace(
            acceleration=instant.acceleration,
            auxiliary=known.get("auxiliary", instant.acceleration),
            multipliers=instant.multipliers[list(machine.model.active)],
            frame_multipliers=tuple(known.get("frame_multipliers", fresh.frame_multipliers)),
            control=control and fresh.control and fresh.control._replace(start=control),
        )
        return March(
            state,
            float(known.get("step", self._run.step_control.first)),
            earlier=_earlier_of(machine, known.get("earlier", np.empty(0))),
            kept=tangent_of(machine, known.get("kept_tangent", np.empty(0))),
        )

    def march(self, state: March, times: np.ndarray) -> Leg[March]:
        """Integrate step by step to each of the output times."""
        began = clock.perf_counter()
        reached: list[FullState] = []
        state, stopped = state._replace(statistics=Statistics()), None
        stops, outputs = self._stops.on_the_way(state.state.time, times)
        for number, end in enumerate(stops):
            if end > state.state.time:  # controllers due at the end are called when the run continues
                state = state._replace(state=self._sampled(state.state))
            state, residual = self._to_output(state, float(end))
            if residual is not None:
                stopped = failure_message(self._machine.system, self._run, state.state.time, residual)
                break
            if number in outputs:
                reached.append(state.state)
        statistics = replace(state.statistics, seconds=clock.perf_counter() - began)
        return Leg((reached, state), len(reached), state, statistics, stopped)

    def _sampled(self, state: FullState) -> FullState:
        """The state after calling the sampled controllers that are due, with its new accelerations."""
        if self._sampling is None or state.control is None:
            return state
        machine, step = self._machine, state.control
        control = self._sampling.called(machine.model, machine.border_motion(state), step.start)
        if control is None:
            return state
        return machine.accelerated(state._replace(control=step._replace(start=control)))

    def _to_output(self, march: March, end: float) -> tuple[March, np.ndarray | None]:
        """Steps up to an output time, and the relative residual if the smallest step fails, else None."""
        control, method = self._run.step_control, self._run.second_order_method
        while march.state.time < end:
            remaining = end - march.state.time
            # A whole number of equal steps to the output time; 1e-9 allows for rounding of the quotient.
            h = remaining / max(np.ceil(remaining / march.step * (1 - 1e-9)), 1.0)
            rule = StepRule(method.coefficients, h)
            step = ImplicitStep(self._machine, march.state, h, rule, self._run.tolerances)
            found = self._iteration(step, _predicted(march.state, march.earlier, h), march.kept)
            new, converged = found.state, found.converged
            error = np.inf
            if converged:
                local = rule.position_error(march.state.auxiliary, new.auxiliary)
                error = float(np.max(abs(local) / self._machine.position_scale))
            proposed = (
                float(next_step(h, march.step, error, control.tolerance, control.largest))
                if converged
                else h / 2
            )
            accepted = converged and error <= control.tolerance
            cost = Statistics(
                steps=int(accepted),
                iterations=found.iterations,
                rejected_steps=int(not accepted),
                factorizations=found.factorizations,
                decades=found.decades,
                largest_error=error if accepted else 0.0,
                largest_turn=self._turn(march.state, new, rule) if accepted else 0.0,
            )
            march = march._replace(step=proposed, kept=found.kept, statistics=march.statistics + cost)
            if accepted:
                if h >= remaining * (1 - 1e-9):
                    new = new._replace(time=end)
                new = self._machine.ended(new)
                march = march._replace(earlier=Earlier(march.state.unknowns, h), state=new)
            elif march.step < control.least:
                return march, found.relative_residual
        return march, None

    def _turn(self, start: FullState, end: FullState, rule: StepRule) -> float:
        """Largest rotation of a body's frame within the step, rad."""
        increments = rule.increment(start.velocity, start.auxiliary, end.auxiliary)
        turns = [increments[part.start + 3 : part.start + 6] for part in self._machine.slices]
        return float(np.linalg.norm(turns, axis=1).max())

    def solution(self, leg: Leg[March]) -> Solution:
        """The motion of a leg."""
        states, last = leg.states
        machine, ending = self._machine, states[-1]
        control = ending.control
        # Internal state of bodies with stations, which the motions do not contain.
        by_velocity = {"velocity": ending.velocity, "acceleration": ending.acceleration}
        return full_solution(
            machine,
            states,
            leg.statistics,
            engine_state={
                "active": np.array(machine.model.active, dtype=float),
                "auxiliary": ending.auxiliary,
                "step": np.array(last.step),
                "frame_multipliers": np.array(ending.frame_multipliers),
                "earlier": _earlier_numbers(machine, last.earlier),
                "kept_tangent": tangent_numbers(machine, last.kept),
                **(by_velocity if machine.lines else {}),
                **kept_control(machine.model, control.start if control else None),
            },
        )


def _predicted(state: FullState, earlier: Earlier | None, h: float) -> Unknowns:
    """Unknowns at the end of a step of size h: `x_1 + (h / h_0) (x_1 - x_0)`; without `earlier`, `x_1`."""
    if earlier is None:
        return state.unknowns
    ratio = h / earlier.step
    return jax.tree.map(lambda own, old: own + ratio * (own - old), state.unknowns, earlier.unknowns)


def _earlier_numbers(machine: FullSystem, earlier: Earlier | None) -> np.ndarray:
    """`Earlier` as one row of numbers; NaN before the first step."""
    if earlier is None:
        return np.full(_size(machine), np.nan)
    acceleration, multipliers, frames = earlier.unknowns
    return np.concatenate([[earlier.step], acceleration, multipliers, *frames])


def _earlier_of(machine: FullSystem, numbers: np.ndarray) -> Earlier | None:
    """The `Earlier` described by `_earlier_numbers`; None for NaN or numbers of another machine."""
    if len(numbers) != _size(machine) or not np.isfinite(numbers).all():
        return None
    m = len(machine.model.active)
    acceleration, multipliers, frames = np.split(numbers[1:], [machine.n, machine.n + m])
    return Earlier(Unknowns(acceleration, multipliers, tuple(frames.reshape(-1, 6))), float(numbers[0]))


def _size(machine: FullSystem) -> int:
    return 1 + machine.n + len(machine.model.active) + 6 * len(machine.interiors)
