"""Rainflow counts: the example of the standard, the package `rainflow`, and repeating histories."""

from collections import Counter

import numpy as np
import pytest

from supple.errors import ArgumentError, ModelError
from supple.fatigue import Residue, rainflow

reference = pytest.importorskip("rainflow")
EXAMPLE = [-2, 1, -3, 5, -1, 3, -4, 4, -2]


def table(cycles, channel=None):
    """Counts by range and mean."""
    found = Counter()
    for stated, mean, count, number in zip(
        cycles.ranges, cycles.means, cycles.counts, cycles.channels, strict=True
    ):
        if channel is None or number == channel:
            found[stated, mean] += count
    return found


def reference_table(history):
    found = Counter()
    for stated, mean, count, *_ in reference.extract_cycles(history):
        if stated:  # a constant history has no cycle
            found[stated, mean] += count
    return found


def test_example_of_the_standard():
    """ASTM E1049-85, figure 6."""
    by_range = Counter()
    for (stated, _), count in table(rainflow(EXAMPLE)).items():
        by_range[stated] += count
    assert by_range == {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}


@pytest.mark.parametrize("levels", [2, 3, 7, 1000])
def test_against_the_package_rainflow(levels):
    """Of few levels, so that equal ranges and plateaus are met; every count, range and mean is the same."""
    random = np.random.default_rng(levels)
    for n in (1, 3, 7, 30, 400):
        history = random.integers(0, levels, n).astype(float)
        assert table(rainflow(history)) == reference_table(history)


def test_two_samples_are_half_a_cycle():
    """The package `rainflow` (3.2.0) drops them."""
    assert table(rainflow([1.0, 4.0])) == {(3.0, 2.5): 0.5}


def test_a_nest_of_cycles_is_counted_on_the_stack():
    """One cycle closes at a time: most of them are left to the stack."""
    k = np.arange(2000)
    history = np.where(k % 2, 1.0, -1.0) * np.abs(k - 1000.25)
    assert table(rainflow(history)) == reference_table(history)


def test_channels_are_counted_on_their_own(monkeypatch):
    """In one line, in groups, and each alone."""
    random = np.random.default_rng(4)
    histories = random.integers(0, 9, (120, 3, 2)).astype(float)
    histories[:, 1, 0] = 5.0  # constant: no cycle, and no join of its neighbours
    together = rainflow(histories)
    assert together.shape == (3, 2)
    monkeypatch.setattr("supple.fatigue.cycle_count._GROUP", 240)
    for cycles in (together, rainflow(histories)):
        for number in range(6):
            assert table(cycles, number) == reference_table(histories.reshape(120, 6)[:, number])
    assert together.total(np.ones(len(together.ranges)))[1, 0] == 0


def test_a_closed_residue_is_the_count_of_the_repeated_history():
    """ASTM E1049-85, 5.4.5: from its highest peak on, all of a repeating history is whole cycles."""
    random = np.random.default_rng(5)
    for _ in range(40):
        history = random.integers(0, 12, 40).astype(float)
        turned = np.roll(history, -int(history.argmax()))
        from_peak = rainflow(np.append(turned, turned[0]))
        closed = rainflow(history, Residue.CLOSED)
        assert (closed.counts == 1).all()
        assert closed.ranges.max() == history.max() - history.min()
        assert closed.total(closed.ranges**3) == pytest.approx(
            from_peak.total(from_peak.ranges**3), rel=1e-12
        )


def test_one_sine_has_its_cycles():
    history = np.sin(np.linspace(0, 20 * np.pi, 4001))
    cycles = rainflow(history)
    assert cycles.total(cycles.ranges > 1.9) == pytest.approx(9.5)  # two quarters at its ends are smaller
    assert cycles.counts.sum() == pytest.approx(10.5)


@pytest.mark.parametrize("history", [[0.0, np.nan, 1.0], [np.inf], np.zeros((0, 3)), np.zeros((5, 0)), 1.0])
def test_what_cannot_be_counted_is_refused(history):
    with pytest.raises(ModelError):
        rainflow(history)


def test_a_rule_is_no_word():
    with pytest.raises(ArgumentError):
        rainflow(EXAMPLE, "closed")
