"""Wind: a mean speed, its growth with height, and turbulence as a sum of harmonics."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from supple.algebra.read_only import read_only
from supple.arrays import FloatArray
from supple.errors import ModelError

__all__ = [
    "HarmonicSeries",
    "PowerLawShear",
    "SpeedHistory",
    "Wind",
    "golden_phases",
    "kaimal_series",
    "random_phases",
]

GOLDEN_RATIO_PART = 0.618034


@dataclass(frozen=True, kw_only=True)
class PowerLawShear:
    """Ratio of the speed at height z to the speed at the hub: (z / hub_height)^exponent."""

    hub_height: float
    exponent: float = 0.2

    def __post_init__(self) -> None:
        if not (isfinite(self.hub_height) and self.hub_height > 0 and isfinite(self.exponent)):
            raise ModelError(
                f"shear with hub height {self.hub_height} m, exponent {self.exponent}; give finite values, "
                "the height above zero"
            )

    def factor(self, height: ArrayLike) -> FloatArray:
        """Ratio of the speed at heights above the ground (m, any shape) to that at the hub.

        Raises ModelError for a height that is not above zero.
        """
        height = np.asarray(height, dtype=np.float64)
        if height.size and height.min() <= 0:
            raise ModelError(
                f"height {height.min():g} m above the ground; the rotor must stay above the ground"
            )
        return (height / self.hub_height) ** self.exponent


@dataclass(frozen=True, eq=False, kw_only=True)
class HarmonicSeries:
    """u(t) = sum_k amplitude_k cos(2 pi frequency_k t + phase_k); frequency in Hz, phase in rad, all (n,)."""

    frequency: FloatArray
    amplitude: FloatArray
    phase: FloatArray

    def __post_init__(self) -> None:
        for name in ("frequency", "amplitude", "phase"):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.ndim != 1 or values.shape != self.frequency.shape or not np.isfinite(values).all():
                raise ModelError(
                    f"harmonics: {name} of shape {values.shape}; give one finite number for each harmonic"
                )

    def at(self, times: ArrayLike) -> FloatArray:
        """Speed u (t,) at the times (t,)."""
        angle = 2 * np.pi * np.multiply.outer(np.asarray(times, dtype=np.float64), self.frequency)
        return np.cos(angle + self.phase) @ self.amplitude


def kaimal_series(
    *,
    mean_speed: float,
    deviation: float,
    length_scale: float,
    frequency_step: float,
    phase: ArrayLike,
) -> HarmonicSeries:
    """Longitudinal turbulence with Kaimal's spectrum, as n harmonics of frequency k df, k = 1 .. n.

        S(f) = 4 sigma^2 (L/U) / (1 + 6 f L/U)^(5/3),   amplitude_k = (2 S(k df) df)^(1/2)
    The speed repeats after 1/df.

    Parameters
    ----------
    mean_speed : float          U, m/s
    deviation : float           sigma, m/s, standard deviation of the whole spectrum; that of the harmonics is
                                smaller, because they contain only the part in their band
    length_scale : float        L, m (IEC 61400-1: 340.2 m from a hub height of 60 m on)
    frequency_step : float      df, Hz
    phase : float array (n,)    rad, one for each harmonic: `golden_phases`, or `random_phases` of a seed
    Returns
    -------
    HarmonicSeries   (n,)
    Raises
    ------
    ModelError   a speed, deviation, length or frequency step that is not above zero
    Source: IEC 61400-1, annex on turbulence models.
    """
    sizes = dict(
        mean_speed=mean_speed, deviation=deviation, length_scale=length_scale, frequency_step=frequency_step
    )
    for name, value in sizes.items():
        if not (isfinite(value) and value > 0):
            raise ModelError(f"turbulence: {name} = {value}; give a finite value above zero")
    phase = np.asarray(phase, dtype=np.float64)
    frequency = frequency_step * np.arange(1, phase.size + 1, dtype=np.float64)
    time_scale = length_scale / mean_speed
    spectrum = 4 * deviation**2 * time_scale / (1 + 6 * frequency * time_scale) ** (5 / 3)
    return HarmonicSeries(frequency=frequency, amplitude=np.sqrt(2 * spectrum * frequency_step), phase=phase)


def golden_phases(n: int) -> FloatArray:
    """Phases 2 pi frac(0.618034 k^2), k = 1 .. n: spread over 0 .. 2 pi without random numbers."""
    return 2 * np.pi * np.mod(GOLDEN_RATIO_PART * np.arange(1, n + 1) ** 2, 1)


def random_phases(n: int, *, seed: int) -> FloatArray:
    """Random phases (n,), uniform over 0 .. 2 pi; equal for equal seeds."""
    return np.random.default_rng(seed).uniform(0, 2 * np.pi, n)


class SpeedHistory(Protocol):
    """A speed over time, such as `HarmonicSeries`, a gust, or a measured series."""

    def at(self, times: ArrayLike) -> FloatArray:
        """Speed u (t,) at the times (t,)."""
        ...


@dataclass(frozen=True, kw_only=True)
class Wind:
    """Axial wind V = (mean_speed + u(t)) shear.factor(height); without turbulence u = 0."""

    mean_speed: float
    shear: PowerLawShear
    turbulence: SpeedHistory | None = None

    def __post_init__(self) -> None:
        if not (isfinite(self.mean_speed) and self.mean_speed > 0):
            raise ModelError(f"mean wind speed {self.mean_speed} m/s; give a finite value above zero")

    def along_blade(self, times: ArrayLike, *, radius: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        """V (t, k) at radii (k,) of a blade at azimuths (t,) from upright: height = hub + r cos(azimuth)."""
        height = self.shear.hub_height + np.multiply.outer(
            np.cos(azimuth), np.asarray(radius, dtype=np.float64)
        )
        gust = 0.0 if self.turbulence is None else self.turbulence.at(times)[:, None]
        return (self.mean_speed + gust) * self.shear.factor(height)
