"""Many load cases of one system in one compiled call.

The cases are systems of the same bodies, joints and kinds of loads that differ in numbers: tables of loads,
initial motion, gravity, even stiffness. Numbers that all cases share are stored once. All others get a
leading axis. The compiled run is mapped over this axis (`jax.vmap`), unless the tangents of the cases are
frozen (`shares_of_cases`). All processor cores are used where that is worthwhile (`worker_processes`).
"""

from __future__ import annotations

import time as clock
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import jax
import numpy as np

from supple.algebra.jax_settings import before_compiled_code
from supple.arguments import check_instance, checked_arguments
from supple.equations.checks.output_rate import report_output_rate
from supple.equations.checks.step_resolution import report_step_length
from supple.equations.checks.validity import Peaks, watch
from supple.equations.control_series import control_series
from supple.equations.floating_solution import failure_message, floating_solution
from supple.equations.machine_model import Model
from supple.equations.stops import Stops, laws_of, padded_stops, stepping_instants
from supple.errors import ModelError
from supple.integrate import Progress, Run, Solution, Statistics
from supple.machine import SampledController
from supple.machine.laws.instants import shortest_scale_of
from supple.machine.system import System
from supple.methods.floating.compiled.batch_start import BatchStart, batch_start, differing, form_of
from supple.methods.floating.compiled.engine import (
    controls,
    engine_state,
    march_statistics,
    system_motion,
)
from supple.methods.floating.compiled.state import State
from supple.programs.worker_processes import on_all_cores
from supple.progress import by_fraction, with_progress_bar
from supple.simulation.batch_in_turn import batch_in_turn, require_memory_of_chunk
from supple.simulation.batch_of_lines import batch_of_lines
from supple.simulation.batch_solution import BatchSolution
from supple.simulation.engines import refuse_explicit
from supple.simulation.shares_of_cases import shares_of
from supple.simulation.watched_run import check_laws_cover, warn_of_unseen_laws

__all__ = ["simulate_batch"]


_CHUNK = 64
"""Chunk size for machines of intrinsic bodies."""
_SMALL_CHUNK = 16
"""Chunk size on a CPU: the time per case is as with `_CHUNK`, and there are more chunks for the cores."""
_LARGE_CHUNK = 1024
"""Chunk size on a GPU: an iteration takes 150 kernels of at least 5 us each, for one case or a thousand."""
_RESULTS_AT_ONCE = 64
"""Number of cases whose solutions are computed together from their states."""
_TANGENTS = 12
"""Number of matrices of the size of the tangent that a case stores at one time."""


@checked_arguments
@with_progress_bar("simulating cases", by_fraction)
def simulate_batch(
    cases: Sequence[System],
    run: Run,
    *,
    chunk: int | None = None,
    progress: Progress | None = None,
) -> BatchSolution:
    """Simulate many load cases of one system, with bodies of any form except explicit parts.

    Cases with full bodies, or with joined or controlled intrinsic bodies, run separately, on all cores.

    Parameters
    ----------
    cases : systems of the same bodies, joints and kinds of loads; numbers may differ, including those of
        laws of time. Functions of time and of controllers must be the same objects in all cases
    run : Run       as for `simulate`
    chunk : number of cases mapped together; by default 64, but for rigid and reduced bodies 16 on a CPU and
        1024 on a GPU
    progress : called with the finished fraction of the cases

    Returns
    -------
    BatchSolution   a failed case does not stop the other cases; `.check()` raises if one failed

    Raises
    ------
    ModelError      no case, explicit parts, a table that does not cover the run, cases that differ in more
                    than numbers, a SampledController in cases without full bodies
    MemoryShortageError     a chunk would not fit in the available memory
    ValueError              a chunk below one
    """
    before_compiled_code()
    _check_cases(cases, run, chunk)
    kinds = {placed.body.kind for system in cases for placed in system.bodies}
    if kinds & {"full", "intrinsic"}:
        if "full" in kinds:
            batch = batch_in_turn(cases, run, progress)
        else:
            batch = batch_of_lines(cases, run, chunk or _CHUNK, progress)
        report_output_rate(cases[0], run, batch.solutions[0])
        return batch
    chunk = chunk or (_SMALL_CHUNK if jax.default_backend() == "cpu" else _LARGE_CHUNK)
    limits = watch(cases[0], run.validity)
    peaks: dict[str, Peaks] = {}
    statistics = Statistics()
    marched: dict[int, _MarchedCase] = {}
    found: dict[int, Solution] = {}
    failures: dict[int, str] = {}
    began = clock.perf_counter()
    ends, outputs = Stops(run.times, stepping_instants(cases, run)).on_the_way(
        float(run.times[0]), run.times[1:]
    )
    starts = batch_start(cases, run)
    _check_alike(starts.models)
    axes = differing(starts.models)
    model, state = starts.models[0], starts.states[0]._replace(kept=None)
    tangents = _TANGENTS * (model.n_velocities + len(model.active)) ** 2
    require_memory_of_chunk(model, axes, state, min(chunk, len(cases)), len(run.times), tangents)
    shares = shares_of(starts, axes, controls(run), padded_stops(ends), chunk)
    shares.program.compiled(*shares.arguments[0]())
    ready = clock.perf_counter()
    for done in on_all_cores(shares.program, shares.arguments):
        seconds_of_each = done.seconds / len(shares.cases[done.number])
        for number, last, states in shares.of_each(done.number, done.result):
            history = jax.tree.map(lambda leaf: leaf[outputs], states)
            marched[number] = _marched(cases[number], starts, number, last, history, seconds_of_each)
            if last.failed:
                failures[number] = failure_message(cases[number], run, last.time, last.relative_residual)
        if len(marched) >= _RESULTS_AT_ONCE or len(marched) + len(found) == len(cases):
            found |= dict(zip(marched, _solutions_of(list(marched.values())), strict=True))
            for number in marched:
                peaks = limits.observe(peaks, found[number])
                statistics = statistics + found[number].statistics
            marched.clear()
        if progress is not None:
            progress((len(found) + len(marched)) / len(cases))
    seconds = clock.perf_counter() - ready
    limits.report(peaks)
    report_step_length(statistics, run)
    in_order = [found[number] for number in range(len(cases))]
    report_output_rate(cases[0], run, in_order[0])
    return BatchSolution(tuple(in_order), dict(sorted(failures.items())), seconds, ready - began)


def _check_cases(cases: Sequence[System], run: Run, chunk: int | None) -> None:
    """Raise for cases that do not form a batch; warn of loads that the steps do not resolve."""
    if not cases:
        raise ModelError("a batch needs at least one case")
    for number, system in enumerate(cases):
        check_instance(f"simulate_batch, case {number}", system, System, "a System")
        refuse_explicit(system, run, "a batch")
    sampled = [each for system in cases for each in system.controllers if isinstance(each, SampledController)]
    if sampled and not any(placed.body.kind == "full" for placed in cases[0].bodies):
        raise ModelError(
            f"controller '{sampled[0].name}' is called between the steps, where cases that run together "
            "cannot stop: simulate them one by one, or write it as a Controller"
        )
    if chunk is not None and chunk < 1:
        raise ValueError(f"chunk must be at least 1, got {chunk}")
    for system in cases:
        check_laws_cover(system, run.times[0], run.times[-1])
    warn_of_unseen_laws(_briefest(cases, run), run)


def _briefest(cases: Sequence[System], run: Run) -> System:
    """The case with the law that varies fastest: steps that resolve it also resolve the other cases."""
    begin, end = float(run.times[0]), float(run.times[-1])

    def shortest(system: System) -> float:
        return min((shortest_scale_of(law, begin, end) for _, law in laws_of(system)), default=np.inf)

    return min(cases, key=shortest)


def _marched(
    system: System, starts: BatchStart, number: int, last: State, history: State, seconds: float
) -> _MarchedCase:
    """A case with its start, its last state, and its states at the output times reached."""
    good = int(np.sum(~history.failed))
    states = jax.tree.map(
        lambda begun, leaf: np.concatenate([np.asarray(begun)[None], leaf[:good]]),
        starts.states[number]._replace(kept=None),
        history,
    )
    return _MarchedCase(system, starts.models[number], states, march_statistics(last, seconds))


def _check_alike(models: Sequence[Model]) -> None:
    forms = [form_of(model) for model in models]
    if any(structure != forms[0][0] for structure, _ in forms):
        raise ModelError(
            "the cases of a batch must differ in numbers only: same bodies, joints, kinds of loads, "
            "and the same function objects for quantities over time (use Table for what differs)"
        )
    if any(shapes != forms[0][1] for _, shapes in forms):
        raise ModelError("the cases of a batch must have tables and bodies of the same sizes")


@dataclass(frozen=True)
class _MarchedCase:
    """The computed part of a case."""

    system: System
    model: Model
    states: State
    """States at the output times reached; the first axis is time."""
    statistics: Statistics


def _solutions_of(cases: Sequence[_MarchedCase]) -> list[Solution]:
    """The solutions of cases.

    Cases with the same bodies and joints are concatenated in time: one call computes their joint forces,
    which takes less time than a call for each case.
    """
    alike: dict[Hashable, list[int]] = {}
    for number, case in enumerate(cases):
        alike.setdefault(_bodies_and_joints(case), []).append(number)
    found: dict[int, Solution] = {}
    for numbers in alike.values():
        together = _found_together([cases[number] for number in numbers])
        found |= dict(zip(numbers, together, strict=True))
    return [found[number] for number in range(len(cases))]


def _bodies_and_joints(case: _MarchedCase) -> Hashable:
    """Key by identity of bodies and joints: cases with equal starts share joint arrays (`batch_start`)."""
    return (
        tuple(id(placed.body) for placed in case.system.bodies),
        tuple(joint.name for joint in case.system.joints),
        id(case.model.joints),
        case.model.active,
    )


def _found_together(cases: Sequence[_MarchedCase]) -> list[Solution]:
    first = cases[0]
    states = jax.tree.map(lambda *own: np.concatenate(own), *(case.states for case in cases))
    motion, model = system_motion(states), first.model
    series = control_series(model, motion, states.control)
    whole = floating_solution(first.system, model.slices, model.active, motion, Statistics(), series=series)
    ends = np.cumsum([len(case.states.time) for case in cases])
    return [
        replace(
            whole.at(slice(end - len(case.states.time), end)),
            statistics=case.statistics,
            engine_state=engine_state(case.model, case.states),
        )
        for case, end in zip(cases, ends, strict=True)
    ]
