"""The compiled engine: systems of rigid and reduced bodies, marched chunk by chunk of output times."""

from __future__ import annotations

import time as clock

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ConvergenceError
from supple.integrate import (
    Solution,
    Statistics,
    StepControl,
    TimeIntegrator,
    Tolerances,
    concatenate,
)
from supple.machine.system import System
from supple.multibody.compiled.compiler_options import MARCHING
from supple.multibody.compiled.initial_state import consistent_start
from supple.multibody.compiled.time_step import Controls, State, march
from supple.multibody.equations.model import Model
from supple.multibody.run_parts import (
    CHUNKS,
    Checkpoint,
    Progress,
    Recorder,
    body_motions,
    failure_message,
    joint_forces,
    last_instant,
)

__all__ = ["as_solution", "controls", "simulate_compiled"]


def controls(step: StepControl, method: TimeIntegrator, tolerances: Tolerances) -> Controls:
    """The numbers that steer a compiled run."""
    return Controls(
        coefficients=method.coefficients,
        first=float(step.first),
        largest=float(step.largest),
        smallest=float(step.smallest),
        error_tolerance=float(step.tolerance),
        residual_tolerance=float(tolerances.residual),
        max_iterations=tolerances.max_iterations,
    )


def simulate_compiled(
    system: System,
    times: np.ndarray,
    step: StepControl,
    method: TimeIntegrator,
    tolerances: Tolerances,
    resume: Checkpoint | None,
    progress: Progress,
    record: Recorder,
) -> Solution:
    """`simulate` for systems without full bodies; see there."""
    began = clock.perf_counter()
    parts: list[Solution] = []
    if resume is None:
        model, state = consistent_start(system, times[0], step.first)
        times = times[1:]
    else:
        model, state, times = _resumed(system, times, step, resume)
    settings = controls(step, method, tolerances)
    size = max(1, int(np.ceil(len(times) / CHUNKS)))
    model_arrays = jax.device_put(model)  # once, not with every chunk
    lowered = march.lower(model_arrays, settings, state, jnp.asarray(times[:size]))
    compiled = lowered.compile(compiler_options=MARCHING)
    ready = clock.perf_counter()
    if resume is None:
        first = jax.tree.map(lambda leaf: jnp.asarray(leaf)[None], state)
        parts.append(
            as_solution(system, model, first, Statistics(compile_seconds=ready - began, seconds=0.0))
        )
        record(parts[0])
    last_mark = ready
    n_done = 0
    counted = _counts(jax.device_get(state))
    while n_done < len(times):
        chunk = times[n_done : n_done + size]
        # A short last chunk repeats its end, where nothing is left to do: all chunks share one compilation.
        padded = np.pad(chunk, (0, size - len(chunk)), mode="edge")
        state, states = compiled(model_arrays, settings, state, jnp.asarray(padded))
        states = jax.device_get(states)
        good = int(np.sum(~states.failed[: len(chunk)]))
        mark = clock.perf_counter()
        last = jax.tree.map(lambda leaf: leaf[-1], states)
        steps, iterations, cuts = _counts(last) - counted
        statistics = Statistics(int(steps), int(iterations), int(cuts), seconds=mark - last_mark)
        counted, last_mark = _counts(last), mark
        if good:
            parts.append(as_solution(system, model, _leading(states, good), statistics))
            record(parts[-1])
        if last.failed:
            raise ConvergenceError(failure_message(float(last.time), last.relative_residual))
        n_done += len(chunk)
        progress(n_done / len(times))
    return concatenate(parts)


def _counts(state: State) -> np.ndarray:
    """Steps, iterations and cuts so far."""
    return np.array([state.steps, state.iterations, state.rejected_steps])


def _leading(states: State, count: int) -> State:
    return jax.tree.map(lambda leaf: leaf[:count], states)


def as_solution(system: System, model: Model, states: State, statistics: Statistics) -> Solution:
    """Stacked states (leading axis: time) as a solution."""
    states = jax.tree.map(np.asarray, states)
    return Solution(
        times=states.time,
        bodies=body_motions(system, model.slices, states.configuration, states.velocity, states.acceleration),
        joint_forces=joint_forces(system, model, states.multipliers),
        statistics=statistics,
    )


def _resumed(
    system: System, times: np.ndarray, step: StepControl, resume: Checkpoint
) -> tuple[Model, State, np.ndarray]:
    """Model and state at the end of a recorded part, and the output times still to come."""
    model, state = consistent_start(system, times[0], step.first)
    last = jax.tree.map(jnp.asarray, last_instant(system, model, resume.solution))
    state = state._replace(**last._asdict(), auxiliary=last.acceleration)
    return model, state, times[times > resume.solution.times[-1] * (1 + 1e-12)]
