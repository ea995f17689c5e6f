"""The box as a slender beam: modes in closed form, and those of stations read along it."""

import numpy as np
import pytest

from supple_benchmarks.intrinsic.slender_box import (
    AREA,
    DENSITY,
    FLAP,
    LENGTH,
    POLAR,
    TORSION,
    E,
    slender_frequency,
    slender_mode,
)


@pytest.mark.parametrize("rank", [0, 1, 2])
@pytest.mark.parametrize(
    ("kind", "mass", "stiffness"),
    [("flapwise", DENSITY * AREA, E * FLAP), ("torsion", DENSITY * POLAR, TORSION)],
)
def test_closed_forms_are_normal_in_mass_and_in_compliance(kind, rank, mass, stiffness):
    s = np.linspace(0, LENGTH, 4001)
    velocity, moment, curvature = slender_mode(kind, rank, s)
    assert np.trapezoid(mass * velocity**2, s) == pytest.approx(1, abs=1e-5)
    assert np.trapezoid(moment * curvature, s) == pytest.approx(1, abs=1e-5)
    assert moment == pytest.approx(stiffness * curvature)
    assert np.abs(moment[-1]) < 1e-6 * np.abs(moment).max()  # a free end


@pytest.mark.parametrize("rank", [0, 1])
def test_the_strain_of_a_mode_is_the_derivative_of_its_velocity(rank):
    s = np.linspace(0, LENGTH, 4001)
    velocity, _, twist = slender_mode("torsion", rank, s)
    rate = -np.gradient(velocity, s) / slender_frequency("torsion", rank)
    assert rate[5:-5] == pytest.approx(twist[5:-5], abs=1e-4 * np.abs(twist).max())
    deflection, _, bend = slender_mode("flapwise", rank, s)
    slope = -np.gradient(deflection, s)  # theta_y of a deflection along z
    rate = -np.gradient(slope, s) / slender_frequency("flapwise", rank)
    assert rate[5:-5] == pytest.approx(bend[5:-5], abs=1e-4 * np.abs(bend).max())
