"""Velocities at the start: a driven body takes those of its drive, and deforms only where it must."""

from __future__ import annotations

import warnings
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.equations.build_model import build_model
from supple.equations.compiled_machine import CompiledMachine, compiled_start
from supple.equations.consistent_start import consistent_start
from supple.equations.start_velocity import change_by_levels
from supple.errors import LockingWarning, StartWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, Run
from supple.machine import (
    GROUND,
    At,
    Ball,
    ConstantRate,
    Fixed,
    Placed,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    System,
)
from supple.mesh import strip
from supple.methods.floating.full.full_system import FullSystem
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, Rubin, reduce
from supple.simulation import simulate, simulate_batch

pytestmark = pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")
Z = (0.0, 0.0, 1.0)
SPIN = 2.0


@pytest.fixture(scope="module")
def soft():
    """A strip along x, 1 m long, that bends about z."""
    wall = HomogeneousSection(Isotropic(1e7, 0.3, 1000.0), 0.02)
    mesh = strip(1.0, 0.1, 6, 2)
    nodes = mesh.nodes[:, [0, 2, 1]] * [1, -1, 1]  # upright, so that z is the axis it bends about
    model = shell_model(replace(mesh, nodes=nodes), wall)
    return flexible_body("strip", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


def _reduced(body, frame, recipe):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        return reduce(body, frame, recipe, derivatives=NoDerivatives(), loads=NoLoads)


@pytest.fixture(scope="module")
def forms(soft):
    """Nonlinear and linear, in both frames, reduced and in full."""
    linear = soft.linearized()
    return {
        "nodal-fixed": _reduced(soft, NodalFixedFrame("root"), CraigBampton(3)),
        "mean-axis": _reduced(soft, MeanAxisFrame(), Rubin(6)),
        "linear": _reduced(linear, MeanAxisFrame(), Rubin(6)),
        "full": FullBody(soft, NodalFixedFrame("root"), None),
        "full in mean axes": FullBody(soft, MeanAxisFrame(), None),
    }


FORMS = ("nodal-fixed", "mean-axis", "linear", "full", "full in mean axes")
# Each compiles a start of its own for each machine: one kind of bodies here, the others in `make test-all`.
ONE_FIRST = [pytest.param(form, marks=() if form == "mean-axis" else pytest.mark.slow) for form in FORMS]


def start_of(system):
    """The machine, and its consistent start."""
    full = system.bodies_of(FullBody)
    machine = FullSystem(system) if full else CompiledMachine(system, build_model(system))
    return consistent_start(machine, 0.0)


def coordinates_at(start, index=0):
    """Velocities of the frame and rates of the coordinates of a body."""
    own = start.velocity[start.machine.slices[index]]
    return own[:6], own[6:]


@pytest.mark.parametrize("form", ONE_FIRST)
def test_a_strip_turned_at_a_constant_rate_turns_as_a_rigid_body(forms, form):
    drive = PrescribedRotation(
        name="drive", first=GROUND, second=At("strip", "root"), axis=Z, angle=ConstantRate(SPIN)
    )
    start = start_of(System([forms[form]], [drive]))
    frame, rates = coordinates_at(start)
    np.testing.assert_allclose(frame, [0, 0, 0, 0, 0, SPIN], atol=1e-9)
    np.testing.assert_allclose(rates, 0, atol=1e-9)
    (taken,) = start.change.taken
    assert (taken.body, pytest.approx(SPIN)) == ("strip", taken.spin)
    assert not start.change.deforming
    assert not start.change.unmet


@pytest.mark.parametrize("form", ONE_FIRST)
def test_a_shaken_strip_moves_with_its_table(forms, form):
    """No deflection comes from the start: displacement a sin(w t) begins at the speed a w."""
    shaker = PrescribedTranslation(
        name="table",
        first=GROUND,
        second=At("strip", "root"),
        axis=(0, 1, 0),
        displacement=lambda t: 0.01 * jnp.sin(30.0 * t),
    )
    start = start_of(System([forms[form]], [shaker]))
    frame, rates = coordinates_at(start)
    np.testing.assert_allclose(frame, [0, 0.3, 0, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(rates, 0, atol=1e-11)


@pytest.mark.parametrize("form", ONE_FIRST)
def test_a_hub_carries_its_strip(forms, form):
    """Both follow the motor at the hub's centre."""
    hub = RigidBody("hub", 2.0, [0, 0, 0], np.eye(3), {"middle": [0, 0, 0], "rim": [0.3, 0, 0]})
    joints = (
        PrescribedRotation(
            name="motor", first=GROUND, second=At("hub", "middle"), axis=Z, angle=ConstantRate(SPIN)
        ),
        Fixed(name="weld", first=At("hub", "rim"), second=At("strip", "root")),
    )
    system = System([hub, Placed(forms[form], position=[0.3, 0, 0])], joints)
    start = start_of(system)
    frame, rates = coordinates_at(start, 1)
    np.testing.assert_allclose(frame[3:], [0, 0, SPIN], atol=1e-9)
    np.testing.assert_allclose(rates, 0, atol=1e-9)
    assert [each.body for each in start.change.taken] == ["hub", "strip"]


@pytest.mark.parametrize("form", ONE_FIRST)
def test_a_flexible_rod_of_a_slider_crank(forms, form):
    """Crank upright, of radius r: the slider moves at -r w, and the rod does not turn at that instant."""
    r = 0.2
    crank = RigidBody("crank", 1.0, [0, r / 2, 0], 0.1 * np.eye(3), {"hub": [0, 0, 0], "pin": [0, r, 0]})
    slider = RigidBody("slider", 0.5, [0, 0, 0], 0.1 * np.eye(3), {"pin": [0, 0, 0]})
    along = np.sqrt(1 - r**2)
    joints = (
        PrescribedRotation(
            name="motor", first=GROUND, second=At("crank", "hub"), axis=Z, angle=ConstantRate(SPIN)
        ),
        Ball(name="big end", first=At("crank", "pin"), second=At("strip", "root")),
        Revolute(name="small end", first=At("slider", "pin"), second=At("strip", "tip"), axis=Z),
        Prismatic(name="way", first=GROUND, second=At("slider", "pin"), axis=(1, 0, 0)),
    )
    rod = Placed(forms[form], position=[0, r, 0], rotation=[0, 0, -np.arcsin(r)])
    start = start_of(System([crank, rod, Placed(slider, position=[along, 0, 0])], joints))
    frame, rates = coordinates_at(start, 1)
    np.testing.assert_allclose(frame[3:], 0, atol=1e-9)
    np.testing.assert_allclose(rates, 0, atol=1e-9)
    np.testing.assert_allclose(start.velocity[start.machine.slices[2]][:3], [-r * SPIN, 0, 0], atol=1e-9)


@pytest.mark.parametrize("form", ONE_FIRST)
def test_only_what_no_rigid_motion_meets_deforms_and_is_said(forms, form):
    """Both ends are pulled apart along the strip: half the speed each way about its middle at rest."""
    speed = 0.1

    def pulled(end, sign):
        return PrescribedTranslation(
            name=f"pull {end}",
            first=GROUND,
            second=At("strip", end),
            axis=(1, 0, 0),
            displacement=ConstantRate(sign * speed),
        )

    start = start_of(System([forms[form]], [pulled("root", -1), pulled("tip", 1)]))
    body, part = forms[form], start.machine.slices[0]
    placed = start.velocity[part]
    moving = placed[0] + body.expand(placed[6:])[:, 0]
    ends = [moving[np.isclose(body.nodes[:, 0], x)].mean() for x in (0.0, 1.0)]
    np.testing.assert_allclose(ends, [-speed, speed], rtol=1e-9)
    (deforming,) = start.change.deforming
    # A linear field would have m v^2 / 6; the least energy of a few modes or nodes is about that.
    assert 0 < deforming.energy < body.mass * speed**2 / 6 * 1.05
    assert {each.joint for each in start.change.unmet} == {"pull root", "pull tip"}


def test_both_frames_deform_alike(soft):
    """In full, what is least does not depend on the frame."""
    energies = []
    for frame in (NodalFixedFrame("root"), MeanAxisFrame()):
        joints = [
            Fixed(name="clamp", first=GROUND, second=At("strip", "root")),
            PrescribedTranslation(
                name="pull",
                first=GROUND,
                second=At("strip", "tip"),
                axis=(1, 0, 0),
                displacement=ConstantRate(0.1),
            ),
        ]
        (deforming,) = start_of(System([FullBody(soft, frame, None)], joints)).change.deforming
        energies.append(deforming.energy)
    np.testing.assert_allclose(energies[1], energies[0], rtol=1e-9)


def test_a_start_that_deforms_a_body_warns(forms):
    joints = [
        Fixed(name="clamp", first=GROUND, second=At("strip", "root")),
        PrescribedTranslation(
            name="push",
            first=GROUND,
            second=At("strip", "tip"),
            axis=(0, 1, 0),
            displacement=ConstantRate(1.0),
        ),
    ]
    words = r"no rigid motion of the bodies has the velocities .* body 'strip' deforms at a rate of kinetic "
    with pytest.warns(StartWarning, match=words + r"energy .*; joints: 'clamp' .*, 'push' "):
        simulate(System([forms["nodal-fixed"]], joints), Run(0.002, 0.001, FixedStep(0.001)))


@pytest.mark.parametrize("form", ONE_FIRST)
def test_a_spinning_body_takes_along_what_is_fixed_to_it(forms, form):
    """Bus and panels: the spin given is kept, momentum is not shared."""
    bus = RigidBody("bus", 5.0, [0, 0, 0], np.eye(3), {"side": [0.2, 0, 0]})
    weld = Fixed(name="weld", first=At("bus", "side"), second=At("strip", "root"))
    bodies = [Placed(bus, angular_velocity=[0, 0, 0.1]), Placed(forms[form], position=[0.2, 0, 0])]
    start = start_of(System(bodies, [weld]))
    np.testing.assert_allclose(coordinates_at(start)[0], [0, 0, 0, 0, 0, 0.1], atol=1e-12)
    np.testing.assert_allclose(coordinates_at(start, 1)[0][3:], [0, 0, 0.1], atol=1e-10)
    np.testing.assert_allclose(coordinates_at(start, 1)[1], 0, atol=1e-10)
    assert not start.change.slowed


def test_given_zeros_are_kept_where_joints_allow(rod):
    """Of two rods on a slide that one of them drives, the one at rest keeps its velocity, or says it."""
    slide = Prismatic(name="slide", first=At("a", "right"), second=At("b", "left"), axis=(1, 0, 0))
    still = {"velocity": [0, 0, 0], "angular_velocity": [0, 0, 0]}
    bodies = [
        Placed(rod("a", 1.0), velocity=[1, 0, 0], angular_velocity=[0, 0, 0]),
        Placed(rod("b", 1.0), position=[1, 0, 0], **still),
    ]
    kept = compiled_start(System(bodies, [slide]), 0.0)
    np.testing.assert_allclose(kept.velocity[6:], 0, atol=1e-14)
    welded = replace(
        System(bodies, [slide]), joints=[Fixed(name="w", first=slide.first, second=slide.second)]
    )
    changed = compiled_start(welded, 0.0).change
    assert {each.body for each in changed.slowed} == {"a", "b"}
    np.testing.assert_allclose(changed.energies, (0.5, 0.25), rtol=1e-9)


def test_zeros_given_to_all_bodies_and_a_law_with_a_rate(rod):
    """The law wins, and the warning names what was given."""
    motor = PrescribedRotation(
        name="motor", first=GROUND, second=At("bar", "left"), axis=Z, angle=ConstantRate(SPIN)
    )
    bar = Placed(rod("bar", 1.0), position=[0.5, 0, 0], velocity=[0, 0, 0], angular_velocity=[0, 0, 0])
    words = r"kinetic energy is 0\.6667 instead of 0; body 'bar' starts with a speed of 1 instead of 0 and "
    words += "an angular velocity of 2 instead of 0.*none to a body that joints drive"
    with pytest.warns(StartWarning, match=words):
        simulate(System([bar], [motor]), Run(0.002, 0.001))


@pytest.mark.slow
def test_a_batch_of_driven_bodies_starts_as_each_does(forms, rod):
    """Cases that differ in what is given do not share a start."""
    motor = PrescribedRotation(
        name="motor", first=GROUND, second=At("bar", "left"), axis=Z, angle=ConstantRate(SPIN)
    )
    weld = Fixed(name="weld", first=At("bar", "right"), second=At("strip", "root"))
    bar = Placed(rod("bar", 1.0), position=[0.5, 0, 0])
    strip_at = Placed(forms["nodal-fixed"], position=[1.0, 0, 0])
    given = replace(strip_at, velocity=[0, 0, 0], angular_velocity=[0, 0, 0])
    cases = [System([bar, strip_at], [motor, weld]), System([bar, given], [motor, weld])]
    with pytest.warns(StartWarning, match="body 'strip' starts with a speed of 2 instead of 0"):
        batch = simulate_batch(cases, Run(0.002, 0.001, FixedStep(0.001)))
    for case in range(2):
        solution = batch.solutions[case]
        np.testing.assert_allclose(solution.bodies["strip"].velocity[0], [0, SPIN, 0], atol=1e-10)
        np.testing.assert_allclose(solution.bodies["strip"].coordinate_rates[0], 0, atol=1e-10)


def test_levels_do_only_what_those_before_them_cannot():
    """x + y = 1 with x first; y alone meets the second equation, which x does not enter."""
    first, second = np.array([[1.0], [0.0]]), np.array([[1.0], [2.0]])
    (x,), (y,) = change_by_levels([first, second], np.array([1.0, 0.0]))
    assert (x, y) == (pytest.approx(1.0), pytest.approx(0.0))
    (x,), (y,) = change_by_levels([first, second], np.array([1.0, 3.0]))
    assert (x, y) == (pytest.approx(-0.5), pytest.approx(1.5))
    (x,), (y,) = change_by_levels([first, second[:, :0]], np.array([1.0, 3.0]))[0], (0.0,)
    assert x == pytest.approx(1.0)
