"""What an explicit march does not do is refused in one sentence, before anything is computed."""

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar, explicit_bar

from supple.body import FullBody, MeanAxisFrame, RigidBody, flexible_body
from supple.correction import self_correct, state_errors
from supple.errors import ArgumentError, ModelError
from supple.explicit import (
    ExplicitEngine,
    ExplicitOptions,
    ExplicitSystem,
    NodalForce,
    Part,
    RigidPlane,
    Support,
    Tie,
    explicit_subdomain,
    modal_subdomain,
    simulate_explicit,
)
from supple.fem import solid_model
from supple.integrate import AdaptiveStep, FixedStep, Newmark, Run, Tolerances
from supple.linearization import campbell_diagram, linearize, machine_modes
from supple.machine import At, Placed, System
from supple.machine.laws import Table
from supple.mesh import CellType, Mesh
from supple.reduction import NoLoads, NormalModes, reduce
from supple.simulation import equilibrium, simulate, simulate_batch

RUN = Run(0.02, 0.01)
MODEL = bar(CellType.HEXA8)
BODY = flexible_body("box", MODEL)


def modal():
    return modal_subdomain(BODY, NormalModes(4))


@pytest.mark.parametrize(
    "ask",
    [
        lambda system: simulate(system, RUN),
        equilibrium,
        linearize,
        machine_modes,
        lambda system: campbell_diagram(system, []),
        lambda system: simulate_batch([system], RUN),
        lambda system: self_correct(system, RUN, {}),
        lambda system: state_errors(system, RUN, None),
    ],
)
def test_questions_of_a_system_name_who_takes_an_explicit_one(ask):
    with pytest.raises(ArgumentError, match="got a ExplicitSystem, which simulate_explicit alone takes"):
        ask(ExplicitSystem([explicit_bar(CellType.HEXA8)]))


@pytest.mark.parametrize(
    "body",
    [
        BODY,
        reduce(BODY, MeanAxisFrame(), NormalModes(4), loads=NoLoads),
        FullBody(BODY, MeanAxisFrame()),
        RigidBody("ball", 1.0, np.zeros(3), np.eye(3)),
    ],
    ids=lambda body: type(body).__name__,
)
def test_bodies_of_other_methods_are_no_parts(body):
    for part in (body, lambda: Part(body)):
        with pytest.raises(ArgumentError, match=r"expected a modal_subdomain.*simulated in a System, got a"):
            ExplicitSystem([part() if callable(part) else part])


def test_parts_are_no_bodies():
    with pytest.raises(ArgumentError, match="named 'box', which an ExplicitSystem takes as a part"):
        System([Placed(modal())])


@pytest.mark.parametrize(
    ("items", "named"),
    [
        ({"ties": [Support(At("bar", "root"))]}, "ties, number 0: expected a Tie, got a Support"),
        ({"supports": [At("bar", "root")]}, "supports, number 0: expected a Support"),
        ({"contacts": [RigidPlane((0, 0, 0), (1, 0, 0))]}, "expected a Contact or SurfaceContact"),
        ({"forces": [Support(At("bar", "root"))]}, "forces, number 0: expected a NodalForce"),
        ({"forces": NodalForce(At("bar", "tip"), (1, 0, 0))}, "forces: expected a list"),
    ],
)
def test_lists_hold_what_they_are_named_for(items, named):
    with pytest.raises(ArgumentError, match=named):
        ExplicitSystem([explicit_bar(CellType.HEXA8)], **items)


def test_a_force_follows_a_modal_frame_alone():
    force = NodalForce(At("bar", "tip"), (1.0, 0.0, 0.0), follows=True)
    with pytest.raises(ModelError, match="'bar' is explicit and has none"):
        ExplicitSystem([explicit_bar(CellType.HEXA8)], forces=[force])


def test_a_modal_part_is_not_held():
    with pytest.raises(ModelError, match="'box' is modal, and flies free"):
        ExplicitSystem([modal()], supports=[Support(At("box", "root"))])


def on_a_modal_part(velocity=(0.0, 0.0, 0.0), **more):
    """A bar tied on a modal one of the same mesh, behind it."""
    moved = Mesh(MODEL.mesh.nodes + np.array([4.0, 0, 0]), MODEL.mesh.cells, MODEL.mesh.node_sets)
    own = explicit_subdomain(solid_model(moved, SOFT), name="bar")
    return ExplicitSystem(
        [modal(), Part(own, velocity=velocity)], ties=[Tie(At("bar", "root"), "box")], **more
    )


def test_nodes_that_a_modal_part_leads_are_not_held():
    with pytest.raises(ModelError, match=r"support of 'bar.root': some of its nodes are tied on 'box'"):
        ExplicitEngine(on_a_modal_part(supports=[Support(At("bar", "root"))]), RUN)
    ExplicitEngine(on_a_modal_part(supports=[Support(At("bar", "tip"))]), RUN)


def test_tied_parts_start_as_one():
    with pytest.raises(ModelError, match="the two sides fly apart by 1 m/s"):
        on_a_modal_part(velocity=(1.0, 0.0, 0.0))
    one, other = explicit_bar(CellType.HEXA8), explicit_subdomain(MODEL, name="other")
    tied = [Tie(At("other", "root"), "bar")]
    with pytest.raises(ModelError, match="the two sides fly apart by 2 m/s"):
        ExplicitSystem([one, Part(other, position=(4, 0, 0), velocity=(0, 2.0, 0))], ties=tied)


def test_what_the_march_has_of_its_own_is_not_asked_of_the_run():
    system = ExplicitSystem([explicit_bar(CellType.HEXA8)])
    for run, options, named in (
        (Run(0.02, 0.01, method=Newmark()), None, "central differences, not by Newmark"),
        (Run(0.02, 0.01, tolerances=Tolerances(residual=1e-3)), None, "iterates nothing"),
        (Run(0.02, 0.01, AdaptiveStep(1e-3)), None, "AdaptiveStep has no meaning here"),
        (Run(0.02, 0.01, FixedStep(1e-3)), ExplicitOptions(step=2e-3), "give one"),
        (Run(0.02, 0.01, FixedStep(1.0)), None, "above the limit"),
    ):
        with pytest.raises(ModelError, match=named):
            simulate_explicit(system, run, options=options)


def test_the_step_of_the_run_is_taken():
    system = ExplicitSystem([explicit_bar(CellType.HEXA8)])
    by_run = simulate_explicit(system, Run(0.02, 0.01, FixedStep(1e-3)))
    by_options = simulate_explicit(system, RUN, options=ExplicitOptions(step=1e-3))
    for solution in (by_run, by_options):
        assert solution.statistics.steps == 20
        assert solution.bodies["steps"].values[-1, 0] == pytest.approx(1e-3)


def test_a_run_that_starts_later_has_the_loads_of_its_time():
    """A force that acts at t = 0 alone does nothing to a run from t = 1 on."""
    gone = Table([0.0, 0.5, 3.0], [1.0, 0.0, 0.0])
    for part in (explicit_bar(CellType.HEXA8), modal()):
        system = ExplicitSystem([part], forces=[NodalForce(At(part.name, "tip"), (0, 0, 1.0), gone)])
        solution = simulate_explicit(system, Run(0.02, 0.01, start=1.0))
        energies = solution.bodies["energies"].values
        assert np.abs(energies).max() < 1e-20
    with pytest.raises(ModelError, match=r"its table goes from t = 0 to 3, the run from 2\.99 to 3\.01"):
        simulate_explicit(system, Run(0.02, 0.01, start=2.99))
