"""Modes of machines with full bodies: against complete bases, of the same motions, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import (
    FullBody,
    MeanAxisFrame,
    ModalDamping,
    NodalFixedFrame,
    RayleighDamping,
    RigidBody,
    RigidInterface,
    flexible_body,
)
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.linearization import TranslationPort, campbell_diagram, linearize, machine_modes, state_space
from supple.machine import (
    GROUND,
    At,
    Fixed,
    FollowerForce,
    FollowerPressure,
    Placed,
    PrescribedRotation,
    Revolute,
    Spin,
    SpringDamper,
    System,
)
from supple.mesh import CellType, strip
from supple.reduction import CraigBampton, NoLoads, reduce

E, LENGTH, WIDTH, THICKNESS, DENSITY = 2.1e11, 1.0, 0.1, 5e-3, 7850.0
UNIT = np.sqrt(E * WIDTH * THICKNESS**3 / 12 / (DENSITY * WIDTH * THICKNESS)) / LENGTH**2
MESH = strip(LENGTH, WIDTH, 3, 2)


def small_strip(name="strip"):
    """72 freedoms: few enough for a basis of all of them."""
    model = shell_model(MESH, HomogeneousSection(Isotropic(E, 0.3, DENSITY), THICKNESS))
    return flexible_body(name, model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


@pytest.fixture(scope="module")
def body():
    return small_strip()


def complete(body, frame, damping=None):
    """Reduced to all its motions."""
    return reduce(body, frame, CraigBampton(body.n - 12), damping=damping, loads=NoLoads)


def hinged(form):
    """The strip on a hinge, pushed, heavy, held by a damped spring, a rigid body at its tip."""
    ball = RigidBody(
        name="ball", mass=2.0, inertia=1e-2 * np.eye(3), centre=np.array([0.05, 0.02, 0.01]),
        points={"face": (0, 0, 0)},
    )  # fmt: skip
    joints = (
        Revolute(name="hinge", first=GROUND, second=At("strip", "root"), axis=(0, 1, 0)),
        Fixed(name="weld", first=At("strip", "tip"), second=At("ball", "face")),
    )
    spring = SpringDamper(
        first=GROUND, second=At("strip", "tip"), anchor=(LENGTH, 0.1, 0.8),
        stiffness=3e3, damping=4.0, rest_length=0.75,
    )  # fmt: skip
    pressure = FollowerPressure(body="strip", faces=MESH.cells[CellType.TRIANGLE3], pressure=400.0)
    bodies = Placed(form), Placed(ball, position=(LENGTH, 0, 0))
    return System(bodies, joints, (spring, pressure), gravity=(0.0, 0.0, -9.81))


def slowest(machine, number):
    """Eigenvalues of a dense machine that nothing leaves free, by the inverse: exact where they are small."""
    k = machine.size
    answers = np.linalg.solve(machine.stiffness, np.hstack([machine.damping, machine.mass]))
    values = 1 / np.linalg.eigvals(np.vstack([-answers, np.eye(k, 2 * k)]))
    values = values[values.imag > 0]
    return values[np.argsort(abs(values))[:number]]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frame", "damping"),
    [
        (NodalFixedFrame("root"), RayleighDamping(2.0, 1e-4)),
        (MeanAxisFrame(), ModalDamping(0.03, n_modes=5)),
    ],
    ids=["nf-rayleigh", "ma-modal"],
)
def test_a_full_body_has_the_modes_of_its_complete_basis(body, frame, damping):
    """Deformed by centimetres, under loads that follow it: eigenvalues alike to 1e-8."""
    full = machine_modes(linearize(hinged(FullBody(body, frame, damping))), 6)
    same = linearize(hinged(complete(body, frame, damping)))
    assert full.eigenvalues == pytest.approx(slowest(same, 6), rel=1e-8)
    assert full.kinetic_shares == pytest.approx(machine_modes(same, 6).kinetic_shares, abs=1e-6)


def spun(form):
    hub = PrescribedRotation(name="hub", first=GROUND, second=At("strip", "root"), axis=(0, 0, 1), angle=0.0)
    return System((Placed(form),), (hub,))


@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(NodalFixedFrame("root"), marks=pytest.mark.slow, id="nf"),
        pytest.param(MeanAxisFrame(), id="ma"),
    ],
)
def test_a_full_body_that_turns_has_the_modes_of_its_complete_basis(body, frame):
    """Stretched by centrifugal forces, with gyroscopic ones: 1e-8."""
    spin = Spin(20.0 * UNIT, (0, 0, 1))
    full = machine_modes(linearize(spun(FullBody(body, frame)), spin=spin), 5)
    same = linearize(spun(complete(body, frame)), spin=spin)
    assert full.frequencies == pytest.approx(slowest(same, 5).imag, rel=1e-8)
    assert abs(full.eigenvalues.real).max() < 1e-9 * full.frequencies.max()


def half(name, first, last):
    """Half of the clamped beam, each a full body."""
    mesh = strip(LENGTH / 2, WIDTH, 20, 2)
    model = shell_model(mesh, HomogeneousSection(Isotropic(E, 0.0, DENSITY), THICKNESS))
    faces = (RigidInterface(first, "root"), RigidInterface(last, "tip"))
    return FullBody(flexible_body(name, model, faces).linearized(), MeanAxisFrame())


@pytest.mark.slow
def test_two_welded_halves_are_a_clamped_beam():
    """Of each family the first: 3.516, 22.03, 61.70 flapwise, within 0.5 %."""
    joints = (
        Fixed(name="clamp", first=GROUND, second=At("inner", "root")),
        Fixed(name="weld", first=At("inner", "middle"), second=At("outer", "middle")),
    )
    bodies = (
        Placed(half("inner", "root", "middle")),
        Placed(half("outer", "middle", "tip"), position=(LENGTH / 2, 0, 0)),
    )
    modes = machine_modes(linearize(System(bodies, joints)), 5)
    for exact in (3.516015, 22.03449, 61.69721):
        assert np.min(abs(modes.frequencies / UNIT / exact - 1)) < 5e-3
    assert modes.kinetic_shares.sum(axis=0) == pytest.approx(np.ones(5))


def test_a_free_full_body_moves_in_six_ways_and_bends():
    """Both clamped-free families start at `22.373` in UNIT."""
    model = shell_model(
        strip(LENGTH, WIDTH, 40, 2), HomogeneousSection(Isotropic(E, 0.0, DENSITY), THICKNESS)
    )
    body = FullBody(flexible_body("strip", model), MeanAxisFrame())
    modes = machine_modes(linearize(System((Placed(body),))), 8)
    assert (modes.eigenvalues[:6] == 0).all()
    assert (modes.frequencies[6:] > 0).all()
    assert modes.frequencies[6] / UNIT == pytest.approx(22.3733, rel=2e-3)


def test_a_full_body_is_followed_over_speed(body):
    machine = spun(FullBody(body, NodalFixedFrame("root")))
    diagram = campbell_diagram(machine, [Spin(rate * UNIT, (0, 0, 1)) for rate in (0.0, 3.0, 6.0)], n_modes=3)
    assert diagram.eigenvalues.shape == (3, 3)
    assert (diagram.likeness > 0.95).all()
    assert (np.diff(diagram.frequencies, axis=0) > 0).all()


def test_what_a_full_body_cannot_do_says_what_to_do(body):
    machine = spun(FullBody(body, NodalFixedFrame("root")))
    linear = linearize(machine)
    port = TranslationPort("strip.tip", (0, 0, 1))
    with pytest.raises(ModelError, match=r"full bodies.*reduce"):
        state_space(linear, inputs=[port], outputs=[port])
    heavy = System(machine.bodies, machine.joints, gravity=(9.81, 0.0, 0.0))
    with pytest.raises(ModelError, match="change as the machine rotates"):
        linearize(heavy, spin=Spin(3.0, (0, 0, 1)))
    few = machine_modes(linear, 1000)
    assert len(few.eigenvalues) == linear.size


@pytest.mark.slow
@pytest.mark.parametrize(("load", "flutters"), [(20.0, False), (20.1, True)])
def test_a_column_under_a_following_force_flutters_at_becks_load(load, flutters):
    """[Beck1952] `20.05 E I / l^2`, where frequencies meet at `11.02` in UNIT: stiffness is unsymmetric."""
    model = shell_model(
        strip(LENGTH, WIDTH, 24, 2), HomogeneousSection(Isotropic(E, 0.0, DENSITY), THICKNESS)
    )
    faces = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    column = FullBody(flexible_body("strip", model, faces), NodalFixedFrame("root"))
    bending = E * WIDTH * THICKNESS**3 / 12
    push = FollowerForce(first="strip.tip", force=(-load * bending / LENGTH**2, 0.0, 0.0))
    clamp = Fixed(first=GROUND, second=At("strip", "root"))
    modes = machine_modes(linearize(System((Placed(column),), (clamp,), (push,))), 3)
    assert modes.unstable[:2].any() == flutters
    if flutters:
        assert modes.frequencies[:2] / UNIT == pytest.approx([11.02, 11.02], rel=5e-3)
    else:
        assert abs(modes.eigenvalues.real).max() < 1e-9 * modes.frequencies.max()


def test_a_full_body_that_turns_about_its_middle_axis_is_unstable():
    """Euler's growth of the rigid body, which elasticity does not change at this speed."""
    model = shell_model(strip(1.0, 0.3, 4, 2), HomogeneousSection(Isotropic(E, 0.3, DENSITY), 0.05))
    racket = flexible_body("racket", model).linearized()
    rate = 5.0
    spin = Spin(rate, (0, 1, 0), (0.5, 0, 0))
    # Two rigid motions, then growth and decay at one rate, whose order is of rounding.
    modes = machine_modes(linearize(System((Placed(FullBody(racket, MeanAxisFrame())),)), spin=spin), 4)
    rigid = racket.rigid_modes.T @ (racket.mass @ racket.rigid_modes)
    # Moments about the centre, half a unit along x from the origin.
    first, second, third = np.diag(rigid)[3:] - rigid[0, 0] * 0.25 * np.array([0.0, 1.0, 1.0])
    growth = rate * np.sqrt((second - first) * (third - second) / (first * third))
    assert modes.eigenvalues.real.max() == pytest.approx(growth, rel=1e-5)
    assert modes.unstable.sum() == 1
