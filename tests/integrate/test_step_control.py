"""Options of a run refuse what makes no sense."""

from __future__ import annotations

import pytest

from supple.integrate import AdaptiveStep, FixedStep, Tolerances


def test_fixed_step_never_grows_nor_judges_the_error():
    step = FixedStep(1e-3)
    assert (step.first, step.largest, step.tolerance) == (1e-3, 1e-3, float("inf"))


@pytest.mark.parametrize("size", [0.0, -1e-3, float("nan"), float("inf")])
def test_fixed_step_must_be_positive(size):
    with pytest.raises(ValueError, match="size must be a positive, finite number, got"):
        FixedStep(size)


@pytest.mark.parametrize("name", ["first", "largest", "tolerance", "smallest"])
def test_adaptive_step_must_be_positive(name):
    with pytest.raises(ValueError, match=f"{name} must be a positive, finite number, got 0.0"):
        AdaptiveStep(**{name: 0.0})


def test_first_adaptive_step_must_not_exceed_the_largest():
    with pytest.raises(ValueError, match=r"the first step \(0.1\) exceeds the largest \(0.01\)"):
        AdaptiveStep(first=0.1, largest=0.01)


def test_smallest_step_must_not_exceed_the_first():
    with pytest.raises(ValueError, match=r"the smallest step \(1e-09\) exceeds the first \(1e-10\)"):
        FixedStep(1e-10, smallest=1e-9)
    with pytest.raises(ValueError, match=r"the smallest step \(0.001\) exceeds the first \(1e-06\)"):
        AdaptiveStep(smallest=1e-3)


@pytest.mark.parametrize("residual", [0.0, -1e-6, float("nan")])
def test_residual_tolerance_must_be_positive(residual):
    with pytest.raises(ValueError, match="residual must be a positive, finite number, got"):
        Tolerances(residual=residual)


def test_at_least_one_iteration():
    with pytest.raises(ValueError, match="max_iterations must be at least 1, got 0"):
        Tolerances(max_iterations=0)
