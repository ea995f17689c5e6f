"""Free obstacles: the step limit includes their mass, and energy that a contact creates stops a run."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar, explicit_bar
from scipy import linalg

from supple.body import flexible_body
from supple.errors import ConvergenceError, ModelError
from supple.fem import solid_model
from supple.integrate import Run, run
from supple.machine import At, Contact, Fixed, Placed, RigidPlane, RigidSphere, System, Tie
from supple.mesh import CellType, Mesh
from supple.methods.explicit import ExplicitEngine, explicit_subdomain, modal_subdomain
from supple.reduction import NormalModes

SPAN = Run(0.2, 0.05)


def ball(mass, radius=1.0):
    """It comes from above, along the vertical through the middle of a bar of 4 x 1 x 1."""
    return RigidSphere((2.0, 0.0, 0.51 + radius), radius, velocity=(0.0, 0.0, -0.5), mass=mass)


def struck(mass, radius=1.0, counts=(2, 2, 2)):
    part = explicit_bar(CellType.HEXA8, counts=counts)
    return ExplicitEngine(System([part], contacts=[Contact(At("bar", "z_max"), ball(mass, radius))]), SPAN)


def modal():
    return modal_subdomain(flexible_body("modal", bar(CellType.TETRA4)), NormalModes(6))


def test_a_light_ball_leaves_at_the_speed_at_which_it_came():
    """The node that it meets weighs 250 times as much."""
    solution = run(struck(1e-3), SPAN.times)
    assert solution.series["obstacles"][-1, 5] == pytest.approx(0.5, rel=0.1)


def test_a_free_obstacle_belongs_to_one_contact():
    """Two contacts would move it as two; one that keeps its velocity may have several."""
    part = explicit_bar(CellType.HEXA8, counts=(2, 2, 2))
    own = ball(1e-3)
    with pytest.raises(ModelError, match="a free RigidSphere is the obstacle of two contacts"):
        System([part], contacts=[Contact(At("bar", face), own) for face in ("z_max", "tip")])
    driven = ball(float("inf"))
    System([part], contacts=[Contact(At("bar", face), driven) for face in ("z_max", "tip")])
    System([part], contacts=[Contact(At("bar", face), ball(1e-3)) for face in ("z_max", "tip")])


def test_energy_that_a_contact_creates_stops_the_run():
    """The same ball, in steps that are too long for it: no other energy shows it."""
    own = struck(1e-3)
    own._built = replace(own.built, model=own.built.model._replace(contact_rate=jnp.zeros(())))
    with pytest.raises(
        ConvergenceError, match=r"contact energy is negative.* a smaller fraction or stiffness"
    ):
        run(own, SPAN.times)


def test_a_part_that_starts_a_little_inside_has_that_energy_and_is_let_go():
    """At rest otherwise: its contact energy returns to zero, not below."""
    part = Placed(explicit_bar(CellType.HEXA8, counts=(2, 2, 2)), position=(1e-6, 0, 0))
    wall = Contact(At("bar", "tip"), RigidPlane((4.0, 0, 0), (-1, 0, 0)))
    energies = run(ExplicitEngine(System([part], contacts=[wall]), SPAN), SPAN.times).series["energies"]
    assert energies[0, 4] > 0
    assert energies[:, :7].sum(axis=1) == pytest.approx(energies[0, 4], rel=1e-9)
    assert np.abs(energies[-1, 4]) < 0.1 * energies[0, 4]


@pytest.mark.parametrize("mass", [0.01, 1.0, 100.0])
def test_the_limit_is_below_the_true_one_with_all_contacts_closed(mass):
    """The fastest vibration of nodes and ball on the penalties alone."""
    model = struck(mass).built.model
    (touching,) = model.touching
    k, nodes = np.asarray(touching.stiffness), np.asarray(touching.nodes)
    m = np.append(np.asarray(model.mass)[nodes], mass)
    K = np.diag(np.append(k, k.sum()))
    K[-1, :-1] = K[:-1, -1] = -k
    largest = np.linalg.eigvalsh(K / np.sqrt(m[:, None] * m))[-1]
    assert 0.5 * float(model.contact_rate) < largest <= (1 + 1e-9) * float(model.contact_rate)


def test_a_small_ball_touches_few_nodes():
    """Nodes inside it are at most its diameter apart."""
    rates = [float(struck(0.01, radius, (16, 4, 4)).built.model.contact_rate) for radius in (0.3, 1.0)]
    assert rates[0] < 0.5 * rates[1]


@pytest.mark.parametrize("joined", [False, True])
def test_the_limit_of_a_modal_part_includes_the_ball(joined):
    """Springs between nodes and ball, equal in all directions; a weld makes no mode faster."""
    joints = [Fixed(name="weld", first="ground", second="modal.root")] if joined else []
    contact = Contact(At("modal", "z_max"), ball(1e-3))
    own = ExplicitEngine(System([modal()], joints=joints, contacts=[contact]), SPAN).built
    frame, (touching,) = own.frames["modal"], own.model.frames[0].touching
    k, B = np.asarray(touching.stiffness), frame.motion(np.asarray(touching.nodes))
    M, K = frame.pencil()
    on_ball = np.einsum("n,nia->ia", k, B)
    K = np.block([[K + np.einsum("n,nia,nib->ab", k, B, B), -on_ball.T], [-on_ball, k.sum() * np.eye(3)]])
    M = linalg.block_diag(M, 1e-3 * np.eye(3))
    held = 2 / np.sqrt(k.sum() / 1e-3)
    true = held if joined else 2 / np.sqrt(linalg.eigh(K, M, eigvals_only=True)[-1])
    assert 0.7 * true < float(own.model.frames[0].step_limit) <= (1 + 1e-9) * true


def test_the_limit_of_a_modal_part_includes_contacts_of_nodes_tied_to_it():
    mesh = bar(CellType.TETRA4).mesh
    moved = Mesh(mesh.nodes + np.array([4.0, 0, 0]), mesh.cells, mesh.node_sets)
    end = explicit_subdomain(solid_model(moved, SOFT), name="end")
    wall = Contact(At("end", "root"), RigidPlane((0, 0, -1), (0, 0, 1)), stiffness=1e3)
    system = System([modal(), end], ties=[Tie(At("end", "root"), "modal")], contacts=[wall])
    own = ExplicitEngine(system, SPAN).built
    frame, arrays = own.frames["modal"], own.model.frames[0]
    B = frame.material_motion(np.asarray(arrays.weights), np.asarray(arrays.shapes))
    M, K = frame.pencil()
    K = K + 1e3 * np.einsum("nia,nib->ab", B, B)
    true = 2 / np.sqrt(linalg.eigh(K, M, eigvals_only=True)[-1])
    assert 0.9 * true < float(arrays.step_limit) <= (1 + 1e-9) * true


def test_a_single_node_may_start_on_a_wall():
    """Its distance is zero to round-off, which the size of a set of one node does not tell."""
    mesh = bar(CellType.HEXA8).mesh
    corner = Mesh(mesh.nodes, mesh.cells, {**mesh.node_sets, "corner": mesh.node_sets["tip"][:1]})
    part = Placed(explicit_subdomain(solid_model(corner, SOFT), name="bar"), rotation=(0, 0.1, 0.3))
    at = part.position + part.rotation @ mesh.nodes[mesh.node_sets["tip"][0]]
    wall = RigidPlane(tuple(at + part.rotation @ [0, 0.1, 0.7]), tuple(part.rotation @ [-1, 0, 0]))
    ExplicitEngine(System([part], contacts=[Contact(At("bar", "corner"), wall)]), SPAN)
