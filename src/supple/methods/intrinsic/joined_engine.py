"""Engine of machines in which joints connect intrinsic bodies to each other and to other bodies."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from supple.equations.checks.start_report import report_start
from supple.equations.compiler_options import MARCHING, STARTING
from supple.equations.configuration import ControlState, SystemMotion
from supple.equations.control_series import control_series
from supple.equations.control_start import first_control, fresh_control, kept_control
from supple.equations.floating_solution import floating_solution
from supple.equations.sampling import joined_legs, march_sampled, sampling_of
from supple.equations.starting_machine import JAMS
from supple.errors import ConvergenceError, ModelError
from supple.integrate import GeneralizedAlpha, Leg, Run, Solution, Statistics, leg_size
from supple.machine import At, System
from supple.methods.intrinsic.implicit_step import first_order_coefficients
from supple.methods.intrinsic.joined_equations import JoinedInstant, JoinedRates, all_velocities
from supple.methods.intrinsic.joined_machine import JoinedArrays, JoinedMachine, joined_machine
from supple.methods.intrinsic.joined_start import instant_rates, joined_start
from supple.methods.intrinsic.joined_step import JoinedState, JoinedStepping, joined_step
from supple.methods.intrinsic.line_march import full_leg, n_good
from supple.methods.intrinsic.machine_of_lines import line_motion
from supple.methods.intrinsic.stable_step import with_chosen_step
from supple.programs.program_cache import CachedProgram

ITERATED = 1e-4
"""Tolerance of implicit steps relative to that of the run, so that only the rule affects the energy."""
QUICK = 40_000
"""Steps times unknowns of a run up to which the quick program is used. It compiles faster (two lines of 104
unknowns: 15 instead of 21 s with the start, three of 145: 15 instead of 23 s), and its steps take 3.7 times
as long (20 and 5 ms, 42 and 12 ms)."""


Outputs = tuple[jax.Array, JoinedRates, jax.Array]
"""Velocities of the model's bodies, rates and multipliers."""


class JoinedEngine:
    """`Engine` of intrinsic, rigid and reduced bodies and their joints; `JoinedState` is its state.

    also : further ends whose stations are included, besides those of joints, forces and controllers
    step : largest step, s
    stepping : step rule and tolerances
    """

    least_leg = 1

    def __init__(self, system: System, run: Run, also: Sequence[At] = ()) -> None:
        run = with_chosen_step(system, run)
        if not isinstance(run.method, GeneralizedAlpha):
            raise ModelError(
                f"joints between intrinsic bodies do not support {type(run.method).__name__}: use "
                "GeneralizedAlpha(rho_inf); explicit rules support bodies with roots on the ground only"
            )
        self._run = run
        self._machine: JoinedMachine = joined_machine(system, run.start, also)
        self._arrays = self._machine.arrays
        self.stepping = JoinedStepping(
            first_order_coefficients(run.method.rho_inf),
            ITERATED * run.tolerances.residual,
            run.tolerances.max_iterations,
            10 * run.tolerances.residual,
        )
        self._interval = float(run.times[1] - run.times[0])
        self.step = float(run.step_control.first)
        self._sampling = sampling_of(self._machine.seen, run)
        self._length = leg_size(len(run.times)) if self._sampling is None else 1
        # The length of the whole run selects the program, so that a resumed run is equal in every digit.
        n_lines = ravel_pytree(self._machine.states)[0].size
        n_unknowns = n_lines + 2 * (self._arrays.n_floating + len(self._arrays.model.active))
        work = (run.times[-1] - run.start) / self.step * n_unknowns
        self._program = _march if work > QUICK else _quick_march

    @property
    def machine(self) -> JoinedMachine:
        """The prepared machine; after the start, without redundant equations."""
        return self._machine._replace(arrays=self._arrays)

    def start(self, time: float) -> JoinedState:
        """Velocities that satisfy the joints, consistent rates and joint forces."""
        self._arrays, begun, change = joined_start(self._machine, time)
        report_start(change, self._run.validity)
        # NumPy types as in all later instants: JAX would compile once more for Python numbers.
        now = jax.tree.map(np.asarray, begun)
        control = fresh_control(self._machine.seen)
        _, rates, forces = self._at(now, control)
        if control is not None:
            control = first_control(self._machine.seen, self._arrays.model, self._motion(now, control))
            _, rates, forces = self._at(now, control)
        return JoinedState(now, rates, forces, control, jnp.zeros(()), jnp.zeros((), dtype=int))

    def resumed(self, last: Solution) -> JoinedState:
        """The exact state at the end of a recorded part of the run."""
        leaves, structure = jax.tree.flatten(self.start(self._run.start))
        known = [last.engine_state[f"leaf {number}"] for number in range(len(leaves))]
        return structure.unflatten(
            [
                jnp.asarray(own, dtype=leaf.dtype).reshape(leaf.shape)
                for own, leaf in zip(known, leaves, strict=True)
            ]
        )

    def march(self, state: JoinedState, times: np.ndarray) -> Leg[JoinedState]:
        """Integrate to each of the output times, in one compiled call (with sampled controllers, several)."""
        march = self._leg if self._sampling is None else self._one_by_one
        return march_sampled(self._sampling, march, self._sampled, state, times)

    def _one_by_one(self, state: JoinedState, times: np.ndarray) -> Leg[JoinedState]:
        """A call for each time: those between calls of controllers are unevenly spaced."""
        legs: list[Leg[JoinedState]] = []
        for time in times:
            legs.append(self._leg(state, np.array([time])))
            state = legs[-1].last
            if legs[-1].stopped is not None:
                break
        return joined_legs(legs)

    def _sampled(self, state: JoinedState) -> JoinedState:
        """The state after calling the sampled controllers that are due, with its new rates."""
        assert self._sampling is not None
        assert state.control is not None
        now = jax.tree.map(np.asarray, state.now)
        control = self._sampling.called(self._arrays.model, self._motion(now, state.control), state.control)
        if control is None:
            return state
        _, rates, forces = self._at(now, control)
        return state._replace(rates=rates, multipliers=forces, control=control)

    def _leg(self, state: JoinedState, times: np.ndarray) -> Leg[JoinedState]:
        began = clock.perf_counter()
        # A short leg repeats its last time, with steps of zero length.
        interval = self._interval if self._sampling is None else float(times[0] - state.time)
        n_steps = max(1, int(np.ceil(interval / self.step * (1 - 1e-9))))
        padded = full_leg(times, self._length)
        reached = jax.device_get(self._program(self._arrays, state, padded, self.stepping, n_steps))
        n_reached = min(n_good(reached.now, reached.worst <= self.stepping.limit), len(times))
        last = jax.tree.map(lambda leaf: jnp.asarray(leaf[max(n_reached, 1) - 1]), reached)
        moving = int(np.count_nonzero(np.diff(times, prepend=float(state.time))))
        iterations, seconds = int(last.iterations - state.iterations), clock.perf_counter() - began
        return Leg(
            states=jax.tree.map(lambda leaf: leaf[:n_reached], reached),
            n_reached=n_reached,
            last=last,
            statistics=Statistics(steps=moving * n_steps, iterations=iterations, seconds=seconds),
            stopped=None if n_reached == len(times) else self._why(reached, n_reached),
        )

    def _why(self, reached: JoinedState, number: int) -> str:
        return (
            f"a step did not converge before t = {float(reached.now.time[number]):.6g}: relative residual "
            f"{float(reached.worst[number]):.2g}. Take shorter steps than {self._run.step_control.first:g}, "
            "allow more iterations (Tolerances), or check for a singular position of the joints"
        )

    def _outputs(self, now: JoinedInstant, control: ControlState | None) -> Outputs:
        """Velocities of the model's bodies, rates and multipliers at instants; an error if friction jams."""
        n = len(now.time)
        both = full_leg((now, control), max(self._length, n))
        found = jax.tree.map(lambda leaf: leaf[:n], _outputs(self._arrays, *both))
        if self._arrays.model.reads_reactions and np.isnan(found[2]).any():
            raise ConvergenceError(JAMS)
        return found

    def _at(self, now: JoinedInstant, control: ControlState | None) -> Outputs:
        """`_outputs` at one instant."""
        found = self._outputs(*jax.tree.map(lambda leaf: np.asarray(leaf)[None], (now, control)))
        return jax.tree.map(lambda leaf: leaf[0], found)

    def _motion(self, now: JoinedInstant, control: ControlState) -> SystemMotion:
        """Motion as the input of controllers."""
        velocities, *_ = self._at(now, control)
        still = np.zeros_like(np.asarray(velocities)), np.zeros(len(self._arrays.model.active))
        return SystemMotion(now.time, now.floating, velocities, *still)

    def solution(self, leg: Leg[JoinedState]) -> Solution:
        """The motion of a leg, with joint forces and accelerations evaluated at its instants."""
        now: JoinedInstant = leg.states.now
        velocities, rates, multipliers = jax.device_get(self._outputs(now, leg.states.control))
        state = {
            f"leaf {number}": np.asarray(leaf, dtype=float)
            for number, leaf in enumerate(jax.tree.leaves(leg.last))
        }
        state["active"] = np.array(self._arrays.model.active, dtype=float)
        state |= kept_control(self._arrays.model, leg.last.control)
        control = leg.states.control
        return joined_solution(
            self.machine, now, velocities, rates, multipliers, leg.statistics, state, control
        )


def joined_solution(
    machine: JoinedMachine,
    now: JoinedInstant,
    velocities: np.ndarray,
    rates: JoinedRates,
    multipliers: np.ndarray,
    statistics: Statistics,
    engine_state: Mapping[str, np.ndarray] = MappingProxyType({}),
    control: ControlState | None = None,
) -> Solution:
    """Stacked instants (leading axis: time) as a solution, with joint forces and outputs of controllers.

    velocities : (t, n)     velocities of all bodies of the model, including stations
    control : of the controllers, stacked; None without controllers
    """
    arrays, model, times = machine.arrays, machine.arrays.model, np.asarray(now.time)
    still = np.zeros((len(times), 6 * arrays.n_coupled))
    accelerations = np.concatenate([rates.acceleration, still], axis=1)
    motion = SystemMotion(times, now.floating, velocities, accelerations, multipliers)
    series = control_series(model, motion, control)
    seen = floating_solution(
        machine.seen, model.slices, model.active, motion, statistics, engine_state, series=series
    )
    lines = {
        placed.body.name: line_motion(placed, own, None, state, rate.q1, times)
        for placed, own, state, rate in zip(machine.lines, arrays.lines, now.lines, rates.lines, strict=True)
    }
    known, names = {**seen.bodies, **lines}, [placed.body.name for placed in machine.system.bodies]
    return replace(seen, bodies={name: known[name] for name in names})


def _march_joined(
    arrays: JoinedArrays,
    start: JoinedState,
    times: jax.Array,
    stepping: JoinedStepping,
    n_steps: jax.Array,
) -> JoinedState:
    def to_output(state: JoinedState, end: jax.Array) -> tuple[JoinedState, JoinedState]:
        h = (end - state.now.time) / n_steps

        last = jax.lax.fori_loop(0, n_steps, lambda _, now: joined_step(arrays, stepping, now, h), state)
        last = last._replace(now=last.now._replace(time=end))
        return last, last

    return jax.lax.scan(to_output, start, times)[1]


def _rates_at(arrays: JoinedArrays, states: JoinedInstant, controls: ControlState | None) -> Outputs:
    def at(now: JoinedInstant, control: ControlState | None) -> Outputs:
        return all_velocities(arrays, now), *instant_rates(arrays, now, control)

    return jax.vmap(at)(states, controls)


_march = CachedProgram(_march_joined, MARCHING)
_quick_march = CachedProgram(_march_joined, STARTING)
_outputs = CachedProgram(_rates_at, STARTING)
