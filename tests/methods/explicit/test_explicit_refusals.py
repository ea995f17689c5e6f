"""What an explicit march does not do is refused in one sentence, before anything is computed."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar, explicit_bar

from supple.body import FullBody, MeanAxisFrame, RigidBody, flexible_body
from supple.equations import balances
from supple.error import state_errors
from supple.errors import ArgumentError, ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.integrate import AdaptiveStep, FixedStep, Newmark, Run, Solution, Statistics, Tolerances
from supple.linearization import campbell_diagram, linearize
from supple.machine import (
    AngleServo,
    At,
    Ball,
    Constant,
    Contact,
    DeadForce,
    DeadTorque,
    FollowerForce,
    HingeFriction,
    NodalLoad,
    Placed,
    Revolute,
    RigidPlane,
    Scaled,
    Spin,
    Support,
    System,
    Table,
    Tie,
    TorsionSpringDamper,
)
from supple.mesh import CellType, Mesh, strip
from supple.methods.explicit import (
    BulkViscosity,
    Explicit,
    ExplicitEngine,
    J2Plasticity,
    LinearHardening,
    NeoHookean,
    PublishedScheme,
    explicit_shell,
    explicit_subdomain,
    modal_subdomain,
)
from supple.reduction import NoLoads, NormalModes, reduce
from supple.simulation import assemble, equilibrium, simulate, simulate_batch

RUN = Run(0.02, 0.01)
STEEL = Isotropic(2.1e11, 0.3, 7800.0)
MODEL = bar(CellType.HEXA8)
BODY = flexible_body("box", MODEL)
WALL = RigidPlane((0, 0, 0), (1, 0, 0))
END = At("ball", "tip")


class OwnLoad(NodalLoad):
    """A load of one's own, in the axes of a frame."""

    label, law = "own load", Constant(1.0)
    nodes, facets, value_shapes, facet_forces = np.arange(1), np.zeros((1, 1), int), ((),), None


def ball():
    return RigidBody("ball", 1.0, np.zeros(3), np.eye(3), {"tip": np.zeros(3)})


def modal():
    return modal_subdomain(BODY, NormalModes(4))


@pytest.mark.parametrize(
    "ask",
    [
        equilibrium,
        linearize,
        lambda system: campbell_diagram(system, [Spin(1.0, (0.0, 0.0, 1.0))]),
        lambda system: simulate_batch([system], RUN),
        lambda system: state_errors(system, RUN, Solution(np.zeros(1), {}, {}, Statistics())),
        assemble,
        lambda system: balances(system, Solution(np.zeros(1), {}, {}, Statistics())),
    ],
)
def test_what_is_not_asked_of_explicit_elements_is_refused_in_one_place(ask):
    with pytest.raises(ModelError, match="has explicit finite elements, which only `simulate` supports"):
        ask(System([explicit_bar(CellType.HEXA8)]))


def test_batches_and_error_estimates_are_not_of_explicit_marches():
    system = System([modal()])
    with pytest.raises(ModelError, match="a batch does not support explicit marches: simulate the machine"):
        simulate_batch([system], RUN)
    with pytest.raises(ModelError, match="an error estimate does not support explicit marches"):
        state_errors(system, RUN, Solution(np.zeros(1), {}, {}, Statistics()))
    with pytest.raises(ModelError, match="a batch does not support explicit marches"):
        simulate_batch([System([ball()])], Run(0.02, 0.01, method=Explicit()))


@pytest.mark.parametrize(
    "body",
    [
        reduce(BODY, MeanAxisFrame(), NormalModes(4), loads=NoLoads),
        FullBody(BODY, MeanAxisFrame()),
    ],
    ids=lambda body: type(body).__name__,
)
def test_bodies_of_other_methods_do_not_march_beside_parts(body):
    with pytest.raises(
        ModelError,
        match=f"body '{body.name}' is {body.kind}, which explicit time integration does not support: use",
    ):
        simulate(System([explicit_bar(CellType.HEXA8), body]), RUN)


def test_ties_contacts_and_supports_are_not_of_rigid_bodies():
    for item in (
        {"supports": [Support(END)]},
        {"contacts": [Contact(END, WALL)]},
        {"ties": [Tie(END, "ball")]},
    ):
        with pytest.raises(ModelError, match="acts on explicit parts, but body 'ball' is rigid"):
            System([ball()], **item)


@pytest.mark.parametrize(
    ("items", "named"),
    [
        ({"ties": [Support(END)]}, "ties: expected ties such as Tie.*, got a Support"),
        ({"supports": [At("bar", "root")]}, "supports: expected supports such as"),
        ({"contacts": [WALL]}, r"contacts: expected a Contact\(.*or a SurfaceContact"),
        ({"ties": Tie(At("bar", "root"), "bar")}, "ties: expected a list of ties"),
    ],
)
def test_lists_hold_what_they_are_named_for(items, named):
    with pytest.raises(ArgumentError, match=named):
        System([explicit_bar(CellType.HEXA8)], **items)


def test_a_node_set_that_is_not_there_is_named():
    with pytest.raises(
        ModelError, match=r"support of 'bar.roof': body 'bar' has no interface 'roof'; did you"
    ):
        System([explicit_bar(CellType.HEXA8)], supports=[Support(At("bar", "roof"))])


def test_what_acts_on_a_part_suits_it():
    bar_alone = explicit_bar(CellType.HEXA8)
    for more, named in (
        (
            {"loads": [FollowerForce(first="bar.tip", force=(1.0, 0.0, 0.0))]},
            r"FollowerForce on bar.tip: it needs a frame, and nodes of explicit elements \('bar'\)",
        ),
        (
            {"loads": [DeadTorque(first="bar.tip", torque=(1.0, 0.0, 0.0))]},
            "DeadTorque on bar.tip: it needs a frame",
        ),
        (
            {"joints": [Ball(name="pin", first="bar.tip", second="ground")]},
            "joint 'pin': it needs a frame, and nodes .* put it on a modal part",
        ),
    ):
        with pytest.raises(ModelError, match=named):
            simulate(System([bar_alone], **more), RUN)


def test_a_modal_part_is_not_held():
    with pytest.raises(ModelError, match="'box' is modal, and its frame is free"):
        simulate(System([modal()], supports=[Support(At("box", "root"))]), RUN)


def on_a_modal_part(velocity=(0.0, 0.0, 0.0), **more):
    """A bar tied on a modal one of the same mesh, behind it."""
    moved = Mesh(MODEL.mesh.nodes + np.array([4.0, 0, 0]), MODEL.mesh.cells, MODEL.mesh.node_sets)
    own = explicit_subdomain(solid_model(moved, SOFT), name="bar")
    return System([modal(), Placed(own, velocity=velocity)], ties=[Tie(At("bar", "root"), "box")], **more)


@pytest.mark.slow
def test_nodes_that_a_modal_part_leads_are_not_held():
    with pytest.raises(ModelError, match=r"support of 'bar.root': some of its nodes are tied to 'box'"):
        ExplicitEngine(on_a_modal_part(supports=[Support(At("bar", "root"))]), RUN)
    ExplicitEngine(on_a_modal_part(supports=[Support(At("bar", "tip"))]), RUN)


def test_tied_parts_start_as_one():
    with pytest.raises(ModelError, match="initial velocities of the two sides differ by 1;"):
        simulate(on_a_modal_part(velocity=(1.0, 0.0, 0.0)), RUN)
    one, other = explicit_bar(CellType.HEXA8), explicit_subdomain(MODEL, name="other")
    tied = [Tie(At("other", "root"), "bar")]
    with pytest.raises(ModelError, match="initial velocities of the two sides differ by 2;"):
        simulate(System([one, Placed(other, position=(4, 0, 0), velocity=(0, 2.0, 0))], ties=tied), RUN)


def test_what_the_march_has_of_its_own_is_not_asked_of_the_run():
    system = System([explicit_bar(CellType.HEXA8)])
    for run, named in (
        (Run(0.02, 0.01, method=Newmark()), "central differences, not Newmark"),
        (Run(0.02, 0.01, tolerances=Tolerances(residual=1e-3)), "has no iterations"),
        (Run(0.02, 0.01, AdaptiveStep(1e-3)), "AdaptiveStep is not supported"),
        (Run(0.02, 0.01, FixedStep(1.0)), "above the stability limit"),
    ):
        with pytest.raises(ModelError, match=named):
            simulate(system, run)


def test_rigid_bodies_alone_have_no_step_limit():
    with pytest.raises(
        ModelError, match=r"rigid bodies without springs are stable at any explicit step.*FixedStep"
    ):
        simulate(System([ball()]), Run(0.02, 0.01, method=Explicit()))


def test_a_joint_and_a_servo_at_its_limit_give_no_step_limit():
    """A step as long as the output step would be stable, and as wrong as that is long."""
    pin = Revolute(name="pin", first="ground", second="ball.tip", axis=(0, 0, 1))
    servo = AngleServo(
        first="ground",
        second="ball.tip",
        axis=(0, 0, 1),
        angle=1.0,
        stiffness=500.0,
        damping=20.0,
        limit=60.0,
    )
    for loads in ([], [servo]):
        with pytest.raises(ModelError, match="rigid bodies without springs are stable at any explicit step"):
            simulate(System([ball()], joints=[pin], loads=loads), Run(0.02, 0.01, method=Explicit()))


def test_what_a_march_does_not_follow_is_refused_with_the_remedy():
    pin = Revolute(name="pin", first="ground", second="ball.tip", axis=(0, 0, 1))
    run = Run(0.02, 0.01, FixedStep(1e-3), method=Explicit())
    friction = HingeFriction(joint=pin, coefficient=0.1, width=0.1, radius=0.1)
    with pytest.raises(
        ModelError, match="does not include the force of a joint in its friction; use RevoluteFriction"
    ):
        simulate(System([ball()], joints=[pin], loads=[friction]), run)
    spring = TorsionSpringDamper(
        first="ground", second="ball.tip", axis=(0, 0, 1), stiffness=1e6, damping=0.0
    )
    with pytest.raises(ModelError, match=r"above the stability limit of 0\.002 s"):
        simulate(System([ball()], joints=[pin], loads=[spring]), replace(run, step=FixedStep(2.1e-3)))
    with pytest.raises(ModelError, match="joined to each other need ProjectedDifference"):
        simulate(System([ball()], joints=[pin]), replace(run, method=Explicit(PublishedScheme())))
    own = OwnLoad(body="bar")
    with pytest.raises(ModelError, match="explicit elements support DeadForce and FollowerPressure only"):
        simulate(System([explicit_bar(CellType.HEXA8)], loads=[own]), RUN)


def test_the_step_of_the_run_is_taken():
    system = System([explicit_bar(CellType.HEXA8)])
    solution = simulate(system, Run(0.02, 0.01, FixedStep(1e-3)))
    assert solution.statistics.steps == 20
    assert solution.series["steps"][-1, 0] == pytest.approx(1e-3)


def test_angular_velocity_is_along_the_axes_of_the_body():
    """Of every body alike: one that stands turned by 90 degrees about x and spins about its own z."""
    bar_turned = explicit_bar(CellType.HEXA8)
    system = System([Placed(bar_turned, rotation=(np.pi / 2, 0, 0), angular_velocity=(0, 0, 1.0))])
    motion = simulate(system, RUN).bodies["bar"]
    # Body z is along - y of space.
    expected = np.cross([0.0, -1.0, 0.0], motion.nodes[0])
    assert motion.velocities[0] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    "make",
    [partial(explicit_bar, CellType.HEXA8), pytest.param(modal, marks=pytest.mark.slow)],
    ids=["elements", "modes"],
)
def test_a_run_that_starts_later_has_the_loads_of_its_time(make):
    """A force that acts at t = 0 alone does nothing to a run from t = 1 on."""
    part = make()
    gone = Scaled(np.array([0.0, 0.0, 1.0]), Table([0.0, 0.5, 3.0], [1.0, 0.0, 0.0]))
    system = System([part], loads=[DeadForce(at=f"{part.name}.tip", force=gone)])
    energies = simulate(system, Run(0.02, 0.01, start=1.0)).series["energies"]
    assert np.abs(energies).max() < 1e-20
    with pytest.raises(ModelError, match=r"its table ends at t = 3, before the run ends \(t = 3.01\)"):
        simulate(system, Run(0.02, 0.01, start=2.99))


def stretching(elements):
    """Rates (N, 3) that stretch a part about its centre."""
    return 0.01 * (elements.nodes - elements.centre_of_mass)


@pytest.mark.slow
def test_parts_start_deformed_as_they_are_placed():
    """A modal part vibrates from its coordinates, q cos(omega t); finite elements have rates alone."""
    part = modal()
    omega = part.frequencies[0]
    start = np.array([1e-3, 0.0, 0.0, 0.0])
    run = Run(2 * np.pi / omega, 2 * np.pi / omega / 8, FixedStep(0.02))
    found = simulate(System([Placed(part, coordinates=start)]), run)
    expected = 1e-3 * np.cos(omega * found.times)
    assert found.bodies["box"].coordinates[:, 0] == pytest.approx(expected, abs=2e-6)
    elements = explicit_bar(CellType.HEXA8, bulk_viscosity=BulkViscosity(0.0, 0.0))
    rates = stretching(elements)
    moved = simulate(System([Placed(elements, coordinate_rates=rates.ravel())]), RUN)
    assert moved.bodies["bar"].velocities[0] == pytest.approx(rates, abs=1e-15)
    assert moved.bodies["bar"].velocities[-1].mean(axis=0) == pytest.approx(np.zeros(3), abs=1e-15)


def test_finite_elements_start_undeformed():
    elements = explicit_bar(CellType.HEXA8)
    with pytest.raises(ModelError, match="part 'bar' has finite elements, which start undeformed"):
        simulate(System([Placed(elements, coordinates=stretching(elements).ravel())]), RUN)


def test_walls_and_materials_beyond_the_explicit_elements_are_refused():
    wall = shell_model(strip(1.0, 0.2, 4, 2), HomogeneousSection(STEEL, 0.01, offset=0.1))
    with pytest.raises(ModelError, match="its section has an offset, an added mass or a shear factor"):
        explicit_shell(wall)


def test_materials_and_laws_that_cannot_march_are_refused():
    mesh, plate = MODEL.mesh, strip(1.0, 0.2, 4, 2)
    own_shear = replace(STEEL, stated_shear_modulus=1e10)
    metal = J2Plasticity(own_shear, LinearHardening(1e8))
    wall = shell_model(plate, HomogeneousSection(own_shear, 0.01))
    for make in (
        lambda: explicit_subdomain(solid_model(mesh, own_shear)),
        lambda: explicit_subdomain(solid_model(mesh, STEEL), metal, name="explicit"),
        lambda: explicit_shell(wall, law=metal, name="explicit"),
    ):
        with pytest.raises(ModelError, match="explicit': its material states a shear modulus of"):
            make()
    rounded = replace(STEEL, stated_shear_modulus=8.08e10)
    explicit_subdomain(solid_model(mesh, STEEL), J2Plasticity(rounded, LinearHardening(1e8)))
    explicit_shell(wall)  # elastic: its stiffness is that of the section
    none = replace(STEEL, density=0.0)
    for make in (
        lambda: explicit_subdomain(solid_model(mesh, none)),
        lambda: explicit_subdomain(solid_model(mesh, none), NeoHookean(STEEL)),
        lambda: explicit_subdomain(solid_model(mesh, STEEL), NeoHookean(none)),
        lambda: explicit_shell(shell_model(plate, HomogeneousSection(none, 0.01))),
    ):
        with pytest.raises(ModelError, match="an explicit part needs mass, and its density is 0"):
            make()
    for make in (
        lambda: explicit_subdomain(MODEL, NeoHookean(SOFT), deletion=0.2),
        lambda: explicit_shell(shell_model(plate, HomogeneousSection(STEEL, 0.01)), deletion=0.2),
    ):
        with pytest.raises(ModelError, match=r"no plastic strain, so deletion = 0\.2 has no effect"):
            make()
