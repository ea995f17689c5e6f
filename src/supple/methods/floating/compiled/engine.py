"""Compiled engine: time integration of machines of rigid and reduced bodies between output times."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import replace

import jax
import numpy as np

from supple.equations.build_model import build_model
from supple.equations.checks.start_report import report_start
from supple.equations.compiled_machine import CompiledMachine, accelerations, compiled_start
from supple.equations.configuration import SystemMotion
from supple.equations.control_series import control_series
from supple.equations.control_start import kept_control, resumed_control
from supple.equations.floating_solution import (
    failure_message,
    floating_solution,
    last_instant,
)
from supple.equations.machine_model import Model
from supple.equations.sampling import march_sampled, sampling_of
from supple.equations.stops import Stops, stepping_instants
from supple.integrate import Leg, Run, Solution, Statistics, Validity
from supple.machine import System
from supple.methods.floating.compiled.contraction import Contraction, no_contraction
from supple.methods.floating.compiled.frozen_tangent import FrozenInverse, freezes_tangent, no_tangent
from supple.methods.floating.compiled.padded_motion import (
    in_all_coordinates,
    in_own_coordinates,
    with_padding_coordinates,
)
from supple.methods.floating.compiled.programs import (
    COMPILED_MARCH,
    QUICK_MARCH,
    STOPS_AT_ONCE,
    brief_steps,
    march_for,
)
from supple.methods.floating.compiled.state import Controls, State

__all__ = ["CompiledEngine"]

WARNING = Validity()


def controls(run: Run) -> Controls:
    """The numerical settings of a compiled run."""
    step = run.step_control
    return Controls(
        coefficients=run.second_order_method.coefficients,
        first=float(step.first),
        largest=float(step.largest),
        smallest=float(step.least),
        error_tolerance=float(step.tolerance),
        residual_tolerance=float(run.tolerances.residual),
        max_iterations=run.tolerances.max_iterations,
    )


def initial_state(
    system: System, time: float, first_step: float, validity: Validity = WARNING
) -> tuple[Model, State]:
    """The compiled model, without redundant constraints, and the consistent state at the initial time.

    Warns StartWarning (ValidityError when strict) about positions or velocities that violate the joints.
    """
    start = compiled_start(system, time)
    report_start(start.change, validity)
    state = State(
        time=time,
        step=first_step,
        configuration=start.configuration,
        velocity=start.velocity,
        acceleration=start.acceleration,
        auxiliary=start.acceleration,
        multipliers=start.multipliers,
        contraction=no_contraction(),
        control=start.control,
        kept=no_tangent(start.model) if freezes_tangent(start.model) else None,
    )
    return start.model, jax.tree.map(np.asarray, state)


def _resumed_tangent(model: Model, known: Mapping[str, np.ndarray]) -> FrozenInverse | None:
    """The recorded tangent, or an empty one if none was recorded."""
    if not freezes_tangent(model):
        return None
    fresh = no_tangent(model)
    found = {name: known.get(f"tangent.{name}", leaf) for name, leaf in fresh._asdict().items()}
    return FrozenInverse(**found)


class CompiledEngine:
    """An `Engine` whose steps are one compiled program; `State` is its state.

    The integration includes padding coordinates. Motions exclude them; `engine_state` includes them.
    """

    def __init__(self, system: System, run: Run) -> None:
        self._own = system
        self._system = with_padding_coordinates(system)
        self._run = run
        self._controls = jax.device_put(controls(run))
        self._model: Model | None = None
        self._program = COMPILED_MARCH
        self._stops = Stops(run.times, stepping_instants([system], run))
        self._sampling = sampling_of(self._system, run)

    @property
    def least_leg(self) -> int:
        """Output times in about 0.1 s."""
        assert self._model is not None
        n_outputs = max(1, len(self._run.times) - 1)
        steps_each = max(1, self._run.n_steps / n_outputs)
        return max(1, int(brief_steps(self._model, self._program) / steps_each))

    def start(self, time: float) -> State:
        """Consistent positions, velocities, accelerations and multipliers."""
        model, state = initial_state(self._system, time, self._run.step_control.first, self._run.validity)
        self._program = march_for(model, self._run.n_steps)
        self._model = jax.device_put(model)  # once, not with every leg
        return state

    def resumed(self, last: Solution) -> State:
        """The state at the end of a recorded part.

        Without `engine_state` the auxiliary acceleration of the integrator is set to the true acceleration.
        This keeps the order of accuracy but not the last digits. The same holds for an `engine_state` of the
        same bodies with another number of padding coordinates.
        """
        known = last.engine_state
        if "active" in known:
            active = tuple(int(index) for index in known["active"])
        else:
            active = compiled_start(self._system, self._run.start).model.active
        model = build_model(self._system, active)
        if np.shape(known.get("auxiliary", ())) != (model.n_velocities,):
            known = {}
        self._program = QUICK_MARCH if known.get("quick", 0.0) else COMPILED_MARCH
        instant = last_instant(self._system, in_all_coordinates(self._own, last))
        self._model = jax.device_put(model)
        state = State(
            time=instant.time,
            step=known.get("step", self._run.step_control.first),
            configuration=instant.configuration,
            velocity=instant.velocity,
            acceleration=instant.acceleration,
            auxiliary=known.get("auxiliary", instant.acceleration),
            multipliers=instant.multipliers[list(active)],
            contraction=Contraction(*known.get("contraction", no_contraction())),
            control=resumed_control(self._system, known),
            kept=_resumed_tangent(model, known),
        )
        return jax.tree.map(np.asarray, state)

    def march(self, state: State, times: np.ndarray) -> Leg[State]:
        """Integrate to each of the output times; sampled controllers are called at their sample times."""
        return march_sampled(self._sampling, self._marched, self._sampled, state, times)

    def _sampled(self, state: State) -> State:
        """The state after calling the controllers that are due, and accelerations for their new outputs."""
        if self._sampling is None or self._model is None or state.control is None:
            return state
        velocity, configuration = np.asarray(state.velocity), jax.tree.map(np.asarray, state.configuration)
        time = np.asarray(float(state.time))
        instant = SystemMotion(time, configuration, velocity, velocity, np.zeros(0))
        control = self._sampling.called(self._model, instant, state.control)
        if control is None:
            return state
        machine = CompiledMachine(self._sampling.system, self._model)
        acceleration, multipliers = accelerations(machine, instant, control)
        return state._replace(
            acceleration=acceleration, auxiliary=acceleration, multipliers=multipliers, control=control
        )

    def _marched(self, state: State, times: np.ndarray) -> Leg[State]:
        """Integrate to each of the output times, in a few calls of the compiled program."""
        began = clock.perf_counter()
        stops, outputs = self._stops.on_the_way(float(state.time), times)
        # Repeating the last stop adds no computation, and all calls share one program.
        calls = np.pad(stops, (0, -len(stops) % STOPS_AT_ONCE), mode="edge").reshape(-1, STOPS_AT_ONCE)
        program = self._program.compiled(self._model, self._controls, state, calls[0])
        ready = clock.perf_counter()
        last, parts = state, []
        for number, own in enumerate(calls):
            last, states = program(self._model, self._controls, last, own)
            left = len(stops) - number * STOPS_AT_ONCE
            parts.append(jax.tree.map(lambda leaf, left=left: leaf[:left], jax.device_get(states)))
            if parts[-1].failed[-1]:
                break
        states = parts[0] if len(parts) == 1 else jax.tree.map(lambda *own: np.concatenate(own), *parts)
        after = jax.device_get(last)
        states = jax.tree.map(lambda leaf: leaf[outputs[outputs < len(leaf)]], states)
        n_reached = int(np.sum(~states.failed))
        return Leg(
            states=jax.tree.map(lambda leaf: leaf[:n_reached], states),
            n_reached=n_reached,
            last=last,
            statistics=march_statistics(
                after, clock.perf_counter() - ready, jax.device_get(state), compile_seconds=ready - began
            ),
            stopped=failure_message(self._system, self._run, after.time, after.relative_residual)
            if after.failed
            else None,
        )

    def solution(self, leg: Leg[State]) -> Solution:
        """The motion of a leg."""
        assert self._model is not None
        kept = leg.last.kept
        if kept is not None and leg.stopped is not None:  # a tangent from beyond the last output time
            kept = no_tangent(self._model)
        found = as_solution(self._system, self._model, leg.states, leg.statistics, kept)
        quick = np.array(float(self._program is QUICK_MARCH))
        found = replace(found, engine_state={**found.engine_state, "quick": quick})
        return in_own_coordinates(self._own, found)


def march_statistics(
    last: State, seconds: float, first: State | None = None, compile_seconds: float = 0.0
) -> Statistics:
    """Counts of steps, iterations and tangents from a first state, or the start of the run, to a last state.

    Where no tangent is frozen, the number of tangents is that of the corrections.
    """

    def counts(state: State) -> np.ndarray:
        tangents = state.iterations if state.kept is None else state.kept.made
        return np.array([state.steps, state.iterations, state.rejected_steps, tangents], dtype=int)

    steps, iterations, rejected, tangents = counts(last) - (0 if first is None else counts(first))
    return Statistics(
        int(steps),
        int(iterations),
        int(rejected),
        seconds,
        compile_seconds,
        float(last.largest_error),
        float(last.largest_turn),
        int(tangents),
    )


def as_solution(
    system: System, model: Model, states: State, statistics: Statistics, kept: FrozenInverse | None = None
) -> Solution:
    """Stacked states (leading axis: time) as a solution.

    kept : frozen tangent at the end, which the states do not contain
    """
    states = jax.tree.map(np.asarray, states)
    motion, ending = system_motion(states), engine_state(model, states, kept)
    series = control_series(model, motion, states.control)
    return floating_solution(system, model.slices, model.active, motion, statistics, ending, series=series)


def system_motion(states: State) -> SystemMotion:
    """The motion of stacked states."""
    return SystemMotion(
        states.time, states.configuration, states.velocity, states.acceleration, states.multipliers
    )


def engine_state(model: Model, states: State, kept: FrozenInverse | None = None) -> dict[str, np.ndarray]:
    """Data that an exact resume requires besides the motion at the end (`kept` as in `as_solution`)."""
    tangent = {} if kept is None else kept._asdict()
    return {
        "active": np.array(model.active, dtype=float),
        "auxiliary": states.auxiliary[-1],
        "step": states.step[-1],
        "contraction": np.array([own[-1] for own in states.contraction]),
        **{f"tangent.{name}": np.asarray(leaf) for name, leaf in tangent.items()},
        **kept_control(model, jax.tree.map(lambda leaf: leaf[-1], states.control)),
    }
