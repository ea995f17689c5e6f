"""March cases of a group and reduce each motion to what is kept of it; nothing else stays in memory."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from supple.cases.notify import silent
from supple.errors import MemoryShortageError, MissingPackageError, ResultFileError, SuppleError
from supple.integrate import Kinematic, Solution
from supple.quantities import read_sensors
from supple.simulation import simulate, simulate_batch
from supple.simulation.engines import is_explicit
from supple.storage.solution_arrays import to_arrays
from supple.sweeps.channel_statistics import channel_statistics
from supple.sweeps.part_file import CaseResult, CaseStatus, Channels
from supple.sweeps.plan import MARCHED_AT_ONCE
from supple.sweeps.swept_group import SweptCase, SweptGroup

__all__ = ["march_cases"]

MOST_AT_ONCE = 64
"""Cases whose motions are in memory together."""
NUMBERS_AT_ONCE = 2**26
"""Numbers of all of their motions, 512 MiB."""
NUMBERS_OF_A_BODY = 40
"""At an output time, besides its coordinates, their rates and accelerations: its frame, a joint."""
NOT_OF_A_CASE = (MemoryShortageError, MissingPackageError, ResultFileError)
"""Errors of the machine or the disk: another try may succeed, so nothing is recorded."""

Began = Callable[[Sequence[int]], None]
"""Called with the numbers of the cases that march from now on."""


def march_cases(group: SweptGroup, cases: Sequence[int], began: Began) -> Iterator[CaseResult]:
    """What cases of a group come to, in their order.

    Cases that march together are one compiled program; where it does not take them, each marches alone.
    """
    size = _at_once(group)
    for start in range(0, len(cases), size):
        block = cases[start : start + size]
        began(block)
        made, results = _made(group, block)
        results |= _marched(group, made)
        yield from (results[number] for number in block)


def _at_once(group: SweptGroup) -> int:
    """Cases that fit in memory together: of the group alone, so that digits do not depend on the machine."""
    bodies = [placed.body for placed in group.like.system.bodies]
    numbers = sum(NUMBERS_OF_A_BODY + 3 * body.n_coordinates for body in bodies) * len(group.like.run.times)
    fitting = min(NUMBERS_AT_ONCE // numbers, MOST_AT_ONCE)
    return max(fitting // MARCHED_AT_ONCE, 1) * MARCHED_AT_ONCE


def _made(group: SweptGroup, cases: Sequence[int]) -> tuple[dict[int, SweptCase], dict[int, CaseResult]]:
    """The machines of cases, and what is wrong with those that make none."""
    made, failed = dict[int, SweptCase](), dict[int, CaseResult]()
    for number in cases:
        try:
            made[number] = group.case(number)
        except NOT_OF_A_CASE:
            raise
        except SuppleError as error:
            failed[number] = CaseResult(number, CaseStatus.FAILED, str(error))
    return made, failed


def _marched(group: SweptGroup, made: dict[int, SweptCase]) -> dict[int, CaseResult]:
    if not made:
        return {}
    run = next(iter(made.values())).run
    together = not isinstance(run.method, Kinematic) and not any(
        is_explicit(own.system, run) for own in made.values()
    )
    if together and len(made) > 1:
        try:
            return _together(group, made)
        except NOT_OF_A_CASE:
            raise
        except SuppleError:
            pass  # perhaps of one case: each says for itself what is wrong
    return {number: _alone(group, number, own) for number, own in made.items()}


def _together(group: SweptGroup, made: dict[int, SweptCase]) -> dict[int, CaseResult]:
    cases = list(made.values())
    found = simulate_batch([own.system for own in cases], cases[0].run, progress=silent)
    results = {}
    for place, (number, own) in enumerate(made.items()):
        solution = found.solutions[place]
        failure = found.failures.get(place)
        if failure is not None:
            solution = replace(solution, stopped=failure)
        results[number] = _result(group, number, own, solution, solution.statistics.seconds)
    return results


def _alone(group: SweptGroup, number: int, own: SweptCase) -> CaseResult:
    began = clock.process_time()
    try:
        solution = simulate(own.system, own.run, check=False, progress=silent)  # the command has a bar
    except NOT_OF_A_CASE:
        raise
    except SuppleError as error:
        return CaseResult(number, CaseStatus.FAILED, str(error), clock.process_time() - began)
    return _result(group, number, own, solution, clock.process_time() - began)


def _result(group: SweptGroup, number: int, own: SweptCase, solution: Solution, seconds: float) -> CaseResult:
    """A motion in numbers; of one that broke off its extremes would be those of a part, so there are none."""
    result = CaseResult(
        number,
        CaseStatus.RAN if solution.stopped is None else CaseStatus.FAILED,
        solution.stopped or "",
        seconds,
        float(solution.times[-1]),
        steps=solution.statistics.steps,
        iterations=solution.statistics.iterations,
    )
    keeps = group.plan.keeps(number)
    if solution.stopped is not None:
        return replace(result, motion=to_arrays(solution) if keeps else {})
    columns = read_sensors(own.quantities, own.system, solution).columns(own.case.units)
    channels = Channels(
        columns.names,
        columns.units,
        tuple(each.quantity.value for each in columns.channels),
        tuple(each.axes for each in columns.channels),
        tuple(each.place for each in columns.channels),
    )
    statistics, spectrum = channel_statistics(columns.times, columns.values), result.spectrum
    fatigue = group.plan.output.fatigue
    if fatigue is not None:
        loads, spectrum = fatigue.of(columns.names, columns.times, columns.values)
        statistics = np.concatenate([statistics, loads])
    return replace(
        result,
        statistics=statistics,
        spectrum=spectrum,
        channels=channels,
        motion=to_arrays(solution) | {"channels": columns.values} if keeps else {},
    )
