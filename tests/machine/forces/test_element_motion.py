"""Machine elements in motion, each against its closed form, or against an equation that SciPy solves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from supple import machine as m
from supple.body import RigidBody
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.quantities import ElementEnergySensor
from supple.simulation import simulate

MASS, INERTIA = 2.0, 0.3
G = 9.81
KEEPING = GeneralizedAlpha(1.0)


def lump(name, mass=MASS):
    return RigidBody(
        name, mass, [0, 0, 0], INERTIA * np.eye(3), {"eye": (0.0, 0.0, 0.0), "rim": (0.5, 0.0, 0.0)}
    )


def run(system, duration, step, output_step=None, method=KEEPING):
    options = {"method": method, "tolerances": Tolerances(residual=1e-10)}
    return simulate(
        system, Run(duration=duration, output_step=output_step or duration, step=FixedStep(step), **options)
    )


def speed_after(before, dissipation):
    """Of a blow: `v/a - ln(1 + a v)/a^2` is the same before and after."""

    def taken(v):
        return v / dissipation - np.log1p(dissipation * v) / dissipation**2

    return brentq(lambda w: taken(-w) - taken(before), 1e-9, min(before, (1 - 1e-12) / dissipation))


@pytest.mark.slow
def test_balls_bounce_with_the_energy_that_their_law_says():
    """On a plane, outside and inside of a cylinder; the speed after does not depend on mass nor stiffness."""
    speed = 0.8
    laws = {
        "soft": (1e4, 1.0, 0.5),
        "hertz": (1e6, 1.5, 0.5),
        "lossy": (1e4, 1.0, 1.5),
        "roller": (1e4, 1.0, 0.5),
    }
    contacts = []
    for name, (stiffness, exponent, dissipation) in laws.items():
        own = {
            "first": f"{name}.eye",
            "radius": 0.1,
            "anchor": (0.0, 0.0, 0.0),
            "penalty": m.Penalty(stiffness=stiffness, exponent=exponent, dissipation=dissipation),
        }
        round_ = m.SphereOnCylinder(axis=(1, 0, 0), cylinder_radius=0.2, **own)
        contacts.append(round_ if name == "roller" else m.SphereOnPlane(axis=(0, 0, 1), **own))
    bodies = [
        m.Placed(
            lump(name, mass),
            position=[0, 0, 0.31 if name == "roller" else 0.11],
            velocity=[0, 0, -speed],
        )
        for name, mass in zip(laws, (1.0, 2.0, 3.0, 4.0), strict=True)
    ]
    motion = run(m.System(bodies, loads=contacts), 0.12, 2.5e-5).bodies
    for name, (_, _, dissipation) in laws.items():
        after = motion[name].velocity[-1, 2]
        assert after == pytest.approx(speed_after(speed, dissipation), rel=2e-5)
    assert motion["lossy"].velocity[-1, 2] < 0.6 * speed


@pytest.mark.slow
def test_a_ball_that_slides_comes_to_roll():
    """Friction keeps the angular momentum about the line of contact: `v_1 = v_0 m r^2 / (m r^2 + I)`."""
    radius, speed, stiffness = 0.3, 1.0, 1e5
    depth = MASS * G / stiffness
    floor = m.SphereOnPlane(
        first="ball.eye",
        axis=(0, 0, 1),
        anchor=(0, 0, 0),
        radius=radius,
        penalty=m.Penalty(stiffness=stiffness),
        friction=m.Coulomb(coefficient=0.5, width=1e-2),
    )
    ball = m.Placed(lump("ball"), position=[0, 0, radius - depth], velocity=[speed, 0, 0])
    motion = run(m.System([ball], loads=[floor], gravity=(0, 0, -G)), 0.4, 1e-3).bodies["ball"]
    lever = radius  # friction acts at the lowest point of the sphere
    rolling = speed * MASS * lever**2 / (MASS * lever**2 + INERTIA)
    np.testing.assert_allclose(motion.velocity[-1], [rolling, 0, 0], atol=1e-6)
    np.testing.assert_allclose(motion.angular_velocity[-1], [0, rolling / lever, 0], atol=1e-5)


@pytest.mark.slow
def test_a_block_creeps_below_the_friction_angle_and_slides_above():
    """The incline is a plane whose normal is tilted; weights press on it as the penalty's spring says."""
    coefficient, width, stiffness = 0.4, 5e-3, 1e6
    slopes = {"sticking": 0.9 * np.arctan(coefficient), "sliding": 1.3 * np.arctan(coefficient)}
    bodies, contacts = [], []
    for name, slope in slopes.items():
        normal = np.array([-np.sin(slope), 0, np.cos(slope)])
        depth = MASS * G * np.cos(slope) / stiffness
        bodies.append(m.Placed(lump(name), position=-depth * normal))
        contacts.append(
            m.SphereOnPlane(
                first=f"{name}.eye",
                axis=tuple(normal),
                anchor=(0, 0, 0),
                penalty=m.Penalty(stiffness=stiffness),
                friction=m.Coulomb(coefficient=coefficient, width=width),
            )
        )
    system = m.System(bodies, loads=contacts, gravity=(0, 0, -G))
    motion = run(system, 0.5, 5e-4, method=GeneralizedAlpha(0.8)).bodies

    def downhill(name):
        along = np.array([np.cos(slopes[name]), 0, np.sin(slopes[name])])
        return -motion[name].velocity[-1] @ along

    part = np.tan(slopes["sticking"]) / coefficient
    assert downhill("sticking") == pytest.approx(width * part / np.sqrt(1 - part**2), rel=1e-9)

    def equation(_, v):
        slope = slopes["sliding"]
        return G * np.sin(slope) - coefficient * G * np.cos(slope) * v / np.sqrt(v**2 + width**2)

    exact = solve_ivp(equation, (0, 0.5), [0.0], method="LSODA", rtol=1e-10, atol=1e-13).y[0, -1]
    assert downhill("sliding") == pytest.approx(exact, rel=2e-4)
    free = 0.5 * G * (np.sin(slopes["sliding"]) - coefficient * np.cos(slopes["sliding"]))
    assert downhill("sliding") == pytest.approx(free, rel=2e-2)


@pytest.mark.slow
def test_friction_in_joints_takes_what_its_preload_says():
    """Far above the width a wheel slows down evenly, and a slider too."""
    wheel, slider = lump("wheel"), lump("slider")
    axis = {"axis": (0, 0, 1)}
    system = m.System(
        [m.Placed(wheel, angular_velocity=[0, 0, 20.0]), m.Placed(slider, velocity=[0, 0, 9.0])],
        joints=[
            m.Revolute(first="ground", second="wheel.eye", **axis),
            m.Prismatic(first="ground", second="slider.eye", **axis),
        ],
        loads=[
            m.RevoluteFriction(first="ground", second="wheel.eye", moment=0.9, width=1e-3, **axis),
            m.PrismaticFriction(first="ground", second="slider.eye", force=4.0, width=1e-3, **axis),
        ],
    )
    motion = run(system, 2.0, 0.02, method=GeneralizedAlpha(0.8)).bodies
    assert motion["wheel"].angular_velocity[-1, 2] == pytest.approx(20 - 2 * 0.9 / INERTIA, rel=1e-8)
    assert motion["slider"].velocity[-1, 2] == pytest.approx(9 - 2 * 4.0 / MASS, rel=1e-7)


@pytest.mark.slow
def test_a_cam_lifts_its_follower_harmonically():
    """An eccentric disc under a flat face: y = R + e sin(phi) - N/k, N its weight and inertia."""
    radius, eccentricity, stiffness, speed = 0.1, 0.02, 1e7, 12.0
    cam = RigidBody(
        "cam", 1.0, [0, 0, 0], 0.01 * np.eye(3), {"axle": (0, 0, 0), "centre": (eccentricity, 0, 0)}
    )
    system = m.System(
        [
            m.Placed(cam, angular_velocity=[0, 0, speed]),
            m.Placed(lump("follower"), position=[0, radius, 0], velocity=[0, eccentricity * speed, 0]),
        ],
        joints=[
            m.PrescribedRotation(
                first="ground", second="cam.axle", axis=(0, 0, 1), angle=m.ConstantRate(speed)
            ),
            m.Prismatic(first="ground", second="follower.eye", axis=(0, 1, 0)),
        ],
        loads=[
            m.SphereOnPlane(
                first="cam.centre",
                second="follower.eye",
                axis=(0, -1, 0),
                radius=radius,
                penalty=m.Penalty(stiffness=stiffness, dissipation=50.0),
            )
        ],
        gravity=(0, -G, 0),
    )
    solution = run(system, 0.5, 2.5e-4, 0.005, GeneralizedAlpha(0.8))
    late = solution.times > 0.2
    lift = eccentricity * np.sin(speed * solution.times)
    pressed = MASS * (G - speed**2 * lift) / stiffness
    height = solution.bodies["follower"].position[:, 1]
    np.testing.assert_allclose((height - radius - lift + pressed)[late], 0, atol=2e-9)


@pytest.mark.slow
def test_a_jeffcott_rotor_whirls_as_its_bearing_says():
    """m z'' + c z' + (k - i q) z = 0, z = x + i y: it grows where q > c sqrt(k/m).

    Three rotors turn at the same speed; the cross term is between rows of its table.
    """
    stiffness, damping = 800.0, 3.0
    limit = damping * np.sqrt(stiffness / MASS)
    cross = {"below": 0.8 * limit, "at the limit": limit, "above": 1.2 * limit}
    bodies = [m.Placed(lump(name), position=[0.01, 0, 0], angular_velocity=[0, 0, 60.0]) for name in cross]
    bearings = [
        m.JournalBearing(
            first="ground",
            second=f"{name}.eye",
            axis=(0, 0, 1),
            speeds=(50, 90),
            # 0.75 and 0.25 of which are the whole one.
            stiffness=[[[stiffness, part * q], [-part * q, stiffness]] for part in (0.8, 1.6)],
            damping=damping * np.eye(2),
        )
        for name, q in cross.items()
    ]
    # The ground's end stands where the rotor starts: it is at rest there, and is pushed.
    for placed in bodies:
        object.__setattr__(placed, "velocity", np.array([0.1, 0, 0]))
    solution = run(m.System(bodies, loads=bearings), 1.0, 2.5e-4, 0.01)
    t = solution.times
    for name, q in cross.items():
        roots = np.roots([MASS, damping, stiffness - 1j * q])
        exact = 0.1 * (np.exp(roots[0] * t) - np.exp(roots[1] * t)) / (roots[0] - roots[1])
        place = solution.bodies[name].position
        found = place[:, 0] - 0.01 + 1j * place[:, 1]
        np.testing.assert_allclose(found, exact, atol=3e-5 * abs(exact).max())
        assert np.sign(np.round(roots.real.max(), 9)) == {"below": -1, "at the limit": 0, "above": 1}[name]


@pytest.mark.slow
def test_an_unbalance_drives_a_rotor_at_its_speed():
    """Steady whirl `U Omega^2 / (k - m Omega^2 + i c Omega)`; the rotor starts on it."""
    stiffness, damping, speed, moment = 900.0, 6.0, 15.0, 0.004
    whirl = moment * speed**2 / (stiffness - MASS * speed**2 + 1j * damping * speed)
    velocity = 1j * speed * whirl
    system = m.System(
        [
            m.Placed(
                lump("rotor"),
                position=[whirl.real, whirl.imag, 0],
                velocity=[velocity.real, velocity.imag, 0],
                angular_velocity=[0, 0, speed],
            )
        ],
        loads=[
            m.Unbalance(first="rotor.eye", moment=(moment, 0, 0)),
            *(
                m.SpringDamper(
                    first="rotor.eye",
                    anchor=tuple(50.0 * np.array(direction)),
                    stiffness=stiffness,
                    damping=damping,
                    rest_length=50.0,
                )
                for direction in ((1, 0, 0), (0, 1, 0))
            ),
        ],
    )
    solution = run(system, 1.0, 2.5e-4, 0.01)
    place = solution.bodies["rotor"].position
    exact = whirl * np.exp(1j * speed * solution.times)
    # Springs 50 m long turn by 1e-4 rad.
    np.testing.assert_allclose(place[:, 0] + 1j * place[:, 1], exact, atol=2e-4 * abs(whirl))


def oscillation(stiffness, flexibility, load, t):
    """`s'' = load - stiffness flexibility s` from rest: s(t), and its double integral."""
    rate = np.sqrt(stiffness * flexibility)
    amplitude = load / rate**2
    return amplitude * (1 - np.cos(rate * t)), amplitude * (t**2 / 2 - (1 - np.cos(rate * t)) / rate**2)


@pytest.mark.slow
def test_gears_screws_and_racks_couple_as_their_ratio_says():
    """Each driven from rest, its mesh elastic: the slip oscillates, the rest follows in closed form."""
    stiffness, load, duration = 2e3, 3.0, 3.0
    teeth, centres = (20, 30), 0.5
    ratio_radii = np.array(teeth) * centres / sum(teeth)
    pitch, radius = 2.4, 0.2
    hinged = {"axis": (0, 0, 1)}
    bodies = [
        lump("pinion"),
        m.Placed(lump("wheel"), position=[centres, 0, 0]),
        m.Placed(lump("bolt"), position=[0, 0, 0.3]),
        m.Placed(lump("roller"), position=[0.1, radius, 0]),
    ]
    system = m.System(
        bodies,
        joints=[
            m.Revolute(first="ground", second="pinion.eye", **hinged),
            m.Revolute(first="ground", second="wheel.eye", **hinged),
            m.Cylindrical(first="ground", second="bolt.eye", **hinged),
            m.PointOnLine(first="ground", second="roller.eye", axis=(1, 0, 0), name="line"),
        ],
        loads=[
            m.Gear(first="pinion.eye", second="wheel.eye", teeth=teeth, stiffness=stiffness, **hinged),
            m.Screw(first="ground", second="bolt.eye", pitch=pitch, stiffness=stiffness, **hinged),
            m.RackAndPinion(
                first="ground",
                second="roller.eye",
                direction=(1, 0, 0),
                radius=radius,
                stiffness=stiffness,
                **hinged,
            ),
            m.TorqueBetween(first="ground", second="pinion.eye", torque=load, **hinged),
            m.DeadForce(body="bolt", at="eye", force=[0, 0, load]),
            m.DeadForce(body="roller", at="eye", force=[load, 0, 0]),
        ],
    )
    solution = run(system, duration, 5e-4, 0.05)
    t, motion = solution.times, solution.bodies

    def angle(name):
        axes = motion[name].rotation
        return np.unwrap(np.arctan2(axes[:, 1, 0], axes[:, 0, 0]))

    _, slipped = oscillation(stiffness, (ratio_radii**2 / INERTIA).sum(), ratio_radii[0] * load / INERTIA, t)
    exact = (load * t**2 / 2 - stiffness * ratio_radii[0] * slipped) / INERTIA
    np.testing.assert_allclose(angle("pinion"), exact, atol=3e-5)
    np.testing.assert_allclose(angle("wheel"), -stiffness * ratio_radii[1] * slipped / INERTIA, atol=3e-5)

    for name, advance, place in (
        ("bolt", pitch / (2 * np.pi), motion["bolt"].position[:, 2] - 0.3),
        ("roller", -radius, motion["roller"].position[:, 0] - 0.1),
    ):
        _, slipped = oscillation(stiffness, 1 / MASS + advance**2 / INERTIA, load / MASS, t)
        np.testing.assert_allclose(place, (load * t**2 / 2 - stiffness * slipped) / MASS, atol=3e-5)
        np.testing.assert_allclose(angle(name), stiffness * advance * slipped / INERTIA, atol=5e-5)
    assert angle("bolt")[-1] > 2 * np.pi


@pytest.mark.slow
def test_a_bar_swings_between_its_stops_and_a_rope_catches_it():
    """Without dissipation stops and bushings keep the energy of what runs into them."""
    axis = {"axis": (0, 0, 1)}
    penalty = m.Penalty(stiffness=3e3)
    names = ("wheel", "slider", "weight", "block")
    bodies = [
        m.Placed(lump("wheel"), angular_velocity=[0, 0, 3.0]),
        m.Placed(lump("slider"), velocity=[0, 0, 2.0]),
        m.Placed(lump("weight"), position=[0.1, 0, 0], velocity=[1.5, 0, 0]),
        m.Placed(lump("block"), velocity=[0.3, 0.2, 0.1], angular_velocity=[1.0, 2.0, 1.5]),
    ]
    loads = [
        m.AngleStop(first="ground", second="wheel.eye", lower=-0.2, upper=0.3, penalty=penalty, **axis),
        m.SlideStop(first="ground", second="slider.eye", lower=-0.1, upper=0.1, penalty=penalty, **axis),
        m.DistanceStop(first="weight.eye", anchor=(0, 0, 0), upper=0.3, penalty=penalty),
        m.Bushing(first="ground", second="block.eye", stiffness=[300, 200, 100, 9, 8, 7]),
    ]
    joints = [
        m.Revolute(first="ground", second="wheel.eye", **axis),
        m.Prismatic(first="ground", second="slider.eye", **axis),
    ]
    solution = run(m.System(bodies, joints, loads), 0.6, 1e-4, 0.01)
    moved = solution.bodies
    turned = np.arctan2(moved["wheel"].rotation[:, 1, 0], moved["wheel"].rotation[:, 0, 0])
    assert turned.max() > 0.3
    assert turned.min() < -0.2
    assert 0.1 < abs(moved["slider"].position[:, 2]).max() < 0.2
    assert 0.3 < moved["weight"].position[:, 0].max() < 0.4
    for name, load in zip(names, loads, strict=True):
        own = moved[name]
        kinetic = (MASS * (own.velocity**2).sum(axis=1) + INERTIA * (own.angular_velocity**2).sum(axis=1)) / 2
        system = m.System(bodies, joints, loads)
        stored = ElementEnergySensor(name, load).values(system, solution)[:, 0]
        assert stored.max() > 0.3 * kinetic[0]
        np.testing.assert_allclose(kinetic + stored, kinetic[0], rtol=5e-4)
