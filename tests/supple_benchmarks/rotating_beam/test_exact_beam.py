"""The exact beam's tip is converged over the whole history, and says how far."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.errors import ConvergenceError
from supple.machine.laws.spin_up import SpinUp
from supple_benchmarks.beam_motion import spin_up_beam
from supple_benchmarks.planar_beam import ROTATING_BEAM
from supple_benchmarks.rotating_beam import exact_beam
from supple_benchmarks.rotating_beam.exact_beam import CONVERGED, exact_tip
from supple_benchmarks.rotating_beam.problem import RotatingBeam
from supple_benchmarks.rotating_beam.tip_motion import TipMotion, apart

PROBLEM = RotatingBeam(duration=2.0)
SPIN = SpinUp(12.0, rise_time=8.0)


@pytest.mark.slow
def test_the_tip_is_within_its_tolerance_of_a_far_finer_one():
    """More elements and a step that needs no extrapolation, at every instant."""
    found = exact_tip(PROBLEM, SPIN)
    assert found.converged_within <= CONVERGED
    step, n = 0.02 / 32, 24
    motion = spin_up_beam(ROTATING_BEAM, SPIN, duration=PROBLEM.duration, step=step, n_elements=n)
    fine = TipMotion(motion.times[::32], motion.tip_axial[::32], motion.tip_transverse[::32])
    np.testing.assert_allclose(found.times, fine.times, atol=1e-12)
    own = apart(found.at_the_models_step, found).max()
    # The finer one's own error in time, of second order.
    assert apart(found, fine).max() <= CONVERGED + own * (step / PROBLEM.step) ** 2
    assert own > CONVERGED


def test_apart_is_taken_over_what_both_have_reached():
    one = TipMotion(np.arange(4.0), np.zeros(4), np.array([0.0, -1.0, -2.0, -3.0]))
    other = TipMotion(np.arange(3.0), np.array([0.0, 0.0, 3.0]), np.array([0.0, -1.0, 2.0]))
    np.testing.assert_array_equal(apart(one, other), [0, 0, 5])


def test_a_beam_that_does_not_converge_says_so(monkeypatch):
    monkeypatch.setattr(exact_beam, "CONVERGED", 1e-15)
    with pytest.raises(ConvergenceError, match=r"exact beam at 12 rad/s: .* start from a smaller step"):
        exact_tip(replace(PROBLEM, duration=0.1), SPIN)
