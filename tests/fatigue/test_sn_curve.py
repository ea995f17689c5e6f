"""S-N curves against the tables of DNVGL-RP-C203, and damage by Miner's rule."""

from dataclasses import replace

import numpy as np
import pytest

from supple.errors import ModelError
from supple.fatigue import Goodman, SNCurve, ThicknessEffect, damage_equivalent_load, miner_damage, rainflow

D = SNCurve(52.63e6, 1e7, 3, 5)
"""Curve D in air: log10 a = 12.164 (m = 3, N <= 1e7), 15.606 (m = 5), MPa."""


@pytest.mark.parametrize(
    ("stress", "log_a", "exponent"), [(120.0, 12.164, 3), (60.0, 12.164, 3), (30.0, 15.606, 5)]
)
def test_curve_d_of_the_standard(stress, log_a, exponent):
    """Table 2-1 of DNVGL-RP-C203, rounded there to three digits of a logarithm."""
    cycles = 10**log_a / stress**exponent
    assert 1 / D.damage(stress * 1e6) == pytest.approx(cycles, rel=4e-3)


def test_the_knee_is_continuous():
    below, above = D.damage([52.63e6 * (1 - 1e-9), 52.63e6 * (1 + 1e-9)])
    assert below == pytest.approx(above, rel=2e-8)


def test_thick_plates_fail_earlier_and_thin_ones_do_not_gain():
    thick = replace(D, thickness=ThicknessEffect(50e-3, 25e-3, 0.2))
    assert thick.damage(100e6) / D.damage(100e6) == pytest.approx(2**0.6, rel=1e-12)
    thin = replace(D, thickness=ThicknessEffect(10e-3, 25e-3, 0.2))
    assert thin.damage(100e6) == D.damage(100e6)
    # The effect also moves a range across the knee.
    assert thick.damage(50e6) == pytest.approx(D.damage(50e6 * 2**0.2), rel=1e-12)


def test_cycles_to_failure_make_a_damage_of_one():
    stress = 100e6
    life = 1 / D.damage(stress)
    history = 0.5 * stress * np.cos(np.pi * np.arange(2001))
    assert miner_damage(rainflow(history), D) * life / 1000 == pytest.approx(1.0, rel=1e-12)


def test_damage_agrees_with_the_equivalent_load_on_a_straight_curve():
    """Method against method: N_eq cycles of the equivalent range do the damage of the history."""
    history = np.random.default_rng(0).standard_normal((500, 2)) * 40e6
    curve, cycles = SNCurve(100e6, 2e6, 4.0), rainflow(history)
    ultimate = Goodman(1e9)
    load = damage_equivalent_load(cycles, 4.0, 77, ultimate)
    assert 77 * curve.damage(load.ranges) == pytest.approx(miner_damage(cycles, curve, ultimate), rel=1e-12)


def test_numbers_that_describe_no_curve_are_refused():
    with pytest.raises(ModelError, match="exchange"):
        SNCurve(1.0, 1e7, 5, 3)
    with pytest.raises(ModelError, match="positive"):
        SNCurve(-1.0, 1e7, 3)
    with pytest.raises(ModelError, match="positive"):
        ThicknessEffect(0.0, 25e-3, 0.2)
