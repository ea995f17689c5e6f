"""Many load cases of one system in one compiled call.

The cases are systems of the same bodies, joints and kinds of loads that differ in numbers: tables of loads,
initial motion, gravity, even stiffness. Numbers that all cases share are kept once; the others get a leading
axis, and the compiled march is mapped over it (`jax.vmap`), but for the solution of Newton's equations, where
cases take turns and converged ones have none (`in_turn`). Cases go in chunks of one size, the last one filled
up. Those that keep their tangents on a processor are not mapped (`cases_one_by_one`).
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import jax
import numpy as np

from supple.algebra.available_memory import require_memory
from supple.algebra.jax_settings import before_compiled_code
from supple.algebra.kept_programs import KeptProgram
from supple.arguments import checked_arguments
from supple.body.full_body import FullBody
from supple.errors import ModelError
from supple.integrate import (
    Progress,
    Run,
    Solution,
    Statistics,
    damps_joint_forces,
)
from supple.intrinsic import IntrinsicBody
from supple.machine.control import SampledController
from supple.machine.laws.instants import shortest_scale_of
from supple.machine.system import System
from supple.multibody.checks.output_rate import report_output_rate
from supple.multibody.checks.step_length import report_step_length
from supple.multibody.checks.validity import Peaks, watch
from supple.multibody.compiled.batch_start import Axes, BatchStart, batch_start, differing, stacked
from supple.multibody.compiled.engine import as_solution, controls, tangents_made
from supple.multibody.compiled.state import Controls, State
from supple.multibody.compiled.time_step import march
from supple.multibody.equations.compiler_options import MARCHING
from supple.multibody.equations.floating_solution import failure_message
from supple.multibody.equations.model import Model
from supple.multibody.equations.stops import Stops, filled_up, laws_of, stepping_instants
from supple.simulation.batch_of_lines import batch_of_lines
from supple.simulation.batch_solution import BatchSolution
from supple.simulation.cases_one_by_one import one_by_one
from supple.simulation.watched_run import check_laws_cover, warn_of_unseen_laws

__all__ = ["simulate_batch"]


@lru_cache(maxsize=32)
def _mapped_march(model_structure: Any, model_axes: Axes) -> KeptProgram:
    """The compiled march over cases, for one pattern of shared and differing numbers."""

    def over_cases(leaves: list[Any], settings: Any, states: State, times: Any) -> Any:
        def one_case(own: list[Any], state: State) -> Any:
            return march(jax.tree.unflatten(model_structure, own), settings, state, times)

        return jax.vmap(one_case, in_axes=(list(model_axes), 0))(leaves, states)

    return KeptProgram(over_cases, MARCHING)


@checked_arguments
def simulate_batch(
    cases: Sequence[System],
    run: Run,
    *,
    chunk: int = 64,
    progress: Progress | None = None,
) -> BatchSolution:
    """Simulate many load cases of one system of rigid and reduced bodies, or of intrinsic ones.

    Parameters
    ----------
    cases : systems of the same bodies, joints and kinds of loads; their numbers may differ, those
        of their laws of time too. Functions, of time and of controllers, must be the same objects in all
    run : Run       as for `simulate`
    chunk : number of cases mapped together
    progress : called with the finished fraction of the cases

    Returns
    -------
    BatchSolution   a failing case does not stop the others; `.check()` raises where one failed

    Raises
    ------
    ModelError      no case, a full body, a SampledController, or cases that differ in more than numbers
    MemoryShortageError     a chunk would not fit in the memory that is left
    """
    before_compiled_code()
    if not cases:
        raise ModelError("a batch needs at least one case")
    if cases[0].bodies_of(FullBody):
        raise ModelError("a batch takes rigid and reduced bodies: reduce the full ones first")
    sampled = [each for system in cases for each in system.controllers if isinstance(each, SampledController)]
    if sampled:
        raise ModelError(
            f"controller '{sampled[0].name}' is called between the steps, which cases that march together "
            "do not leave: simulate them one by one, or trace it as a Controller"
        )
    if chunk < 1:
        raise ValueError(f"chunk must be at least 1, got {chunk}")
    for system in cases:
        check_laws_cover(system, run.times[0], run.times[-1])
    warn_of_unseen_laws(_briefest(cases, run), run)
    if any(system.bodies_of(IntrinsicBody) for system in cases):
        batch = batch_of_lines(cases, run, chunk, progress)
        report_output_rate(cases[0], run, batch.solutions[0])
        return batch
    settings = controls(run)
    stops = Stops(run.times, stepping_instants(cases, run))
    limits = watch(cases[0], run.validity)
    peaks: dict[str, Peaks] = {}
    solutions: list[Solution] = []
    failures: dict[int, str] = {}
    seconds = compile_seconds = 0.0
    statistics = Statistics()
    began = clock.perf_counter()
    starts = batch_start(cases, run)
    _check_alike(starts.models)
    axes = differing(starts.models)
    _require_memory(starts, axes, min(chunk, len(cases)), len(run.times))
    compile_seconds += clock.perf_counter() - began
    for begin in range(0, len(cases), chunk):
        own = range(begin, min(begin + chunk, len(cases)))
        # A last chunk that is shorter repeats its last case, so that one program marches all.
        numbers = [*own, *[own[-1]] * (chunk - len(own) if begin else 0)]
        chosen = BatchStart([starts.models[i] for i in numbers], [starts.states[i] for i in numbers])
        part = _marched_together([cases[i] for i in own], chosen, axes, run, stops, settings)
        for solution in part.solutions:
            peaks = limits.observe(peaks, solution)
            statistics = statistics + solution.statistics
        solutions += part.solutions
        failures |= {begin + own: message for own, message in part.failures.items()}
        seconds += part.seconds
        compile_seconds += part.compile_seconds
        if progress is not None:
            progress(min(begin + chunk, len(cases)) / len(cases))
    limits.report(peaks)
    report_step_length(statistics, run)
    report_output_rate(cases[0], run, solutions[0])
    return BatchSolution(tuple(solutions), failures, seconds, compile_seconds)


def _briefest(cases: Sequence[System], run: Run) -> System:
    """The case with the law that varies fastest: the others, which differ in numbers, are seen better."""
    begin, end = float(run.times[0]), float(run.times[-1])

    def shortest(system: System) -> float:
        return min((shortest_scale_of(law, begin, end) for _, law in laws_of(system)), default=np.inf)

    return min(cases, key=shortest)


class _Part(NamedTuple):
    """What became of the cases of one chunk."""

    solutions: list[Solution]
    failures: dict[int, str]
    """By the number of the case in the chunk."""
    seconds: float
    compile_seconds: float


def _marched_together(
    cases: Sequence[System],
    starts: BatchStart,
    axes: Axes,
    run: Run,
    stops: Stops,
    settings: Controls,
) -> _Part:
    """March the cases of a chunk; its starts may go on with repeated cases."""
    began = clock.perf_counter()
    models, states = starts
    ends, outputs = stops.on_the_way(float(run.times[0]), run.times[1:])
    if states[0].kept is None:
        compiled_march = _side_by_side(models, axes, settings, states, filled_up(ends))
    else:
        alone = slice(len(cases))
        compiled_march = one_by_one(models[alone], settings, states[alone], filled_up(ends))
    ready = clock.perf_counter()
    final, history = compiled_march()
    seconds = clock.perf_counter() - ready
    solutions = []
    for own, (system, model, first) in enumerate(zip(cases, models, states, strict=False)):
        last = jax.tree.map(lambda array, own=own: array[own], final)
        cost = Statistics(
            steps=int(last.steps),
            iterations=int(last.iterations),
            rejected_steps=int(last.rejected_steps),
            factorizations=tangents_made(last),
            seconds=seconds / len(cases),
            largest_error=float(last.largest_error),
            largest_turn=float(last.largest_turn),
        )
        of_case = jax.tree.map(lambda array, own=own: array[own][outputs], history)
        solutions.append(_case_solution(system, model, first, of_case, cost))
    undamped = bool(cases[0].joints) and not damps_joint_forces(run.second_order_method)
    failures = {
        int(own): failure_message(float(final.time[own]), final.relative_residual[own], undamped=undamped)
        for own in np.flatnonzero(final.failed[: len(cases)])
    }
    return _Part(solutions, failures, seconds, ready - began)


def _side_by_side(
    models: Sequence[Model], axes: Axes, settings: Controls, states: Sequence[State], stops: np.ndarray
) -> Callable[[], tuple[State, State]]:
    """The march of cases that are mapped together, compiled."""
    start = jax.tree.map(lambda *items: np.stack([np.asarray(item) for item in items]), *states)
    arguments = stacked(models, axes), settings, start, stops
    program = _mapped_march(jax.tree.structure(models[0]), axes).compiled(*arguments)
    return lambda: jax.device_get(program(*arguments))


def _check_alike(models: Sequence[Model]) -> None:
    if any(jax.tree.structure(model) != jax.tree.structure(models[0]) for model in models):
        raise ModelError(
            "the cases of a batch must differ in numbers only: same bodies, joints, kinds of loads, "
            "and the same function objects for quantities over time (use Table for what differs)"
        )
    shapes = [[np.shape(leaf) for leaf in jax.tree.leaves(model)] for model in models]
    if any(own != shapes[0] for own in shapes):
        raise ModelError("the cases of a batch must have tables and bodies of the same sizes")


_TANGENTS = 12
"""Matrices of the size of the tangent that a case has at one time."""


def _require_memory(starts: BatchStart, axes: Axes, chunk: int, n_times: int) -> None:
    """MemoryShortageError where a chunk would take more than is left."""
    model, state = starts.models[0], starts.states[0]
    numbers = [
        np.size(leaf) * (1 if axis is None else chunk)
        for leaf, axis in zip(jax.tree.leaves(model), axes, strict=True)
    ]
    history = 3 * n_times * sum(np.size(leaf) for leaf in jax.tree.leaves(state._replace(kept=None)))
    tangents = _TANGENTS * (model.n_velocities + len(model.active)) ** 2
    require_memory(
        8 * (2 * sum(numbers) + chunk * (history + tangents)),
        f"a chunk of {chunk} cases with {n_times} output times",
        "take fewer cases at a time (`chunk`) or fewer output times",
    )


def _case_solution(system: System, model: Model, first: State, history: State, cost: Statistics) -> Solution:
    good = int(np.sum(~history.failed))
    states = jax.tree.map(
        lambda begun, leaf: np.concatenate([np.asarray(begun)[None], leaf[:good]]),
        first._replace(kept=None),
        history,
    )
    return as_solution(system, model, states, cost)
