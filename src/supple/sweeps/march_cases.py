"""Simulation of cases of a group; only the requested results of each motion are stored."""

from __future__ import annotations

import time as clock
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from supple.arrays import FloatArray
from supple.cases.notify import silent
from supple.errors import ModelError, SuppleError, SuppleWarning
from supple.integrate import Kinematic, Solution
from supple.quantities import read_sensors
from supple.simulation import simulate, simulate_batch
from supple.simulation.engines import is_explicit
from supple.storage.solution_arrays import to_arrays
from supple.sweeps.attempts import NOT_OF_A_CASE
from supple.sweeps.certificate import EstimatedError
from supple.sweeps.certified_group import CertifiedGroup
from supple.sweeps.channel_statistics import channel_statistics
from supple.sweeps.fatigue_loads import DAMAGE
from supple.sweeps.greedy_basis import indicated
from supple.sweeps.hot_spots import damage_of_hot_spots
from supple.sweeps.part_file import CaseRecord, CaseStatus, Channels
from supple.sweeps.plan import MARCHED_AT_ONCE
from supple.sweeps.swept_group import SweptCase, SweptGroup

MOST_AT_ONCE = 64
"""Largest number of cases whose motions are in memory at a time."""
NUMBERS_AT_ONCE = 2**26
"""Largest count of numbers in the motions in memory, 512 MiB, unless `MARCHED_AT_ONCE` cases need more."""
NUMBERS_OF_A_BODY = 40
"""Numbers per body and output time for its frame and a joint, in addition to its coordinates and rates."""

Began = Callable[[Sequence[int]], None]
"""Callback with the numbers of the cases whose simulation begins."""


def march_cases(certified: CertifiedGroup, cases: Sequence[int], began: Began) -> Iterator[CaseRecord]:
    """The results of cases of a group, in their order.

    The cases run in batches of one compiled program. If a batch fails, its cases run one at a time.
    """
    group = certified.group
    size = _at_once(group)
    for start in range(0, len(cases), size):
        block = cases[start : start + size]
        began(block)
        made, results = _made(group, block)
        results |= _marched(certified, made)
        yield from (results[number] for number in block)


def _at_once(group: SweptGroup) -> int:
    """Number of cases of a batch; it depends on the group only, so that all computers give equal digits."""
    bodies = [placed.body for placed in group.like.system.bodies]
    numbers = sum(NUMBERS_OF_A_BODY + 3 * body.n_coordinates for body in bodies) * len(group.like.run.times)
    fitting = min(NUMBERS_AT_ONCE // numbers, MOST_AT_ONCE)
    return max(fitting // MARCHED_AT_ONCE, 1) * MARCHED_AT_ONCE


def _made(group: SweptGroup, cases: Sequence[int]) -> tuple[dict[int, SweptCase], dict[int, CaseRecord]]:
    """The machines of cases, and records of the cases whose machine cannot be built."""
    made, failed = dict[int, SweptCase](), dict[int, CaseRecord]()
    for number in cases:
        try:
            made[number] = group.case(number)
        except NOT_OF_A_CASE:
            raise
        except SuppleError as error:
            failed[number] = CaseRecord(number, CaseStatus.FAILED, str(error))
    return made, failed


def _marched(certified: CertifiedGroup, made: dict[int, SweptCase]) -> dict[int, CaseRecord]:
    if not made:
        return {}
    run = next(iter(made.values())).run
    together = not isinstance(run.method, Kinematic) and not any(
        is_explicit(own.system, run) for own in made.values()
    )
    if together and len(made) > 1:
        try:
            return _together(certified, made)
        except NOT_OF_A_CASE:
            raise
        except SuppleError:
            pass  # perhaps an error of one case: single runs find the case
    return {number: _alone(certified, number, own) for number, own in made.items()}


def _together(certified: CertifiedGroup, made: dict[int, SweptCase]) -> dict[int, CaseRecord]:
    cases = list(made.values())
    found = simulate_batch([own.system for own in cases], cases[0].run, progress=silent)
    solutions = [
        replace(solution, stopped=found.failures.get(place)) for place, solution in enumerate(found.solutions)
    ]
    errors = _errors(certified, list(made), cases, solutions)
    return {
        number: _result(certified.group, number, own, solution, solution.statistics.seconds, error)
        for (number, own), solution, error in zip(made.items(), solutions, errors, strict=True)
    }


def _errors(
    certified: CertifiedGroup,
    numbers: Sequence[int],
    cases: Sequence[SweptCase],
    solutions: Sequence[Solution],
) -> list[EstimatedError]:
    """Estimated errors of the runs of some cases.

    NaN for runs that stopped early; NaN for all without a certificate, or, with a SuppleWarning, if the
    indicators cannot be computed.
    """
    bodies = certified.certificate.bodies
    none = [EstimatedError()] * len(cases)
    if not bodies:
        return none
    try:
        found = indicated(certified.group, cases, solutions, bodies)
    except NOT_OF_A_CASE:
        raise
    except SuppleError as error:
        warnings.warn(f"errors of cases are not estimated: {error}", SuppleWarning, stacklevel=2)
        return none
    return [
        certified.certificate.case_error(number, own) if solution.stopped is None else EstimatedError()
        for number, own, solution in zip(numbers, found, solutions, strict=True)
    ]


def _alone(certified: CertifiedGroup, number: int, own: SweptCase) -> CaseRecord:
    began = clock.process_time()
    try:
        solution = simulate(
            own.system, own.run, check=False, progress=silent
        )  # the command shows a progress bar
    except NOT_OF_A_CASE:
        raise
    except SuppleError as error:
        return CaseRecord(number, CaseStatus.FAILED, str(error), clock.process_time() - began)
    seconds = clock.process_time() - began
    (error,) = _errors(certified, [number], [own], [solution])
    return _result(certified.group, number, own, solution, seconds, error)


def _result(
    group: SweptGroup, number: int, own: SweptCase, solution: Solution, seconds: float, error: EstimatedError
) -> CaseRecord:
    """The record of a case. A run that stopped early has no statistics: they would cover a part only."""
    result = CaseRecord(
        number,
        CaseStatus.RAN if solution.stopped is None else CaseStatus.FAILED,
        solution.stopped or "",
        seconds,
        float(solution.times[-1]),
        *error,
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
        if fatigue.hot_spot:
            try:
                channels, statistics = _with_damage(group, own, solution, channels, statistics)
            except ModelError as failure:  # a peak beyond the ultimate stress
                return replace(result, status=CaseStatus.FAILED, cause=str(failure))
    return replace(
        result,
        statistics=statistics,
        spectrum=spectrum,
        channels=channels,
        motion=to_arrays(solution) | {"channels": columns.values} if keeps else {},
    )


def _with_damage(
    group: SweptGroup, own: SweptCase, solution: Solution, channels: Channels, statistics: FloatArray
) -> tuple[Channels, FloatArray]:
    """Channels and statistics, extended by a channel with the damage at each node of the hot spots."""
    fatigue = group.plan.output.fatigue
    assert fatigue is not None
    found = damage_of_hot_spots(fatigue.hot_spot, fatigue.residue, group.like, own.system, solution)
    k = len(found.names)
    wide = np.full((len(statistics) + 1, statistics.shape[1] + k), np.nan)
    wide[:-1, :-k], wide[-1, -k:] = statistics, found.damage
    more = Channels(found.names, ("",) * k, (DAMAGE,) * k, ("",) * k, found.places)
    both = zip(vars(channels).values(), vars(more).values(), strict=True)
    return Channels(*(one + other for one, other in both)), wide
