"""Reduced bodies in motion: conservation, joints, steady spin, stiffening and its lack."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import NodalFixedFrame, RigidInterface, flexible_body
from supple.equations.checks.energy import balances
from supple.errors import ValidityWarning
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, Newmark, Run, Tolerances
from supple.machine import GROUND, At, Ball, Placed, PrescribedRotation, Revolute, System
from supple.mesh import CellType, block
from supple.reduction import CompleteBasis, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate

TIGHT = Tolerances(residual=1e-11)


@pytest.fixture(scope="module")
def tumbling(floating_blade):
    """A free strip, set bending while it tumbles."""
    rates = np.array([0.3, 0.2, 0, 0, 0, 0]) * np.sqrt(floating_blade.gram[0, 0])
    placed = Placed(
        floating_blade, velocity=[0.3, -0.2, 0.1], angular_velocity=[1.0, 1.5, 2.0], coordinate_rates=rates
    )
    return System((placed,))


@pytest.mark.slow
def test_free_body_keeps_energy_and_momenta_at_order_two(tumbling):
    """The trapezoidal rule takes nothing on purpose; the frame's origin is at no special point."""

    def drifts(h):
        solution = simulate(
            tumbling,
            Run(duration=1.0, output_step=0.02, step=FixedStep(h), method=Newmark(), tolerances=TIGHT),
        )
        kept = balances(tumbling, solution)
        assert np.ptp(kept.strain) > 0.02 * kept.total[0]
        return np.array(
            [
                np.abs(values - values[0]).max() / np.abs(values).max()
                for values in (kept.total, kept.momentum, kept.angular_momentum)
            ]
        )

    coarse, fine = drifts(1e-4), drifts(5e-5)
    assert (fine < 1e-4).all()
    np.testing.assert_allclose(np.log2(coarse / fine), 2.0, atol=0.2)


@pytest.fixture(scope="module")
def chain(floating_blade, rod):
    """A flexible strip on a ball joint, with a light rod hinged to its tip, falling."""
    return System(
        bodies=(Placed(floating_blade), Placed(rod("rod", 0.5, mass=0.1), position=[1.25, 0, 0])),
        joints=(
            Ball(first=GROUND, second=At("blade", "root"), name="shoulder"),
            Revolute(first=At("blade", "tip"), second=At("rod", "left"), axis=(0, 1, 0), name="elbow"),
        ),
        gravity=(0, 0, -2.0),
    )


@pytest.fixture(scope="module")
def fall(chain):
    return simulate(chain, Run(duration=2.0, output_step=0.05, step=FixedStep(1e-3), tolerances=TIGHT))


def test_joints_of_a_flexible_body_stay_closed_over_thousands_of_steps(fall, floating_blade):
    assert fall.statistics.steps == 2000
    blade, rod = fall.bodies["blade"], fall.bodies["rod"]

    def interface(name):
        own = floating_blade.interface(name)
        local = own.position + blade.coordinates @ own.motion[:3].T
        return blade.position + np.einsum("tij,tj->ti", blade.rotation, local)

    assert np.abs(interface("root")).max() < 1e-11
    left = rod.position - 0.25 * rod.rotation[:, :, 0]
    assert np.abs(interface("tip") - left).max() < 1e-11
    assert np.abs(floating_blade.expand(blade.coordinates)).max() > 0.01


def test_falling_chain_keeps_its_energy(fall, chain):
    """The damping of the integrator takes high frequencies alone."""
    kept = balances(chain, fall)
    assert np.ptp(kept.total) < 1e-3 * np.ptp(kept.potential)


def spun(body, speed, duration):
    """The root turned up about z to a speed, within half of the duration and without a jump."""
    ramp = duration / 2

    def angle(t):
        s = jnp.minimum(t / ramp, 1.0)
        rise = s**2 / 2 + (jnp.cos(2 * jnp.pi * s) - 1) / (4 * jnp.pi**2)
        return speed * (ramp * rise + jnp.maximum(t - ramp, 0.0))

    motor = PrescribedRotation(first=GROUND, second=At(body.name, "root"), axis=(0, 0, 1), angle=angle)
    return System((Placed(body),), (motor,))


@pytest.mark.slow
def test_steady_spin_stretches_a_bar():
    """E u'' + rho w^2 (x + u) = 0, u(0) = 0, u'(L) = 0: u(L) = tan(k L)/k - L, k^2 = rho w^2 / E."""
    length, modulus, density, speed = 1.0, 1e7, 1000.0, 6.0
    model = solid_model(block(length, 0.1, 0.1, 4, 1, 1, CellType.HEXA8), Isotropic(modulus, 0.0, density))
    bar = flexible_body("bar", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))
    body = reduce(bar, NodalFixedFrame("root"), CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads)
    damped = replace(body, damping=15.0 * np.eye(body.r))
    solution = simulate(spun(damped, speed, 2.0), Run(duration=2.6, output_step=0.04, step=FixedStep(2e-3)))
    tip = solution.bodies["bar"].coordinates @ body.interface("tip").motion[:3].T
    k = np.sqrt(density * speed**2 / modulus)
    np.testing.assert_allclose(tip[-1], [np.tan(k * length) / k - length, 0, 0], rtol=5e-3, atol=1e-6)


SPEED = 20.0
"""rad/s: twice the first frequency of the clamped strip in its plane."""


@pytest.mark.filterwarnings("ignore::supple.errors.ResolutionWarning")  # it diverges
@pytest.mark.slow
def test_nonlinear_body_stiffens_where_the_linear_one_diverges(clamped_blade):
    """The same strip, basis and motion, with and without the quadratic and cubic forces."""

    def sway(body):
        solution = simulate(spun(body, SPEED, 2.0), Run(duration=2.0, output_step=0.04, step=FixedStep(2e-3)))
        return np.abs(body.expand(solution.bodies["blade"].coordinates)[:, :, 1]).max()

    with pytest.warns(
        ValidityWarning, match="up to 156 % of the stiffness are missing"
    ):  # 0.4 m with thirty columns
        assert sway(clamped_blade) < 0.2
    linear = replace(clamped_blade, cubic=None, quartic=None)
    with pytest.warns(ValidityWarning) as warned:
        assert sway(linear) > 10.0
    assert "body 'blade' is linear and rotates at 20" in str(warned[0].message)
