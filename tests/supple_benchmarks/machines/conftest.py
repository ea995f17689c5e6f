"""Machines shared by the tests of the benchmarks; every compiled system costs seconds."""

from __future__ import annotations

import pytest

from supple_benchmarks.machines.quadruple_pendulum import QuadruplePendulum
from supple_benchmarks.machines.slider_crank import SliderCrank


@pytest.fixture(scope="session")
def pendulum():
    return QuadruplePendulum.quick().machine()


@pytest.fixture(scope="session")
def slider_crank():
    return SliderCrank.quick().machine()
