"""Sample times of a run, at which its residual is evaluated: at random in intervals, and where loads peak."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from supple.equations.stops import laws_of
from supple.machine import System
from supple.machine.laws.instants import instants_of
from supple.machine.laws.sampled_law import sampled

__all__ = ["followed", "load_peaks", "stratified_samples"]

MOST_PEAKS = 8
"""With 50 others, and what a body's modes take: sixty factorisations."""

FOLLOWED = 100
"""Besides those that are asked for."""


def stratified_samples(n_times: int, number: int, seed: int) -> NDArray[np.intp]:
    """One of the output times 1 .. n_times - 1 at random in each of `number` equal intervals, ascending.

    At evenly spread instants a periodic load would look the same each time.
    """
    edges = np.linspace(1, n_times, number + 1)
    draw = np.random.default_rng(seed).uniform(edges[:-1], edges[1:])
    return np.unique(np.minimum(draw.astype(np.intp), n_times - 1))


def load_peaks(system: System, times: Sequence[float] | NDArray[np.float64]) -> NDArray[np.intp]:
    """Output times at which laws are largest, or just after they kink; ascending, the start left out."""
    times = np.asarray(times)
    found: list[float] = []
    for _, law in laws_of(system):
        values = np.linalg.norm(sampled(law, times[:: _stride(times)])[0], axis=1)
        found.append(times[:: _stride(times)][int(np.argmax(values))])
        found += list(instants_of(law, float(times[0]), float(times[-1])))[:MOST_PEAKS]
    rows = np.unique(np.clip(np.searchsorted(times, found, side="left"), 1, len(times) - 1))
    if len(rows) > MOST_PEAKS:
        rows = rows[np.linspace(0, len(rows) - 1, MOST_PEAKS).round().astype(int)]
    return rows.astype(np.intp)


def followed(instants: NDArray[np.intp]) -> NDArray[np.intp]:
    """Instants and others between, ascending: at all of them missed motion is sought, one after the other."""
    return np.union1d(instants, np.linspace(1, np.max(instants), FOLLOWED).round().astype(np.intp))


def _stride(times: NDArray[np.float64]) -> int:
    return max(1, len(times) // 500)
