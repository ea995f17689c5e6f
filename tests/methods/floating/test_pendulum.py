"""The physical pendulum, known in closed form at any swing: accuracy, steps, tolerances, and how runs go."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from supple.body import RigidBody
from supple.errors import StepCutWarning
from supple.integrate import AdaptiveStep, FixedStep, Run, Tolerances
from supple.machine import GROUND, At, Placed, Revolute, System
from supple.machine.joints.joint import axes_along
from supple.simulation import simulate

MASS, ARM, INERTIA, GRAVITY = 2.0, 0.8, 0.15, 9.81
SWING = 2.0  # rad
OMEGA_SQUARED = MASS * GRAVITY * ARM / (INERTIA + MASS * ARM**2)


def exact_angle(t):
    """sin(theta / 2) = k sn(K - omega t), k = sin(swing / 2): released at rest."""
    k = np.sin(SWING / 2)
    sn, _, _, _ = ellipj(ellipk(k**2) - np.sqrt(OMEGA_SQUARED) * t, k**2)
    return 2 * np.arcsin(k * sn)


def exact_rate_squared(angle):
    """Energy: (I + m l^2) thetadot^2 / 2 = m g l (cos theta - cos swing)."""
    return 2 * OMEGA_SQUARED * (np.cos(angle) - np.cos(SWING))


def hanging(turned, angle):
    """Frame at the centre of mass, hinge above it along the body's z; the angle is about global x."""
    bob = RigidBody("bob", MASS, [0, 0, 0], np.diag([INERTIA, 0.2, 0.25]), {"hinge": [0, 0, ARM]})
    rotation = turned(0, angle)
    placed = Placed(bob, position=-rotation @ [0, 0, ARM], rotation=rotation)
    hinge = Revolute(first=GROUND, second=At("bob", "hinge"), axis=(1, 0, 0), name="hinge")
    return System((placed,), (hinge,), gravity=(0, 0, -GRAVITY))


@pytest.fixture(scope="module")
def pendulum(turned):
    return hanging(turned, SWING)


def angle_error(solution):
    """Largest error of the angle at the output times."""
    rotation = solution.bodies["bob"].rotation
    angle = np.arctan2(rotation[:, 2, 1], rotation[:, 1, 1])
    return np.abs(angle - exact_angle(solution.times)).max()


def run(system, h=0.01, duration=2.0, output_step=0.1, step=None, tolerances=Tolerances()):  # noqa: B008
    return simulate(system, Run(duration, output_step, step=step or FixedStep(h), tolerances=tolerances))


def test_swing_follows_the_elliptic_integral_at_order_two(pendulum):
    errors = np.array([angle_error(run(pendulum, h)) for h in (0.01, 0.005, 0.0025)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.03)


def test_period(pendulum):
    """Back at rest at the same height after 4 K(k) / omega."""
    period = 4 * ellipk(np.sin(SWING / 2) ** 2) / np.sqrt(OMEGA_SQUARED)
    solution = run(pendulum, 1e-3, duration=period, output_step=period / 20)
    np.testing.assert_allclose(
        solution.bodies["bob"].position[-1], solution.bodies["bob"].position[0], atol=1e-4
    )


def test_hinge_carries_weight_and_centripetal_force(pendulum):
    """Along the arm: m g cos(theta) + m l thetadot^2, upwards on the bob, so downwards on the ground."""
    solution = run(pendulum, 1e-3)
    angle = exact_angle(solution.times)
    along = MASS * GRAVITY * np.cos(angle) + MASS * ARM * exact_rate_squared(angle)
    up = solution.bodies["bob"].rotation[:, :, 2]
    joint_axes = axes_along((1, 0, 0))
    on_ground = solution.multipliers["hinge"][:, :3] @ joint_axes.T
    np.testing.assert_allclose(-np.einsum("ti,ti->t", on_ground, up), along, atol=1e-3 * along.max())


def test_hinge_stays_closed_over_thousands_of_steps(pendulum):
    solution = run(pendulum, 5e-3, duration=20.0, output_step=0.4)
    assert solution.statistics.steps == 4000
    motion = solution.bodies["bob"]
    hinge = motion.position + ARM * motion.rotation[:, :, 2]
    assert np.abs(hinge).max() < 1e-12
    assert np.abs(motion.rotation[:, 1:, 0]).max() < 1e-12


@pytest.mark.slow
def test_tighter_tolerances_never_hurt(pendulum):
    """The discretisation error is the same for all; what tolerances add to it only falls."""
    reference = run(pendulum, tolerances=Tolerances(residual=1e-13)).bodies["bob"].position
    distances = []
    for residual in (1e-3, 1e-5, 1e-7, 1e-9, 1e-11):
        solution = run(pendulum, tolerances=Tolerances(residual=residual))
        assert solution.statistics.rejected_steps == 0
        distances.append(np.abs(solution.bodies["bob"].position - reference).max())
    assert distances[0] < 1e-2
    assert all(b <= max(a, 1e-12) for a, b in pairwise(distances))
    assert distances[-1] < 1e-10


@pytest.mark.parametrize("residual", [1e-6, 1e-12])
def test_small_steps_stay_accurate(pendulum, residual):
    """Index 3: a careless scaling loses digits like 1/h^2; the error here keeps falling to 1e-5."""
    errors = [
        angle_error(
            run(pendulum, h, duration=0.04, output_step=0.004, tolerances=Tolerances(residual=residual))
        )
        for h in (1e-3, 1e-4, 1e-5)
    ]
    assert errors[0] < 1e-7
    assert errors[1] < errors[0] / 50
    assert errors[2] < max(errors[1] / 10, 1e-12)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
def test_adaptive_step_meets_its_tolerance(pendulum, tolerance):
    """The sum of the local errors bounds the error here, where neighbouring motions stay close."""
    solution = run(pendulum, step=AdaptiveStep(largest=0.05, tolerance=tolerance))
    assert angle_error(solution) < tolerance * solution.statistics.steps


def test_adaptive_step_takes_more_steps_for_less_error(pendulum):
    """A local error of third order: a hundredth of the tolerance costs 100^(1/3) = 4.6 times the steps."""
    coarse, fine = (
        run(pendulum, step=AdaptiveStep(largest=0.1, tolerance=t), output_step=2.0) for t in (1e-5, 1e-7)
    )
    ratio = fine.statistics.steps / coarse.statistics.steps
    assert 3.5 < ratio < 6.0


def test_adaptive_step_rarely_tries_in_vain(pendulum):
    """Steps that grow only when it is worth it do not chase the spurious roots that a change excites."""
    statistics = run(pendulum, step=AdaptiveStep(largest=0.1, tolerance=1e-6)).statistics
    assert statistics.rejected_steps < 0.05 * statistics.steps


@pytest.mark.filterwarnings("ignore::supple.errors.ResolutionWarning")  # of steps as long as these
def test_a_cut_step_is_reported_and_the_answer_right(pendulum):
    """Half a second a step is too much for four iterations: halved until it converges, and said so."""
    with pytest.warns(StepCutWarning, match=r"steps did not converge and were cut .* a fixed step below 0.5"):
        solution = run(
            pendulum,
            0.5,
            duration=2.0,
            output_step=0.5,
            tolerances=Tolerances(residual=1e-9, max_iterations=4),
        )
    assert solution.statistics.rejected_steps > 0
    hinge = solution.bodies["bob"].position + ARM * solution.bodies["bob"].rotation[:, :, 2]
    assert np.abs(hinge).max() < 1e-9


@pytest.mark.parametrize("h", [1e-2, 1e-4])
def test_place_in_space_does_not_matter(pendulum, h):
    """Ten thousand arm lengths from the origin: positions have fewer digits, which must not cut steps."""
    placed = pendulum.bodies[0]
    far = replace(pendulum, bodies=(replace(placed, position=placed.position + np.array([3e3, 7e3, 1e3])),))
    solution = run(far, h, duration=0.2, output_step=0.02, tolerances=Tolerances(residual=1e-9))
    near = run(pendulum, h, duration=0.2, output_step=0.02, tolerances=Tolerances(residual=1e-9))
    assert solution.statistics.rejected_steps == 0
    np.testing.assert_allclose(solution.bodies["bob"].rotation, near.bodies["bob"].rotation, atol=1e-9)
