"""Limits of the kinematics are seen, said with the number, and held when strict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame
from supple.errors import ValidityError, ValidityWarning
from supple.integrate import FloatingMotion, Run, Solution, Statistics, Validity
from supple.machine import Placed, System
from supple.multibody.checks.validity import Peaks, watch
from supple.simulation import simulate


def still(body, spin=0.0, coordinates=None):
    """Three instants of a body that spins about z and is deformed in the second one."""
    zero, shape = np.zeros((3, 3)), np.zeros((3, body.n_coordinates))
    if coordinates is not None:
        shape[1] = coordinates
    motion = FloatingMotion(
        zero,
        np.tile(np.eye(3), (3, 1, 1)),
        shape,
        zero,
        np.outer([0, 1, 0.5], [0, 0, spin]),
        0 * shape,
        zero,
        zero,
        0 * shape,
    )
    return Solution(np.array([0.0, 1.0, 2.0]), {body.name: motion}, {}, Statistics())


@pytest.fixture(scope="module")
def linear(floating_blade):
    return replace(floating_blade, cubic=None, quartic=None)


def messages(body, solution, validity=None):
    limits = watch(System((Placed(body),)), validity or Validity())
    return [excess.message for excess in limits.excesses(limits.observe({}, solution))]


def test_linear_body_that_spins_near_its_lowest_frequency(linear):
    lowest = linear.frequencies[0]
    (message,) = messages(linear, still(linear, spin=0.4 * lowest))
    assert message.startswith(
        f"body 'blade' is linear and spins at {0.4 * lowest:.4g} rad per unit of time (t = 1), "
        "0.40 times its lowest frequency"
    )
    assert messages(linear, still(linear, spin=0.2 * lowest)) == []


def test_nonlinear_body_may_spin(floating_blade):
    assert messages(floating_blade, still(floating_blade, spin=1e3)) == []


def test_spin_ratio_is_the_users(linear):
    spinning = still(linear, spin=0.2 * linear.frequencies[0])
    assert messages(linear, spinning, Validity(spin_ratio=0.5)) == []
    assert len(messages(linear, spinning, Validity(spin_ratio=0.1))) == 1


def test_linear_full_body_is_held_to_its_own_lowest_frequency(blade, linear):
    """Found by an eigensolution in its frame, as it has no reduced modes."""
    full = FullBody(blade.linearized(), MeanAxisFrame())
    lowest = linear.frequencies[0]
    assert len(messages(full, still(full, spin=0.31 * lowest))) == 1
    assert messages(full, still(full, spin=0.29 * lowest)) == []


def coordinates_that_turn(body, angle):
    """The first mode, as large as it takes to turn some point by the angle."""
    turns = np.linalg.norm(body.rotation_basis[:, :, 0], axis=1).max()
    return np.eye(body.r)[0] * angle / turns


def test_rotation_beyond_the_kinematics(floating_blade):
    too_far = still(floating_blade, coordinates=coordinates_that_turn(floating_blade, 0.55))
    (message,) = messages(floating_blade, too_far)
    assert message.startswith(
        "body 'blade' turns by 0.550 rad against its frame (t = 1); its kinematics hold to about 0.50 rad."
    )
    fine = still(floating_blade, coordinates=coordinates_that_turn(floating_blade, 0.45))
    assert messages(floating_blade, fine) == []


def test_body_without_known_rotations_is_not_judged_by_them(floating_blade):
    silent = replace(floating_blade, rotation_basis=None)
    assert messages(silent, still(silent, coordinates=coordinates_that_turn(floating_blade, 1.0))) == []


def test_strict_stops_at_once(linear):
    limits = watch(System((Placed(linear),)), Validity(strict=True))
    with pytest.raises(ValidityError, match="body 'blade' is linear and spins at"):
        limits.observe({}, still(linear, spin=linear.frequencies[0]))


def test_otherwise_a_warning_at_the_end(linear):
    limits = watch(System((Placed(linear),)), Validity())
    peaks = limits.observe({}, still(linear, spin=linear.frequencies[0]))
    with pytest.warns(ValidityWarning, match="body 'blade' is linear and spins at"):
        limits.report(peaks)


def test_a_run_watches_from_its_first_instant(linear):
    """The initial state alone breaks the limit; strict, so nothing is simulated."""
    fast = System((Placed(linear, angular_velocity=[0, 0, 50.0]),))
    with pytest.raises(ValidityError, match=r"spins at 50 rad per unit of time \(t = 0\)"):
        simulate(fast, Run(duration=1.0, output_step=0.1, validity=Validity(strict=True)))


def test_peaks_keep_the_larger_with_its_time():
    merged = Peaks(1.0, 0.1, 0.2, 0.3).merged(Peaks(2.0, 1.1, 0.1, 1.3))
    assert merged == Peaks(2.0, 1.1, 0.2, 0.3)


@pytest.mark.parametrize("ratio", [0.0, -1.0, float("nan"), float("inf")])
def test_spin_ratio_must_be_positive(ratio):
    with pytest.raises(ValueError, match="spin_ratio must be positive, got"):
        Validity(spin_ratio=ratio)
