"""Controllers with states in equilibria and linear equations: characteristic polynomials, exact tangents."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg

from supple import machine as m
from supple.body import RigidBody
from supple.equations import StaticSearch
from supple.equations.build_model import build_model
from supple.equations.configuration import advance
from supple.equations.consistent_start import placed_configuration
from supple.equations.control_linearization import control_at_rest
from supple.equations.steady_motion import SteadyRotation, steady_motion
from supple.errors import ConvergenceError, ModelError
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.linearization import (
    RotationPort,
    Velocity,
    campbell_diagram,
    frequency_response,
    linearize,
    machine_modes,
    state_space,
)
from supple.simulation import equilibrium, simulate

MASS, ARM, INERTIA, GRAVITY = 3.0, 0.4, 0.7, 9.81
AXIS = (0.0, 0.0, 1.0)
HINGE = {"hinge": m.JointReading("hinge")}
GOAL, P, INTEGRAL, D = 0.3, 40.0, 60.0, 5.0


def pendulum(controllers, gravity=GRAVITY):
    """Level at angle zero; its moment of inertia about the hinge is `INERTIA`."""
    own = (INERTIA - MASS * ARM**2) * np.eye(3)
    body = RigidBody("arm", MASS, [ARM, 0, 0], own, {"root": (0, 0, 0), "mass": (ARM, 0, 0)})
    joint = m.Revolute(first="ground", second="arm.root", axis=AXIS, name="hinge")
    return m.System([body], [joint], gravity=(0, -gravity, 0), controllers=controllers)


def motor():
    return {"motor": m.TorqueBetween(first="ground", second="arm.root", axis=AXIS)}


def controller(rates, outputs, initial, **given):
    return m.Controller(
        reads=given.pop("reads", HINGE),
        drives=motor(),
        rates=rates,
        outputs=outputs,
        initial=initial,
        **given,
    )


PID = controller(
    lambda _t, reads, _z: jnp.stack([GOAL - reads["hinge"].angle]),
    lambda _t, reads, z: {
        "motor": P * (GOAL - reads["hinge"].angle) + INTEGRAL * z[0] - D * reads["hinge"].rate
    },
    [0.0],
    name="pid",
)


def eigenvalues(system, **given):
    return machine_modes(linearize(system, **given)).eigenvalues


def roots(polynomial):
    """As modes give them: of a pair the one above."""
    found = np.roots(polynomial)
    found = found[found.imag >= 0]
    return found[np.lexsort((found.real, abs(found)))]


def turned(placed):
    return np.arctan2(placed.rotation[1, 0], placed.rotation[0, 0])


@pytest.mark.slow
def test_an_integrator_holds_a_pendulum_where_it_shall_be():
    found = equilibrium(pendulum([PID]))
    weight = MASS * GRAVITY * ARM
    np.testing.assert_allclose(turned(found.system.bodies[0]), GOAL, atol=1e-10)
    np.testing.assert_allclose(
        found.system.controllers[0].initial, [weight * np.cos(GOAL) / INTEGRAL], rtol=1e-9
    )
    gravity_stiffness = -weight * np.sin(GOAL)
    expected = roots([INERTIA, D, P + gravity_stiffness, INTEGRAL])
    np.testing.assert_allclose(eigenvalues(pendulum([PID])), expected, rtol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(("length", "time", "mass"), [(1e3, 1e3, 1.0), (1e6, 1e9, 1e3)], ids=["ms", "ns"])
def test_eigenvalues_are_those_of_any_units(length, time, mass):
    """Millimetres, milliseconds, kilograms; micrometres, nanoseconds, grams."""
    torque, arm = mass * length**2 / time**2, ARM * length
    faces = {"root": (0, 0, 0)}
    inertia = (INERTIA - MASS * ARM**2) * mass * length**2 * np.eye(3)
    body = RigidBody("arm", MASS * mass, [arm, 0, 0], inertia, faces)

    def outputs(_t, reads, z):
        hinge = reads["hinge"]
        wanted = P * (GOAL - hinge.angle) + INTEGRAL / time * z[0] - D * time * hinge.rate
        return {"motor": torque * wanted}

    system = replace(pendulum([replace(PID, outputs=outputs)]), bodies=[body])
    system = replace(system, gravity=(0, -GRAVITY * length / time**2, 0))
    np.testing.assert_allclose(time * eigenvalues(system), eigenvalues(pendulum([PID])), rtol=1e-8)


@pytest.mark.slow
def test_a_run_from_the_equilibrium_stays_there():
    system = equilibrium(pendulum([PID])).system
    run = Run(duration=0.5, output_step=0.1, step=FixedStep(0.01), tolerances=Tolerances(residual=1e-11))
    solution = simulate(system, run)
    assert abs(solution.bodies["arm"].angular_velocity).max() < 1e-8
    assert abs(solution.bodies["arm"].acceleration).max() < 1e-7


@pytest.mark.slow
def test_a_filter_of_the_rate_is_in_the_loop():
    """`J s^2 + D s / (T s + 1) + P`."""
    lag = 0.08
    own = controller(
        lambda _t, reads, z: jnp.stack([(reads["hinge"].rate - z[0]) / lag]),
        lambda _t, reads, z: {"motor": -P * reads["hinge"].angle - D * z[0]},
        [0.4],
    )
    expected = roots([INERTIA * lag, INERTIA, D + P * lag, P])
    np.testing.assert_allclose(eigenvalues(pendulum([own], gravity=0.0)), expected, rtol=1e-8)


@pytest.mark.slow
def test_a_filter_of_the_place_makes_the_loop_unstable():
    """`J s^2 (T s + 1) + P`: two roots with positive real parts, whose equilibrium is found all the same."""
    lag = 0.08
    own = controller(
        lambda _t, reads, z: jnp.stack([(reads["hinge"].angle - z[0]) / lag]),
        lambda _t, _reads, z: {"motor": -P * z[0]},
        [0.1],
    )
    system = pendulum([own], gravity=0.0)
    modes = machine_modes(linearize(system))
    np.testing.assert_allclose(modes.eigenvalues, roots([INERTIA * lag, INERTIA, 0, P]), rtol=1e-8)
    np.testing.assert_array_equal(modes.unstable, modes.eigenvalues.real > 0)
    assert modes.unstable.any()


@pytest.mark.slow
def test_two_controllers_stand_beside_each_other():
    """A PID without its D, which a second controller gives through a filter, with its states before."""
    lag = 0.05
    filtered = controller(
        lambda _t, reads, z: jnp.stack([z[1], (reads["hinge"].rate - z[0] - 2 * lag * z[1]) / lag**2]),
        lambda _t, _reads, z: {"motor": -D * z[0]},
        [0.2, -3.0],
        name="filter",
    )
    both = pendulum([filtered, replace(PID, outputs=lambda t, r, z: _without_rate(r, z))])
    stiffness = P - MASS * GRAVITY * ARM * np.sin(GOAL)
    second_order = np.array([lag**2, 2 * lag, 1.0])
    loop = np.convolve([INERTIA, 0, stiffness, INTEGRAL], second_order)
    expected = roots(np.polyadd(loop, [D, 0, 0]))
    np.testing.assert_allclose(eigenvalues(both), expected, rtol=1e-7)


def _without_rate(reads, z):
    return {"motor": P * (GOAL - reads["hinge"].angle) + INTEGRAL * z[0]}


def test_the_state_space_is_that_of_the_closed_loop():
    """`q / M = s / (J s^3 + D s^2 + K s + I)` from a moment to the angle, s times that to the rate."""
    port = RotationPort("arm.root", AXIS)
    space = state_space(linearize(pendulum([PID])), inputs=[port], outputs=[port, Velocity(port)])
    assert space.a.shape == (3, 3)
    stiffness = P - MASS * GRAVITY * ARM * np.sin(GOAL)
    w = np.array([0.3, 3.0, 8.0, 40.0])
    s = 1j * w
    expected = s / (INERTIA * s**3 + D * s**2 + stiffness * s + INTEGRAL)
    found = frequency_response(space, w).transfer[:, :, 0]
    np.testing.assert_allclose(found, np.stack([expected, s * expected], axis=1), rtol=1e-8)


@pytest.mark.slow
def test_a_small_motion_is_that_of_the_linear_equations():
    """A run with small steps from a turned start, against the exponential of A."""
    rest = equilibrium(pendulum([PID])).system
    port = RotationPort("arm.root", AXIS)
    space = state_space(linearize(rest), inputs=[port], outputs=[port])
    small, end = 1e-5, 0.4
    (arm,), (own,) = rest.bodies, rest.controllers
    turn = np.array([[np.cos(small), -np.sin(small), 0], [np.sin(small), np.cos(small), 0], [0, 0, 1]])
    moved = replace(
        rest,
        bodies=[replace(arm, rotation=turn @ arm.rotation)],
        controllers=[replace(own, initial=own.initial + 2 * small)],
    )

    def last(step):
        run = Run(
            duration=end,
            output_step=end,
            step=FixedStep(step),
            method=GeneralizedAlpha(0.9),
            tolerances=Tolerances(residual=1e-12),
        )
        rotation = simulate(moved, run).bodies["arm"].rotation[-1]
        return np.arctan2(rotation[1, 0], rotation[0, 0]) - GOAL

    start = np.concatenate([np.linalg.lstsq(space.c[:, :1], [small], rcond=None)[0], [0.0, 2 * small]])
    exact = float((space.c @ scipy.linalg.expm(end * space.a) @ start)[0])
    extrapolated = (4 * last(1e-3) - last(2e-3)) / 3
    assert abs(extrapolated - exact) < 3e-5 * small


def two_arms(controllers):
    own = 0.2 * np.eye(3)
    faces = {"root": (0, 0, 0), "tip": (0.8, 0.1, 0)}
    bodies = [
        m.Placed(RigidBody("upper", 2.0, [0.4, 0, 0], own, faces)),
        m.Placed(RigidBody("fore", 1.0, [0.3, 0, 0.1], own, faces), position=[0.8, 0.1, 0]),
    ]
    joints = [m.Ball(first="upper.tip", second="fore.root", name="elbow")]
    return m.System(bodies, joints, controllers=controllers)


@pytest.mark.slow
def test_the_tangent_of_resting_controllers_is_that_of_finite_differences():
    """Readings of places, axes and velocities of bodies that turn; forces that follow what they push."""

    def rates(_t, reads, z):
        tip = reads["tip"]
        return jnp.stack(
            [
                tip.velocity @ tip.axes[:, 0] + jnp.sin(z[1]),
                reads["elbow"].rate + tip.point[1] * z[0] + tip.angular_velocity[2],
            ]
        )

    def outputs(_t, _reads, z):
        return {"pull": z[0] ** 2 + z[1], "twist": jnp.stack([z[1], z[0], 0.5 * z[0] * z[1]])}

    own = m.Controller(
        reads={"tip": m.EndReading("fore.tip"), "elbow": m.JointReading("elbow")},
        drives={
            "pull": m.ForceBetween(first="ground", second="fore.tip", axis=(0, 1, 0)),
            "twist": m.FollowerForce(first="upper.tip", force=(0, 0, 0)),
        },
        rates=rates,
        outputs=outputs,
        initial=[0.3, -0.7],
    )
    system = two_arms([own])
    model, turning = build_model(system), SteadyRotation(np.array([[0, 0, 1.3], [0, 0, 0.4]]), np.zeros(3))
    configuration, states = placed_configuration(system), np.array([0.3, -0.7])

    def at(configuration, states, velocity_change=0.0):
        motion = steady_motion(model, turning, 0.0, configuration, np.zeros(3), states)
        motion = motion._replace(velocity=velocity + velocity_change)
        return control_at_rest(model, motion)

    velocity = steady_motion(model, turning, 0.0, configuration, np.zeros(3), states).velocity
    linear, n, h = at(configuration, states).linear, model.n_velocities, 1e-6

    def slope(of):
        return (of(h) - of(-h)) / (2 * h)

    unit = np.eye(n)
    by_position = [
        slope(lambda d, row=row: at(advance(model, configuration, d * row), states).rates) for row in unit
    ]
    by_velocity = [slope(lambda d, row=row: at(configuration, states, d * row).rates) for row in unit]
    by_state = [slope(lambda d, row=row: at(configuration, states + d * row).rates) for row in np.eye(2)]
    np.testing.assert_allclose(linear.by_position, np.transpose(by_position), atol=1e-8)
    np.testing.assert_allclose(linear.by_velocity, np.transpose(by_velocity), atol=1e-8)
    np.testing.assert_allclose(linear.by_state, np.transpose(by_state), atol=1e-8)
    assert abs(linear.by_position).max() > 0.1


def speed_loop(goal):
    """PI control of the speed of a rotor."""
    return controller(
        lambda _t, reads, _z: jnp.stack([goal - reads["hinge"].rate]),
        lambda _t, reads, z: {"motor": 6.0 * z[0] + 1.5 * (goal - reads["hinge"].rate)},
        [0.1],
        name="speed",
    )


def rotor(controllers):
    body = RigidBody("arm", 2.0, [0, 0, 0], INERTIA * np.eye(3), {"root": (0, 0, 0)})
    joint = m.Revolute(first="ground", second="arm.root", axis=AXIS, name="hinge")
    return m.System([body], [joint], controllers=controllers)


@pytest.mark.slow
def test_a_speed_loop_turns_steadily():
    """`J s^2 + 1.5 s + 6` of the rate, and the free angle at zero; the same at each rate."""
    modes = machine_modes(linearize(rotor([speed_loop(2.0)]), spin=m.Spin(2.0, AXIS)))
    expected = np.concatenate([[0.0], roots([INERTIA, 1.5, 6.0])])
    np.testing.assert_allclose(modes.eigenvalues, expected, atol=1e-8)
    np.testing.assert_allclose(modes.kinetic_shares, 1.0, rtol=1e-12)


@pytest.mark.slow
def test_a_controller_without_rest_is_named():
    few = StaticSearch(max_iterations=20)
    with pytest.raises(
        ConvergenceError, match=r"state 0 of controller 'speed' has the rate 2\. An integrator"
    ):
        equilibrium(rotor([speed_loop(2.0)]), search=few)
    drifting = replace(PID, rates=lambda _t, reads, _z: jnp.stack([0.1 + 0 * reads["hinge"].angle]))
    with pytest.raises(ConvergenceError, match=r"state 0 of controller 'pid' has the rate 0.1"):
        equilibrium(pendulum([drifting]), search=few)
    leaking = replace(PID, rates=lambda _t, _reads, z: 0.1 - z / 5.0)
    found = equilibrium(pendulum([leaking]))
    np.testing.assert_allclose(found.system.controllers[0].initial, [0.5], rtol=1e-9)


@pytest.mark.slow
def test_a_controller_that_sees_the_angle_of_the_turn_is_refused():
    def watching(reads, z):
        return jnp.stack([jnp.sin(reads["hinge"].angle) - z[0]])

    seeing = controller(
        lambda _t, reads, z: watching(reads, z), lambda _t, _reads, z: {"motor": 0.0 * z[0]}, [0.0]
    )
    with pytest.raises(ModelError, match=r"equations change as the machine rotates .* controllers"):
        linearize(rotor([seeing]), spin=m.Spin(2.0, AXIS))


@pytest.mark.slow
def test_modes_in_which_a_controller_changes_alone():
    """A clock that leaks and drives nothing beside a stiff spring: its pole has no shape."""
    slow = 1e-4
    own = controller(lambda _t, _reads, z: -slow * z, lambda _t, _reads, z: {"motor": 0.0 * z[0]}, [1.0])
    spring = m.TorsionSpringDamper(first="ground", second="arm.root", axis=AXIS, stiffness=1e8)
    system = replace(rotor([own]), loads=[spring])
    modes = machine_modes(linearize(system))
    np.testing.assert_allclose(modes.eigenvalues, [-slow, 1j * np.sqrt(1e8 / INERTIA)], rtol=1e-9, atol=1e-6)
    assert not modes.shapes[:, 0].any()
    np.testing.assert_allclose(abs(modes.states[0]), [1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(modes.kinetic_shares, [[0.0, 1.0]], atol=1e-12)


def test_an_integrator_that_drives_nothing_counts_once_at_zero():
    """Beside the free turn of a rotor, which has two poles there."""
    own = controller(
        lambda _t, reads, _z: jnp.stack([reads["hinge"].rate]),
        lambda _t, _reads, z: {"motor": 0.0 * z[0]},
        [0.0],
    )
    values = eigenvalues(rotor([own]))
    np.testing.assert_array_equal(values, [0.0, 0.0])


@pytest.mark.slow
def test_a_campbell_diagram_follows_the_modes_of_a_closed_loop():
    spins = [m.Spin(rate, AXIS) for rate in (2.0, 2.5, 3.0)]

    def rates(_t, reads, z):
        return jnp.stack([z[1], (reads["hinge"].rate - z[0] - 0.1 * z[1]) / 0.01])

    own = controller(rates, lambda _t, _reads, z: {"motor": -1.5 * z[1]}, [2.0, 0.0], name="notch")
    diagram = campbell_diagram(rotor([own]), spins, n_modes=2)
    expected = np.concatenate([[0.0], roots([0.01 * INERTIA, 0.1 * INERTIA, INERTIA + 1.5])])
    np.testing.assert_allclose(diagram.eigenvalues, [expected] * 3, atol=1e-7)


def test_sampled_controllers_have_no_rest():
    sampled = m.SampledController(
        reads=HINGE, drives=motor(), law=lambda *_: ({"motor": 0.0}, {}), every=0.1, name="clock"
    )
    for looked_at in (equilibrium, linearize):
        with pytest.raises(ModelError, match=r"controller 'clock' is sampled: .* Write it as a Controller"):
            looked_at(pendulum([sampled]))


def test_a_law_without_a_derivative_ends_in_words():
    """A square root at zero."""
    own = m.Controller(
        reads=HINGE,
        drives=motor(),
        outputs=lambda _t, reads, _z: {"motor": -jnp.sqrt(abs(reads["hinge"].angle))},
    )
    with pytest.raises(ConvergenceError, match=r"derivatives of the forces are not finite in iteration 0"):
        equilibrium(pendulum([own]))


def test_rates_that_are_no_numbers_are_named():
    broken = replace(PID, rates=lambda _t, _reads, z: jnp.log(z - 1))
    with pytest.raises(ConvergenceError, match="state 0 of controller 'pid' has the rate nan"):
        equilibrium(pendulum([broken]))
