"""Damage-equivalent loads: closed forms, invariances, and the conventions that they state."""

import numpy as np
import pytest

from supple.errors import ModelError
from supple.fatigue import Goodman, Residue, damage_equivalent_load, rainflow

EXAMPLE = np.array([-2, 1, -3, 5, -1, 3, -4, 4, -2.0])


def sine(n_cycles, amplitude=1.0, mean=0.0):
    return mean + amplitude * np.cos(np.pi * np.arange(2 * n_cycles + 1))


@pytest.mark.parametrize("exponent", [1, 4, 12.5])
def test_a_load_of_constant_amplitude_is_its_own_equivalent(exponent):
    cycles = rainflow(sine(50, 3.0, mean=8.0))
    assert damage_equivalent_load(cycles, exponent, 50).ranges == pytest.approx(6.0, rel=1e-12)
    assert damage_equivalent_load(cycles, exponent, 100).ranges == pytest.approx(
        6.0 * 0.5 ** (1 / exponent), rel=1e-12
    )


def test_by_hand_from_the_table_of_the_standard():
    counts = {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}
    expected = (sum(n * s**4 for s, n in counts.items()) / 10) ** 0.25
    load = damage_equivalent_load(rainflow(EXAMPLE), 4, 10)
    assert load.ranges == pytest.approx(expected, rel=1e-14)
    assert "exponent 4, 10 reference cycles" in str(load)
    assert "residue as half cycles, no mean correction" in str(load)


def test_units_scale_it_and_large_powers_do_not_overflow():
    small, large = (rainflow(scale * EXAMPLE) for scale in (1.0, 1e40))
    ratio = damage_equivalent_load(large, 12, 10).ranges / damage_equivalent_load(small, 12, 10).ranges
    assert ratio == pytest.approx(1e40, rel=1e-13)


def test_the_rule_for_the_residue_matters_and_is_stated():
    half = damage_equivalent_load(rainflow(EXAMPLE), 4, 10)
    closed = damage_equivalent_load(rainflow(EXAMPLE, Residue.CLOSED), 4, 10)
    assert closed.ranges > 1.01 * half.ranges
    assert "residue as closed" in closed.conventions


def test_channels_without_cycles_have_no_load():
    load = damage_equivalent_load(rainflow(np.stack([EXAMPLE, np.full(9, 3.0)], axis=1)), 4, 10)
    assert load.ranges[1] == 0
    assert load.ranges[0] > 0


def test_goodman_by_hand_and_symmetric():
    """A mean of half the ultimate load doubles a range, in tension and in compression."""
    for mean in (50.0, -50.0):
        cycles = rainflow(sine(20, 3.0, mean=mean))
        load = damage_equivalent_load(cycles, 5, 20, Goodman(100.0))
        assert load.ranges == pytest.approx(12.0, rel=1e-12)
    assert "Goodman" in str(load)


def test_goodman_has_an_ultimate_load_of_each_channel():
    cycles = rainflow(np.stack([sine(20, 3.0, 50.0)] * 2, axis=1))
    load = damage_equivalent_load(cycles, 5, 20, Goodman([100.0, 200.0]))
    assert load.ranges == pytest.approx([12.0, 8.0], rel=1e-12)
    with pytest.raises(ModelError, match="one for each channel"):
        damage_equivalent_load(cycles, 5, 20, Goodman([1e3, 1e3, 1e3]))


def test_a_peak_beyond_the_ultimate_load_is_refused():
    with pytest.raises(ModelError, match=r"channel 0 reaches 53.*ultimate load of 52"):
        damage_equivalent_load(rainflow(sine(20, 3.0, mean=50.0)), 5, 20, Goodman(52.0))


@pytest.mark.parametrize(("exponent", "reference"), [(0, 1), (-3, 1), (3, 0), (np.nan, 1), (3, np.inf)])
def test_numbers_that_mean_nothing_are_refused(exponent, reference):
    with pytest.raises(ModelError):
        damage_equivalent_load(rainflow(EXAMPLE), exponent, reference)
