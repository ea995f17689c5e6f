"""Sensors beside closed forms and derivatives of each other."""

from __future__ import annotations

import csv

import h5py
import numpy as np
import pytest
from fixtures.bar_of_every_form import bar_as

from supple.body import FullBody, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.errors import ArgumentError, ModelError
from supple.export import write_readings
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, Run, Solution, Statistics
from supple.machine import (
    GROUND,
    At,
    BaseAcceleration,
    Fixed,
    FollowerForce,
    Placed,
    PrescribedRotation,
    Prismatic,
    Revolute,
    Scaled,
    Sine,
    SpinUp,
    SpringDamper,
    System,
    Unbalance,
)
from supple.mesh import strip
from supple.methods.explicit.motions import NodalMotion
from supple.quantities import (
    AccelerationSensor,
    AngularVelocitySensor,
    Component,
    DeflectionSensor,
    EnergySensor,
    JointForceSensor,
    JointMotionSensor,
    Place,
    PositionSensor,
    Principal,
    SpringForceSensor,
    StrainSensor,
    StressSensor,
    VelocitySensor,
    VonMises,
    read_in_parts,
    read_sensors,
)
from supple.simulation import equilibrium, simulate
from supple.units import UnitSystem

SI = UnitSystem("m", "kg", "s")
SPEED, RAMP = np.pi, 1.0


@pytest.fixture(scope="module")
def spun(clamped_blade):
    """The strip spun up about a vertical axis through its root, two turns; 400 outputs."""
    hub = PrescribedRotation(
        first=GROUND,
        second=At("blade", "root"),
        axis=(0.0, 0.0, 1.0),
        angle=SpinUp(SPEED, RAMP),
        name="hub",
    )
    system = System((Placed(clamped_blade),), (hub,))
    return system, simulate(system, Run(4.4, 0.011, FixedStep(0.0055)))


def read(sensor, machine):
    (reading,) = read_sensors([sensor], *machine)
    return reading.values


def derivative(values, times):
    return (values[2:] - values[:-2]) / (times[2:] - times[:-2])[:, None]


@pytest.mark.parametrize("at", ["tip", (20, 19)])
def test_velocity_and_acceleration_are_the_derivatives_of_the_position(spun, at):
    times = spun[1].times
    place = Place("blade", at)
    position = read(PositionSensor("tip", place), spun)
    velocity = read(VelocitySensor("tip", place), spun)
    acceleration = read(AccelerationSensor("tip", place), spun)
    np.testing.assert_allclose(velocity[1:-1], derivative(position, times), atol=4e-3 * abs(velocity).max())
    np.testing.assert_allclose(
        acceleration[1:-1], derivative(velocity, times), atol=1e-2 * abs(acceleration).max()
    )


def test_the_angle_of_a_joint_is_the_law_of_its_motion_over_whole_turns(spun):
    times = spun[1].times
    law = SpinUp(SPEED, RAMP)
    angle, rate, slide, speed = read(JointMotionSensor("hub", "hub"), spun).T
    exact = np.array([float(law(time)) for time in times])
    assert exact[-1] > 3 * np.pi
    np.testing.assert_allclose(angle, exact, atol=1e-8)
    np.testing.assert_allclose(rate[1:-1], derivative(exact[:, None], times)[:, 0], atol=2e-3 * rate.max())
    np.testing.assert_allclose([slide, speed], 0.0, atol=1e-8)
    turning = read(AngularVelocitySensor("root", At("blade", "root")), spun)
    np.testing.assert_allclose(turning[:, 2], rate, atol=1e-9)


def test_readings_of_parts_are_those_of_the_whole(spun):
    """Two turns, counted across the parts."""
    system, whole = spun
    sensors = [JointMotionSensor("hub", "hub"), PositionSensor("tip", Place("blade", "tip"))]
    parts = (whole.at(slice(start, start + 150)) for start in range(0, len(whole.times), 150))
    found, expected = read_in_parts(sensors, system, parts), read_sensors(sensors, system, whole)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one.times, other.times)
        np.testing.assert_allclose(one.values, other.values, rtol=1e-12, atol=1e-12)
    with pytest.raises(ModelError, match="there is no output time to read"):
        read_in_parts(sensors, system, [])


def test_loads_on_one_end_are_read_there(spun):
    """They have no force on a second end: U w^2 outwards, and a force that rotates with the root."""
    angle, rate = read(JointMotionSensor("hub", "hub"), spun)[:, :2].T
    outwards = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    heavy = read(SpringForceSensor("heavy", Unbalance(first="blade.root", moment=(0.2, 0.0, 0.0))), spun)
    np.testing.assert_allclose(heavy[:, :2], 0.2 * rate[:, None] ** 2 * outwards, atol=1e-7)
    np.testing.assert_allclose(heavy[:, 2:], 0.0, atol=1e-7)
    pull = read(SpringForceSensor("pull", FollowerForce(first="blade.root", force=(3.0, 0.0, 0.0))), spun)
    np.testing.assert_allclose(pull[:, :2], 3.0 * outwards, atol=1e-7)


def test_a_deflection_is_a_position_seen_from_the_root(spun):
    angle = read(JointMotionSensor("hub", "hub"), spun)[:, 0]
    position = read(PositionSensor("tip", Place("blade", "tip")), spun)
    seen = read(DeflectionSensor("bent", Place("blade", "tip")), spun)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]).transpose(2, 0, 1)
    blade = spun[0].bodies[0].body
    rest = blade.interface("tip").position - blade.interface("root").position
    back = np.einsum("tji,tj->ti", turn, position[:, :2]) - rest[:2]
    assert abs(seen[:, :2]).max() > 1e-4
    np.testing.assert_allclose(seen[:, :2], back, atol=1e-8)
    other = read(DeflectionSensor("back", Place("blade", "root"), At("blade", "tip")), spun)
    assert abs(other).max() > 1e-4


def test_a_deflection_seen_from_another_body_is_zero_at_assembly_and_rotates_with_its_interface(
    clamped_blade,
):
    """A hub whose axes are not those of the blade on it: the blade is seen from the hub as from its root."""
    turn, centre = np.array([0.0, np.pi / 2, 0.0]), np.array([1.0, 2.0, 3.0])
    shaft = np.array([0.2, 0.0, 0.0])
    hub = RigidBody("hub", 10.0, np.zeros(3), np.eye(3), {"axle": np.zeros(3), "shaft": shaft})
    at_root = centre - [0.0, 0.0, 0.2] - clamped_blade.interface("root").position
    drive = PrescribedRotation(
        first=GROUND, second=At("hub", "axle"), axis=(0, 0, 1), angle=SpinUp(3.0, 0.4), name="axle"
    )
    weld = Fixed(first=At("hub", "shaft"), second=At("blade", "root"), name="weld")
    system = System(
        (Placed(hub, position=centre, rotation=turn), Placed(clamped_blade, position=at_root)), (drive, weld)
    )
    machine = system, simulate(system, Run(0.4, 0.02, FixedStep(0.01)))
    expected = read(DeflectionSensor("tip", "blade.tip"), machine)
    assert abs(expected).max() > 1e-3
    for interface in ("shaft", "axle"):
        seen = read(DeflectionSensor("tip", "blade.tip", At("hub", interface)), machine)
        np.testing.assert_allclose(seen, expected, atol=1e-9)
    # A rigid body does not deform, but moves as seen from the tip: by x of the hub, -z of the blade.
    back = read(DeflectionSensor("back", "hub.shaft", At("blade", "root")), machine)
    np.testing.assert_allclose(back, 0.0, atol=1e-9)
    back = read(DeflectionSensor("back", "hub.shaft", At("blade", "tip")), machine)
    same = read(DeflectionSensor("back", "blade.root", At("blade", "tip")), machine)
    assert abs(same).max() > 1e-3
    np.testing.assert_allclose(back, np.column_stack([-same[:, 2], same[:, 1], same[:, 0]]), atol=1e-9)


def test_a_mass_on_a_spring_pulls_at_it_and_at_its_guide_as_newton_says():
    mass, stiffness, rest = 2.0, 800.0, 0.5
    block = RigidBody("block", mass, np.zeros(3), np.eye(3), {"hook": np.zeros(3)})
    spring = SpringDamper(
        first=At("block", "hook"),
        second=GROUND,
        anchor=(0.0, 0.0, 1.0),
        stiffness=stiffness,
        rest_length=rest,
    )
    guide = Prismatic(first=GROUND, second=At("block", "hook"), axis=(0.0, 0.0, 1.0), name="guide")
    system = System((Placed(block),), (guide,), (spring,), gravity=np.array([3.0, 0.0, 0.0]))
    machine = system, simulate(system, Run(0.5, 0.005, FixedStep(0.0005)))
    times = machine[1].times
    omega = np.sqrt(stiffness / mass)
    # From rest at z = 0 the spring, pulled from 0.5 to 1, swings about z = 0.5.
    exact = rest * (1 - np.cos(omega * times))
    slide, speed = read(JointMotionSensor("guide", "guide"), machine)[:, 2:].T
    np.testing.assert_allclose(slide, exact, atol=2e-4)
    np.testing.assert_allclose(speed, rest * omega * np.sin(omega * times), atol=5e-3)
    force = read(SpringForceSensor("spring", spring), machine)
    np.testing.assert_allclose(force[:, 2], -stiffness * (1.0 - slide - rest), atol=1e-8)
    np.testing.assert_allclose(force[:, [0, 1, 3, 4, 5]], 0.0, atol=1e-10)
    held = read(JointForceSensor("guide", "guide"), machine)
    axes = guide.initial_axes
    np.testing.assert_allclose(held[:, :3] @ axes.T, np.tile([-mass * 3.0, 0, 0], (len(times), 1)), atol=1e-6)


@pytest.mark.slow
def test_an_accelerometer_on_a_shaken_base_shows_the_acceleration_in_space():
    """A mass on a spring on a shaken table, from rest: relative x'' = - w^2 x - a, in space - w^2 x."""
    mass, stiffness, amplitude, rate = 2.0, 800.0, 3.0, 13.0
    block = RigidBody("block", mass, np.zeros(3), np.eye(3), {"hook": np.zeros(3)})
    spring = SpringDamper(
        first=At("block", "hook"),
        second=GROUND,
        anchor=(0.0, 0.0, 1.0),
        stiffness=stiffness,
        rest_length=1.0,
    )
    guide = Prismatic(first=GROUND, second=At("block", "hook"), axis=(0.0, 0.0, 1.0), name="guide")
    shaken = BaseAcceleration(acceleration=Scaled((0.0, 0.0, amplitude), Sine(1.0, rate / (2 * np.pi))))
    system = System((Placed(block),), (guide,), (spring, shaken))
    machine = system, simulate(system, Run(0.5, 0.005, FixedStep(0.0005)))
    times, w = machine[1].times, np.sqrt(stiffness / mass)
    relative = -amplitude / (w**2 - rate**2) * (np.sin(rate * times) - rate / w * np.sin(w * times))
    found = read(AccelerationSensor("table", Place("block", "hook")), machine)
    np.testing.assert_allclose(found[:, 2], -(w**2) * relative, atol=5e-3 * w**2 * abs(relative).max())
    np.testing.assert_allclose(
        read(PositionSensor("p", Place("block", "hook")), machine)[:, 2], relative, atol=2e-5
    )


def test_a_pendulum_keeps_its_energy(rod):
    pivot = Revolute(first=GROUND, second=At("rod", "left"), axis=(0.0, 1.0, 0.0))
    system = System((Placed(rod("rod", 1.0)),), (pivot,), gravity=np.array([0.0, 0.0, -9.81]))
    machine = system, simulate(system, Run(1.0, 0.01, FixedStep(0.002)))
    kinetic, strain, potential, total = read(EnergySensor("energy"), machine).T
    assert kinetic.max() > 4.0
    np.testing.assert_allclose(strain, 0.0)
    np.testing.assert_allclose(total, total[0], atol=1e-4 * kinetic.max())
    np.testing.assert_allclose(kinetic + potential, total)


@pytest.fixture(scope="module")
def bent():
    """A strip clamped at x = 0 that bends under its own weight: full body at rest, its elements."""
    wall = HomogeneousSection(Isotropic(2.1e11, 0.0, 7850.0), 0.01)
    model = shell_model(strip(1.0, 0.1, 16, 2), wall)
    body = flexible_body("strip", model, (RigidInterface("root", "root"),))
    system = System(
        (Placed(FullBody(body, NodalFixedFrame("root"))),),
        (Fixed(first=GROUND, second=At("strip", "root")),),
        gravity=np.array([0.0, 0.0, -9.81]),
    )
    return (system, equilibrium(system).solution), model


def test_stress_and_strain_of_a_bent_strip_are_those_of_the_beam(bent):
    machine, model = bent
    node = int(np.argmin(np.linalg.norm(model.mesh.nodes - [0.5, 0.0, 0.0], axis=1)))
    density, height, g, young = 7850.0, 0.01, 9.81, 2.1e11
    moment_per_area = density * g * 0.5**2 / 2 * 6 / height  # M h/2 / (h^3/12), per width
    low, middle, high = read(StressSensor("s", "strip", model, node, Component("xx")), machine)[0]
    assert high == pytest.approx(moment_per_area, rel=0.01), "the upper side is pulled"
    assert low == pytest.approx(-moment_per_area, rel=0.01)
    assert abs(middle) < 1e-2 * high
    first, second, third = read(StressSensor("p", "strip", model, node, Principal()), machine)[0, 6:]
    assert first == pytest.approx(high, rel=1e-3)
    assert max(abs(second), abs(third)) < 1e-2 * high
    equivalent = read(StressSensor("m", "strip", model, node), machine)[0]
    assert equivalent[2] == pytest.approx(abs(high), rel=2e-2)
    gauge = read(StrainSensor("e", "strip", model, node, Component("xx")), machine)[0]
    np.testing.assert_allclose(gauge * young, [low, middle, high], rtol=1e-6, atol=1e-6 * high)
    assert read(StrainSensor("v", "strip", model, node, VonMises()), machine)[0, 2] > 0


def test_readings_are_written_with_all_digits_units_and_axes(spun, tmp_path):
    sensors = [
        PositionSensor("tip", Place("blade", "tip")),
        JointMotionSensor("hub motion", "hub"),
        EnergySensor("energy"),
    ]
    readings = read_sensors(sensors, *spun)
    path = write_readings(tmp_path / "sensors.csv", readings, units=SI)
    with path.open(newline="") as file:
        heads, *rows = csv.reader(file)
    assert heads[:6] == [
        "Time_[s]",
        "tip.x_[m]",
        "tip.y_[m]",
        "tip.z_[m]",
        "hub motion.angle_[rad]",
        "hub motion.rate_[rad/s]",
    ]
    table = np.array(rows, dtype=float)
    np.testing.assert_array_equal(table[:, 0], spun[1].times)
    np.testing.assert_array_equal(table[:, 1:4], readings[0].values)
    with h5py.File(write_readings(tmp_path / "sensors.h5", readings, units=SI)) as file:
        np.testing.assert_array_equal(file["tip"], readings[0].values)
        assert np.asarray(file["tip"].attrs["units"]).tolist() == ["m"] * 3
        assert np.asarray(file["hub motion"].attrs["channels"]).tolist() == [
            "angle",
            "rate",
            "slide",
            "speed",
        ]
        assert file["time"].attrs["unit"] == "s"
    told = readings[0].plain(SI)["x"]
    assert told["largest"] == readings[0].values[:, 0].max()
    assert told["unit"] == "m"


@pytest.mark.parametrize("names", [("time",), ("tip", "tip/side"), ("/",)])
def test_names_that_hdf5_cannot_have_are_refused(spun, tmp_path, names):
    readings = read_sensors([PositionSensor(name, Place("blade", "tip")) for name in names], *spun)
    with pytest.raises(ModelError, match=r"(give another|rename one)"):
        write_readings(tmp_path / "a.h5", readings)
    write_readings(tmp_path / "a.csv", readings)


def test_readings_as_a_data_set(spun):
    pytest.importorskip("xarray")
    readings = read_sensors([PositionSensor("tip", Place("blade", "tip"))], *spun)
    data = readings.to_xarray(SI)
    np.testing.assert_array_equal(data["tip.x"], readings[0].values[:, 0])
    assert data["tip.x"].attrs == {"units": "m", "axes": "global"}
    np.testing.assert_array_equal(data["time"], spun[1].times)


@pytest.mark.parametrize(
    ("sensor", "cause"),
    [
        (PositionSensor("p", Place("blades", "tip")), "blades"),
        (VelocitySensor("v", Place("blade", "tipp")), "tipp"),
        (JointMotionSensor("j", "hob"), "did you mean 'hub'"),
        (JointForceSensor("j", "hob"), "did you mean 'hub'"),
    ],
)
def test_what_is_not_there_is_named(spun, sensor, cause):
    with pytest.raises(ModelError, match=cause):
        read_sensors([sensor], *spun)


def test_places_and_ends_are_read_as_joints_read_them(spun):
    place = Place("blade", "tip")
    assert PositionSensor("p", "blade.tip").place == place
    assert VelocitySensor("v", At("blade", "tip")).place == place
    assert DeflectionSensor("d", "blade.tip", "blade.root").seen_from == At("blade", "root")
    assert AngularVelocitySensor("w", "blade.tip").at == At("blade", "tip")
    assert AccelerationSensor("a", Place("blade", np.array([3, 5]))).place.at == (3, 5)


def test_a_deflection_of_explicit_elements_is_seen_from_a_node_set():
    """Stretched by a thousandth and turned by a right angle: a thousandth of its length along its axis."""
    bar = bar_as("finite elements")
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    nodes = (bar.nodes * [1.001, 1.0, 1.0]) @ turn.T + [3.0, 0.0, 0.0]
    still, cells = np.zeros((1, *nodes.shape)), np.ones((1, 8))
    motion = NodalMotion(nodes[None], still, still, 0 * cells, 0 * cells, cells)
    machine = System([bar]), Solution(np.zeros(1), {"bar": motion}, {}, Statistics())
    end = tuple(np.flatnonzero(np.isclose(bar.nodes[:, 0], 1.0)).tolist())
    seen = read(DeflectionSensor("bent", Place("bar", end), At("bar", "root")), machine)
    np.testing.assert_allclose(seen, [[1e-3, 0.0, 0.0]], atol=1e-12)
    with pytest.raises(ModelError, match="whose energies are recorded with the run"):
        EnergySensor("energy").channels(machine[0])
    with pytest.raises(ModelError, match="reference of its deflection: give seen_from"):
        read(DeflectionSensor("bent", Place("bar", end)), machine)


def test_a_place_without_nodes_is_refused():
    with pytest.raises(ModelError, match="a place of body 'blade': give an interface, or node numbers"):
        Place("blade", ())


@pytest.mark.parametrize(
    ("make", "cause"),
    [
        (lambda _: PositionSensor("p", "blade"), r"PositionSensor 'p', place: expected Place\(body, at\)"),
        (lambda _: PositionSensor("p", 7), r"expected Place\(body, at\) .* got 7"),
        (lambda _: VelocitySensor("", Place("blade", "tip")), "the name of the sensor, got ''"),
        (lambda _: Place("blade", 3), "the name of an interface, or node numbers, got 3"),
        (lambda spun: JointForceSensor("j", spun[0].joints[0]), "JointForceSensor, joint: expected a string"),
        (lambda _: JointMotionSensor("j", 1), "JointMotionSensor, joint: expected a string"),
        (lambda _: SpringForceSensor("s", "spring"), "SpringForceSensor, element: expected"),
        (lambda _: StressSensor("s", "blade", "mesh", 3), "StressSensor, model: expected"),
        (lambda spun: read_sensors(EnergySensor("e"), *spun), "read_sensors, sensors: expected a list"),
        (
            lambda spun: write_readings("x.csv", read_sensors([EnergySensor("e")], *spun), units="SI"),
            "write_readings, units: expected an object of the kind UnitSystem, got 'SI'",
        ),
    ],
)
def test_mistakes_are_named_where_they_are_made(spun, make, cause):
    with pytest.raises(ArgumentError, match=cause):
        make(spun)


def test_a_rigid_body_has_no_stress(rod, bent):
    _, model = bent
    system = System((Placed(rod("rod", 1.0)),))
    machine = system, equilibrium(system).solution
    with pytest.raises(ModelError, match="body 'rod' is rigid: it has no stress"):
        read_sensors([StressSensor("s", "rod", model, 0)], *machine)


def test_names_differ_and_components_exist(spun):
    twice = [EnergySensor("one"), EnergySensor("one")]
    with pytest.raises(ModelError, match="names must differ"):
        read_sensors(twice, *spun)
    with pytest.raises(ModelError, match="no component 'xz2'"):
        Component("xz2")
    with pytest.raises(ModelError, match="at least one sensor"):
        write_readings("nowhere.csv", [])
