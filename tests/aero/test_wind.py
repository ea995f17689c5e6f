"""Wind: variance and spectrum of the series, shear, seeds, and the error messages."""

import numpy as np
import pytest

from supple.aero import (
    HarmonicSeries,
    PowerLawShear,
    Wind,
    golden_phases,
    kaimal_series,
    random_phases,
)
from supple.errors import ModelError

KAIMAL = {"mean_speed": 12.0, "deviation": 1.2, "length_scale": 340.2, "frequency_step": 0.01}
PERIOD = np.arange(0, 100, 0.1)


@pytest.mark.parametrize("phase", [golden_phases(50), random_phases(50, seed=7)])
def test_variance_is_that_of_the_band(phase):
    """Parseval: over a period, the variance is the sum of amplitude^2 / 2 = S df, whatever the phases."""
    series = kaimal_series(**KAIMAL, phase=phase)
    f = 0.01 * np.arange(1, 51)
    S = 4 * 1.2**2 * (340.2 / 12) / (1 + 6 * f * 340.2 / 12) ** (5 / 3)
    np.testing.assert_allclose(series.at(PERIOD).var(), S.sum() * 0.01, rtol=1e-12)
    np.testing.assert_allclose(series.at(PERIOD + 100), series.at(PERIOD), atol=1e-10)


def test_the_whole_spectrum_carries_the_whole_variance():
    fine = kaimal_series(**{**KAIMAL, "frequency_step": 1e-4}, phase=np.zeros(10**6))
    np.testing.assert_allclose((fine.amplitude**2).sum() / 2, 1.2**2, rtol=0.01)


def test_series_of_the_blade_benchmark():
    """Standard deviation 0.92 m/s, range 9.9 to 14.1 m/s about 12 m/s, by an independent code."""
    speed = 12 + kaimal_series(**KAIMAL, phase=golden_phases(50)).at(PERIOD)
    np.testing.assert_allclose([speed.std(), speed.min(), speed.max()], [0.92, 9.9, 14.1], atol=0.05)


def test_seeds_repeat_and_differ():
    np.testing.assert_array_equal(random_phases(9, seed=3), random_phases(9, seed=3))
    assert np.abs(random_phases(9, seed=3) - random_phases(9, seed=4)).min() > 0


def test_one_harmonic():
    series = HarmonicSeries(frequency=[0.5], amplitude=[2.0], phase=[np.pi / 3])
    np.testing.assert_allclose(series.at([0.0, 0.5]), [1.0, -np.sqrt(3)])


def test_a_gust_takes_the_place_of_turbulence():
    """The extreme operating gust of IEC 61400-1 rises by 0.74 V_gust at half its duration of 10.5 s."""

    class Gust:
        def at(self, times):
            t = np.clip(np.asarray(times) - 2.0, 0, 10.5) / 10.5
            return -0.37 * 8.0 * np.sin(3 * np.pi * t) * (1 - np.cos(2 * np.pi * t))

    wind = Wind(mean_speed=12.0, shear=PowerLawShear(hub_height=90.0), turbulence=Gust())
    speed = wind.along_blade([0.0, 2.0 + 5.25, 20.0], radius=[30.0], azimuth=np.full(3, np.pi / 2))
    np.testing.assert_allclose(speed[:, 0], [12.0, 12.0 + 0.74 * 8.0, 12.0])


def test_shear_along_a_turning_blade():
    wind = Wind(mean_speed=10.0, shear=PowerLawShear(hub_height=80.0, exponent=0.5))
    speeds = wind.along_blade([0.0, 1.0, 2.0], radius=[0.0, 60.0], azimuth=[0.0, np.pi / 2, np.pi])
    factors = np.sqrt([[1, 140 / 80], [1, 1], [1, 20 / 80]])
    np.testing.assert_allclose(speeds, 10 * factors)


@pytest.mark.parametrize("name", list(KAIMAL))
def test_turbulence_sizes_are_above_zero(name):
    with pytest.raises(ModelError, match=f"{name} = 0"):
        kaimal_series(**{**KAIMAL, name: 0.0}, phase=golden_phases(5))


def test_errors():
    with pytest.raises(ModelError, match=r"amplitude of shape \(1,\)"):
        HarmonicSeries(frequency=[0.1, 0.2], amplitude=[1.0], phase=[0.0, 0.0])
    with pytest.raises(ModelError, match="hub height 0"):
        PowerLawShear(hub_height=0.0)
    with pytest.raises(ModelError, match="height -10 m above the ground"):
        PowerLawShear(hub_height=50.0).factor([50.0, -10.0])
    with pytest.raises(ModelError, match="mean wind speed nan"):
        Wind(mean_speed=np.nan, shear=PowerLawShear(hub_height=50.0))
