"""Kinematic runs: closed forms, inverse dynamics against the integrator, what cannot be told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.algebra.cross import cross_matrix
from supple.body import FullBody, NodalFixedFrame, RigidBody
from supple.errors import ConvergenceError, ModelError, ResolutionWarning
from supple.integrate import FixedStep, Kinematic, Run, Tolerances
from supple.machine import GROUND, At, ConstantRate, Placed, PrescribedRotation, Prismatic, Revolute, System
from supple.methods.intrinsic import CLAMPED, intrinsic_body, released
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate

Z = (0.0, 0.0, 1.0)
LENGTH = 3.0
"""Of the rod, in cranks."""
pytestmark = pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")


def kinematic(duration, outputs):
    output_step = duration / outputs
    return Run(duration, output_step, step=FixedStep(min(0.02, output_step)), method=Kinematic())


def slider_crank(rod, length=LENGTH, angle=lambda t: t**2):
    """A crank of length one, driven; a rod of some length; its end on a slide along x."""
    bodies = {"crank": (1.0, 0.0), "rod": (length, 1.0), "slider": (0.2, 1.0 + length)}
    return System(
        bodies=tuple(
            Placed(rod(name, own), position=[begin + own / 2, 0, 0]) for name, (own, begin) in bodies.items()
        ),
        joints=(
            PrescribedRotation(first=GROUND, second=At("crank", "left"), axis=Z, angle=angle, name="motor"),
            Revolute(first=At("crank", "right"), second=At("rod", "left"), axis=Z, name="pin"),
            Revolute(first=At("rod", "right"), second=At("slider", "left"), axis=Z, name="wrist"),
            Prismatic(first=GROUND, second=At("slider", "left"), axis=(1, 0, 0), name="slide"),
        ),
    )


@pytest.fixture(scope="module")
def turned_twice(rod):
    return simulate(slider_crank(rod), kinematic(np.sqrt(4 * np.pi), 100))


def test_the_slider_is_where_pythagoras_puts_it(turned_twice):
    angle = turned_twice.times**2
    slide = turned_twice.bodies["slider"].position[:, 0] - 0.1
    np.testing.assert_allclose(slide, np.cos(angle) + np.sqrt(LENGTH**2 - np.sin(angle) ** 2), atol=1e-12)


def test_speeds_and_accelerations_are_derivatives_of_the_closed_form(turned_twice):
    angle, rate = turned_twice.times**2, 2 * turned_twice.times
    sine, cosine = np.sin(angle), np.cos(angle)
    along = np.sqrt(LENGTH**2 - sine**2)
    slope = -sine - sine * cosine / along
    curvature = -cosine - (cosine**2 - sine**2) / along - (sine * cosine) ** 2 / along**3
    slider = turned_twice.bodies["slider"]
    np.testing.assert_allclose(slider.velocity[:, 0], slope * rate, atol=1e-11 * rate.max())
    expected = curvature * rate**2 + 2 * slope
    np.testing.assert_allclose(slider.acceleration[:, 0], expected, atol=1e-11 * abs(expected).max())


@pytest.mark.slow
def test_forces_are_those_of_the_integrated_machine(rod):
    """Inverse dynamics against a run in time, which converges towards it with the square of its step."""
    own = simulate(slider_crank(rod), kinematic(1.0, 10))
    apart = []
    for step in (2e-3, 1e-3):
        run = Run(1.0, 0.1, step=FixedStep(step), tolerances=Tolerances(residual=1e-11))
        integrated = simulate(slider_crank(rod), run)
        forces = ((own.joint_forces[name], each) for name, each in integrated.joint_forces.items())
        apart.append(max(np.abs(mine[1:] - each[1:]).max() for mine, each in forces))
    assert apart[1] < 1e-4
    assert 3.5 < apart[0] / apart[1] < 4.5


def test_the_motor_does_the_work(turned_twice, rod):
    """Torque times speed is the rate of the kinetic energy, m v.a + J w alpha, at every instant."""
    power = turned_twice.joint_forces["motor"][:, 5] * 2 * turned_twice.times
    rate = np.zeros_like(power)
    for placed in slider_crank(rod).bodies:
        motion, body = turned_twice.bodies[placed.body.name], placed.body
        rate += body.mass * (motion.velocity * motion.acceleration).sum(axis=1)
        rate += body.inertia[2, 2] * motion.angular_velocity[:, 2] * motion.angular_acceleration[:, 2]
    np.testing.assert_allclose(power, rate, atol=1e-11 * abs(rate).max())


@pytest.mark.slow
def test_a_run_cut_in_two_is_the_same_run(rod):
    run = kinematic(2.0, 40)
    legs = []
    whole = simulate(slider_crank(rod), run, record=legs.append)
    rest = simulate(slider_crank(rod), run, resume=legs[5])
    again = len(rest.times)
    assert 0 < again < len(whole.times)
    np.testing.assert_array_equal(rest.bodies["rod"].rotation, whole.bodies["rod"].rotation[-again:])
    np.testing.assert_array_equal(rest.joint_forces["pin"], whole.joint_forces["pin"][-again:])


@pytest.mark.slow
def test_what_the_joints_leave_free_is_refused(rod):
    system = slider_crank(rod)
    hinge = Revolute(first=GROUND, second=At("crank", "left"), axis=Z, name="motor")
    with pytest.raises(ModelError, match="the joints leave 1 degree of freedom"):
        simulate(replace(system, joints=(hinge, *system.joints[1:])), kinematic(1.0, 10))


@pytest.mark.slow
def test_a_dead_point_ends_the_run_with_its_time(rod):
    """A rod shorter than the crank cannot follow beyond the angle whose sine is its length."""
    system = slider_crank(rod, 0.8, ConstantRate(1.0))
    with pytest.raises(ConvergenceError, match=r"the joints cannot be closed at t = 0\.9"):
        simulate(system, kinematic(2.0, 100))
    kept = simulate(system, kinematic(2.0, 100), check=False)
    assert np.arcsin(0.8) - 0.021 < kept.times[-1] <= np.arcsin(0.8)


@pytest.mark.slow
def test_a_step_that_is_too_long_is_warned_of(rod):
    """Between instants the crank turns by 1.2 rad: another configuration may be nearer than the right one."""
    with pytest.warns(ResolutionWarning, match=r"rotates by .* or less$"):  # no adaptive steps exist here
        simulate(slider_crank(rod, angle=ConstantRate(1.0)), Run(6.0, 1.2, method=Kinematic()))


@pytest.mark.filterwarnings("ignore:body '.*' is treated as rigid:supple.errors.ValidityWarning")
@pytest.mark.slow
@pytest.mark.parametrize("form", ["full", "reduced", "intrinsic"])
def test_a_body_of_any_form_is_moved_as_a_rigid_one_of_its_mass(rod, blade, form):
    """A coupler of another form in a crank mechanism: motion and forces of a rigid body like it."""
    if form == "full":
        body = FullBody(blade, NodalFixedFrame("root"))
        modes, mass = blade.rigid_modes, blade.mass
    elif form == "reduced":
        modes, mass = blade.rigid_modes, blade.mass
        basis = CraigBampton(1)
        body = reduce(blade, NodalFixedFrame("root"), basis, derivatives=NoDerivatives(), loads=NoLoads)
    else:
        section = {"EA": 1e4, "EI": 5.0, "GJ": 5.0, "mass_per_length": 1.0, "radius": 0.05}
        body = released(intrinsic_body(beam_line(straight(1.0, 3), **section), CLAMPED))
        modes, mass = body.line.twists, body.line.mass
    gram = modes.T @ mass @ modes
    centre, cross = body.centre_of_mass, cross_matrix(body.centre_of_mass)
    inertia = gram[3:, 3:] + body.mass * cross @ cross
    ends = {"root": np.zeros(3), "tip": [1.0, 0, 0]}
    rigid = RigidBody(body.name, body.mass, centre, inertia, ends)

    def machine(coupler):
        name = coupler.name
        crank, slider = rod("crank", 0.4), rod("slider", 0.2)
        return System(
            bodies=(
                Placed(crank, position=[0.2, 0, 0]),
                Placed(coupler, position=[0.4, 0, 0]),
                Placed(slider, position=[1.5, 0, 0]),
            ),
            joints=(
                PrescribedRotation(
                    first=GROUND, second=At("crank", "left"), axis=Z, angle=lambda t: t**2, name="motor"
                ),
                Revolute(first=At("crank", "right"), second=At(name, "root"), axis=Z, name="pin"),
                Revolute(first=At(name, "tip"), second=At("slider", "left"), axis=Z, name="wrist"),
                Prismatic(first=GROUND, second=At("slider", "left"), axis=(1, 0, 0), name="slide"),
            ),
            gravity=(0, -9.81, 0),
        )

    run = kinematic(1.0, 10)
    legs = []
    own = simulate(machine(body), run, record=legs.append)
    expected = simulate(machine(rigid), run)
    assert own.bodies["slider"].position == pytest.approx(expected.bodies["slider"].position, abs=1e-11)
    for name, forces in expected.joint_forces.items():
        assert own.joint_forces[name] == pytest.approx(forces, abs=1e-8 * abs(forces).max() + 1e-9)
    rest = simulate(machine(body), run, resume=legs[0])
    assert np.array_equal(rest.joint_forces["pin"][-1], own.joint_forces["pin"][-1])
