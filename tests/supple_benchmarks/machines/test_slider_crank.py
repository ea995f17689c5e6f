"""The slider-crank: masses, the exact path of a rigid rod, the work of the torque."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.equations import balances, joint_residuals
from supple.integrate import FixedStep, Run, Tolerances
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate
from supple_benchmarks.machines.slider_crank import (
    CRANK_RADIUS,
    ROD,
    TOTAL_MASS,
    SliderCrank,
    slider_position,
)

SOFT = 1e-3


def run(stiffness):
    machine = replace(SliderCrank.quick(), stiffness=stiffness).machine()
    rod = reduce(
        machine.body, machine.frame, CraigBampton(n_modes=3), derivatives=NoDerivatives(), loads=NoLoads
    )
    system = machine.system(rod)
    solution = simulate(
        system, Run(duration=0.2, output_step=0.001, step=FixedStep(5e-4), tolerances=Tolerances(1e-10))
    )
    return machine, system, solution


@pytest.fixture(scope="module")
def soft():
    return run(SOFT)


@pytest.fixture(scope="module")
def stiff():
    return run(1e3 * SOFT)


def test_all_parts_together_have_the_papers_mass(slider_crank):
    rod = slider_crank.body
    mass = rod.rigid_modes[:, 0] @ (rod.mass @ rod.rigid_modes[:, 0])
    system = slider_crank.system(
        reduce(rod, slider_crank.frame, CraigBampton(n_modes=0), derivatives=NoDerivatives(), loads=NoLoads)
    )
    rigid = sum(placed.body.mass for placed in system.bodies if placed.body.kind == "rigid")
    assert rigid + mass == pytest.approx(TOTAL_MASS, rel=1e-12)


def slider_error(solution):
    """Largest distance of the slider from where a rigid rod would put it."""
    axes = solution.bodies["crank"].rotation
    angle = np.arctan2(axes[:, 1, 0], axes[:, 0, 0])
    return np.abs(solution.bodies["slider"].position[:, 0] - slider_position(angle)).max()


@pytest.mark.slow
def test_a_stiff_rod_moves_the_slider_as_a_rigid_one_would(stiff, soft):
    _, _, solution = stiff
    travel = np.ptp(solution.bodies["slider"].position[:, 0])
    assert travel > 0.5 * CRANK_RADIUS
    assert slider_error(solution) < 1e-6 * ROD.length
    # A thousand times the modulus, a thousandth of the rod's own strain.
    assert slider_error(soft[2]) / slider_error(solution) == pytest.approx(1e3, rel=0.1)


def test_slider_position_closes_the_triangle():
    angle = np.linspace(0.0, 6.0, 25)
    pin = CRANK_RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    end = np.column_stack([slider_position(angle), 0 * angle])
    np.testing.assert_allclose(np.linalg.norm(end - pin, axis=1), ROD.length, rtol=1e-14)


@pytest.mark.slow
def test_energy_is_the_work_of_the_torque(stiff):
    machine, system, solution = stiff
    energies = balances(system, solution)
    work = machine.work(solution)
    assert work[-1] > 0.1
    np.testing.assert_allclose(energies.total - energies.total[0], work, atol=1e-4 * work[-1])
    assert np.abs(joint_residuals(system, solution)).max() < 1e-11


@pytest.mark.slow
def test_the_slider_stays_on_its_path(stiff):
    slider = stiff[2].bodies["slider"]
    assert np.abs(slider.position[:, 1:]).max() < 1e-12
    np.testing.assert_allclose(slider.rotation, np.broadcast_to(np.eye(3), slider.rotation.shape), atol=1e-12)


def test_the_default_rod_has_the_papers_number_of_cells():
    assert SliderCrank().mesh().n_cells == 4374
