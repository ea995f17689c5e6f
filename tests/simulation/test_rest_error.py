"""What a basis costs at rest and in steady rotation, beside closed forms; stability of what is found."""

from __future__ import annotations

import pickle
import warnings
from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body

from supple.body import (
    FullBody,
    MeanAxisFrame,
    ModalDamping,
    NodalFixedFrame,
    RigidBody,
    RigidInterface,
    flexible_body,
)
from supple.errors import BasisWarning, ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.linearization import linearize, machine_modes
from supple.machine import (
    GROUND,
    AngleServo,
    At,
    DeadForce,
    Fixed,
    Placed,
    PrescribedRotation,
    Revolute,
    Spin,
    System,
)
from supple.mesh import CellType, block, strip
from supple.quantities import Place, tracked_places
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    NoDerivatives,
    NoLoads,
    NormalModes,
    PlainQuartic,
    Rubin,
    project,
    reduce,
    reduction_basis,
)
from supple.simulation import equilibrium, full_rest, place_errors

pytestmark = pytest.mark.filterwarnings("ignore:body 'bar' is linear and rotates at [26]0")
"""The closed forms are those of the linear bar, so that its spin may exceed that of its validity."""

LENGTH, E, DENSITY, RATE = 1.0, 1e9, 1000.0, 20.0
STRETCH = DENSITY * RATE**2 * LENGTH**3 / (3 * E)
"""Elongation of a bar that spins about its end."""
SPIN = Spin(RATE, (0, 0, 1))
ROOT = NodalFixedFrame("root")


@pytest.fixture(scope="module")
def bar():
    """Slender, with an interface at its root alone; its six lowest modes are bending and torsion."""
    model = solid_model(block(LENGTH, 0.02, 0.01, 8, 1, 1, CellType.HEXA20), Isotropic(E, 0.0, DENSITY))
    return flexible_body("bar", model, (RigidInterface("root", "root"),)).linearized()


def turned(form):
    hub = PrescribedRotation(name="hub", first=GROUND, second=At("bar", "root"), axis=(0, 0, 1), angle=0.0)
    return System((Placed(form),), (hub,))


def of_the_end(bar, displacement):
    return displacement[np.isclose(bar.nodes[:, 0], LENGTH)].mean(axis=0)


@pytest.mark.slow
def test_a_basis_without_axial_modes_says_what_it_misses_of_a_stretch(bar):
    reduced = reduce(bar, ROOT, Rubin(6), derivatives=NoDerivatives(), loads=NoLoads)
    with pytest.warns(BasisWarning, match=r"body 'bar': at rest a node is off by .* % of the largest"):
        found = equilibrium(turned(reduced), spin=SPIN, fulls=[FullBody(bar, ROOT)])
    error = found.errors["bar"]
    (placed,) = found.system.bodies
    short = of_the_end(bar, placed.body.expand(placed.coordinates))[0]
    # (w / w_axial)^2 / 2.5 of the stretch grows with it: 2e-4.
    assert short + of_the_end(bar, error.displacement)[0] == pytest.approx(STRETCH, rel=5e-4)
    assert error.relative > 0.5
    assert error.strain > 0.5
    assert error.second < 0.01
    system, solution = found.full
    assert np.allclose(
        system.bodies[0].positions() - placed.positions(), error.displacement, atol=1e-6 * STRETCH
    )
    assert solution.bodies["bar"].coordinates.shape == (1, bar.n)


def test_a_load_on_a_clamped_interface_leaves_no_error_of_the_basis(bar):
    """Rounding errors of 1e-18 have no relative error, such as 200 % of each other, of which to warn."""
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    held = flexible_body("bar", replace(bar.model), ends).linearized()
    reduced = reduce(held, MeanAxisFrame(), CraigBampton(2), derivatives=NoDerivatives(), loads=NoLoads)
    joints = tuple(Fixed(name=end.name, first=GROUND, second=At("bar", end.name)) for end in ends)
    load = DeadForce(at="bar.tip", force=(0.3, 0.1, -10.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error", BasisWarning)
        found = equilibrium(System((Placed(reduced),), joints, loads=(load,)))
    error = found.errors["bar"]
    assert error.size < 1e-12
    assert error.relative == error.strain == error.worst == 0.0


def test_rounding_errors_in_a_machine_without_forces_are_no_error_of_the_basis():
    """An arm in a servo, without gravity: both displacement and error are below 1e-28."""
    body = reduce(beam_body("root", n=4), ROOT, CraigBampton(3), derivatives=NoDerivatives())
    hinge = Revolute(first=GROUND, second="beams.root", axis=(0, 1, 0))
    servo = AngleServo(first=GROUND, second="beams.root", axis=(0, 1, 0), angle=0.1, stiffness=3e3)
    error = equilibrium(System([body], [hinge], [servo])).errors["beams"]
    assert error.relative == error.strain == 0.0


@pytest.mark.slow
def test_a_rest_out_of_reach_of_the_reduced_one_is_found_from_the_start(bar, monkeypatch):
    """The same equilibrium, and so the same error, though the search near the reduced rest is given up."""
    reduced = reduce(bar, ROOT, Rubin(6), derivatives=NoDerivatives(), loads=NoLoads)
    errors = []
    for rate in (full_rest.CONTRACTS, -1.0):
        monkeypatch.setattr(full_rest, "CONTRACTS", rate)
        with pytest.warns(BasisWarning, match="at rest a node is off by"):
            errors.append(equilibrium(turned(reduced), spin=SPIN, fulls=[FullBody(bar, ROOT)]).errors["bar"])
        monkeypatch.setattr(full_rest, "NEAR_BY", 1)
    near, far = errors
    assert far.known
    assert far.displacement == pytest.approx(near.displacement, abs=1e-6 * near.worst)


def test_a_body_that_rounding_alone_deforms_has_no_error():
    """A balanced rotor on a mast exerts forces of 1e-13 on it: no load, and no error in per cent."""
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    mesh = block(LENGTH, 0.02, 0.01, 2, 1, 1, CellType.HEXA20)
    mast = flexible_body("mast", solid_model(mesh, Isotropic(E, 0.0, DENSITY)), ends).linearized()
    reduced = reduce(mast, ROOT, Rubin(1), derivatives=NoDerivatives(), loads=NoLoads)
    centre = np.array([LENGTH, 0, 0])
    arms = [0.3 * np.array([np.cos(angle), np.sin(angle), 0]) for angle in 2 * np.pi / 3 * np.arange(3)]
    places = {f"arm {k}": arm for k, arm in enumerate(arms)}
    rotor = [Placed(RigidBody("hub", 1.0, np.zeros(3), np.eye(3), {"axle": [0, 0, 0], **places}), centre)]
    joints = [
        Fixed(name="clamp", first=GROUND, second=At("mast", "root")),
        PrescribedRotation(
            name="axle", first=At("mast", "tip"), second=At("hub", "axle"), axis=(0, 0, 1), angle=0.0
        ),
    ]
    for k, arm in enumerate(arms):
        mass = RigidBody(f"mass {k}", 1.0, np.zeros(3), np.eye(3), {"at": [0, 0, 0]})
        rotor.append(Placed(mass, centre + arm))
        joints.append(Fixed(name=f"weld {k}", first=At("hub", f"arm {k}"), second=At(mass.name, "at")))
    spin = Spin(RATE, (0, 0, 1), point=centre, bodies=[placed.body.name for placed in rotor])
    found = equilibrium(
        System((Placed(reduced), *rotor), tuple(joints)), spin=spin, fulls=[FullBody(mast, ROOT)]
    )
    error = found.errors["mast"]
    assert error.worst < 1e-15
    assert (error.size, error.relative, error.strain) == (0, 0, 0)


@pytest.fixture(scope="module")
def spun():
    """A bar with a mass at its end, that spins: by bending modes alone, and with all coordinates."""
    model = solid_model(block(LENGTH, 0.02, 0.01, 4, 1, 1, CellType.HEXA20), Isotropic(E, 0.0, DENSITY))
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    bar = flexible_body("bar", model, ends).linearized()
    ball = RigidBody("mass", 0.01, np.zeros(3), 1e-6 * np.eye(3), {"centre": np.zeros(3)})
    mass = Placed(ball, position=(LENGTH, 0, 0))
    weld = Fixed(name="weld", first=At("bar", "tip"), second=At("mass", "centre"))
    frame = MeanAxisFrame()
    full = FullBody(bar, frame)
    reduced = reduce(bar, frame, NormalModes(8), derivatives=NoDerivatives(), loads=NoLoads)

    def machine(form):
        hub = turned(form)
        return replace(hub, bodies=(*hub.bodies, mass), joints=(*hub.joints, weld))

    with pytest.warns(BasisWarning, match="at rest a node is off by"):
        found = equilibrium(machine(reduced), spin=SPIN, fulls=[full])
    return found, equilibrium(machine(full), spin=SPIN)


@pytest.mark.slow
def test_errors_at_places_are_those_of_the_full_machine(spun):
    """Of the mass too, which has no basis: it is where the bar holds it."""
    found, exact = spun
    middle = tuple(np.flatnonzero(np.isclose(found.system.placed("bar").body.nodes[:, 0], 0.5)).tolist())
    places = {"end": Place("bar", "tip"), "middle": Place("bar", middle), "mass": Place("mass", "centre")}
    errors = place_errors(found, places)
    by_basis = tracked_places(found.system, found.solution, places)
    right = tracked_places(exact.system, exact.solution, places)
    for name, place in right.items():
        true = by_basis[name].position[0] - place.position[0]
        assert errors[name].position == pytest.approx(true, abs=1e-6 * STRETCH)
        assert true[0] < -0.2 * STRETCH
    true = by_basis["end"].deflection[0] - right["end"].deflection[0]
    assert errors["end"].deflection == pytest.approx(true, abs=1e-6 * STRETCH)
    assert errors["mass"].deflection is None
    assert place_errors(replace(found, full=None), places) == {}


@pytest.mark.slow
def test_a_place_that_no_joint_holds_has_no_error_of_position(spun):
    found, _ = spun
    (error,) = place_errors(replace(found, is_held=False), {"end": Place("bar", "tip")}).values()
    assert error.position is None
    assert error.deflection[0] < -0.2 * STRETCH


def test_a_full_body_without_a_reduced_one_is_refused(bar):
    other = RigidBody("bar", 1.0, np.zeros(3), np.eye(3), {"root": np.zeros(3)})
    with pytest.raises(ModelError, match="body 'bar' is rigid, but errors at rest are estimated for reduced"):
        equilibrium(turned(other), fulls=[FullBody(bar, ROOT)])
    with pytest.raises(ModelError, match="there is no body 'bar'"):
        equilibrium(System((replace(other, name="rod"),)), fulls=[FullBody(bar, ROOT)])


def test_a_reduction_as_it_comes_holds_steady_loads(bar):
    reduced = reduce(bar, ROOT, Rubin(6), derivatives=NoDerivatives())
    error = equilibrium(turned(reduced), spin=SPIN, fulls=[FullBody(bar, ROOT)]).errors["bar"]
    assert error.relative < 1e-3


def test_a_full_body_other_than_the_one_reduced_is_refused(bar):
    model = solid_model(block(LENGTH, 0.02, 0.02, 8, 1, 1, CellType.HEXA20), Isotropic(E, 0.0, DENSITY))
    other = flexible_body("bar", model, (RigidInterface("root", "root"),)).linearized()
    reduced = reduce(bar, ROOT, Rubin(2), derivatives=NoDerivatives(), loads=NoLoads)
    with pytest.raises(ModelError, match="is not the one that was reduced"):
        equilibrium(turned(reduced), spin=SPIN, fulls=[FullBody(other, ROOT)])


@pytest.mark.slow
def test_a_machine_that_turns_faster_than_it_vibrates_is_found_in_mean_axes(bar):
    """Its frame moves as it stretches, and the centrifugal force of the whole body with it."""
    fast = Spin(60.0, (0, 0, 1))  # its first frequency is 10 rad/s
    stretched = {}
    for frame in (ROOT, MeanAxisFrame()):
        (placed,) = equilibrium(turned(FullBody(bar, frame)), spin=fast).system.bodies
        stretched[frame] = of_the_end(bar, placed.positions() - bar.nodes)[0]
    assert stretched[MeanAxisFrame()] == pytest.approx(stretched[ROOT], rel=1e-7)


def test_modes_of_a_reduced_machine_carry_their_error():
    """Without the axial shape that a spin stretches nothing stiffens: 12 % of the first frequency."""
    model = solid_model(block(LENGTH, 0.02, 0.01, 4, 1, 1, CellType.HEXA20), Isotropic(E, 0.0, DENSITY))
    bar = flexible_body("bar", model, (RigidInterface("root", "root"),))
    reduced = reduce(bar, MeanAxisFrame(), CraigBampton(4), derivatives=NoDerivatives(), loads=NoLoads)
    full = FullBody(bar, MeanAxisFrame())
    with pytest.warns(BasisWarning, match="at rest a node is off by"):
        machine = linearize(turned(reduced), spin=SPIN, fulls=[full])
    with pytest.warns(BasisWarning, match=r"mode 1 is off by .* %"):
        modes = machine_modes(machine, 3)
    exact = machine_modes(linearize(turned(full), spin=SPIN), 3)
    assert modes.error.eigenvalues == pytest.approx(exact.eigenvalues, rel=1e-6)
    apart = abs(modes.eigenvalues - exact.eigenvalues) / abs(exact.eigenvalues)
    assert modes.error.relative == pytest.approx(apart, rel=1e-6)
    assert apart.max() > 0.05


def test_modes_that_a_basis_lacks_are_named(bar):
    """Six vibrations of the free body, held at its root, lack some of its modes."""
    clamp = Fixed(name="clamp", first=GROUND, second=At("bar", "root"))
    reduced = reduce(bar, MeanAxisFrame(), NormalModes(8), derivatives=NoDerivatives(), loads=NoLoads)
    full = FullBody(bar, MeanAxisFrame())
    machine = linearize(System((reduced,), (clamp,)), fulls=[full])
    with pytest.warns(BasisWarning, match="mode .* is (not a mode of|off by)"):
        modes = machine_modes(machine, 6)
    exact = machine_modes(linearize(System((full,), (clamp,))), 12)
    assert (modes.error.relative >= 0.01).any()
    told = np.append(modes.error.eigenvalues[~np.isnan(modes.error.eigenvalues)], modes.error.missed)
    for value in exact.eigenvalues[abs(exact.eigenvalues) < 0.98 * abs(modes.eigenvalues).max()]:
        assert abs(told - value).min() < 1e-6 * abs(value)


@pytest.mark.parametrize(("up", "stable"), [(1.0, False), (-1.0, True)])
def test_a_rod_that_stands_on_its_hinge_is_not_stable(up, stable):
    rod = RigidBody("rod", 1.0, (0, 0, 0.5 * up), np.eye(3) / 12, {"hinge": (0, 0, 0)})
    hinge = Revolute(first=GROUND, second=At("rod", "hinge"), axis=(0, 1, 0))
    assert equilibrium(System((rod,), (hinge,), gravity=(0, 0, -9.81))).stable is stable


@pytest.mark.parametrize(("up", "stable"), [(1.0, False), (-1.0, True)])
def test_nor_is_a_full_body(bar, up, stable):
    hinge = Revolute(first=GROUND, second=At("bar", "root"), axis=(0, 1, 0))
    standing = Placed(FullBody(bar, ROOT), rotation=(0, -up * np.pi / 2, 0))
    assert equilibrium(System((standing,), (hinge,), gravity=(0, 0, -0.01))).stable is stable


def test_a_reduced_body_knows_the_one_it_was_made_of(bar):
    """By reference, until it goes to another process: errors are stated unless they are left out."""
    reduced = reduce(bar, ROOT, Rubin(6), derivatives=NoDerivatives(), loads=NoLoads)
    assert reduced.full.body is bar
    with pytest.warns(BasisWarning, match="at rest a node is off by"):
        found = equilibrium(turned(reduced), spin=SPIN)
    assert found.errors["bar"].relative > 0.5
    assert equilibrium(turned(reduced), spin=SPIN, fulls=()).errors == {}
    assert pickle.loads(pickle.dumps(reduced)).full is None


@pytest.mark.slow
def test_modal_damping_of_all_modes_is_counted_in_full(bar):
    """As many modes as the reduced body has are damped: the whole of its basis."""
    reduced = reduce(bar, ROOT, CraigBampton(3), derivatives=NoDerivatives(), damping=ModalDamping(0.02))
    assert reduced.full.damping.n_modes == reduced.r
    modes = machine_modes(linearize(turned(reduced)), 2)
    assert modes.damping_ratios == pytest.approx([0.02, 0.02], rel=1e-6)
    assert modes.error.eigenvalues == pytest.approx(modes.eigenvalues, rel=1e-5)


@pytest.mark.slow
def test_condensed_motion_is_no_error_of_a_machine_that_may_turn():
    """A strip that gravity bends by 6 % of its length: nearly the same error clamped and hinged about it."""
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    body = flexible_body("strip", shell_model(strip(1.0, 0.1, 6, 2), wall), (RigidInterface("root", "root"),))
    reduced = reduce(body, ROOT, CraigBampton(3), derivatives=NoDerivatives())
    ends = {"name": "support", "first": GROUND, "second": At("strip", "root")}
    clamped, turning = (
        equilibrium(System((reduced,), (joint,), gravity=(0, 0, -4.0))).errors["strip"]
        for joint in (Fixed(**ends), Revolute(axis=(0, 0, 1), **ends))
    )
    assert turning.relative < 3e-4  # with the shortening by the sag 6e-3
    assert 0.5 < turning.rms / clamped.rms < 2


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.LockingWarning")
def test_a_fixed_size_that_locks_under_a_uniform_load_says_by_how_much():
    """Ten modes, ten derivatives, tip at 12 % of the length: plain tensors err by 1.4 %, condensed 0.01 %."""
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    mesh = strip(1.0, 0.1, 8, 2)
    body = flexible_body("strip", shell_model(mesh, wall), (RigidInterface("root", "root"),))
    clamp = Fixed(name="clamp", first=GROUND, second=At("strip", "root"))
    columns = reduction_basis(body, ROOT, CraigBampton(10), derivatives=CompressedDerivatives(10))
    machine = System((project(body, columns, quartic=PlainQuartic()),), (clamp,), gravity=(0, 0, -8.0))
    with pytest.warns(BasisWarning, match="at rest a node is off by"):
        locked = equilibrium(machine)
    followed = equilibrium(replace(machine, bodies=(project(body, columns),)), fulls=())
    exact, plain, condensed = (
        system.bodies[0].positions()[mesh.nodes_of("tip"), 2].mean()
        for system in (locked.full[0], locked.system, followed.system)
    )
    assert 1 - plain / exact == pytest.approx(locked.errors["strip"].relative, rel=0.05)
    assert 0.01 < 1 - plain / exact < 0.02
    assert abs(condensed / exact - 1) < 3e-4
