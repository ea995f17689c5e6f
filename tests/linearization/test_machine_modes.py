"""Modes of machines against closed forms: springs and pendulums, rotating beams, rotors."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_bodies import beam_body
from scipy.linalg import eigh

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import BeamSection, HomogeneousSection, Isotropic, shell_model
from supple.linearization import campbell_diagram, linearize, machine_modes, mode_motion
from supple.machine import (
    GROUND,
    AngleServo,
    At,
    Ball,
    Bushing,
    ConstantRate,
    Controller,
    Cylindrical,
    EndReading,
    Fixed,
    Placed,
    PrescribedRotation,
    Revolute,
    Spin,
    SpringDamper,
    System,
    TorqueBetween,
)
from supple.mesh import CellType, Mesh, strip
from supple.reduction import CraigBampton, NoLoads, Rubin, reduce

E, LENGTH, WIDTH, THICKNESS, DENSITY = 2.1e11, 1.0, 0.1, 5e-3, 7850.0
UNIT = np.sqrt(E * WIDTH * THICKNESS**3 / 12 / (DENSITY * WIDTH * THICKNESS)) / LENGTH**2
"""rad/s: frequencies of a beam, and its speed of rotation, are told in this."""


def rod(name, mass=2.0, length=1.0):
    inertia = np.diag([1e-6, 1.0, 1.0]) * mass * length**2 / 12
    points = {"start": (-length / 2, 0, 0), "end": (length / 2, 0, 0)}
    return RigidBody(name=name, mass=mass, inertia=inertia, centre=np.zeros(3), points=points)


@pytest.mark.slow
def test_a_double_pendulum_has_two_frequencies_and_no_other():
    """Uniform rods: `3 g / 2 l (...)`, the eigenvalues of [[4/3, 1/2], [1/2, 1/3]] and g/l diag(3/2, 1/2)."""
    turned = (0, np.pi / 2, 0)  # along -z
    bodies = [Placed(rod(f"rod {i}"), position=(0, 0, -0.5 - i), rotation=turned) for i in range(2)]
    joints = [
        Revolute(first=GROUND, second=At("rod 0", "start"), axis=(0, 1, 0)),
        Revolute(first=At("rod 0", "end"), second=At("rod 1", "start"), axis=(0, 1, 0)),
    ]
    modes = machine_modes(linearize(System(bodies, joints, gravity=(0, 0, -9.81))))
    expected = eigh(9.81 * np.diag([1.5, 0.5]), [[4 / 3, 1 / 2], [1 / 2, 1 / 3]], eigvals_only=True)
    assert modes.eigenvalues.imag == pytest.approx(np.sqrt(expected), rel=1e-9)
    assert abs(modes.eigenvalues.real).max() < 1e-9


def test_a_damped_mass_has_the_damping_ratio_of_its_formula():
    mass, stiffness, damping = 3.0, 400.0, 8.0
    stone = RigidBody(
        name="stone", mass=mass, inertia=np.eye(3), centre=np.zeros(3), points={"top": (0, 0, 0)}
    )
    springs = [
        SpringDamper(
            first=GROUND,
            second=At("stone", "top"),
            anchor=tuple(5.0 * axis),
            stiffness=stiffness,
            damping=damping,
            rest_length=5.0,
        )
        for axis in np.eye(3)
    ]
    modes = machine_modes(linearize(System((Placed(stone),), (), springs)))
    natural = np.sqrt(stiffness / mass)
    ratio = damping / (2 * mass * natural)
    moving = modes.frequencies > 0
    assert moving.sum() == 3  # and three rotations that nothing holds
    assert modes.damping_ratios[moving] == pytest.approx(np.full(3, ratio), rel=1e-9)
    assert modes.frequencies[moving] == pytest.approx(np.full(3, natural * np.sqrt(1 - ratio**2)), rel=1e-9)
    assert not modes.unstable.any()


@pytest.mark.parametrize(
    "frame", [MeanAxisFrame(), NodalFixedFrame("root")], ids=["mean-axis", "nodal-fixed"]
)
def test_a_free_body_has_six_rigid_motions_and_its_free_vibrations(frame):
    """Six zeros, then `4.7300^2 sqrt(E I / m L^4)`; in a spin, motions along and about the axis stay free."""
    body = reduce(beam_body("root", "tip", n=30), frame, CraigBampton(8), loads=NoLoads)
    modes = machine_modes(linearize(System((Placed(body),)), fulls=()), 8)
    bending = 4.7300407**2 * np.sqrt(7e10 * 0.1**2 / 12 / 2700.0) / 4.0**2
    assert modes.frequencies[:6] == pytest.approx(np.zeros(6), abs=1e-6 * bending)
    assert modes.frequencies[6] == pytest.approx(bending, rel=0.01)
    assert (modes.damping_ratios == 0).all()  # not rounding errors, which look like growth
    assert np.linalg.matrix_rank(modes.shapes[:, :6]) == 6
    turning = machine_modes(linearize(System((Placed(body),)), spin=Spin(5.0, (1, 0, 0)), fulls=()), 3)
    assert turning.frequencies[:2] == pytest.approx(np.zeros(2), abs=1e-9)
    assert turning.frequencies[2] > 4.0


@pytest.mark.parametrize("stiffness", [0.0, 40.0])
def test_a_satellite_with_a_controlled_wheel_keeps_its_free_motions(stiffness):
    """The torque depends on the hub and acts on the wheel too: J a'' + 260 a' + k a = 0 for the hub's angle.

    Free: three translations, two rotations, and the spin of the wheel (of the satellite as well, for k = 0).
    """
    inertia = 280.0
    hub = RigidBody("hub", 800.0, np.zeros(3), np.diag([300.0, 250.0, inertia]), {"centre": np.zeros(3)})
    wheel = RigidBody("wheel", 5.0, np.zeros(3), np.diag([0.05, 0.05, 0.1]), {"axle": np.zeros(3)})
    joint = Revolute(first="hub.centre", second="wheel.axle", axis=(0, 0, 1))
    motor = TorqueBetween(first="hub.centre", second="wheel.axle", axis=(0, 0, 1))

    def outputs(time, reads, states):
        axes, rate = reads["hub"].axes, reads["hub"].angular_velocity[2]
        return {"motor": stiffness * jnp.arctan2(axes[1, 0], axes[0, 0]) + 260.0 * rate}

    reads, drives = {"hub": EndReading("hub.centre")}, {"motor": motor}
    control = Controller(reads=reads, drives=drives, outputs=outputs)
    values = machine_modes(linearize(System([hub, wheel], [joint], controllers=[control]))).eigenvalues
    roots = np.roots([inertia, 260.0, stiffness])
    assert values[values != 0] == pytest.approx(sorted(roots[roots != 0], reverse=True))
    assert np.count_nonzero(values == 0) == (6 if stiffness else 7)


def test_a_body_that_turns_about_its_middle_axis_is_unstable():
    """Euler's equations: growth `W sqrt((I2 - I1)(I3 - I2) / I1 I3)`."""
    first, second, third = 1.0, 2.0, 2.5
    racket = RigidBody(name="racket", mass=1.0, inertia=np.diag([first, second, third]), centre=np.zeros(3))
    modes = machine_modes(linearize(System((Placed(racket),)), spin=Spin(5.0, (0, 1, 0))))
    growth = 5.0 * np.sqrt((second - first) * (third - second) / (first * third))
    assert modes.unstable.any()
    assert modes.eigenvalues.real.max() == pytest.approx(growth, rel=1e-9)


def test_a_conical_pendulum_nutates_at_the_frequency_of_its_formula():
    """A point mass circling at `cos a = g / l w^2` nods at `w sqrt(1 + 3 cos^2 a)`."""
    bob = RigidBody(
        name="bob", mass=2.0, inertia=1e-4 * np.eye(3), centre=np.zeros(3), points={"top": (0, 0, 1.0)}
    )
    placed = Placed(bob, position=(np.sin(0.3), 0, -np.cos(0.3)), rotation=(0, -0.3, 0))
    machine = System((placed,), (Ball(first=GROUND, second=At("bob", "top")),), gravity=(0, 0, -9.81))
    rate = 4.0
    modes = machine_modes(linearize(machine, spin=Spin(rate, (0, 0, 1))))
    cosine = 9.81 / rate**2
    # The others: turning about the axis, free, and the bob about its own rod, which the spin carries along.
    assert np.min(abs(modes.frequencies - rate * np.sqrt(1 + 3 * cosine**2))) < 1e-4 * rate
    assert not modes.damping_ratios[modes.frequencies > 0.1 * rate].any()  # not the rounding errors of s


def exact_flap(rate, n_terms=14):
    """Flap frequencies of a clamped beam that turns, in UNIT: Ritz, `w''` of Legendre polynomials.

    int w''^2 dx + rate^2 int (1 - x^2) / 2 w'^2 dx = omega^2 int w^2 dx
    """
    places, weights = np.polynomial.legendre.leggauss(40)
    x = (places + 1) / 2
    curvatures = [np.polynomial.Legendre.basis(j, domain=[0, 1]) for j in range(n_terms)]
    slopes = [each.integ(lbnd=0) for each in curvatures]
    bent, turned, moved = (
        np.array([each(x) for each in of])
        for of in (curvatures, slopes, [each.integ(lbnd=0) for each in slopes])
    )

    def gram(fields, weight):
        return (fields * weight * weights / 2) @ fields.T

    stiffness = gram(bent, 1.0) + rate**2 * gram(turned, (1 - x**2) / 2)
    return np.sqrt(eigh(stiffness, gram(moved, 1.0), eigvals_only=True))


@pytest.fixture(scope="module")
def flat_strip():
    model = shell_model(
        strip(LENGTH, WIDTH, 40, 2), HomogeneousSection(Isotropic(E, 0.0, DENSITY), THICKNESS)
    )
    return flexible_body("strip", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


def spun(body):
    hub = PrescribedRotation(name="hub", first=GROUND, second=At("strip", "root"), axis=(0, 0, 1), angle=0.0)
    return System((Placed(body),), (hub,))


def test_the_reference_is_the_published_one():
    """[Wright1982] Table 1: 3.5160, 22.0345, 61.6972 at rest; 13.1702, 37.6031, 79.6145 at 12."""
    assert exact_flap(0.0)[:3] == pytest.approx([3.5160, 22.0345, 61.6972], abs=1e-4)
    assert exact_flap(12.0)[:3] == pytest.approx([13.1702, 37.6031, 79.6145], abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frame", "basis"),
    [
        (NodalFixedFrame("root"), CraigBampton(10)),
        (MeanAxisFrame(), Rubin(10)),
        (NodalFixedFrame("root"), None),
        (MeanAxisFrame(), None),
    ],
    ids=["nf", "ma", "nf-full", "ma-full"],
)
def test_a_rotating_beam_stiffens_as_southwell_says(flat_strip, frame, basis):
    """First three flap modes at 0 ... 12: within 0.5 % of the exact beam."""
    machine = spun(
        FullBody(flat_strip, frame) if basis is None else reduce(flat_strip, frame, basis, loads=NoLoads)
    )
    for rate in (0.0, 3.0, 6.0, 12.0):
        modes = machine_modes(
            linearize(machine, spin=Spin(rate * UNIT, (0, 0, 1))), 6 if basis is None else None
        )
        found = modes.frequencies / UNIT
        for exact in exact_flap(rate)[:3]:
            assert np.min(abs(found / exact - 1)) < 5e-3
        assert abs(modes.eigenvalues.real).max() < 1e-8 * modes.frequencies.max()


@pytest.fixture(scope="module")
def rotor():
    """A rigid disc amid a light round shaft along x, clamped but for its turning."""
    radius, span, n = 0.01, 1.0, 8
    second = np.pi * radius**4 / 4
    section = BeamSection(
        Isotropic(E, 0.3, 1.0),
        area=np.pi * radius**2,
        I1=second,
        I2=second,
        J=2 * second,
        K1=1e6,
        K2=1e6,
        orientation=(0.0, 1.0, 0.0),
    )
    nodes = np.linspace(0, span, n + 1)[:, None] * [1.0, 0.0, 0.0]
    cells = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    sets = {"left": np.array([0]), "middle": np.array([n // 2]), "right": np.array([n])}
    mesh = Mesh(nodes, {CellType.LINE2: cells}, node_sets=sets)
    names = ("left", "middle", "right")
    shaft = flexible_body("shaft", shell_model(mesh, section), [RigidInterface(name, name) for name in names])
    mass, polar, transverse = 10.0, 0.2, 0.11
    disc = RigidBody(
        name="disc",
        mass=mass,
        inertia=np.diag([polar, transverse, transverse]),
        centre=np.zeros(3),
        points={"hub": (0, 0, 0)},
    )
    reduced = reduce(shaft, NodalFixedFrame("left"), CraigBampton(4), loads=NoLoads)
    joints = (
        Revolute(name="bearing", first=GROUND, second=At("shaft", "left"), axis=(1, 0, 0)),
        Cylindrical(name="far bearing", first=GROUND, second=At("shaft", "right"), axis=(1, 0, 0)),
        Fixed(name="shrink fit", first=At("shaft", "middle"), second=At("disc", "hub")),
    )
    machine = System((Placed(reduced), Placed(disc, position=(span / 2, 0, 0))), joints)
    bending = E * second
    return machine, mass, polar, transverse, 192 * bending / span**3, 16 * bending / span


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")
def test_a_rotor_whirls_forward_and_backward(rotor):
    """Jeffcott's rotor: translation at `sqrt(k/m)`, tilt at the roots of `I w^2 - I_p W w - k_t = 0`.

    Seen in the turning axes: forward whirl at `w - W`, backward at `|w| + W`.
    """
    machine, mass, polar, transverse, lateral, tilting = rotor
    rate = 150.0
    modes = machine_modes(linearize(machine, spin=Spin(rate, (1, 0, 0))))
    centre = np.sqrt(lateral / mass)
    roots = np.roots([transverse, -polar * rate, -tilting])
    expected = [abs(centre - rate), centre + rate, *(abs(root - rate) for root in roots)]
    for each in expected:
        assert np.min(abs(modes.frequencies - each)) < 1e-4 * max(centre, rate)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")
def test_modes_are_followed_over_speed(rotor):
    """Laval's rotor: its centre whirls at `sqrt(k/m)` in space, seen lower and higher by the rate."""
    machine, mass, _, _, lateral, _ = rotor
    rates = np.linspace(0.0, 60.0, 4)
    diagram = campbell_diagram(machine, [Spin(rate, (1, 0, 0)) for rate in rates], n_modes=5)
    assert diagram.eigenvalues.shape == (4, 5)
    assert diagram.likeness.shape == (3, 5)
    steps = abs(np.diff(diagram.frequencies, axis=0))
    assert steps.max() < 2.5 * rates[1]
    centre = np.sqrt(lateral / mass)
    for rate, found in zip(rates, diagram.frequencies, strict=True):
        for expected in (centre - rate, centre + rate):
            assert np.min(abs(found - expected)) < 1e-4 * centre


@pytest.mark.slow
def test_what_has_no_constant_equations_is_refused(flat_strip):
    machine = spun(reduce(flat_strip, NodalFixedFrame("root"), CraigBampton(4), loads=NoLoads))
    heavy = System(machine.bodies, machine.joints, gravity=(9.81, 0.0, 0.0))
    with pytest.raises(ModelError, match="change as the machine rotates"):
        linearize(heavy, spin=Spin(3.0, (0, 0, 1)))
    with pytest.raises(ModelError, match="there is no body 'stirp'"):
        linearize(machine, spin=Spin(3.0, (0, 0, 1), bodies=["stirp"]))


@pytest.mark.parametrize("spin", [None, Spin(5.0, (0, 0, 1))])
def test_a_machine_without_free_motion_has_no_modes(spin):
    rotor = RigidBody("rotor", 1.0, (0.5, 0, 0), np.eye(3), {"hub": (0, 0, 0)})
    drive = PrescribedRotation(first=GROUND, second=At("rotor", "hub"), axis=(0, 0, 1), angle=0.0)
    with pytest.raises(ModelError, match=r"leave the machine no free motion.*Leave a motion free"):
        linearize(System((rotor,), (drive,)), spin=spin)


def test_of_modes_as_slow_as_each_other_those_that_grow_come_first():
    rod = RigidBody("rod", 1.0, (0, 0, 0.5), np.eye(3) / 12, {"hinge": (0, 0, 0)})
    hinge = Revolute(first=GROUND, second=At("rod", "hinge"), axis=(0, 1, 0))
    modes = machine_modes(linearize(System((rod,), (hinge,), gravity=(0, 0, -9.81))), 1)
    assert modes.unstable.all()


@pytest.mark.slow
@pytest.mark.parametrize("soft", [0.0, 1.0])
def test_soft_motions_beside_a_stiff_bushing_are_those_of_a_joint(soft):
    """1e12 N/m and N m/rad but for one angle: free, or held by 1 N m/rad; the strip's modes stay its own."""
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    whole = flexible_body("strip", shell_model(strip(1.0, 0.1, 4, 2), wall), ends)
    body = Placed(reduce(whole, NodalFixedFrame("root"), CraigBampton(4)))
    hinge = {"first": GROUND, "second": At("strip", "root"), "axis": (0.0, 0.0, 1.0)}
    spring = Bushing(**hinge, stiffness=(0.0, 0.0, 0.0, 0.0, 0.0, soft))
    exact = machine_modes(linearize(System((body,), (Revolute(**hinge),), (spring,))), 5)
    stiff = Bushing(**hinge, stiffness=(1e12, 1e12, 1e12, 1e12, 1e12, soft))
    modes = machine_modes(linearize(System((body,), (), (stiff,))), 5)
    assert modes.frequencies == pytest.approx(exact.frequencies, rel=1e-6, abs=0.0)
    assert np.sum(modes.frequencies == 0.0) == (1 if soft == 0.0 else 0)


@pytest.mark.parametrize("position", [(0.0, 0.0, 0.0), (30.0, -20.0, 50.0)])
def test_a_body_on_a_stiff_ball_of_springs_turns_freely(position):
    """Three rotations of frequency zero, none that rounding of 1e12 N/m makes slow."""
    stone = RigidBody(
        name="stone",
        mass=1e3,
        inertia=1e3 * np.diag([0.5, 0.7, 1.1]),
        centre=np.zeros(3),
        points={"foot": (0.2, 0.1, -0.3)},
    )
    springs = Bushing(
        first=GROUND, second=At("stone", "foot"), axis=(1.0, 2.0, 3.0), stiffness=(1e12, 1e12, 1e12, 0, 0, 0)
    )
    placed = Placed(stone, position=position, rotation=(0.3, 0.5, -0.7))
    modes = machine_modes(linearize(System((placed,), (), (springs,))))
    assert np.sum(modes.eigenvalues == 0.0) == 3
    assert np.sum(modes.frequencies > 1e4) == 3


def test_a_pendulum_beside_a_stiff_bushing_keeps_its_frequency():
    """`sqrt(m g l / (I + m l^2))`, in one machine with a body held by 1e12 N/m and N m/rad."""
    bob = RigidBody(name="bob", mass=2.0, inertia=np.eye(3), centre=np.zeros(3), points={"top": (0, 0, 9.81)})
    stone = RigidBody(
        name="stone", mass=2.0, inertia=np.eye(3), centre=np.zeros(3), points={"foot": (1, 2, 3)}
    )
    held = Bushing(first=GROUND, second=At("stone", "foot"), axis=(1.0, 2.0, 3.0), stiffness=(1e12,) * 6)
    hinge = Revolute(first=GROUND, second=At("bob", "top"), axis=(0, 1, 0))
    modes = machine_modes(
        linearize(System((Placed(bob), Placed(stone)), (hinge,), (held,), gravity=(0, 0, -9.81)))
    )
    exact = np.sqrt(2.0 * 9.81**2 / (1.0 + 2.0 * 9.81**2))
    assert modes.frequencies[0] == pytest.approx(exact, rel=1e-9)


def test_a_spin_in_which_no_point_moves_turns_by_a_radian():
    bob = RigidBody("bob", 1.0, np.array([0, 0, -1.0]), 0.1 * np.eye(3), {"eye": np.zeros(3)})
    ball = Ball(first=GROUND, second=At("bob", "eye"), name="ball")
    modes = machine_modes(linearize(System([bob], [ball], gravity=(0, 0, -9.81))), 3)
    rotation = mode_motion(modes, 0, amplitude=0.1).bodies["bob"].rotation
    assert np.trace(rotation, axis1=1, axis2=2).min() == pytest.approx(1 + 2 * np.cos(1.0), rel=1e-6)


@pytest.mark.parametrize(("ends", "time"), [(("ground", "rotor.hub"), 0.0), (("rotor.hub", "ground"), 0.7)])
def test_a_rotor_that_a_servo_drives_at_its_spin_swings_about_the_set_point(ends, time):
    """Its set-point rotates on with the rotor; that of another speed does not."""
    axis, spin = np.array([2.0, -1.0, 2.0]) / 3, 7.0
    rotor = RigidBody("rotor", 2.0, np.zeros(3), 0.3 * np.eye(3), {"hub": np.zeros(3)})
    hinge = Revolute(first=GROUND, second="rotor.hub", axis=tuple(axis))
    rate = spin if ends[0] == "ground" else -spin

    def driven(rate):
        law = ConstantRate(rate, start=0.4)
        servo = AngleServo(
            first=ends[0], second=ends[1], axis=tuple(axis), angle=law, stiffness=100.0, damping=2.0
        )
        return linearize(System([rotor], [hinge], [servo]), time=time, spin=Spin(spin, axis))

    machine = driven(rate)
    np.testing.assert_allclose(machine.stiffness / machine.mass, 100.0 / 0.3, rtol=1e-9)
    np.testing.assert_allclose(machine.damping / machine.mass, 2.0 / 0.3, rtol=1e-9)
    with pytest.raises(ModelError, match="change as the machine rotates"):
        driven(0.9 * rate)
