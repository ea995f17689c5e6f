"""Prescribed loads: resultants of the lumping, the ramp, turning axes, and the error messages."""

import numpy as np
import pytest

from supple.aero import (
    CosineRamp,
    NodalForces,
    Operation,
    PowerLawShear,
    Rotor,
    Wind,
    air_loads,
    lumped_forces,
    prescribed_forces,
)
from supple.errors import ModelError
from supple.machine import DeadForce, Table

SPAN = np.array([0.0, 10.0, 18.0, 33.0, 50.0, 61.5])
RUN = Operation(angular_speed=1.267, pitch=np.radians(3.4))
WIND = Wind(mean_speed=12.0, shear=PowerLawShear(hub_height=90.0))
TIMES = np.linspace(0, 6, 13)


@pytest.fixture(scope="module")
def forces(rotor):
    return prescribed_forces(rotor, RUN, WIND, span=SPAN, hub_radius=1.5, times=TIMES)


@pytest.fixture
def short_rotor(thin_airfoil):
    polars = (thin_airfoil,) * 2
    return Rotor(radius=[1.1, 21.2], chord=[2.0, 1.0], twist=[0.2, 0.0], polars=polars, n_blades=3)


def test_lumping_keeps_the_resultant():
    """The shares are those of the trapezoidal rule: a constant load gives load times length."""
    lumped = lumped_forces(SPAN, np.full(6, 3.0), np.full(6, 2.0))
    np.testing.assert_allclose(lumped.sum(axis=0), [3 * 61.5, -2 * 61.5, 0])
    np.testing.assert_allclose(lumped[1], [3 * 9, -2 * 9, 0])


def test_forces_are_those_of_the_air(rotor, forces):
    wind = WIND.along_blade(TIMES, radius=SPAN + 1.5, azimuth=1.267 * TIMES)
    loads = air_loads(rotor, RUN, radius=SPAN + 1.5, wind=wind)
    np.testing.assert_allclose(
        forces.forces[..., 0].sum(axis=1), np.trapezoid(loads.normal, SPAN), rtol=1e-12
    )
    np.testing.assert_allclose(
        forces.forces[..., 1].sum(axis=1), -np.trapezoid(loads.tangential, SPAN), rtol=1e-12
    )
    assert (forces.forces[..., 0].sum(axis=1) > 0).all()
    assert not forces.forces[..., 2].any()


def test_a_tip_beyond_the_table_by_rounding_is_the_tip(short_rotor):
    """20.1 + 1.1 exceeds 21.2 in floating point; at the tip the loss factor, and so the load, is zero."""
    span = np.array([0.0, 10.0, 20.1])
    assert span[-1] + 1.1 > short_rotor.tip_radius == 21.2
    forces = prescribed_forces(short_rotor, RUN, WIND, span=span, hub_radius=1.1, times=TIMES).forces
    assert abs(forces[:, -1]).max() < 1e-3 * forces[:, 1, 0].min()
    with pytest.raises(ModelError, match=r"off the blade, which runs from 1\.1 to 21\.2"):
        prescribed_forces(short_rotor, RUN, WIND, span=span, hub_radius=1.11, times=TIMES)


def test_ramp_starts_from_rest(rotor, forces):
    ramp = CosineRamp(4.0)
    ramped = prescribed_forces(rotor, RUN, WIND, span=SPAN, hub_radius=1.5, times=TIMES, ramp=ramp)
    np.testing.assert_allclose(
        ramp.at([0, 1, 2, 3, 4, 9]), [0, (1 - np.sqrt(0.5)) / 2, 0.5, (1 + np.sqrt(0.5)) / 2, 1, 1]
    )
    np.testing.assert_allclose(ramped.forces, ramp.at(TIMES)[:, None, None] * forces.forces)
    step = 1e-4
    np.testing.assert_allclose((ramp.at([step, 4 + step]) - ramp.at([0, 4 - step])) / step, 0, atol=1e-3)


def test_turned_forces_follow_the_blade():
    """A quarter turn about x takes the blade from z to -y, and what acted along -y to -z."""
    forces = NodalForces(np.arange(2.0), np.array([[[5.0, -3.0, 0.0]], [[5.0, -3.0, 0.0]]]))
    turned = forces.turned([0.0, np.pi / 2])
    np.testing.assert_allclose(turned.forces, [[[5, -3, 0]], [[5, 0, -3]]], atol=1e-15)


def test_forces_suit_a_dead_force(forces):
    load = DeadForce(body="blade", at=np.arange(6), force=Table(forces.times, forces.forces))
    np.testing.assert_allclose(load.law(TIMES[3]), forces.forces[3])


def test_errors():
    with pytest.raises(ModelError, match="from root to tip"):
        lumped_forces([0.0, 2.0, 1.0], np.ones(3), np.ones(3))
    with pytest.raises(ModelError, match=r"ramp of 0\.0 s"):
        CosineRamp(0.0)
