"""Jumps and turning points of a law of time, found by sampling.

A law given as a Python function is evaluated at about 17 000 equally spaced times of the run, or at fewer if
it has many values. Intervals in which the values change most are divided repeatedly, until a jump is located.
Time steps end at turning points, so that the integration does not miss a pulse, and step control shortens the
next steps. A feature shorter than the sampling interval can be missed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.programs.program_cache import CachedProgram

BLOCK = 64 * 33
"""Largest number of times in one call of the program: 33 points of subdivision for each of 64 jumps."""
N_SAMPLES = 8 * BLOCK - 1
"""Largest number of sampling intervals of a run."""
MOST_NUMBERS = 4_000_000
"""Largest number of values in all samples, because of memory; a load on many nodes has fewer samples."""
MOST_JUMPS = 64
DIVISIONS, ROUNDS = 32, 5
"""Parts into which an interval is divided, and number of divisions: a jump is located to 32^-5 of a sampling
interval."""
JUMPS = 1e-4
"""Smallest change of a jump, over its interval after the last division, relative to the range of the law."""
TURNS = 1e-3
"""A turning point is ignored if both changes of value, from the turning point before it and to the one after
it, are less than this fraction of the range of the law."""
MOST_TURNS = 512
"""Largest number of turning points that end time steps. If a law has more, none of them ends a step; the
ordinary time steps do not miss so many."""

_OfTime = Callable[[jax.Array], jax.Array]

Sampled = Callable[[np.ndarray], np.ndarray]
"""A function that returns values (k, m) for times (k,)."""


class Jumps(NamedTuple):
    """Jumps of a function, ascending: times (k,) just before each jump, and times (k,) just after it."""

    before: np.ndarray
    after: np.ndarray


def law_samples(law: _OfTime, times: np.ndarray, *, order: int = 0) -> list[np.ndarray]:
    """Values of a law at times (k,), and its derivatives up to an order: a list of arrays (k, m)."""
    # All blocks have one size, so one compiled program evaluates any number of times.
    size = max(1, min(BLOCK, MOST_NUMBERS // _n_values(law)))
    blocks = np.pad(times, (0, -len(times) % size), mode="edge").reshape(-1, size)
    parts = [jax.device_get(_program(order)(law, block)) for block in blocks]
    return [np.concatenate(each)[: len(times)] for each in zip(*parts, strict=True)]


def _n_values(law: _OfTime) -> int:
    """Number of values of a law at one time."""
    shape = jax.eval_shape(lambda time: jnp.asarray(law(time)), jnp.zeros(())).shape
    return max(1, int(np.prod(shape)))


@lru_cache
def _program(order: int) -> CachedProgram:
    return CachedProgram(partial(_of_block, order), {"xla_backend_optimization_level": 0})


def _of_block(order: int, law: _OfTime, times: jax.Array) -> list[jax.Array]:
    functions: list[_OfTime] = [lambda time: jnp.ravel(jnp.asarray(law(time), dtype=float))]
    for _ in range(order):
        functions.append(_rate(functions[-1]))
    return [jax.vmap(function)(times) for function in functions]


def _rate(function: _OfTime) -> _OfTime:
    return lambda time: jax.jvp(function, (time,), (jnp.ones_like(time),))[1]


def jumps(of_times: Sampled, times: np.ndarray, values: np.ndarray) -> Jumps:
    """Jumps of a function from its values (k, m) at equally spaced times (k,), at most `MOST_JUMPS`."""
    size = float(np.max(np.ptp(values, axis=0), initial=0.0))
    change = np.abs(np.diff(values, axis=0)).max(axis=1)
    if size == 0 or not np.isfinite(size):
        return Jumps(np.zeros(0), np.zeros(0))
    # A jump changes much more than the intervals on both sides of it; a steep but smooth part does not.
    beside = np.minimum(np.append(change[1:], 0.0), np.insert(change[:-1], 0, 0.0))
    order = np.argsort(beside - change)[:MOST_JUMPS]
    left, right = times[order], times[order + 1]
    for _ in range(ROUNDS):
        inner = left[:, None] + np.linspace(0.0, 1.0, DIVISIONS + 1) * (right - left)[:, None]
        fine = of_times(inner.ravel()).reshape(*inner.shape, -1)
        steps = np.abs(np.diff(fine, axis=1)).max(axis=2)
        steepest = np.argmax(steps, axis=1)
        rows = np.arange(len(left))
        left, right = inner[rows, steepest], inner[rows, steepest + 1]
        change = steps[rows, steepest]
    found = np.flatnonzero(change > JUMPS * size)
    found = found[np.argsort(left[found])]
    return Jumps(left[found], right[found])


def sampled_instants(law: _OfTime, begin: float, end: float) -> np.ndarray:
    """Times (k,) strictly between `begin` and `end`: both sides of each jump, and turning points."""
    if not end > begin:
        return np.zeros(0)
    n_values = _n_values(law)
    n = min(N_SAMPLES, MOST_NUMBERS // n_values)
    times = np.linspace(begin, end, max(n, 2) + 1)

    # More than three components are replaced by three random linear combinations of all components.
    mix = np.random.default_rng(0).standard_normal((n_values, 3))

    def of_times(at: np.ndarray) -> np.ndarray:
        (values,) = law_samples(law, at)
        return values if values.shape[1] <= mix.shape[1] else values @ mix

    values = of_times(times)
    breaks = jumps(of_times, times, values)
    turns = [_turning_points(times, column) for column in values.T]
    every = np.unique(np.concatenate([breaks.before, breaks.after, *turns]))
    return every[(every > begin) & (every < end)]


def _turning_points(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Times of the turning points of samples (k,); none for a function that oscillates everywhere."""
    size = np.ptp(values)
    moving = np.flatnonzero(np.abs(np.diff(values)) > 1e-9 * size)
    if not moving.size:
        return np.zeros(0)
    signs = np.sign(np.diff(values)[moving])
    # Both ends of a plateau are turning points: its first sample and its last.
    turn = np.flatnonzero(signs[1:] != signs[:-1])
    at = np.unique(np.concatenate([[0], moving[turn] + 1, moving[turn + 1], [len(values) - 1]]))
    steps = np.abs(np.diff(values[at]))
    inner = at[1:-1][(steps[1:] > TURNS * size) | (steps[:-1] > TURNS * size)]
    return times[inner] if len(inner) <= MOST_TURNS else np.zeros(0)
