"""Rigid interfaces to second order: the strains that are kept, what a turned one stores, what joints see."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from supple.algebra.rotation import rotation_exp
from supple.body import (
    AveragingInterface,
    FlexibleBody,
    Frame,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    flexible_body,
)
from supple.body.averaging_error import DEFLECTION_ERROR, section_softness
from supple.body.internal_force import QuadraticStrainForce
from supple.fem import (
    VON_KARMAN,
    HomogeneousSection,
    Isotropic,
    shell_model,
    solid_model,
)
from supple.fem.quadratic_strain import strain
from supple.mesh import CellType, block, box_beam, strip

ALUMINIUM = Isotropic(7e10, 0.3, 2700.0)
WALL = HomogeneousSection(ALUMINIUM, 0.04)
ENDS = (RigidInterface("root", "root"), RigidInterface("tip", "tip", position=(2.1, 0.3, -0.2)))


def box(*interfaces, n_length=8):
    return flexible_body("box", shell_model(box_beam(10.0, 1.0, 0.5, n_length, 2, 1), WALL), interfaces)


def bar(cell_type, n_length):
    return flexible_body("bar", solid_model(block(2.0, 0.4, 0.3, n_length, 1, 1, cell_type), ALUMINIUM), ENDS)


BODIES = {
    "shell": lambda: flexible_body("box", shell_model(box_beam(2.0, 0.4, 0.3, 2, 1, 1), WALL), ENDS),
    "tetra4": lambda: bar(CellType.TETRA4, 2),
    "hexa20, one element at both": lambda: bar(CellType.HEXA20, 1),
}


@pytest.fixture(params=BODIES, scope="module")
def tied(request) -> FlexibleBody:
    return BODIES[request.param]()


def first_order(body: FlexibleBody) -> FlexibleBody:
    """The same body with ties that are linear in the rotation."""
    force = QuadraticStrainForce(body.model, body.expansion)
    return replace(body, force=force)


def moved(body: FlexibleBody, q: np.ndarray) -> np.ndarray:
    """Nodal freedoms T q + Q(q, q) / 2, set by set."""
    nodal = (body.expansion @ q).reshape(len(body.nodes), -1)
    for interface in body.interfaces:
        theta = (interface.motion @ q)[3:]
        arms = body.nodes[interface.node_ids] - interface.position
        nodal[interface.node_ids, :3] += np.cross(theta, np.cross(theta, arms)) / 2
    return nodal.ravel()


def test_strains_are_those_of_the_second_order_motion_cut_back_to_quadratic(tied):
    """eps(T q + Q(q, q) / 2) is a polynomial of degree four in q, whose first two orders are kept."""
    q = np.random.default_rng(2).normal(size=tied.n)
    t = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    fit = np.linalg.inv(np.vander(t, increasing=True))

    def orders(blocks, freedoms):
        """Coefficients of t .. t^4 (4, strains of all points), whatever the order of the elements."""
        samples = [
            np.concatenate([strain(block, u[block.dofs]).ravel() for block in blocks])
            for u in map(freedoms, t)
        ]
        return np.array([np.sort(np.abs(row)) for row in (fit @ np.array(samples))[1:]])

    force = tied.force
    kept = orders(force.blocks, lambda s: force.expansion @ (s * q))
    composed = orders(tied.model.blocks, lambda s: moved(tied, s * q))
    np.testing.assert_allclose(kept[:2], composed[:2], atol=1e-12 * composed[:2].max())
    assert np.abs(kept[2:]).max() < 1e-12 * composed[:2].max()
    assert np.abs(composed[2:]).max() > 1e-3 * composed[1].max()


def test_tangent_and_force_are_derivatives(tied):
    rng = np.random.default_rng(1)
    q, x = 0.05 * rng.normal(size=(2, tied.n))
    a, step = tied.assembly, 1e-30j
    force = a.internal_force(q + step * x).imag / step.imag
    np.testing.assert_allclose(a.tangent(q) @ x, force, atol=1e-12 * np.abs(force).max())
    np.testing.assert_allclose(a.energy(q + step * x).imag / step.imag, x @ a.internal_force(q), rtol=1e-11)


def test_the_linear_stiffness_is_that_of_the_linear_tie(tied):
    K = tied.assembly.tangent(np.zeros(tied.n)) - tied.stiffness
    assert abs(K).max() < 1e-12 * abs(tied.stiffness).max()


def exact_turn(body: FlexibleBody, theta: np.ndarray) -> np.ndarray:
    """All free nodes turned exactly about the first interface, which turns by theta."""
    root = body.interfaces[0]
    arms = body.nodes - root.position
    exact = np.zeros((len(body.nodes), body.dofs_per_node))
    exact[:, :3] = arms @ Rotation.from_rotvec(theta).as_matrix().T - arms
    exact[:, 3:] = theta[: body.dofs_per_node - 3]
    q = splu((body.expansion.T @ body.expansion).tocsc()).solve(body.expansion.T @ exact.ravel())
    q[root.motion.indices] = np.concatenate([np.zeros(3), theta])
    return q


def turned(body: FlexibleBody, theta: np.ndarray) -> float:
    """Energy of the unloaded body when its first interface is turned by theta and all else may follow."""
    held = body.interfaces[0].motion.indices
    q = exact_turn(body, theta)
    free = np.setdiff1d(np.arange(body.n), held)
    for _ in range(15):
        tangent = body.assembly.tangent(q)[free][:, free].tocsc()
        step = splu(tangent).solve(-body.assembly.internal_force(q)[free])
        q[free] += step
        if np.abs(step).max() < 1e-9:
            return float(body.assembly.energy(q))
    raise AssertionError("Newton's method did not converge")


@pytest.mark.parametrize("axis", [(1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0), (0.48, 0.6, 0.64)])
def test_a_turned_interface_stores_an_energy_of_sixth_order(axis):
    body = box(RigidInterface("root", "root"))
    energies = [turned(body, angle * np.array(axis)) for angle in (0.03, 0.06, 0.12)]
    np.testing.assert_allclose(np.log2(np.divide(energies[1:], energies[:-1])), 6.0, atol=0.1)
    fourth = turned(first_order(body), 0.06 * np.array(axis))
    assert energies[1] < 2e-3 * fourth


def test_a_turned_solid_interface_stores_little():
    body = bar(CellType.HEXA8, 4)
    theta = np.array([0.0, 0.06, 0.0])
    assert turned(body, theta) < 3e-3 * turned(first_order(body), theta)


def test_von_karman_strains_keep_the_linear_tie():
    """They see no turn in the plane, so that shortening by it would strain them."""
    model = shell_model(strip(2.0, 0.4, 4, 2), HomogeneousSection(ALUMINIUM, 0.02), kinematics=VON_KARMAN)
    body = flexible_body("strip", model, [RigidInterface("root", "root")])
    assert body.force.blocks is model.blocks


# --- what joints see


@pytest.mark.parametrize(
    ("kind", "axis"), [*(("bar", axis) for axis in np.eye(3)), *(("box", axis) for axis in np.eye(3)[1:])]
)
def test_a_rigid_interface_has_turned_as_the_unloaded_body_has(kind, axis):
    """All other nodes are turned by phi, and the interface is where it meets no force.

    A shell's own rotations want theta = phi, but bend softly: a fifteenth of the cubic term is theirs.
    """
    root = RigidInterface("root", "root")
    model = solid_model(block(2.0, 0.4, 0.3, 4, 1, 1, CellType.HEXA8), ALUMINIUM)
    body = box(root) if kind == "box" else flexible_body("bar", model, [root])
    motion = body.interfaces[0].motion
    errors = []
    for angle in (0.1, 0.2):
        q = exact_turn(body, angle * axis)
        own = motion.indices
        for _ in range(15):
            tangent = body.assembly.tangent(q)[own][:, own].toarray()
            q[own] -= np.linalg.solve(tangent, body.assembly.internal_force(q)[own])
        theta = motion[3:] @ q
        phi = (1 + body.interfaces[0].cubic_turn * theta @ theta) * theta
        errors.append(np.linalg.norm(phi - angle * axis))
    if kind == "bar":
        assert errors[0] < 0.1**5
        assert np.log2(errors[1] / errors[0]) == pytest.approx(5, abs=0.3)
    assert errors[0] < 0.1**3 / 3 / 15


@pytest.mark.parametrize("axis", np.eye(3))
def test_an_averaging_interface_has_turned_as_its_nodes_have(axis):
    body = box(AveragingInterface("root", "root"))
    (root,) = body.interfaces
    errors = []
    for angle in (0.2, 0.4):
        arms = body.nodes - root.position
        field = np.zeros((len(body.nodes), 6))
        field[:, :3] = arms @ Rotation.from_rotvec(angle * axis).as_matrix().T - arms
        theta = (root.motion @ field.ravel())[3:]
        phi = (1 + root.cubic_turn * theta @ theta) * theta
        errors.append(np.linalg.norm(phi - angle * axis))
    assert errors[0] < 0.2**5 / 10
    assert np.log2(errors[1] / errors[0]) == pytest.approx(5, abs=0.2)


def test_rotations_taken_from_nodes_and_those_of_linear_bodies_are_rotation_vectors():
    edge = flexible_body("strip", shell_model(strip(2.0, 0.4, 4, 2), WALL), [RigidInterface("root", "root")])
    assert edge.interfaces[0].cubic_turn == 0
    body = box(RigidInterface("root", "root"), AveragingInterface("tip", "tip"))
    assert [interface.cubic_turn for interface in body.interfaces] == [-1 / 3, 1 / 6]
    assert [interface.cubic_turn for interface in body.linearized().interfaces] == [0, 0]


# --- statics in two frames


def place(w, cubic_turn, root, tip):
    """Of the tip, seen from the root, after the motions (12,) of both."""
    phi = (1 + cubic_turn * (w[3:6] @ w[3:6])) * w[3:6]
    return rotation_exp(-phi) @ (tip + w[6:9] - root - w[:3])


WORK = [jax.jit(kind(lambda w, load, *ends: place(w, *ends) @ load)) for kind in (jax.grad, jax.hessian)]
"""Derivatives of the work of a dead force for the motions."""


def clamped_tip(body: FlexibleBody, frame: Frame, force: np.ndarray) -> np.ndarray:
    """Where a dead force takes the second interface while the first is clamped in space."""
    root, tip = body.interfaces
    held = frame.constraint(body)
    held = held * (body.stiffness.diagonal().max() / np.abs(held).max())
    motion = np.vstack([root.motion.toarray(), tip.motion.toarray()])

    ends = root.cubic_turn, root.position, tip.position
    n = body.n
    q, multipliers = np.zeros(n), np.zeros(6)
    for load in (force / 2, force):
        for _ in range(15):
            w = motion @ q
            first, second = (np.asarray(derivative(w, load, *ends)) for derivative in WORK)
            unbalanced = body.assembly.internal_force(q) - motion.T @ first + held.T @ multipliers
            tangent = body.assembly.tangent(q).toarray() - motion.T @ second @ motion
            bordered = np.block([[tangent, held.T], [held, np.zeros((6, 6))]])
            step = -np.linalg.solve(bordered, np.concatenate([unbalanced, held @ q]))
            q, multipliers = q + step[:n], multipliers + step[n:]
            if np.abs(step[:n]).max() < 1e-9:
                break
        else:
            raise AssertionError("Newton's method did not converge")
    return np.asarray(place(motion @ q, *ends))


FRAMES = {"mean axes": MeanAxisFrame(), "the other end": NodalFixedFrame("tip")}


@pytest.mark.parametrize(
    ("ends", "other", "allowed"),
    [
        (RigidInterface, "mean axes", 6e-3),
        pytest.param(RigidInterface, "the other end", 1e-2, marks=pytest.mark.slow),
        pytest.param(AveragingInterface, "mean axes", 2e-3, marks=pytest.mark.slow),
        (AveragingInterface, "the other end", 4e-3),
    ],
)
def test_a_bent_bar_of_solids_is_the_same_in_every_frame(ends, other, allowed):
    """Tip at a tenth of the length, obliquely: joints turn by 0.1 rad and more against the other frames."""
    model = solid_model(block(2.0, 0.1, 0.1, 8, 1, 1, CellType.HEXA8), Isotropic(2e6, 0.0, 1000.0))
    body = flexible_body("bar", model, [ends("root", "root"), ends("tip", "tip")])
    force = np.array([0.0, 0.8, 1.0])
    own, elsewhere = (clamped_tip(body, frame, force) for frame in (NodalFixedFrame("root"), FRAMES[other]))
    moved_by = np.linalg.norm(own - [2.0, 0, 0])
    assert moved_by > 0.19
    assert np.linalg.norm(own - elsewhere) < allowed * moved_by


def test_a_bent_box_with_rigid_ends_is_the_same_in_mean_axes():
    """Tip at a tenth of the length; with ties of first order, mean axes are a fifth off."""
    body = box(RigidInterface("root", "root"), RigidInterface("tip", "tip"), n_length=6)
    force = np.array([0.0, 0.0, 1.2e6])
    frames = NodalFixedFrame("root"), MeanAxisFrame()
    own, elsewhere = (clamped_tip(body, frame, force) for frame in frames)
    moved_by = np.linalg.norm(own - [10.0, 0, 0])
    assert moved_by > 0.8
    assert np.linalg.norm(own - elsewhere) < 6e-3 * moved_by


# --- what averaging on a section that yields costs


@pytest.mark.slow
def test_the_error_of_averaging_on_a_soft_ring_is_foretold():
    """6 phi^2 c / C of the deflection of a box under a force at its tip, where the frame is."""
    ends = [AveragingInterface("root", "root"), AveragingInterface("tip", "tip")]
    body = box(*ends, n_length=6)
    root, _ = body.interfaces
    measured, foretold = [], []
    for force in (0.0, 0.0, 3e5), (0.0, 0.0, 6e5):
        own, elsewhere = (
            clamped_tip(body, NodalFixedFrame(name), np.array(force)) for name in ("root", "tip")
        )
        deflection = own[2]
        # A beam under a force at its end turns there by 3/2 of its deflection over its length.
        turned = 1.5 * deflection / 10.0
        measured.append(np.linalg.norm(own - elsewhere) / deflection)
        foretold.append(DEFLECTION_ERROR * turned**2 * section_softness(body, root)[1])
    assert measured[1] > 0.02
    np.testing.assert_allclose(measured, foretold, rtol=0.3)
    assert measured[1] / measured[0] == pytest.approx(4, rel=0.1)


def test_sections_that_keep_their_shape_cost_nothing():
    model = solid_model(block(2.0, 0.1, 0.1, 8, 1, 1, CellType.HEXA8), Isotropic(2e6, 0.0, 1000.0))
    body = flexible_body("bar", model, [AveragingInterface("root", "root"), AveragingInterface("tip", "tip")])
    assert section_softness(body, body.interfaces[0]).max() < 0.03
    rigid = box(RigidInterface("root", "root"))
    assert not section_softness(rigid, rigid.interfaces[0]).any()
    linear = box(AveragingInterface("root", "root")).linearized()
    assert not section_softness(linear, linear.interfaces[0]).any()
