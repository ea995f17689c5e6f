"""Check for loads that excite modes missing from a reduced body: load band and frequencies are compared.

A load f(t) over a run of length T is the sum of a straight line between its end values and a sine series

    f(t) = f_0 + (f_T - f_0) t / T + sum_k b_k sin(k pi t / T),

The mean square is taken as that of the line plus, by Parseval, b_k^2 / 2 for every frequency k pi / T; the
mean product of line and series is omitted. The difference from the line vanishes at both ends, so that its
coefficients fall as k^-3 where f is smooth: no window is needed, and the beginning of a run has the same
weight as its middle. The onset of a load at t = 0 and gravity are not included. The load of a prescribed
motion is its acceleration.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np
import scipy  # its parts are imported when first used

from supple.algebra import read_only
from supple.body import FlexibleBody, Frame
from supple.errors import LoadSpectrumWarning, ModelError
from supple.machine import Constant, TimeLaw
from supple.machine.laws.sampled_law import law_samples
from supple.machine.system import System
from supple.reduction import ReducedBody
from supple.units import UNNAMED, UnitSystem, with_unit

__all__ = ["BandCoverage", "LoadSpectrum", "band_coverage", "load_spectra", "warn_of_missing_modes"]

SHARE = 0.999
"""Share of a load's mean square within its band."""
SAME = 1.05
"""Ratio of a frequency of the reduced body to one of the full body, up to which both are of the same mode."""
MOST_MODES = 200
"""Largest number of modes of a full body that are compared."""
MOST_SAMPLES = 20_000
"""Largest number of times at which loads are evaluated."""
FEW, SAMPLES = 33, 257
"""If there are fewer than FEW output times, which do not resolve a load, SAMPLES times are used instead."""


@dataclass(frozen=True, eq=False)
class LoadSpectrum:
    """Mean square of a load over a run, by frequency.

    label : str
    frequencies : (k,)      rad/s, ascending
    mean_squares : (k,)     b^2 / 2, summed over the components of the load
    steady : float          mean square of the straight line
    """

    label: str
    frequencies: np.ndarray
    mean_squares: np.ndarray
    steady: float

    def __post_init__(self) -> None:
        for item in ("frequencies", "mean_squares"):
            object.__setattr__(self, item, read_only(getattr(self, item)))

    @property
    def band(self) -> float:
        """Frequency below which SHARE of the mean square lies, rad/s; 0 for a nearly constant load."""
        above = np.append(np.cumsum(self.mean_squares[::-1])[::-1], 0.0)
        within = int(np.argmax(above <= (1 - SHARE) * (above[0] + self.steady)))
        return float(self.frequencies[within - 1]) if within else 0.0


@dataclass(frozen=True)
class BandCoverage:
    """Modes of a reduced body inside the band of the loads.

    load : str              the load with the highest band
    band : float            rad/s, below which SHARE of its mean square lies
    kept : float            rad/s, up to which the reduced body has every mode of the full body
    missing : (k,) tuple    rad/s, modes of the full body inside the band that the reduced body lacks
    n_modes : int           modes of the full body inside the band: the number needed
    """

    load: str
    band: float
    kept: float
    missing: tuple[float, ...]
    n_modes: int


def load_spectra(system: System, times: np.ndarray) -> tuple[LoadSpectrum, ...]:
    """Spectra of all loads and prescribed motions that vary over a run.

    times : (t,)    evenly spaced, t >= 3; frequencies above half the sampling rate are not resolved
    Raises ModelError for other times.
    """
    steps = np.diff(times)
    if len(times) < 3 or not np.allclose(steps, steps[:1], rtol=1e-6, atol=0.0):
        raise ModelError("spectrum of the loads: give at least three evenly spaced times")
    histories = [
        (load.label, law_samples(law, times)[0]) for load in system.acting if _varies(law := load.law)
    ] + [
        (f"joint '{joint.name}'", law_samples(law, times, order=2)[2])
        for joint in system.joints
        if _varies(law := joint.law)
    ]
    return tuple(
        _spectrum(label, np.asarray(history).reshape(len(times), -1), times) for label, history in histories
    )


def _varies(law: TimeLaw | None) -> TypeGuard[TimeLaw]:
    return law is not None and not isinstance(law, Constant)


def _spectrum(label: str, history: np.ndarray, times: np.ndarray) -> LoadSpectrum:
    """Spectrum of a history (t, m)."""
    n = len(times) - 1
    first, last = history[0], history[-1]
    line = first + np.linspace(0.0, 1.0, n + 1)[:, None] * (last - first)
    coefficients = np.asarray(scipy.fft.dst((history - line)[1:-1], type=1, axis=0)) / n
    return LoadSpectrum(
        label,
        np.arange(1, n) * np.pi / (times[-1] - times[0]),
        np.sum(coefficients**2, axis=1) / 2,
        float(np.sum(first**2 + first * last + last**2) / 3),
    )


def band_coverage(
    spectra: Sequence[LoadSpectrum], kept: np.ndarray, of_body: np.ndarray
) -> BandCoverage | None:
    """Compare the band of the loads with the modes of a body and of its reduced form; None without spectra.

    kept : (r,)         rad/s, ascending, of the reduced body in its frame
    of_body : (m,)      rad/s, ascending, of the full body in the same frame, up to the band or beyond
    """
    if not spectra:
        return None
    widest = max(spectra, key=lambda spectrum: spectrum.band)
    missing, found = [], 0
    # Rayleigh-Ritz: frequencies of the reduced body are above those of the full body, in the same order.
    for frequency in of_body:
        if found < len(kept) and kept[found] <= SAME * frequency:
            found += 1
        else:
            missing.append(float(frequency))
    below_the_first = of_body if not missing else of_body[of_body < missing[0]]
    return BandCoverage(
        load=widest.label,
        band=widest.band,
        kept=float(np.max(below_the_first, initial=0.0)),
        missing=tuple(frequency for frequency in missing if frequency <= widest.band),
        n_modes=int(np.sum(of_body <= widest.band)),
    )


def warn_of_missing_modes(
    system: System,
    times: np.ndarray,
    body: FlexibleBody,
    reduced: ReducedBody,
    units: UnitSystem = UNNAMED,
) -> BandCoverage | None:
    """Warn of loads that excite modes of a body missing from its reduced form; returns the comparison.

    None is returned if all loads are constant or nearly constant over the run.

    system : System     with its loads and prescribed motions
    times : (t,)        of the run, evenly spaced
    units : UnitSystem  frequencies are given in Hz where the unit of time is known
    Warns LoadSpectrumWarning: the load, its band, the modes missing, and the number needed.
    """
    spectra = load_spectra(system, _thinned(times))
    if not any(spectrum.band > 0 for spectrum in spectra):
        return None
    band = max(spectrum.band for spectrum in spectra)
    coverage = band_coverage(spectra, reduced.frequencies, _frequencies(body, reduced.frame, band, reduced.r))
    if coverage is not None and coverage.missing:
        unit, factor = units.frequency_shown
        lacking = ", ".join(f"{factor * each / (2 * np.pi):.3g}" for each in coverage.missing[:5])
        lacking = with_unit(lacking + (", ..." if len(coverage.missing) > 5 else ""), unit)
        reach = with_unit(f"{factor * coverage.band / (2 * np.pi):.3g}", unit)
        warnings.warn(
            f"the frequencies of {coverage.load} reach {reach}: of the {coverage.n_modes} modes of body "
            f"'{body.name}' up to there, {len(coverage.missing)} are missing from its basis ({lacking}). "
            f"Take at least {coverage.n_modes} modes",
            LoadSpectrumWarning,
            stacklevel=2,
        )
    return coverage


def _thinned(times: np.ndarray) -> np.ndarray:
    """At most MOST_SAMPLES evenly spaced times over the same span; SAMPLES for a run with few outputs."""
    if FEW <= len(times) <= MOST_SAMPLES:
        return times
    return np.linspace(times[0], times[-1], SAMPLES if len(times) < FEW else MOST_SAMPLES)


def _frequencies(body: FlexibleBody, frame: Frame, band: float, at_least: int) -> np.ndarray:
    """Lowest frequencies of the full body in its frame, the last one above the band; at most MOST_MODES."""
    constraint = frame.constraint(body)
    most = min(body.n - len(constraint), MOST_MODES)
    n = min(at_least, most)
    while True:
        found = body.lowest_frequencies(n, constraint)
        if found[-1] > band or n == most:
            return found
        n = min(2 * n, most)
