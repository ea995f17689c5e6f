"""Load cases of a machine of intrinsic bodies, run together.

Chunks of cases are distributed over the devices of JAX. There is one device, unless more are set before JAX
starts (JAX_NUM_CPU_DEVICES=2 in the environment).
"""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ModelError
from supple.integrate import Progress, Run, Solution
from supple.machine import System
from supple.methods.floating.compiled.batch_start import differing, form_of, stacked
from supple.methods.intrinsic import IntrinsicEngine
from supple.methods.intrinsic.line_march import LineMarchState, Stepping
from supple.methods.intrinsic.line_system import LineSystem
from supple.methods.intrinsic.march_of_cases import march_of_cases
from supple.methods.intrinsic.supported_root import is_joined
from supple.methods.intrinsic.truncation_error import report_truncation_of_cases
from supple.simulation.batch_in_turn import batch_in_turn, require_memory_of_chunk
from supple.simulation.batch_solution import BatchSolution


def batch_of_lines(cases: Sequence[System], run: Run, chunk: int, progress: Progress | None) -> BatchSolution:
    """Simulate cases of machines of intrinsic bodies; the solutions are those of `simulate(check=False)`.

    If `is_joined` is true for any case, all cases run separately. Otherwise roots are connected only to the
    ground, and the cases run together. The gain is largest for the Runge-Kutta method with cases that differ
    only in loads, motions and initial states. Where default steps differ, all cases take the shortest one.
    Raises ModelError for cases that differ in more than numbers.
    """
    if any(map(is_joined, cases)):
        return batch_in_turn(cases, run, progress)
    began = clock.perf_counter()
    engines = [IntrinsicEngine(system, run) for system in cases]
    systems = [engine.lines for engine in engines]
    _check_alike(systems)
    structure, axes = jax.tree.structure(systems[0]), differing(systems)
    first = engines[0]
    # Bodies of other frequencies have other default steps: all cases take the shortest.
    n_steps = max(engine.n_steps for engine in engines)
    for engine in engines:
        engine.n_steps = n_steps
    starts = [engine.start(float(run.times[0])) for engine in engines]
    chunk = min(chunk, len(cases))
    stations = sum(np.size(model.twists) for model in systems[0].lines)
    require_memory_of_chunk(systems[0], axes, starts[0], chunk, len(run.times), 10 * stations)
    march = march_of_cases(structure, axes, Stepping(first.rule, n_steps, run.tolerances.max_iterations))
    times = jnp.asarray(run.times[1:])
    devices = jax.devices()
    preparing = clock.perf_counter() - began

    def sent(own: range, device: jax.Device) -> LineMarchState:
        # A shorter last chunk repeats its last case, so that all chunks use one compiled program.
        numbers = [*own, *[own[-1]] * (chunk - len(own))]
        together = jax.tree.map(lambda *leaves: np.stack(leaves), *(starts[i] for i in numbers))
        leaves = stacked([systems[i] for i in numbers], axes)
        return march(*jax.device_put((leaves, together, times), device), first.tolerance)

    chunks = [range(i, min(i + chunk, len(cases))) for i in range(0, len(cases), chunk)]
    solutions: list[Solution] = []
    failures: dict[int, str] = {}
    seconds = 0.0
    for begin in range(0, len(chunks), len(devices)):
        began = clock.perf_counter()
        group = chunks[begin : begin + len(devices)]
        marching = [sent(own, device) for own, device in zip(group, devices, strict=False)]
        # The first call compiles the program when dispatched; the call is asynchronous.
        preparing += (sending := clock.perf_counter() - began)
        began += sending
        reached = jax.device_get(marching)
        seconds += (passed := clock.perf_counter() - began)
        share = passed / sum(map(len, group))
        for own, states in zip(group, reached, strict=True):
            for place, number in enumerate(own):
                of_case = jax.tree.map(lambda leaf, place=place: leaf[place], states)
                solution = _solution(engines[number], starts[number], of_case, run.times, share)
                solutions.append(solution)
                if solution.stopped is not None:
                    failures[number] = solution.stopped
        if progress is not None:
            progress(len(solutions) / len(cases))
    report_truncation_of_cases(cases, run, solutions)
    return BatchSolution(tuple(solutions), failures, seconds, preparing)


def _solution(
    engine: IntrinsicEngine, start: LineMarchState, reached: LineMarchState, times: np.ndarray, seconds: float
) -> Solution:
    """The solution of a case from its start to the time reached."""
    whole = jax.tree.map(lambda first, leaf: np.concatenate([np.asarray(first)[None], leaf]), start, reached)
    leg = engine.leg(start, whole, times, seconds)
    return replace(engine.solution(leg), stopped=leg.stopped)


def _check_alike(systems: Sequence[LineSystem]) -> None:
    for number, system in enumerate(systems):
        if form_of(system) != form_of(systems[0]):
            raise ModelError(
                f"case {number} differs from the first in more than numbers: the cases of a batch have the "
                "same bodies, joints, kinds of loads and sizes of tables, gravity or none, and the same "
                "functions of time (use Table for what differs)"
            )
