"""Modal damping of full bodies: decay of single modes, and the reduced body with all coordinates."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body

from supple.algebra import lowest_modes
from supple.body import FullBody, MeanAxisFrame, ModalDamping, NodalFixedFrame
from supple.errors import ModelError
from supple.integrate import FixedStep, Newmark, Run, Tolerances
from supple.machine import GROUND, At, Ball, Fixed, Placed, System
from supple.methods.floating.full.full_damping import full_damping
from supple.reduction import CompleteBasis, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate


@pytest.fixture(scope="module")
def small():
    return beam_body("root", n=2, length=4.0)


def test_each_mode_decays_at_its_own_rate_and_no_other_does(small):
    """q = exp(-zeta omega t) (cos + zeta / sqrt(1 - zeta^2) sin) of the damped frequency; mode 4 is free."""
    frame = NodalFixedFrame("root")
    body = small.linearized()
    modes = lowest_modes(body.stiffness, body.mass, 4, constraint=frame.constraint(body))
    ratios = np.array([0.02, 0.1, 0.3])
    full = FullBody(body, frame, ModalDamping(ratios, n_modes=3))
    period = 2 * np.pi / np.sqrt(modes.values[0])
    placed = Placed(full, coordinates=1e-4 * modes.vectors.sum(axis=1))
    held = Fixed(name="clamp", first=GROUND, second=At("beams", "root"))
    step = period / 200
    run = Run(
        duration=step * 100,
        output_step=step,
        step=FixedStep(step),
        tolerances=Tolerances(1e-10),
        method=Newmark(),
    )
    solution = simulate(System((placed,), (held,)), run)
    found = solution.bodies["beams"].coordinates @ (body.mass @ modes.vectors) / 1e-4
    for q, square, ratio in zip(found.T, modes.values, [*ratios, 0.0], strict=True):
        omega, root = np.sqrt(square), np.sqrt(1 - ratio**2)
        # The trapezoidal rule turns by 2 arctan(omega h / 2) a step.
        turned = 2 * np.arctan(omega * step / 2) / step * solution.times
        expected = np.exp(-ratio * turned) * (np.cos(root * turned) + ratio / root * np.sin(root * turned))
        np.testing.assert_allclose(q, expected, atol=0.01)


@pytest.mark.slow
def test_the_reduced_body_with_all_coordinates_moves_the_same(small):
    """A swing through space, bent far: the constant matrix acts against the same frame in both."""
    frame = MeanAxisFrame()
    damping = ModalDamping(np.array([0.05, 0.1, 0.2]), n_modes=8)
    hinge = Ball(first=GROUND, second=At("beams", "root"))
    run = Run(duration=0.1, output_step=0.02, step=FixedStep(0.0025), tolerances=Tolerances(1e-9))

    def swing(body):
        placed = Placed(body, angular_velocity=np.array([2.0, -30.0, 8.0]))
        solution = simulate(System((placed,), (hinge,), gravity=np.array([0, 0, -9.81])), run)
        return body.positions(solution.bodies["beams"])

    full = swing(FullBody(small, frame, damping))
    reduced, undamped = (
        swing(reduce(small, frame, CompleteBasis(), derivatives=NoDerivatives(), damping=each, loads=NoLoads))
        for each in (damping, None)
    )
    assert np.abs(full - reduced).max() < 1e-3 * np.abs(full - undamped).max()


def test_its_power_is_that_of_the_modes(small):
    """q_dot^T C q_dot = sum 2 zeta omega (phi^T M q_dot)^2; none beyond the modes damped."""
    frame = NodalFixedFrame("root")
    full = FullBody(small, frame, ModalDamping(0.1, n_modes=2))
    modes = lowest_modes(small.stiffness, small.mass, 3, constraint=frame.constraint(small))
    rates = modes.vectors @ [1.0, 2.0, 3.0]
    force = full_damping(full).force(rates)
    omega = np.sqrt(modes.values)
    assert rates @ force == pytest.approx(0.2 * (omega[0] + 4 * omega[1]))


def test_a_full_body_needs_the_number_of_its_damped_modes(small):
    full = FullBody(small, NodalFixedFrame("root"), ModalDamping(0.02))
    with pytest.raises(ModelError, match=r"the number of damped modes, for example ModalDamping"):
        full_damping(full)
