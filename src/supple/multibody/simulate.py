"""Simulate a system: one case, in chunks of output times, recorded and reported as they complete."""

from __future__ import annotations

import time as clock
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ConvergenceError, ModelError, StepCutWarning
from supple.integrate import (
    BodyMotion,
    FixedStep,
    GeneralizedAlpha,
    Solution,
    Statistics,
    StepControl,
    TimeIntegrator,
    Tolerances,
    concatenate,
)
from supple.multibody.compiler_options import MARCHING
from supple.multibody.equations import Configuration
from supple.multibody.full_body import FullBody
from supple.multibody.initial_state import consistent_start
from supple.multibody.model import Model
from supple.multibody.system import System
from supple.multibody.time_step import Controls, State, march
from supple.multibody.validity import Peaks, Validity, watch

__all__ = ["Checkpoint", "Progress", "Recorder", "output_times", "simulate"]

Progress = Callable[[float], None]
"""Called with the completed fraction of a run, 0 to 1."""
Recorder = Callable[[Solution], None]
"""Called with each completed chunk of a run; the first holds the initial state."""

CHUNKS = 50
"""A run is handed on in so many parts."""


@dataclass(frozen=True)
class Checkpoint:
    """A finished part of a run, from whose last instant a new run goes on.

    Made by `Checkpoint(solution)` from what was recorded; the auxiliary acceleration of the integrator is
    taken equal to the true one, which keeps the order of accuracy.
    """

    solution: Solution


def output_times(duration: float, output_step: float, start: float = 0.0) -> np.ndarray:
    """`start, start + output_step, .. , start + duration`; the duration must be a multiple of the step."""
    for name, value in (("duration", duration), ("output_step", output_step)):
        if not (np.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be a positive, finite number, got {value}")
    n = round(duration / output_step)
    if n < 1 or abs(n * output_step - duration) > 1e-6 * output_step:
        raise ValueError(
            f"the duration ({duration}) is not a multiple of the output step ({output_step}): "
            f"try an output step of {duration / max(n, 1):.6g}"
        )
    return start + np.arange(n + 1) * (duration / n)


def check_laws_cover(system: System, begin: float, end: float) -> None:
    """Raise ModelError for a tabulated load or motion that starts after the run does, or stops before."""
    laws = [(f"joint '{joint.name}'", joint.law) for joint in system.joints]
    laws += [(load.label, load.law) for load in system.loads]
    for what, law in laws:
        if law is not None and law.begin > begin:
            raise ModelError(
                f"{what}: its table begins at t = {law.begin:g}, after the run does (t = {begin:g}). "
                "Extend the table backwards"
            )
        if law is not None and law.end < end * (1 - 1e-12):
            raise ModelError(
                f"{what}: its table ends at t = {law.end:g}, before the run does (t = {end:g}). "
                "Extend the table or shorten the run"
            )


def simulate(
    system: System,
    *,
    duration: float,
    output_step: float,
    step: StepControl | None = None,
    method: TimeIntegrator | None = None,
    tolerances: Tolerances | None = None,
    validity: Validity | None = None,
    resume: Checkpoint | None = None,
    progress: Progress | None = None,
    record: Recorder | None = None,
) -> Solution:
    """Motion of a system from its initial state over a duration, by generalized-alpha.

    Parameters
    ----------
    system : System     bodies all rigid or reduced (compiled engine), or some full (sparse engine)
    duration, output_step : float   unit of time; the duration is a multiple of the output step
    step : FixedStep | AdaptiveStep     default: a fixed step equal to the output step
    method : GeneralizedAlpha (default, rho_inf = 0.8) | Newmark | HilberHughesTaylor
    tolerances : Tolerances
    validity : Validity     warn of a motion beyond what the kinematics allow (default), or stop at it
    resume : Checkpoint     go on from the end of an earlier part of the same run
    progress, record : called as the run goes on; `record` receives every completed chunk

    Returns
    -------
    Solution    at the output times; when resuming, only the new ones

    Raises
    ------
    ModelError          a joint open at the start, a table that begins too late or ends too early
    ConvergenceError    a step that fails at the smallest size: time, residual and remedy; what was computed
                        until then has been handed to `record`
    ValidityError       a motion beyond the kinematics, under `Validity(strict=True)`

    Warns
    -----
    ValidityWarning, StepCutWarning, RedundantConstraintWarning
    """
    times = output_times(duration, output_step)
    step = step or FixedStep(output_step)
    method = method or GeneralizedAlpha()
    tolerances = tolerances or Tolerances()
    check_laws_cover(system, times[0], times[-1])
    if resume is not None and resume.solution.times[-1] >= times[-1] * (1 - 1e-12):
        raise ValueError(
            f"nothing is left to simulate: the recorded part ends at t = {resume.solution.times[-1]:g} and "
            f"the run at t = {times[-1]:g}"
        )
    limits = watch(system, validity or Validity())
    peaks: dict[str, Peaks] = {}

    def observed(chunk: Solution) -> None:
        if record is not None:
            record(chunk)
        peaks.update(limits.observe(peaks, chunk))

    if any(isinstance(placed.body, FullBody) for placed in system.bodies):
        from supple.multibody.full_order import simulate_full_order as engine
    else:
        engine = _simulate_compiled
    solution = engine(system, times, step, method, tolerances, resume, progress or _silent, observed)
    report_cuts(solution.statistics, step)
    limits.report(peaks)
    return solution


def _silent(fraction: float) -> None: ...


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


def _simulate_compiled(
    system: System,
    times: np.ndarray,
    step: StepControl,
    method: TimeIntegrator,
    tolerances: Tolerances,
    resume: Checkpoint | None,
    progress: Progress,
    record: Recorder,
) -> Solution:
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
            raise ConvergenceError(failure_message(float(last.time), last.imbalance))
        n_done += len(chunk)
        progress(n_done / len(times))
    return concatenate(parts)


def _counts(state: State) -> np.ndarray:
    """Steps, iterations and cuts so far."""
    return np.array([state.steps, state.iterations, state.cuts])


def _leading(states: State, count: int) -> State:
    return jax.tree.map(lambda leaf: leaf[:count], states)


def report_cuts(statistics: Statistics, step: StepControl) -> None:
    """Warn when steps of a fixed size had to be cut: the answer is good, the step was too long."""
    if statistics.cuts and isinstance(step, FixedStep):
        warnings.warn(
            f"{statistics.cuts} steps did not converge and were cut ({statistics.steps} steps were taken); "
            f"a fixed step below {step.size:g} avoids this",
            StepCutWarning,
            stacklevel=3,
        )


def failure_message(time: float, imbalance: np.ndarray) -> str:
    """Why and where a run stopped; `imbalance` is the relative residual of the four kinds of equations."""
    kinds = ("forces", "moments", "deformation", "constraints")
    worst = int(np.argmax(np.where(np.isfinite(imbalance), imbalance, np.inf)))
    return (
        f"no convergence at t = {time:.6g} with the smallest step allowed: relative residual "
        f"{imbalance[worst]:.2g} in the {kinds[worst]}. A singular position (a mechanism stretched out), a "
        "motion prescribed with a jump, loads far beyond the body's stiffness, or a basis without the "
        "nonlinear terms it needs are the usual causes; what was computed until then is kept"
    )


def as_solution(system: System, model: Model, states: State, statistics: Statistics) -> Solution:
    """Stacked states (leading axis: time) as a solution."""
    states = jax.tree.map(np.asarray, states)
    return Solution(
        times=states.time,
        bodies=body_motions(system, model.slices, states.configuration, states.velocity, states.acceleration),
        joint_forces=joint_forces(system, model, states.multipliers),
        statistics=statistics,
    )


def body_motions(
    system: System,
    slices: tuple[slice, ...],
    configuration: Configuration,
    velocity: np.ndarray,
    acceleration: np.ndarray,
) -> dict[str, BodyMotion]:
    """Split stacked states (leading axis: time) by body."""
    motions = {}
    for index, (placed, part) in enumerate(zip(system.bodies, slices, strict=True)):
        own, rate = velocity[..., part], acceleration[..., part]
        motions[placed.body.name] = BodyMotion(
            position=configuration.origins[..., index, :],
            rotation=configuration.rotations[..., index, :, :],
            coordinates=configuration.coordinates[index],
            velocity=own[..., :3],
            angular_velocity=own[..., 3:6],
            coordinate_rates=own[..., 6:],
            acceleration=rate[..., :3],
            angular_acceleration=rate[..., 3:6],
            coordinate_accelerations=rate[..., 6:],
        )
    return motions


def joint_forces(system: System, model: Model, multipliers: np.ndarray) -> dict[str, np.ndarray]:
    """Multipliers by joint; zero for the equations that were left out as redundant."""
    every = np.zeros((*multipliers.shape[:-1], model.n_equations))
    every[..., list(model.active)] = multipliers
    forces, start = {}, 0
    for joint in system.joints:
        forces[joint.name] = every[..., start : start + joint.n_constraints]
        start += joint.n_constraints
    return forces


def _resumed(
    system: System, times: np.ndarray, step: StepControl, resume: Checkpoint
) -> tuple[Model, State, np.ndarray]:
    """Model and state at the end of a recorded part, and the output times still to come."""
    done = resume.solution
    model, state = consistent_start(system, times[0], step.first)
    last: Mapping[str, BodyMotion] = done.bodies
    names = [placed.body.name for placed in system.bodies]
    if set(names) != set(last) or {j.name for j in system.joints} != set(done.joint_forces):
        raise ModelError(
            "the recorded part has other bodies or joints than this system: it cannot be continued"
        )
    configuration = state.configuration._replace(
        origins=jnp.array([last[name].position[-1] for name in names]),
        rotations=jnp.array([last[name].rotation[-1] for name in names]),
        coordinates=tuple(jnp.array(last[name].coordinates[-1]) for name in names),
    )

    def joined(*items: str) -> jax.Array:
        return jnp.concatenate([getattr(last[name], item)[-1] for name in names for item in items])

    acceleration = joined("acceleration", "angular_acceleration", "coordinate_accelerations")
    every = np.concatenate([np.zeros(0)] + [done.joint_forces[joint.name][-1] for joint in system.joints])
    state = state._replace(
        time=jnp.asarray(float(done.times[-1])),
        configuration=configuration,
        velocity=joined("velocity", "angular_velocity", "coordinate_rates"),
        acceleration=acceleration,
        auxiliary=acceleration,
        multipliers=jnp.asarray(every[list(model.active)]),
    )
    return model, state, times[times > done.times[-1] * (1 + 1e-12)]
