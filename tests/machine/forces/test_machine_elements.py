"""What elements between two ends have in common, on random motions; and what is refused.

Forces that hold each other in balance keep momentum and angular momentum; elements that store energy give
back what they take: the power of the wrenches is the fall of their energy.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple import machine as m
from supple.algebra.rotation import rotation_exp
from supple.errors import ModelError
from supple.machine.pose import Pose

ENDS = {"first": "a.eye", "second": "b.eye"}
AXIS = {**ENDS, "axis": (0.2, -0.3, 0.9)}
PENALTY = m.Penalty(stiffness=50.0, exponent=1.5)
RNG = np.random.default_rng(16)
SQUARE = RNG.normal(size=(6, 6))

STORING = {
    "spring": m.SpringDamper(**ENDS, stiffness=7.0, rest_length=0.3),
    "torsion spring": m.TorsionSpringDamper(**AXIS, stiffness=3.0, rest_angle=0.2),
    "bushing": m.Bushing(**ENDS, stiffness=SQUARE @ SQUARE.T, x_axis=(1, 1, 0)),
    "slide stop": m.SlideStop(**AXIS, lower=-0.1, upper=-0.05, penalty=PENALTY),
    "distance stop": m.DistanceStop(**ENDS, upper=0.2, penalty=PENALTY),
    "gear": m.Gear(**AXIS, teeth=(17, 40), stiffness=4.0),
    "ring gear": m.Gear(**AXIS, teeth=(17, -40), stiffness=4.0),
    "screw": m.Screw(**AXIS, pitch=0.7, stiffness=5.0),
    "rack and pinion": m.RackAndPinion(**AXIS, direction=(1, 0, 0), radius=0.2, stiffness=5.0),
    "on a plane": m.SphereOnPlane(**AXIS, radius=2.0, penalty=PENALTY),
    "on a cylinder": m.SphereOnCylinder(**AXIS, radius=0.8, cylinder_radius=0.7, penalty=PENALTY),
    "in a cylinder": m.SphereInCylinder(**AXIS, radius=0.01, cylinder_radius=0.02, penalty=PENALTY),
}
OTHERS = {
    "damped bushing": m.Bushing(**ENDS, stiffness=[1] * 6, damping=[2] * 6),
    "torque": m.TorqueBetween(**AXIS, torque=2.0),
    "force": m.ForceBetween(**AXIS, force=2.0),
    "hinge friction": m.RevoluteFriction(**AXIS, moment=2.0, width=0.1),
    "slide friction": m.PrismaticFriction(**AXIS, force=2.0, width=0.1),
    "servo": m.AngleServo(**AXIS, angle=lambda t: 0.3 * t, stiffness=2.0, damping=0.3, limit=0.4),
    "slide servo": m.SlideServo(**AXIS, slide=0.1, stiffness=2.0, damping=0.3),
    "motor": m.MotorCurve(**AXIS, torque=m.Curve([-2, 0, 2], [3, 2, -1])),
    "motor with a command": m.MotorCurve(
        **AXIS, torque=m.Surface([-2, 2], [0, 2], [[1, 2], [3, 5]]), command=0.5
    ),
    "table of torque": m.TabledTorque(**AXIS, torque=m.Surface([-4, 4], [-3, 3], [[1, 2], [3, 5]])),
    "table of force": m.TabledForce(**AXIS, force=m.Surface([-4, 4], [-3, 3], [[1, 2], [3, 5]])),
    "table of tension": m.TabledTension(**ENDS, tension=m.Surface([0, 4], [-3, 3], [[1, 2], [3, 5]])),
    "bearing": m.JournalBearing(**AXIS, stiffness=[[3, 1], [-1, 4]], damping=[[0.3, 0], [0, 0.2]]),
    "contact with friction": m.SphereOnPlane(
        **AXIS, radius=2.0, penalty=PENALTY, friction=m.Coulomb(coefficient=0.4, width=0.1)
    ),
}


def ends(seed):
    """Two ends near each other, moving somehow."""
    rng = np.random.default_rng(seed)

    def of(point):
        axes = rotation_exp(jnp.array(rng.normal(size=3) * 0.3))
        velocity, spin = jnp.array(rng.normal(size=(2, 3)))
        return Pose(jnp.array(point + 0.2 * rng.normal(size=3)), axes, velocity, spin)

    return of(np.zeros(3)), of([0.6, 0.3, -0.5])


def put_together(element):
    """With its ends where they were, and its own axes on both poses."""
    element = element.assembled(np.zeros(3), np.array([0.6, 0.3, -0.5]))
    value = None if element.law is None else element.law(1.5)
    return element, value


def poses(element, seed):
    return tuple(pose._replace(axes=pose.axes @ element.initial_axes) for pose in ends(seed))


def hinged(first, second):
    """The second end's axes turned about the first's z alone, by 0.8 rad."""
    axis = first.axes[:, 2]
    axes = first.axes @ rotation_exp(jnp.array([0, 0, 0.8]))
    return second._replace(axes=axes, angular_velocity=first.angular_velocity + 1.3 * axis)


def after(pose, time):
    """The pose moved on, at constant velocities."""
    turned = rotation_exp(time * pose.angular_velocity) @ pose.axes
    return pose._replace(point=pose.point + time * pose.velocity, axes=turned)


def power(pose, wrench):
    return wrench.force @ pose.velocity + wrench.moment @ pose.angular_velocity


@pytest.mark.parametrize("name", [*STORING, *OTHERS])
def test_forces_balance_each_other(name):
    element, value = put_together((STORING | OTHERS)[name])

    @jax.jit
    def loads(first, second):
        on_first, on_second = element.wrenches(first, second, value, element.parameters)
        about = [
            jnp.cross(end.point, own.force) + own.moment
            for end, own in ((first, on_first), (second, on_second))
        ]
        return on_first.force, on_second.force, *about

    for seed in range(3):
        found = loads(*poses(element, seed))
        size = float(np.abs(found).max())
        assert size > 1e-3
        np.testing.assert_allclose(found[0], -found[1], atol=1e-13 * size)
        np.testing.assert_allclose(found[2], -found[3], atol=1e-13 * size)


@pytest.mark.parametrize("name", [name for name in STORING if not name.endswith("gear")])
def test_what_is_stored_is_given_back(name):
    element, value = put_together(STORING[name])

    @jax.jit
    def stored_and_given(first, second):
        def stored(time):
            return element.energy(after(first, time), after(second, time), value, element.parameters)

        wrenches = element.wrenches(first, second, value, element.parameters)
        given = sum(power(end, own) for end, own in zip((first, second), wrenches, strict=True))
        return *jax.jvp(stored, (0.0,), (1.0,)), given

    for seed in range(3):
        first, second = poses(element, seed)
        if name in ("torsion spring", "screw", "rack and pinion"):  # whose angle is that of a hinge
            second = hinged(first, second)
        energy, rate, given = stored_and_given(first, second)
        assert energy > 1e-3
        np.testing.assert_allclose(given, -rate, rtol=1e-10, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("teeth", [(17, 40), (17, -40)])
def test_a_gear_gives_back_what_it_stores_whatever_its_carrier_does(teeth):
    """Parallel axes at a constant distance, the line of centres turning."""
    gear = m.Gear(**ENDS, axis=(0, 0, 1), teeth=teeth, stiffness=4.0, line=(1, 0, 0))
    carrier, spins = 0.7, (2.0, -1.3)

    def wheels(time):
        def wheel(spin, radius):
            turn = rotation_exp(jnp.array([0, 0, 1.0]) * (spin * time + 0.01))
            line = jnp.array([jnp.cos(carrier * time), jnp.sin(carrier * time), 0.0])
            across = jnp.array([-jnp.sin(carrier * time), jnp.cos(carrier * time), 0.0])
            return Pose(radius * line, turn, radius * carrier * across, jnp.array([0, 0, spin]))

        return wheel(spins[0], 0.1), wheel(spins[1], 0.6)

    def stored(time):
        return gear.energy(*wheels(time), None, gear.parameters)

    energy, rate = jax.jvp(stored, (0.002,), (1.0,))
    both = wheels(0.002)
    wrenches = gear.wrenches(*both, None, gear.parameters)
    given = sum(power(end, own) for end, own in zip(both, wrenches, strict=True))
    assert energy > 1e-8
    np.testing.assert_allclose(given, -rate, rtol=1e-10)


@pytest.mark.parametrize("teeth", [(20, 60), (20, -60), (35, -20)])
def test_wheels_that_roll_carry_nothing(teeth):
    """Turned by many turns in the ratio of Willis, seen from a carrier that turns as well."""
    gear = m.Gear(**ENDS, axis=(0, 0, 1), teeth=teeth, stiffness=4.0, line=(1, 0, 0))
    for turns in (0.3, 7.7, -123.4):
        carrier = 2.1 * turns
        first = carrier + turns
        second = carrier - turns * teeth[0] / teeth[1]
        line = np.array([np.cos(carrier), np.sin(carrier), 0])

        def pose(angle, point):
            return Pose(jnp.array(point), rotation_exp(jnp.array([0, 0, angle])), jnp.zeros(3), jnp.zeros(3))

        _, on_second = gear.wrenches(pose(first, 0 * line), pose(second, line), None, gear.parameters)
        np.testing.assert_allclose(on_second.force, 0, atol=1e-11)


def test_a_bushing_is_its_matrix_for_small_motions():
    """Offset and rotation vector in the bushing's axes, which are turned."""
    bushing = m.Bushing(
        **ENDS, stiffness=SQUARE @ SQUARE.T, damping=np.eye(6), axis=(0, 1, 0), x_axis=(0, 0, 1)
    )
    axes = bushing.initial_axes
    x, rate = 1e-6 * RNG.normal(size=6), 1e-6 * RNG.normal(size=6)
    still = Pose(jnp.zeros(3), jnp.array(axes), jnp.zeros(3), jnp.zeros(3))
    moved = Pose(
        jnp.array(axes @ x[:3]),
        axes @ rotation_exp(jnp.array(x[3:])),
        jnp.array(axes @ rate[:3]),
        jnp.array(axes @ rate[3:]),
    )
    _, on_second = bushing.wrenches(still, moved, None, bushing.parameters)
    found = np.concatenate([axes.T @ on_second.force, axes.T @ on_second.moment])
    np.testing.assert_allclose(found, -(SQUARE @ SQUARE.T @ x + rate), rtol=1e-5)


@pytest.mark.parametrize("free", [(0,), (3,), (5,), (0, 1, 2), range(6)])
def test_a_bushing_may_leave_some_motions_free(free):
    """It resists the others alone, whatever the units of the rest."""
    stiffness = np.array([1e8, 2e8, 3e8, 40.0, 50.0, 60.0])
    stiffness[list(free)] = 0.0
    bushing = m.Bushing(**ENDS, stiffness=stiffness, damping=1e-3 * stiffness)
    np.testing.assert_array_equal(bushing.stiffness, np.diag(stiffness))
    still = Pose(jnp.zeros(3), jnp.eye(3), jnp.zeros(3), jnp.zeros(3))
    moved = still._replace(point=1e-6 * jnp.ones(3), axes=rotation_exp(1e-6 * jnp.ones(3)))
    _, on_second = bushing.wrenches(still, moved, None, bushing.parameters)
    found = np.concatenate([on_second.force, on_second.moment])
    np.testing.assert_allclose(found, -1e-6 * stiffness, rtol=1e-5, atol=1e-9)


def test_a_free_motion_of_a_bushing_is_coupled_to_no_other():
    coupled = np.diag([1.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    coupled[0, 1] = coupled[1, 0] = 0.1
    with pytest.raises(ModelError, match="must not be negative in any direction"):
        m.Bushing(**ENDS, stiffness=coupled)


def test_vectors_may_be_arrays():
    """A bushing displaced by its offset is free of force; a gear keeps its given line of centres."""
    offset = np.array([0.1, 0.2, -0.3])
    bushing = m.Bushing(**ENDS, stiffness=[1.0] * 6, offset=offset).assembled(np.zeros(3), np.ones(3))
    still = Pose(jnp.zeros(3), jnp.eye(3), jnp.zeros(3), jnp.zeros(3))
    _, on_second = bushing.wrenches(still, still._replace(point=offset), None, bushing.parameters)
    np.testing.assert_allclose(on_second.force, 0.0, atol=1e-15)
    gear = m.Gear(**ENDS, axis=(0, 0, 1), teeth=(10, 20), stiffness=1.0, line=np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(gear.assembled(np.zeros(3), np.ones(3)).initial_axes[:, 0], [0, 1, 0])


def test_slopes_at_rows_are_those_of_the_intervals():
    curve = m.Curve([-3, 0, 3], [6, 0, -6])  # a straight line: the slope is -2 everywhere
    surface = m.Surface([-3, 0, 3], [-1, 0, 1], np.add.outer([6, 0, -6], [-5, 0, 5]))
    for x in (-3.0, 0.0, 1.0, 3.0):
        assert float(jax.grad(curve)(x)) == pytest.approx(-2)
        np.testing.assert_allclose(jax.grad(surface, (0, 1))(x, x / 3), (-2, 5), rtol=1e-15)
    assert float(jax.grad(curve)(3.1)) == 0.0


def test_tables_in_one_variable_and_in_two():
    curve = m.Curve([0, 1, 3], [2, 4, 0])
    np.testing.assert_allclose([curve(x) for x in (-1, 0, 0.5, 2, 3, 9)], [2, 2, 3, 2, 0, 0])
    surface = m.Surface([0, 1], [0, 2], [[1, 3], [5, 11]])
    np.testing.assert_allclose(surface(0.5, 1.0), 5.0)
    np.testing.assert_allclose([surface(-1, 5), surface(9, -9)], [3, 5])


def test_a_table_of_tension_acts_along_the_line():
    """A linear table, 7 (l - 0.3) + 2 dl/dt, is a spring and damper of the same numbers."""
    lengths, rates = np.array([0.0, 4.0]), np.array([-9.0, 9.0])
    table = m.Surface(lengths, rates, 7.0 * (lengths[:, None] - 0.3) + 2.0 * rates)
    tabled = m.TabledTension(**ENDS, tension=table)
    same = m.SpringDamper(**ENDS, stiffness=7.0, damping=2.0, rest_length=0.3)
    first, second = ends(3)
    for own, other in zip(
        *(each.wrenches(first, second, None, each.parameters) for each in (tabled, same)), strict=True
    ):
        np.testing.assert_allclose(own.force, other.force, rtol=1e-6)
        assert not np.any(own.moment)


@pytest.mark.parametrize("first_row", [0.0, -np.pi, -0.5 * np.pi])
@pytest.mark.parametrize("angle", [0.1, 1.9, 3.3, 6.1, -0.7, 11.0])
def test_a_table_of_torque_over_one_revolution_is_periodic(first_row, angle):
    rows = first_row + np.linspace(0.0, 2 * np.pi, 721)
    table = m.Surface(rows, [-1, 1], np.stack([np.sin(rows), np.sin(rows)], axis=1))
    element = m.TabledTorque(**ENDS, axis=(0, 0, 1), torque=table)
    still = Pose(jnp.zeros(3), jnp.eye(3), jnp.zeros(3), jnp.zeros(3))
    turned = still._replace(axes=rotation_exp(jnp.array([0, 0, angle])))
    _, on_second = element.wrenches(still, turned, None, element.parameters)
    np.testing.assert_allclose(on_second.moment[2], np.sin(angle), atol=2e-5)


def test_a_motor_gives_what_its_curve_says():
    element, value = put_together(OTHERS["motor with a command"])
    still = Pose(jnp.zeros(3), jnp.array(element.initial_axes), jnp.zeros(3), jnp.zeros(3))
    turning = still._replace(angular_velocity=1.0 * still.axes[:, 2])
    _, on_second = element.wrenches(still, turning, value, element.parameters)
    # Three quarters down from 1.25 to 3.5.
    np.testing.assert_allclose(
        on_second.moment, (1.25 + 0.75 * 2.25) * np.asarray(still.axes[:, 2]), rtol=1e-14
    )


def test_a_servo_is_held_within_its_limit_and_counts_whole_turns():
    servo = m.AngleServo(**ENDS, axis=(0, 0, 1), angle=lambda t: 2 * np.pi * t, stiffness=5.0, damping=2.0)
    still = Pose(jnp.zeros(3), jnp.eye(3), jnp.zeros(3), jnp.zeros(3))
    _, on_second = servo.wrenches(still, still, servo.law(3.01), servo.parameters)
    np.testing.assert_allclose(on_second.moment[2], 5 * 2 * np.pi * 0.01 + 2 * 2 * np.pi, rtol=1e-12)
    limited = (5.0, 2.0, 0.7)
    np.testing.assert_allclose(servo.wrenches(still, still, servo.law(3.01), limited)[1].moment[2], 0.7)


@pytest.mark.parametrize(("angle", "depth"), [(3.2, 0.1), (-0.4, -0.2), (1.5, 0.0)])
def test_a_stop_near_half_a_revolution_pushes_back_beyond_it(angle, depth):
    """At 3.2 rad the wrapped angle, -3.08, is far below the lower limit, on the other side of the range."""
    stop = m.AngleStop(
        **ENDS, axis=(0, 0, 1), lower=-0.2, upper=3.1, penalty=m.Penalty(stiffness=50.0, dissipation=0.5)
    )
    still = Pose(jnp.zeros(3), jnp.eye(3), jnp.zeros(3), jnp.zeros(3))
    turned = still._replace(axes=rotation_exp(jnp.array([0, 0, angle])))
    _, on_second = stop.wrenches(still, turned, None, stop.parameters)
    np.testing.assert_allclose(on_second.moment[2], -50 * depth, atol=1e-12)
    np.testing.assert_allclose(stop.energy(still, turned, None, stop.parameters), 25 * depth**2, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: m.Penalty(stiffness=0.0), "stiffness must be finite and positive"),
        (lambda: m.Penalty(stiffness=1.0, exponent=0.5), "exponent must be finite and at least 1"),
        (lambda: m.Penalty(stiffness=1.0, dissipation=-1.0), "dissipation must be finite, not negative"),
        (lambda: m.Coulomb(coefficient=-1.0, width=1.0), "friction coefficient must be finite"),
        (
            lambda: m.Coulomb(coefficient=1.0, width=0.0),
            "width of a friction law must be a positive velocity",
        ),
        (lambda: m.RevoluteFriction(**AXIS, moment=1.0, width=0.0), "width must be finite and positive"),
        (lambda: m.RevoluteFriction(**AXIS, moment=-1.0, width=0.1), "moment must not be negative"),
        (lambda: m.PrismaticFriction(**AXIS, force=-1, width=0.1), "force must not be negative"),
        (lambda: m.Bushing(**ENDS, stiffness=np.ones(5)), r"must be \(6,\) or \(6, 6\) finite numbers"),
        (lambda: m.Bushing(**ENDS, stiffness=SQUARE), "must be symmetric"),
        (lambda: m.Bushing(**ENDS, stiffness=[1, 1, -1, 1, 1, 1]), "must not be negative"),
        (lambda: m.AngleStop(**AXIS, lower=0.0, upper=4.0, penalty=PENALTY), "-pi < lower <= upper < pi"),
        (lambda: m.SlideStop(**AXIS, lower=1.0, upper=0.0, penalty=PENALTY), "lower must not be above upper"),
        (lambda: m.DistanceStop(first="a.eye", penalty=PENALTY), "needs an anchor"),
        (lambda: m.Gear(**AXIS, teeth=(1.5, 2), stiffness=1.0), "two whole numbers"),
        (lambda: m.Gear(**AXIS, teeth=(20, -20), stiffness=1.0), "not opposite and equal"),
        (lambda: m.Screw(**AXIS, pitch=0.0, stiffness=1.0), "pitch must be finite and not zero"),
        (
            lambda: m.RackAndPinion(**AXIS, direction=(1, 0, 0), radius=0.0, stiffness=1.0),
            "radius must be finite and not zero",
        ),
        (lambda: m.AngleServo(**AXIS, angle=0.0, stiffness=1.0, limit=0.0), "limit must be positive"),
        (lambda: m.Curve([0, 0], [1, 2]), "two or more ascending numbers"),
        (lambda: m.Curve([0, 1], [1, 2, 3]), "2 points, and values of shape"),
        (lambda: m.Surface([0, 1], [0, 1], [[1, 2]]), "2 rows and 2 columns"),
        (lambda: m.Curve([0, 1], [1, np.nan]), "every number must be finite"),
        (lambda: m.JournalBearing(**AXIS, stiffness=np.eye(3)), r"must be \(2, 2\) or \(2, 2, 2\)"),
        (
            lambda: m.JournalBearing(**AXIS, stiffness=[np.eye(2), 2 * np.eye(2)]),
            "needs the speeds of its mat",
        ),
        (lambda: m.JournalBearing(**AXIS, stiffness=np.eye(2), speeds=(1, 0)), "speeds must be two or more"),
        (lambda: m.Unbalance(first="a.eye", moment=(1, 2)), "three finite numbers"),
        (
            lambda: m.Unbalance(first="ground", second="a.eye", moment=(1, 2, 3)),
            r"on its first end alone, so on the ground it has no effect: give first='a\.eye'",
        ),
        (
            lambda: m.FollowerTorque(first="ground", second="a.eye", torque=(1, 2, 3)),
            "on its first end alone, so on the ground it has no effect",
        ),
        (
            lambda: m.SphereInCylinder(**AXIS, radius=1.0, cylinder_radius=0.5, penalty=PENALTY),
            "must be more than the sphere's",
        ),
    ],
)
def test_what_is_refused(make, message):
    with pytest.raises(ModelError, match=message):
        make()
