"""Limits of the kinematics are seen, said with the number, and held when strict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import AveragingInterface, FullBody, MeanAxisFrame, NodalFixedFrame, flexible_body
from supple.equations.checks.validity import Peaks, watch
from supple.errors import ValidityError, ValidityWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FloatingMotion, Run, Solution, Statistics, Validity
from supple.machine import GROUND, At, Ball, Fixed, Placed, System
from supple.mesh import box_beam
from supple.reduction import CompressedDerivatives, CraigBampton, NoLoads, Rubin, reduce, reduction_basis
from supple.reduction.condensed_inertia import missing_centrifugal_stiffness
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


def messages(body, solution, validity=None, joints=()):
    limits = watch(System((Placed(body),), joints), validity or Validity())
    return limits.excesses(limits.observe({}, solution))


def test_linear_body_that_spins_near_its_lowest_frequency(linear):
    lowest = linear.frequencies[0]
    (message,) = messages(linear, still(linear, spin=0.4 * lowest))
    assert message.startswith(
        f"body 'blade' is linear and rotates at {0.4 * lowest:.4g} rad per unit of time (t = 1), "
        "0.40 times its lowest frequency"
    )
    assert messages(linear, still(linear, spin=0.2 * lowest)) == []


def test_nonlinear_body_may_spin(blade):
    body = reduce(
        blade, MeanAxisFrame(), Rubin(n_columns=14), derivatives=CompressedDerivatives(2), loads=NoLoads
    )
    assert messages(body, still(body, spin=1e3)) == []


def test_condensed_body_without_inertia_of_what_it_condensed_may_not(floating_blade):
    """No static shapes in mean axes: the largest share of stiffness missing is told by its own number."""
    flying_apart = missing_centrifugal_stiffness(floating_blade)[2] ** -0.5
    assert messages(floating_blade, still(floating_blade, spin=0.29 * flying_apart)) == []
    (message,) = messages(floating_blade, still(floating_blade, spin=0.4 * flying_apart))
    assert "up to 16 % of the stiffness are missing" in message
    assert message.endswith("or add derivatives"), "it is in mean axes already"
    about_itself = replace(
        still(floating_blade).bodies["blade"], angular_velocity=np.tile([0.4 * flying_apart, 0, 0], (3, 1))
    )
    solution = Solution(np.array([0.0, 1.0, 2.0]), {"blade": about_itself}, {}, Statistics())
    assert messages(floating_blade, solution) == []


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
        "body 'blade' rotates by 0.550 rad relative to its frame (t = 1); "
        "its kinematics hold to about 0.50 rad."
    )
    assert "mean-axis frame" not in message, "it has one"
    assert "Split the body (split = { parts = 2 } in a case file, split_body in Python)" in message
    assert "condense a slender body" in message
    on_its_root = replace(floating_blade, frame=NodalFixedFrame("root"))
    (message,) = messages(on_its_root, too_far)
    assert "Choose a mean-axis frame, or split the body" in message
    fine = still(floating_blade, coordinates=coordinates_that_turn(floating_blade, 0.45))
    assert messages(floating_blade, fine) == []


def test_body_without_known_rotations_is_not_judged_by_them(floating_blade):
    silent = replace(floating_blade, rotation_basis=None)
    assert messages(silent, still(silent, coordinates=coordinates_that_turn(floating_blade, 1.0))) == []


def test_strict_stops_at_once(linear):
    limits = watch(System((Placed(linear),)), Validity(strict=True))
    with pytest.raises(ValidityError, match="body 'blade' is linear and rotates at"):
        limits.observe({}, still(linear, spin=linear.frequencies[0]))


def test_otherwise_a_warning_at_the_end(linear):
    limits = watch(System((Placed(linear),)), Validity())
    peaks = limits.observe({}, still(linear, spin=linear.frequencies[0]))
    with pytest.warns(ValidityWarning, match="body 'blade' is linear and rotates at"):
        limits.report(peaks)


def test_a_run_watches_from_its_first_instant(linear):
    """The initial state alone breaks the limit; strict, so nothing is simulated."""
    fast = System((Placed(linear, angular_velocity=[0, 0, 50.0]),))
    with pytest.raises(ValidityError, match=r"rotates at 50 rad per unit of time \(t = 0\)"):
        simulate(fast, Run(duration=1.0, output_step=0.1, validity=Validity(strict=True)))


def test_peaks_keep_the_larger_with_its_time():
    merged = Peaks(1.0, 0.1, 0.2, 0.3).merged(Peaks(2.0, 1.1, 0.1, 1.3))
    assert merged == Peaks(2.0, 1.1, 0.2, 0.3)


@pytest.mark.parametrize("ratio", [0.0, -1.0, float("nan"), float("inf")])
def test_spin_ratio_must_be_positive(ratio):
    with pytest.raises(ValueError, match="spin_ratio must be positive, got"):
        Validity(spin_ratio=ratio)


def test_a_soft_section_that_has_turned_with_its_averaging_interface():
    """From 6 phi^2 c / C of one per cent, of reduced and of full bodies."""
    ends = [AveragingInterface("root", "root"), AveragingInterface("tip", "tip")]
    model = shell_model(
        box_beam(10.0, 1.0, 0.5, 4, 2, 1), HomogeneousSection(Isotropic(7e10, 0.3, 2700.0), 0.04)
    )
    box = flexible_body("box", model, ends)
    frame = NodalFixedFrame("root")
    body = reduce(box, frame, CraigBampton(n_modes=2), derivatives=CompressedDerivatives(2), loads=NoLoads)
    tip = body.interfaces[1]
    assert tip.softness[1] > 0.5
    gamma = np.zeros(body.r)
    gamma[0] = 1.0
    turned = tip.motion[3:, 0]
    share = 6 * (turned**2) @ tip.softness
    welded = Fixed(name="weld", first=GROUND, second=At("box", "tip"))
    for allowed, count in ((0.009, 0), (0.011, 1)):
        size = np.sqrt(allowed / share)
        assert len(messages(body, still(body, coordinates=size * gamma), joints=[welded])) == count
    turned = still(body, coordinates=size * gamma)
    (message,) = messages(body, turned, joints=[welded])
    # A ball joint carries no moment.
    assert messages(body, turned, joints=[Ball(name="ball", first=GROUND, second=At("box", "tip"))]) == []
    assert "averaging interface" in message
    assert "off by some 1.1 %" in message
    full = FullBody(box, frame)
    q = reduction_basis(box, frame, CraigBampton(n_modes=2), derivatives=CompressedDerivatives(2)).vectors[
        :, 0
    ]
    assert messages(full, still(full, coordinates=size * q), joints=[welded]) == [message]
