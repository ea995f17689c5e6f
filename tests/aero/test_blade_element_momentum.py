"""Blade-element momentum: the momentum balance itself, limits, published numbers, error messages."""

import numpy as np
import pytest

from supple.aero import (
    Operation,
    Polar,
    PowerLawShear,
    Rotor,
    Wind,
    air_loads,
    golden_phases,
    kaimal_series,
    rotor_power,
    rotor_thrust,
)
from supple.errors import ConvergenceError, ModelError

RATED_SPEED = 1.267
FINE = np.linspace(1.5, 63, 500)


def operation(pitch_deg, angular_speed=RATED_SPEED):
    return Operation(angular_speed=angular_speed, pitch=np.radians(pitch_deg))


def small_rotor(polar, chord=0.3):
    radius = np.array([1.0, 3.0, 5.0])
    twist = np.radians([20.0, 8.0, 3.0])
    return Rotor(radius=radius, chord=np.full(3, chord), twist=twist, polars=(polar,) * 3, n_blades=3)


def momentum_terms(rotor, run, radius, loads, wind):
    """Thrust and torque per length of all blades, and of the air: 4 pi r rho V^2 F ... of [Hansen2015]."""
    phi = loads.angle_of_attack + np.interp(radius, rotor.radius, rotor.twist) + run.pitch
    exponent = rotor.n_blades / 2 * (rotor.tip_radius - radius) / (radius * np.sin(phi))
    F = 2 / np.pi * np.arccos(np.exp(-exponent))
    a, a_prime = loads.axial_induction, loads.tangential_induction
    thrust_coefficient = np.where(a <= 0.2, 4 * a * (1 - a), 4 * (0.2**2 + (1 - 2 * 0.2) * a)) * F
    thrust = thrust_coefficient * run.air_density / 2 * wind**2 * 2 * np.pi * radius
    torque = 4 * np.pi * radius**3 * run.air_density * wind * run.angular_speed * (1 - a) * a_prime * F
    return (
        (rotor.n_blades * loads.normal, thrust),
        (rotor.n_blades * loads.tangential * radius, torque),
        (np.tan(phi), (1 - a) * wind / ((1 + a_prime) * run.angular_speed * radius)),
    )


@pytest.mark.parametrize(("pitch", "angular_speed"), [(3.83, RATED_SPEED), (0.0, 0.838), (0.0, 1.9)])
def test_blades_and_air_exchange_the_same_momentum(rotor, pitch, angular_speed):
    run, radius = operation(pitch, angular_speed), np.linspace(1.5, 62.9, 60)
    wind = np.full(60, 9.0)
    loads = air_loads(rotor, run, radius=radius, wind=wind)
    for blades, air in momentum_terms(rotor, run, radius, loads, wind):
        np.testing.assert_allclose(blades, air, rtol=1e-7, atol=1e-7 * np.abs(air).max())


def test_both_branches_of_the_thrust_law_are_met(rotor):
    fast = air_loads(rotor, operation(0.0, 1.9), radius=FINE[:-1], wind=np.full(499, 9.0)).axial_induction
    assert fast.min() < 0.2 < 0.4 < fast.max() < 1


def test_slender_blades_leave_the_wind_as_it_is(thin_airfoil):
    """As the chord vanishes: phi = atan(V / omega r), F_N = rho/2 (V^2 + (omega r)^2) c C_n."""
    chord, wind, radius = 1e-9, 8.0, np.array([1.5, 2.5, 4.0])
    blade, run = small_rotor(thin_airfoil, chord), operation(1.0, 4.0)
    loads = air_loads(blade, run, radius=radius, wind=np.full(3, wind))
    phi = np.arctan(wind / (4.0 * radius))
    alpha = phi - np.interp(radius, blade.radius, blade.twist) - run.pitch
    lift = np.interp(alpha, thin_airfoil.angle, thin_airfoil.lift)
    pressure = 1.225 / 2 * (wind**2 + (4.0 * radius) ** 2) * chord
    np.testing.assert_allclose(loads.angle_of_attack, alpha, atol=1e-7)
    np.testing.assert_allclose(loads.normal, pressure * (lift * np.cos(phi) + 0.01 * np.sin(phi)), rtol=1e-6)
    np.testing.assert_allclose(
        loads.tangential, pressure * (lift * np.sin(phi) - 0.01 * np.cos(phi)), rtol=1e-6
    )


def test_load_vanishes_at_the_tip(rotor):
    loads = air_loads(rotor, operation(3.83), radius=[50.0, 63.0], wind=np.full(2, 12.0))
    assert abs(loads.normal[1]) < 1e-4 * loads.normal[0]
    assert abs(loads.tangential[1]) < 1e-4 * loads.tangential[0]


def test_power_stays_below_the_limit_of_betz(rotor):
    for speed in (0.6, 0.838, RATED_SPEED):
        run = operation(0.0, speed)
        power = rotor_power(
            rotor, run, radius=FINE, loads=air_loads(rotor, run, radius=FINE, wind=np.full(FINE.size, 8.0))
        )
        assert power < 16 / 27 * 1.225 / 2 * 8.0**3 * np.pi * 63**2


def test_rows_of_wind_are_independent(rotor):
    radius = np.array([10.0, 30.0, 50.0])
    wind = np.array([[8.0, 9.0, 10.0], [11.0, 12.0, 13.0], [4.0, 14.0, 20.0]])
    together = air_loads(rotor, operation(3.4), radius=radius, wind=wind)
    alone = [air_loads(rotor, operation(3.4), radius=radius, wind=row) for row in wind]
    np.testing.assert_allclose(together.normal, [loads.normal for loads in alone], rtol=1e-9)


@pytest.mark.parametrize(
    ("wind", "pitch", "power"), [(12.0, 3.83, 5.297e6), (15.0, 10.45, 5.297e6), (20.0, 17.47, 5.297e6)]
)
def test_power_of_the_reference_turbine(rotor, wind, pitch, power):
    """5.297 MW of aerodynamic power by the pitch schedule of [Jonkman2009], table 7-1; a rigid rotor without
    cone, tilt and hub loss comes within 1.5 %."""
    run = operation(pitch)
    loads = air_loads(rotor, run, radius=FINE, wind=np.full(FINE.size, wind))
    np.testing.assert_allclose(rotor_power(rotor, run, radius=FINE, loads=loads), power, rtol=0.015)


def test_power_by_an_independent_code(rotor):
    """5.358, 5.308 and 5.338 MW by bisection on about a hundred points; the rest is their quadrature."""
    radius = np.linspace(1.5, 63, 92)
    powers = []
    for wind, pitch in ((12.0, 3.83), (15.0, 10.45), (20.0, 17.47)):
        loads = air_loads(rotor, operation(pitch), radius=radius, wind=np.full(radius.size, wind))
        powers.append(rotor_power(rotor, operation(pitch), radius=radius, loads=loads))
    np.testing.assert_allclose(powers, [5.358e6, 5.308e6, 5.338e6], rtol=5e-4)


def test_thrust_by_an_independent_code(rotor):
    """206 kN a blade at 12 m/s, pitch 3.40 deg."""
    loads = air_loads(rotor, operation(3.40), radius=FINE, wind=np.full(FINE.size, 12.0))
    np.testing.assert_allclose(rotor_thrust(rotor, radius=FINE, loads=loads) / 3, 206e3, rtol=5e-3)


@pytest.mark.parametrize(
    ("pitch", "angular_speed", "mean_speed", "normal", "tangential"),
    [
        (
            3.40, RATED_SPEED, 12.0,
            [(1298, 956, 1666), (3845, 2383, 5268), (5487, 3532, 7329)],
            [(577, 422, 714), (827, 383, 1376), (776, 324, 1318)],
        ),
        (
            0.0, 0.838, 8.0,
            [(621, 490, 779), (2184, 1645, 2773), (3227, 2462, 3965)],
            [(227, 188, 276), (425, 244, 694), (404, 203, 680)],
        ),
    ],
)  # fmt: skip
def test_loads_in_the_wind_by_an_independent_code(
    rotor, pitch, angular_speed, mean_speed, normal, tangential
):
    """Mean, least and largest load per length over 100 s at spans of 10, 33 and 50 m, printed to 1 N/m."""
    times, radius = np.arange(0, 100, 0.05), np.array([10.0, 33.0, 50.0]) + 1.5
    turbulence = kaimal_series(
        mean_speed=mean_speed,
        deviation=0.1 * mean_speed,
        length_scale=340.2,
        frequency_step=0.01,
        phase=golden_phases(50),
    )
    wind = Wind(mean_speed=mean_speed, shear=PowerLawShear(hub_height=90.0), turbulence=turbulence)
    speeds = wind.along_blade(times, radius=radius, azimuth=angular_speed * times)
    loads = air_loads(rotor, operation(pitch, angular_speed), radius=radius, wind=speeds)
    for values, expected in ((loads.normal, normal), (loads.tangential, tangential)):
        found = np.stack([values.mean(axis=0), values.min(axis=0), values.max(axis=0)], axis=1)
        np.testing.assert_allclose(found, expected, atol=1.6)


def test_uncovered_angle_of_attack(thin_airfoil):
    narrow = Polar(
        "narrow", thin_airfoil.angle[175:186], thin_airfoil.lift[175:186], thin_airfoil.drag[175:186]
    )
    with pytest.raises(
        ModelError,
        match=r"deg at radius 2 m, row 1 of the wind is not covered: .* from -5\.00 to 5\.00",
    ):
        air_loads(small_rotor(narrow), operation(0.0, 6.0), radius=[2.0], wind=np.array([[4.0], [25.0]]))


def test_a_rotor_that_drives_the_air():
    """A section that lifts backwards at every angle finds no balance between 0 and 90 degrees."""
    backwards = Polar("backwards", [-4.0, 4.0], [-50.0, -50.0], [0.01, 0.01])
    with pytest.raises(ConvergenceError, match="radius 3 m, wind 9 m/s: the rotor drives the air"):
        air_loads(small_rotor(backwards), operation(0.0, 1.0), radius=[3.0], wind=np.array([9.0]))


@pytest.mark.parametrize("speed", [0.0, -3.0, np.nan])
def test_wind_that_does_not_blow(rotor, speed):
    with pytest.raises(ModelError, match=r"wind .* m/s at radius 50 m"):
        air_loads(rotor, operation(3.4), radius=[30.0, 50.0], wind=np.array([10.0, speed]))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"angular_speed": 0.0}, "angular speed 0.0"),
        ({"pitch": np.nan}, "pitch nan"),
        ({"air_density": -1.0}, "air density -1.0"),
    ],
)
def test_impossible_operation(changes, message):
    with pytest.raises(ModelError, match=message):
        Operation(**{"angular_speed": 1.0, "pitch": 0.0, **changes})
