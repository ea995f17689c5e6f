"""The quadruple pendulum: its dimensions, the balance of forces and energy, a link as a compound pendulum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.equations import balances, joint_residuals
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import GROUND, At, Ball, Placed, System
from supple.mesh import CellType
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate
from supple_benchmarks.machines.quadruple_pendulum import (
    GRAVITY,
    LENGTH,
    RADIUS,
    TO_JOINT,
    QuadruplePendulum,
    rigid_link,
)


@pytest.fixture(scope="module")
def system(pendulum):
    basis = CraigBampton(n_modes=4)
    return pendulum.system(
        reduce(pendulum.body, pendulum.frame, basis, derivatives=NoDerivatives(), loads=NoLoads)
    )


@pytest.fixture(scope="module")
def fall(system):
    return simulate(
        system, Run(duration=0.3, output_step=0.002, step=FixedStep(0.001), tolerances=Tolerances(1e-10))
    )


def test_flexible_cylinder_has_the_papers_cells_and_size():
    mesh = QuadruplePendulum(cell_type=CellType.TETRA4).mesh()
    assert mesh.n_cells == 3528
    assert np.ptp(mesh.nodes[:, 0]) == pytest.approx(LENGTH)
    assert np.hypot(mesh.nodes[:, 1], mesh.nodes[:, 2]).max() == pytest.approx(RADIUS)


@pytest.mark.slow
def test_rigid_links_weigh_and_turn_like_the_flexible_one():
    # The polygon that stands for the circle lies inside it: 12 sides lack 4.5 % of its area.
    body = replace(QuadruplePendulum.quick(), cell_type=CellType.TETRA10).machine().body
    own = rigid_link(1)
    inertia = body.rigid_modes.T @ (body.mass @ body.rigid_modes)
    assert inertia[0, 0] == pytest.approx(own.mass, rel=2e-3)
    centre = np.array([inertia[2, 4], inertia[0, 5], inertia[1, 3]]) / -inertia[0, 0]
    np.testing.assert_allclose(np.abs(centre), [0.5 * LENGTH, 0.0, 0.0], atol=1e-6)
    arm = own.centre @ own.centre * np.eye(3) - np.outer(own.centre, own.centre)
    about_origin = own.inertia + own.mass * arm
    np.testing.assert_allclose(np.diag(inertia)[3:], np.diag(about_origin), rtol=5e-3)


@pytest.mark.slow
def test_energy_is_kept_and_joints_stay_closed(system, fall):
    energies = balances(system, fall)
    assert np.ptp(energies.total) < 2e-5 * energies.kinetic.max()
    assert np.abs(joint_residuals(system, fall)).max() < 1e-11


@pytest.mark.slow
def test_the_first_joint_carries_weight_and_change_of_momentum(system, fall):
    momentum = balances(system, fall).momentum
    mass = sum(placed.body.mass for placed in system.bodies[:-1]) + system.bodies[-1].body.gram[0, 0]
    rate = (momentum[2:] - momentum[:-2]) / (2 * np.diff(fall.times)[0])
    # The joint's forces are those on its first end, the ground.
    expected = mass * np.array(GRAVITY) - rate
    # Not at once: at the start the link begins to ring, faster than the differences over outputs resolve.
    later = slice(10, None)
    error = np.linalg.norm(fall.multipliers["ball 1"][1:-1] - expected, axis=1)[later]
    assert error.max() < 2e-3 * mass * np.linalg.norm(GRAVITY)


def test_a_stiff_link_swings_with_the_period_of_a_compound_pendulum(pendulum):
    stiff = replace(QuadruplePendulum.quick(), stiffness=1e3).machine()
    link = reduce(
        stiff.body, stiff.frame, CraigBampton(n_modes=4), derivatives=NoDerivatives(), loads=NoLoads
    )
    # Hanging down along -y, released 0.01 rad off.
    angle = -0.5 * np.pi + 0.01
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    swing = simulate(
        System(
            bodies=(Placed(link, position=TO_JOINT * along, rotation=[0.0, 0.0, angle]),),
            joints=(Ball(first=GROUND, second=At(link.name, "near")),),
            gravity=GRAVITY,
        ),
        Run(duration=2.0, output_step=0.005, step=FixedStep(0.005)),
    )
    mass_matrix = stiff.body.rigid_modes.T @ (stiff.body.mass @ stiff.body.rigid_modes)
    mass, moment = mass_matrix[0, 0], mass_matrix[1, 5]
    # About the joint, TO_JOINT before the mesh's origin.
    inertia = mass_matrix[5, 5] + 2 * TO_JOINT * moment + mass * TO_JOINT**2
    to_centre = TO_JOINT + moment / mass
    period = 2 * np.pi * np.sqrt(inertia / (mass * -GRAVITY[1] * to_centre))
    tilt = swing.bodies[link.name].rotation[:, 0, 0]  # x component of the link's axis, which is small
    down = np.flatnonzero((tilt[:-1] > 0) & (tilt[1:] <= 0))[:2]
    crossings = swing.times[down] + tilt[down] / (tilt[down] - tilt[down + 1]) * 0.005
    assert crossings[1] - crossings[0] == pytest.approx(period, rel=2e-4)
