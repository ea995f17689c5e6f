"""Sample times of a run, at which its residual is evaluated: stratified samples and load peaks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from supple.equations.stops import laws_of
from supple.machine import System
from supple.machine.laws.instants import instants_of_law
from supple.machine.laws.sampled_law import law_samples

MOST_PEAKS = 8
"""Largest number of load peaks and kinks, added to the stratified samples."""

FOLLOWED = 100
"""Number of intermediate times."""


def stratified_samples(n_times: int, number: int, seed: int) -> NDArray[np.intp]:
    """Indices of output times in 1 .. n_times - 1: a random one in each of `number` equal intervals.

    Evenly spaced samples could hit a periodic load always at the same phase.
    """
    edges = np.linspace(1, n_times, number + 1)
    draw = np.random.default_rng(seed).uniform(edges[:-1], edges[1:])
    return np.unique(np.minimum(draw.astype(np.intp), n_times - 1))


def load_peaks(system: System, times: Sequence[float] | NDArray[np.float64]) -> NDArray[np.intp]:
    """Indices of output times where laws are largest, or that follow a kink; ascending, without the start."""
    times = np.asarray(times)
    found: list[float] = []
    for _, law in laws_of(system):
        values = np.linalg.norm(law_samples(law, times[:: _stride(times)])[0], axis=1)
        found.append(times[:: _stride(times)][int(np.argmax(values))])
        found += list(instants_of_law(law, float(times[0]), float(times[-1])))[:MOST_PEAKS]
    rows = np.unique(np.clip(np.searchsorted(times, found, side="left"), 1, len(times) - 1))
    if len(rows) > MOST_PEAKS:
        rows = rows[np.linspace(0, len(rows) - 1, MOST_PEAKS).round().astype(int)]
    return rows.astype(np.intp)


def followed(instants: NDArray[np.intp]) -> NDArray[np.intp]:
    """Sample times and intermediate times, ascending, along which the missing motion is followed."""
    return np.union1d(instants, np.linspace(1, np.max(instants), FOLLOWED).round().astype(np.intp))


def _stride(times: NDArray[np.float64]) -> int:
    return max(1, len(times) // 500)
