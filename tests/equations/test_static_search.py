"""The search for an equilibrium on a machine of one freedom: followed up in steps where it is far off."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from supple.equations.configuration import Configuration
from supple.equations.static_search import (
    EquilibriumResidual,
    StaticSearch,
    StaticState,
    StaticStep,
    search_equilibrium,
)
from supple.errors import ConvergenceError


@dataclass(frozen=True)
class Narrow:
    """`x = spin + load`, where Newton's method goes astray that begins farther off than `reach`."""

    reach: float
    spin: float = 0.6
    load: float = 0.8
    held: float = 0.0

    position_scale = np.ones(1)

    def residual(self, state, _time):
        return state.configuration.coordinates - self.spin - self.load - self.held

    def unbalance(self, state, time):
        left = self.residual(state, time)
        return EquilibriumResidual(np.array([0.0, 0.0, abs(left[0])]), 0.0, left)

    def correction(self, _state, _time, unbalance, k):
        (left,) = unbalance.terms
        step = -left * k / (1 + k)
        return StaticStep(np.array([step if abs(left) < self.reach else -step]), np.zeros(0))

    def moved(self, configuration, increment):
        return configuration._replace(coordinates=configuration.coordinates + increment)

    def at_rest(self):
        return replace(self, spin=0.0)

    def eased(self, share, held):
        return replace(self, spin=share * self.spin, held=float(held[0]))


START = StaticState(Configuration(np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(1)), np.zeros(0))


def test_load_and_spin_are_followed_up_where_the_direct_search_is_lost():
    told = []
    found, iterations = search_equilibrium(
        Narrow(reach=0.4), START, 0.0, StaticSearch(), lambda number, _: told.append(number)
    )
    assert found.configuration.coordinates == pytest.approx([1.4], rel=1e-9)
    assert 60 <= iterations <= 200
    assert told == sorted(told)


def test_a_search_that_came_part_of_the_way_says_how_far():
    with pytest.raises(ConvergenceError, match="Load and rotation, increased in steps, reached 0 of"):
        search_equilibrium(Narrow(reach=1e-9), START, 0.0, StaticSearch())
