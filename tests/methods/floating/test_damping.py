"""Damping of moving bodies: by strain rate it is the same in every frame, and takes the energy it should."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    FullBody,
    LinearRayleighDamping,
    MeanAxisFrame,
    ModalDamping,
    NodalFixedFrame,
    RayleighDamping,
    flexible_body,
)
from supple.equations.checks.energy import balances
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, Newmark, Run, Tolerances
from supple.machine import GROUND, At, Ball, DeadForce, Fixed, Placed, System
from supple.mesh import CellType, block
from supple.simulation import simulate

FRAMES = (NodalFixedFrame("root"), MeanAxisFrame())
LENGTH = 2.0
BETA = 0.02
TIGHT = Tolerances(residual=1e-10)


@pytest.fixture(scope="module")
def bar():
    """A slender soft bar along x with averaging ends: Green-Lagrange strains do not know the frame."""
    model = solid_model(block(LENGTH, 0.1, 0.1, 4, 1, 1, CellType.HEXA8), Isotropic(1e7, 0.0, 1000.0))
    return flexible_body("bar", model, [AveragingInterface(name, name) for name in ("root", "tip")])


def swing(bar, frame, damping, h, duration=0.6):
    """The bar on a ball joint, falling, its tip pushed up: the tip's path."""
    full = FullBody(bar, frame, damping)
    push = DeadForce(body="bar", at=np.flatnonzero(bar.nodes[:, 0] == LENGTH), force=[0.0, 0.0, 40.0])
    pivot = Ball(first=GROUND, second=At("bar", "root"))
    system = System((Placed(full),), (pivot,), (push,), (0, 0, -9.81))
    run = Run(duration=duration, output_step=0.02, step=FixedStep(h), tolerances=TIGHT)
    return full.positions(simulate(system, run).bodies["bar"], push.nodes)[:, :, 2].mean(axis=1)


@pytest.mark.slow
def test_damping_by_strain_rate_does_not_know_the_frame(bar):
    """What is left are the integrator's different paths, of order h^2; beta K makes another machine of it."""

    def apart(damping, h):
        paths = [swing(bar, frame, damping, h) for frame in FRAMES]
        return np.abs(paths[0] - paths[1]).max()

    coarse, fine = (apart(RayleighDamping(0.0, BETA), h) for h in (0.01, 0.005))
    assert fine < 1e-3
    assert 3.0 < coarse / fine < 5.0
    assert apart(LinearRayleighDamping(0.0, BETA), 0.01) > 20 * coarse


def test_energy_is_lost_to_the_work_of_the_damping_force(bar):
    """E(0) - E(t) = int rates . D(q) rates dt of a free bar, by the trapezoidal rule in both."""
    full = FullBody(bar, FRAMES[1], RayleighDamping(0.0, BETA))
    bending = lowest_modes(bar.stiffness, bar.mass, 1, constraint=FRAMES[1].constraint(bar)).vectors[:, 0]
    rates = 12.0 * bending
    system = System((Placed(full, angular_velocity=[0.0, 0.0, 3.0], coordinate_rates=rates),))
    step = 1e-3
    run = Run(duration=0.1, output_step=step, step=FixedStep(step), method=Newmark(), tolerances=TIGHT)
    solution = simulate(system, run)
    motion = solution.bodies["bar"]
    power = np.array(
        [
            BETA * rate @ bar.assembly.strain_rate_force(q, rate)
            for q, rate in zip(motion.coordinates, motion.coordinate_rates, strict=True)
        ]
    )
    kept = balances(system, solution)
    lost = kept.total[0] - kept.total[-1]
    assert lost > 0.2 * kept.strain.max()
    np.testing.assert_allclose(step * (power[1:] + power[:-1]).sum() / 2, lost, rtol=5e-3)
    np.testing.assert_allclose(kept.angular_momentum[-1], kept.angular_momentum[0], rtol=1e-3, atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    "damping", [RayleighDamping(20.0, 0.0, held="root"), ModalDamping(0.2, n_modes=4, held="root")]
)
def test_damping_against_an_interface_does_not_know_the_frame(damping):
    """A beam held at its root, pushed at its tip: the same path, half a millimetre, in both frames."""
    body = beam_body("root", "tip", n=2, length=4.0).linearized()
    run = Run(duration=0.05, output_step=0.01, step=FixedStep(2e-3), tolerances=TIGHT)

    def path(frame, given):
        full = FullBody(body, frame, given)
        clamp = Fixed(name="clamp", first=GROUND, second=At("beams", "root"))
        push = DeadForce(body="beams", at="tip", force=[0.0, 300.0, 100.0])
        solution = simulate(System((Placed(full),), (clamp,), (push,)), run)
        # Across: along itself a linear body that turns against its frame grows by its square.
        return full.positions(solution.bodies["beams"], [2])[:, 0, 1:]

    held, floating = (path(frame, damping) for frame in FRAMES)
    size = np.abs(held).max()
    assert np.abs(path(FRAMES[0], None) - held).max() > 0.1 * size
    np.testing.assert_allclose(floating, held, atol=2e-4 * size)
