"""Choosing the modes of a Craig-Bampton basis."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.reduction import (
    CouplingMoment,
    CraigBampton,
    EffectiveInterfaceMass,
    LowestFrequency,
    fixed_interface_component,
    fixed_interface_modes,
)


def test_lowest_frequency_is_the_default(strip_body, frame):
    default = CraigBampton(n_modes=3).build(strip_body, frame)
    chosen = CraigBampton(n_modes=3, selection=LowestFrequency()).build(strip_body, frame)
    np.testing.assert_array_equal(default.vectors, chosen.vectors)
    assert default.labels == chosen.labels


@pytest.mark.parametrize("rule", [EffectiveInterfaceMass(30), CouplingMoment(30)])
def test_best_modes_are_kept_in_ascending_order_under_their_own_numbers(strip_body, frame, rule):
    candidates = fixed_interface_modes(strip_body, 30)
    scores = rule.scores(strip_body, fixed_interface_component(strip_body, candidates))
    basis = CraigBampton(n_modes=5, selection=rule).build(strip_body, frame)
    numbers = [int(label.removeprefix("fixed-interface mode ")) for label in basis.labels[6:]]
    assert numbers == sorted(numbers)
    assert numbers != [1, 2, 3, 4, 5]
    assert min(scores[i - 1] for i in numbers) >= max(np.delete(scores, np.array(numbers) - 1))
    np.testing.assert_allclose(basis.frequencies[6:] ** 2, candidates.values[np.array(numbers) - 1])


def test_more_modes_than_candidates_are_refused(strip_body, frame):
    with pytest.raises(ModelError, match="12 modes cannot be chosen among 10 candidates"):
        CraigBampton(n_modes=12, selection=EffectiveInterfaceMass(10)).build(strip_body, frame)


def test_more_candidates_than_modes_are_refused(solid_body, frame):
    with pytest.raises(ModelError, match="n_modes = 80, but body 'block' has 54 modes"):
        CraigBampton(n_modes=2, selection=CouplingMoment(80)).build(solid_body, frame)
