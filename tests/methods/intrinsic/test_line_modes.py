"""Rest and modes of machines with intrinsic bodies: closed forms, other forms of bodies, differences."""

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.equations.steady_motion import SteadyRotation
from supple.errors import ModelError
from supple.fem import BeamSection, Isotropic, shell_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run
from supple.linearization import (
    RotationPort,
    TranslationPort,
    campbell_diagram,
    frequency_response,
    linearize,
    machine_modes,
    mode_motion,
    state_space,
)
from supple.machine import (
    Ball,
    Bushing,
    Fixed,
    Placed,
    PrescribedRotation,
    Revolute,
    Spin,
    SpringDamper,
    System,
)
from supple.mesh import CellType, Mesh
from supple.methods.intrinsic import CLAMPED, FREE, condensed_line, intrinsic_body, released
from supple.methods.intrinsic.line_statics import line_statics
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import equilibrium, simulate

BEAM = {"EA": 1e6, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 1e-3}
G = 9.81
DOWN = [[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]]
FLAP = {0.0: [3.5160, 22.0345], 6.0: [7.3604, 26.8091], 12.0: [13.1702, 37.6031]}
"""Of a uniform beam that turns about its root, over sqrt(EI / m L^4). Source: [Wright1982], table 1."""


def beam(n=16, support=CLAMPED, n_modes=10, **section):
    return intrinsic_body(beam_line(straight(1.0, n), **(BEAM | section)), support, n_modes)


def driven(body, angle=0.0):
    """About z, at its root."""
    drive = PrescribedRotation(first="ground", second="beam.root", axis=(0, 0, 1), angle=angle, name="drive")
    return System([body], [drive])


def modes_of(system, n_modes=6, **options):
    return machine_modes(linearize(system, **options), n_modes)


def arms(n_modes=14):
    """A beam of 1 kg and 1 m as a reduced body and as an intrinsic one, of the same elements."""
    points, cells = straight(1.0, 8), np.column_stack([np.arange(8), np.arange(1, 9)])
    section = BeamSection(Isotropic(1e6, 0.0, 100.0), 0.01, 1e-4, 1e-4, 2e-4, orientation=(0, 0, 1))
    mesh = Mesh(points, {CellType.LINE2: cells}, node_sets={"root": [0], "tip": [8]})
    model = shell_model(mesh, section)
    ends = [RigidInterface("root", "root"), RigidInterface("tip", "tip")]
    flexible = flexible_body("arm", model, ends)
    reduced = reduce(
        flexible, NodalFixedFrame("root"), CraigBampton(8), derivatives=NoDerivatives(), loads=NoLoads
    )
    line = condensed_line("arm", points, model.stiffness, model.mass)
    return reduced, released(intrinsic_body(line, CLAMPED, n_modes))


def test_modes_at_rest_are_those_of_the_line():
    body = beam()
    clamp = Fixed(first="ground", second="beam.root")
    own = body.modes.frequencies[:6]
    assert modes_of(System([body], [clamp])).frequencies == pytest.approx(own, rel=1e-8)
    # The same by a joint, which holds the free root of the same modes.
    joined = modes_of(System([released(body)], [clamp]))
    assert joined.frequencies == pytest.approx(own, rel=1e-8)
    assert joined.kinetic_shares == pytest.approx(np.ones((1, 6)))


@pytest.mark.slow
def test_a_free_body_has_six_rigid_modes():
    body = beam(8, FREE)
    found = modes_of(System([body]), 8)
    assert found.frequencies[:6] == pytest.approx(np.zeros(6), abs=1e-6 * found.frequencies[-1])
    assert found.frequencies[6:] == pytest.approx(body.modes.frequencies[:2], rel=1e-8)


@pytest.mark.parametrize(
    "form",
    [pytest.param(lambda body: body, id="held", marks=pytest.mark.slow), pytest.param(released, id="joined")],
)
def test_a_beam_that_turns_flaps_and_lags_as_published(form):
    """Flap over speed from the table; lag by sqrt(flap^2 - speed^2), for one bending stiffness."""
    system = driven(form(beam()))
    rates = [0.0, 6.0, 12.0]
    diagram = campbell_diagram(system, [Spin(rate) for rate in rates], n_modes=4)
    for rate, found in zip(rates, diagram.frequencies, strict=True):
        flap = np.array(FLAP[rate])
        exact = np.sort(np.concatenate([flap, np.sqrt(flap**2 - rate**2)]))
        assert np.sort(found) == pytest.approx(exact, rel=1e-2)
    assert np.abs(diagram.damping_ratios).max() < 1e-9


def test_a_clamped_beam_turns_with_its_ground_as_with_a_driven_hub():
    """If all bodies rotate, a joint to the ground is one to a rotating platform."""
    clamp = Fixed(first="ground", second="beam.root", name="clamp")
    flap = FLAP[6.0][0]
    found = modes_of(System([released(beam())], [clamp]), spin=Spin(6.0)).frequencies[:2]
    assert found == pytest.approx([np.sqrt(flap**2 - 36), flap], rel=1e-2)


@pytest.mark.slow
def test_a_beam_of_few_modes_that_turns_about_its_tip_flaps_and_lags_as_published():
    """Its modes are those of a clamped root; without static responses at its tip lag is 28 % higher."""
    drive = PrescribedRotation(first="ground", second="beam.tip", axis=(0, 0, 1), angle=0.0)
    system = System([Placed(released(beam()), position=[-1.0, 0, 0])], [drive])
    flap = FLAP[6.0][0]
    found = modes_of(system, spin=Spin(6.0)).frequencies[:2]
    assert found == pytest.approx([np.sqrt(flap**2 - 36), flap], rel=1e-2)


@pytest.mark.slow
def test_the_pull_of_a_beam_that_turns():
    """m L^2 w^2 / 2 at its root; a run from there goes on without any strain rate."""
    system = driven(released(beam()))
    found = equilibrium(system, spin=Spin(6.0))
    assert found.stable
    assert found.joint_forces["drive"][0] == pytest.approx(-18.0, rel=1e-4)
    motion = found.solution.bodies["beam"]
    tip = system.bodies[0].body.interface_motion(motion, "tip")
    assert np.linalg.norm(tip.velocity) == pytest.approx(6.0, rel=1e-4)
    assert np.linalg.norm(tip.acceleration) == pytest.approx(36.0, rel=1e-4)


@pytest.mark.parametrize("rate", [pytest.param(0.0, marks=pytest.mark.slow), 5.0])
def test_the_tangent_is_the_derivative_of_the_residual(rate):
    """By central differences, of a bent beam that a joint holds, and that gravity and a spring load."""
    body = released(beam(4, n_modes=4))
    placed = Placed(body, coordinates=0.1 * np.arange(1, body.n_coordinates + 1) ** -2.0)
    spring = SpringDamper(first="beam.tip", second="ground", stiffness=3.0, anchor=(1.2, 0.1, 0.4))
    joint = Revolute(first="ground", second="beam.root", axis=(0, 0, 1), name="hinge")
    system = System([placed], [joint], [spring], gravity=[0, 0, -G])
    turning = SteadyRotation(np.array([[0, 0, rate]]), np.zeros(3)) if rate else None
    machine = line_statics(system, turning, 0.0)
    state = machine.start()._replace(multipliers=np.linspace(-1, 2, 5))
    tangent = machine._small_motions(state)
    for column, step in enumerate(1e-5 * np.eye(len(tangent.mass))):
        ends = [
            state._replace(configuration=machine.moved(state.configuration, sign * step)) for sign in (1, -1)
        ]
        up, down = (machine.residual(end, 0.0) for end in ends)
        assert tangent.stiffness[:, column] == pytest.approx(
            (up - down) / 2e-5, rel=1e-6, abs=1e-6 * np.abs(tangent.stiffness).max()
        )


@pytest.mark.slow
def test_a_heavy_pendulum_is_the_same_as_a_reduced_body():
    for place in ({"rotation": DOWN}, {}):
        found = []
        for arm in arms():
            system = System(
                [Placed(arm, **place)],
                [Revolute(first="ground", second="arm.root", axis=(0, 1, 0), name="hinge")],
                gravity=[0, 0, -G],
            )
            rest = equilibrium(system)
            assert rest.stable
            assert rest.joint_forces["hinge"][:3] @ rest.joint_forces["hinge"][:3] == pytest.approx(G**2)
            found.append(modes_of(rest.system, 5).frequencies)
        assert found[1] == pytest.approx(found[0], rel=2e-3)
        # Of a rigid rod, a little stiffer than this one.
        assert found[1][0] == pytest.approx(np.sqrt(1.5 * G), rel=2e-2)


def bridge(arm):
    """A rigid block on the tip of an arm, that a spring holds from the side."""
    block = RigidBody("block", 2.0, np.zeros(3), 0.02 * np.eye(3), {"top": np.zeros(3)})
    joints = [
        Fixed(first="ground", second="arm.root", name="clamp"),
        Ball(first="arm.tip", second="block.top"),
    ]
    spring = SpringDamper(first="block.top", second="ground", stiffness=50.0, anchor=(1.0, 0.5, 0.0))
    return System([Placed(block, position=[1.0, 0, 0]), arm], joints, [spring], gravity=[0, 0, -0.1])


@pytest.mark.slow
def test_a_block_on_an_arm_rests_and_vibrates_as_with_a_reduced_arm():
    found = []
    for arm in arms():
        rest = equilibrium(bridge(arm))
        linear = linearize(bridge(arm))
        space = state_space(
            linear,
            inputs=[TranslationPort("arm.tip", (0, 0, 1))],
            outputs=[TranslationPort("block.top", (0, 0, 1)), RotationPort("arm.tip", (0, 1, 0))],
        )
        modes = machine_modes(linear)
        elastic = modes.frequencies > 1.0
        found.append(
            (
                rest.system.bodies[0].position[2],
                rest.joint_forces["clamp"][[2, 4]],
                modes.frequencies[elastic][:4],
                modes.kinetic_shares[1, elastic][:2],
                frequency_response(space, [4.0]).transfer[0, :, 0],
            )
        )
    for reduced, intrinsic in zip(*found, strict=True):
        assert intrinsic == pytest.approx(reduced, rel=1e-2)


def chain(arm):
    """An arm, a beam on its tip and a block on the beam's."""
    tip = released(beam(4, EI=100.0, GJ=100.0, EA=1e4))
    block = RigidBody("block", 0.5, np.zeros(3), 0.02 * np.eye(3), {"top": np.zeros(3)})
    joints = [
        Fixed(first="ground", second="arm.root", name="clamp"),
        Fixed(first="arm.tip", second="beam.root"),
        Fixed(first="beam.tip", second="block.top"),
    ]
    bodies = [arm, Placed(block, position=[2.0, 0, 0]), Placed(tip, position=[1.0, 0, 0])]
    return System(bodies, joints, gravity=[0, 0, -0.01])


@pytest.mark.slow
def test_rigid_reduced_and_intrinsic_bodies_rest_and_vibrate_together():
    """With all modes of the arm: those of its clamped line alone meet a force on its tip slowly."""
    found = []
    for arm in arms(None):
        rest = equilibrium(chain(arm))
        # 1 kg at 0.5 m, 1 kg at 1.5 m, 0.5 kg at 2 m.
        assert rest.joint_forces["clamp"][[2, 4]] == pytest.approx([0.025, -0.03], rel=1e-3)
        found.append(modes_of(chain(arm), 4).frequencies)
    assert found[1] == pytest.approx(found[0], rel=5e-3)


@pytest.mark.slow
def test_a_machine_stays_in_the_equilibrium_that_was_found():
    _, arm = arms()
    rest = equilibrium(bridge(arm)).system
    run = Run(0.1, 0.05, step=FixedStep(0.01), method=GeneralizedAlpha(1.0))
    moved = simulate(rest, run).bodies["block"].position
    assert np.abs(moved - moved[0]).max() < 1e-12


def test_a_shaft_on_unequal_bearings_whirls_in_axes_fixed_in_space():
    """A disc between two bearings: `M x'' + r G x' + K x = 0` of its tilts, with constant coefficients."""
    EI, stiff, soft, rate = 100.0, 1e6, 2e4, 40.0
    m, across, along = 5.0, 0.02, 0.035
    whole = beam_line(straight(1.0, 2), EA=1e6, EI=EI, GJ=50.0, mass_per_length=1e-6, radius=0.01)
    mass = whole.mass.copy()
    mass[6:12, 6:12] += np.diag([m, m, m, along, across, across])
    rotor = intrinsic_body(condensed_line("rotor", whole.tree.points, whole.stiffness, mass), FREE)
    bearings = [
        Bushing(
            first="ground", second=f"rotor.{end}", axis=(0, 0, 1), stiffness=(axial, soft, stiff, 0, 0, 0)
        )
        for end, axial in (("root", 1e6), ("tip", 0.0))
    ]
    found = linearize(System([rotor], loads=bearings), spin=Spin(rate, axis=(1, 0, 0)))
    assert found.is_in_space
    assert found.periodic is None
    bending = [1 / (1 / (48 * EI) + 1 / (2 * k)) for k in (stiff, soft)]
    tilting = np.diag([1 / (1 / (12 * EI) + 2 / k) for k in (stiff, soft)])
    turning = rate * along * np.array([[0, 1.0], [-1.0, 0]])
    first = -np.hstack([tilting, turning]) / across
    tilts = np.linalg.eigvals(np.vstack([np.eye(4)[2:], first]))
    exact = np.sort(np.concatenate([np.sqrt(np.array(bending) / m), tilts[tilts.imag > 0].imag]))
    assert machine_modes(found, 5).frequencies[1:] == pytest.approx(exact, rel=1e-4)


@pytest.mark.slow
def test_static_responses_at_ports_are_those_of_a_cantilever():
    """F L^3 / 3 EI and -F L^2 / 2 EI."""
    linear = linearize(driven(beam()))
    lift = TranslationPort("beam.tip", (0, 0, 1))
    space = state_space(linear, inputs=[lift], outputs=[lift, RotationPort("beam.tip", (0, 1, 0))])
    found = frequency_response(space, [1e-6]).transfer[0, :, 0].real
    assert found == pytest.approx([1 / 3, -1 / 2], rel=5e-3)


def test_a_mode_moves_as_its_shape_says():
    modes = modes_of(System([beam()], [Fixed(first="ground", second="beam.root")]), 2)
    body = modes.machine.system.bodies[0].body
    moved = body.positions(mode_motion(modes, 0, amplitude=1e-3).bodies["beam"]) - body.nodes
    sizes = np.linalg.norm(moved, axis=2)
    assert sizes.max() == pytest.approx(1e-3, rel=1e-3)
    assert sizes[0, -1] == sizes.max()
    # First mode of a cantilever at half its length: 0.3395 of the tip.
    assert sizes[0, 8] / sizes[0, -1] == pytest.approx(0.3395, rel=5e-3)


def test_what_has_no_steady_motion_is_refused_with_the_remedy():
    body = beam(4)
    clamp = Fixed(first="ground", second="beam.root")
    with pytest.raises(ModelError, match=r"cannot rotate with the spin.*Revolute, PrescribedRotation"):
        linearize(System([body], [clamp]), spin=Spin(1.0))
    with pytest.raises(ModelError, match="equations change as the machine rotates"):
        linearize(replace_gravity(driven(body)), spin=Spin(1.0))


def replace_gravity(system):
    from dataclasses import replace

    return replace(system, gravity=[0, -1.0, 0])
