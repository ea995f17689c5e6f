"""Ties at the start: all parts that meet are joined, and both sides start at one place with one velocity."""

from functools import cache
from itertools import permutations

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar

from supple.body import RigidBody, flexible_body
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.integrate import Run
from supple.machine import At, ConstantRate, Placed, PrescribedRotation, System, Tie
from supple.mesh import CellType, Mesh, block, strip
from supple.methods.explicit import ExplicitEngine, explicit_shell, explicit_subdomain, modal_subdomain
from supple.reduction import NormalModes

SPAN = Run(0.02, 0.01)
PLATE = HomogeneousSection(Isotropic(1000.0, 0.3, 1.0), 0.05)


def part(name, corner, **sets):
    """A cube of one cell with its lowest corner at a place; `sets` are nodes of equal coordinates."""
    mesh = block(1, 1, 1, 1, 1, 1, CellType.HEXA8)
    at = mesh.nodes - mesh.nodes.min(axis=0) + np.array(corner, dtype=float)
    own = {key: np.flatnonzero(at[:, axis] == value) for key, (axis, value) in sets.items()}
    return explicit_subdomain(solid_model(Mesh(at, mesh.cells, own), SOFT), name=name)


@cache
def modal(name="box"):
    return modal_subdomain(flexible_body(name, bar(CellType.TETRA4)), NormalModes(6))


def behind(name="bar"):
    """A bar whose root is at the tip of the modal one."""
    mesh = bar(CellType.TETRA4).mesh
    moved = Mesh(mesh.nodes + np.array([4.0, 0, 0]), mesh.cells, mesh.node_sets)
    return explicit_subdomain(solid_model(moved, SOFT), name=name)


@pytest.mark.parametrize("order", list(permutations("ABC")))
def test_parts_that_meet_at_an_edge_are_all_joined(order):
    """C meets A with its left side and B with its lower one; the three share the edge between them."""
    parts = {
        "A": part("A", (0, 0, 0)),
        "B": part("B", (1, -1, 0)),
        "C": part("C", (1, 0, 0), left=(0, 1.0), lower=(1, 0.0)),
    }
    ties = [Tie(At("C", "left"), "A"), Tie(At("C", "lower"), "B")]
    built = ExplicitEngine(System([parts[name] for name in order], ties=ties), SPAN).built
    x = np.asarray(built.start.x).T
    # 8 nodes each, less 4 that C shares with A, and 4 with B.
    assert len(x) == len(np.unique(np.concatenate(list(built.nodes.values())))) == 16
    for name, numbers in built.nodes.items():
        assert x[numbers] == pytest.approx(parts[name].nodes)
    (edge,) = np.flatnonzero((x == [1, 0, 0]).all(axis=1))
    assert all(edge in numbers for numbers in built.nodes.values())
    assert float(built.model.mass[edge]) == pytest.approx(3 / 8)


def test_a_tie_of_one_node_allows_for_round_off():
    mesh = block(1, 1, 1, 1, 1, 1, CellType.HEXA8)
    own = Mesh(mesh.nodes, mesh.cells, {"corner": np.array([0])})
    one, other = (
        explicit_subdomain(solid_model(each, SOFT), name=name)
        for each, name in ((mesh, "one"), (own, "other"))
    )
    turned = Placed(other, rotation=(0.1, 0.7, 0.3))
    position = mesh.nodes[-1] - turned.rotation @ mesh.nodes[0] + 1e-15
    placed = Placed(other, rotation=turned.rotation, position=position)
    ExplicitEngine(System([one, placed], ties=[Tie(At("other", "corner"), "one")]), SPAN)


@pytest.mark.parametrize(
    ("axis", "side"),
    [((0, 0, 1), "y_max"), ((0, 1, 0), "root")],
    ids=["about the normal", "about the edge"],
)
def test_shells_of_other_rotations_share_triads(axis, side):
    """A plate, and another that is turned by 90 degrees; both start without forces, in any order."""
    mesh = strip(1.0, 1.0, 2, 2)
    sides = {"y_max": mesh.nodes[:, 1] == mesh.nodes[:, 1].max(), "root": mesh.nodes[:, 0] == 0}
    own = Mesh(mesh.nodes, mesh.cells, {"edge": np.flatnonzero(sides[side])})
    first = explicit_shell(shell_model(mesh, PLATE), name="first")
    second = explicit_shell(shell_model(own, PLATE), name="second")
    turned = Placed(second, rotation=np.pi / 2 * np.array(axis))
    meets = mesh.nodes[mesh.node_sets["tip"]].mean(axis=0)
    position = meets - turned.rotation @ mesh.nodes[sides[side]].mean(axis=0)
    for bodies in permutations([Placed(first), Placed(second, position=position, rotation=turned.rotation)]):
        engine = ExplicitEngine(System(bodies, ties=[Tie(At("second", "edge"), "first")]), SPAN)
        start = engine.start(0.0)
        assert len(start.x.T) == 2 * 9 - 3
        assert np.abs(start.forces).max() < 1e-12
        assert np.abs(start.turning.moments).max() < 1e-12


def test_tied_shells_start_at_one_angular_velocity():
    """They meet at the axis of the spin, where velocities are zero."""
    plates = [explicit_shell(shell_model(strip(1.0, 1.0, 2, 2), PLATE), name=name) for name in "ab"]
    ends = [
        plate.nodes[plate.mesh.node_sets[end]] for plate, end in zip(plates, ("tip", "root"), strict=True)
    ]
    shift = ends[0].mean(axis=0) - ends[1].mean(axis=0)
    turning = Placed(plates[1], position=shift, angular_velocity=(0.0, 1.0, 0.0), velocity=(0.0, 0.0, 0.0))
    with pytest.raises(ModelError, match=r"'b' is tied to another shell.* velocities differ by 1 rad/s"):
        ExplicitEngine(System([plates[0], turning], ties=[Tie(At("b", "root"), "a")]), SPAN)


def on_a_spinning_hub(other, tie, **flight):
    """A modal part that a joint turns about z from the start, at 0.1 rad/s; no velocity of it is given."""
    turn = PrescribedRotation(
        name="motor", first="ground", second="box.root", axis=(0, 0, 1), angle=ConstantRate(0.1)
    )
    return System([modal(), Placed(other, **flight)], joints=[turn], ties=[tie])


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", ["explicit", "modal"])
def test_tied_parts_start_with_the_motion_of_their_joints(kind):
    other, tie = behind(), Tie(At("bar", "root"), "box")
    if kind == "modal":
        body = flexible_body("bar", solid_model(behind().mesh, SOFT))
        other = modal_subdomain(body, NormalModes(6))
    with pytest.raises(ModelError, match=r"initial velocities of the two sides differ by .* of their joints"):
        ExplicitEngine(on_a_spinning_hub(other, tie), SPAN)
    ExplicitEngine(on_a_spinning_hub(other, tie, angular_velocity=(0, 0, 0.1), velocity=(0, 0, 0)), SPAN)


def test_rates_of_deformation_count_at_a_tie():
    tie = [Tie(At("bar", "root"), "box")]
    rates = np.eye(6)[0]
    with pytest.raises(ModelError, match="initial velocities of the two sides differ"):
        ExplicitEngine(System([Placed(modal(), coordinate_rates=rates), behind()], ties=tie), SPAN)


@pytest.mark.parametrize("kind", ["explicit", "modal"])
def test_a_tied_modal_part_starts_undeformed_at_the_tie(kind):
    other = behind()
    if kind == "modal":
        other = modal_subdomain(flexible_body("bar", solid_model(other.mesh, SOFT)), NormalModes(6))
    bent = Placed(modal(), coordinates=1e-3 * np.eye(6)[0])
    with pytest.raises(ModelError, match=r"two sides start .* apart, as a modal part has coordinates"):
        ExplicitEngine(System([bent, other], ties=[Tie(At("bar", "root"), "box")]), SPAN)


def test_nodes_are_not_tied_on_a_rigid_body():
    ball = RigidBody("ball", 1.0, np.zeros(3), np.eye(3), {"tip": np.zeros(3)})
    with pytest.raises(ModelError, match="'ball' is rigid and has no faces; tie the nodes on a modal part"):
        ExplicitEngine(System([behind(), ball], ties=[Tie(At("bar", "root"), "ball")]), SPAN)
