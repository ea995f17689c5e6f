from __future__ import annotations

import pickle
import sys

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    flexible_body,
)
from supple.errors import MeshError, ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip


def test_matrices_are_the_nodal_ones_with_the_rigid_end_eliminated(body):
    T = body.expansion.toarray()
    held = body.interface("root").node_ids.size * body.dofs_per_node
    assert body.n == body.n_nodal - held + 6
    np.testing.assert_allclose(
        body.mass.toarray(), T.T @ body.nodal_mass @ T, atol=1e-12 * abs(body.mass).max()
    )
    K = body.model.stiffness
    np.testing.assert_allclose(body.stiffness.toarray(), T.T @ K @ T, atol=1e-12 * abs(K).max())


def test_the_indices_of_its_matrices_are_narrow(body):
    for matrix in (body.expansion, body.nodal_mass, body.mass, body.stiffness):
        assert matrix.indices.dtype == np.int32


def test_rigid_modes_are_rigid_motions_of_all_nodes(body, rigid_field):
    u, theta = np.array([1.0, -2, 3]), np.array([0.4, 0.5, -0.6])
    nodal = body.expansion @ (body.rigid_modes @ np.concatenate([u, theta]))
    np.testing.assert_allclose(nodal, rigid_field(body.nodes, body.dofs_per_node, u, theta), atol=1e-14)
    force = np.abs(body.stiffness @ body.rigid_modes)
    assert np.max(force) < 1e-11 * abs(body.stiffness).max()


def test_interfaces_follow_rigid_motion_exactly(body):
    u, theta = np.array([1.0, -2, 3]), np.array([0.4, 0.5, -0.6])
    q = body.rigid_modes @ np.concatenate([u, theta])
    for interface in body.interfaces:
        expected = np.concatenate([u + np.cross(theta, interface.position), theta])
        np.testing.assert_allclose(interface.motion @ q, expected, atol=1e-13)


def test_a_wrench_at_an_interface_has_its_resultant(body):
    wrench = np.array([10.0, 20, -30, 4, -5, 6])
    for interface in body.interfaces:
        resultant = body.rigid_modes.T @ (interface.motion.T @ wrench)
        moment = wrench[3:] + np.cross(interface.position, wrench[:3])
        np.testing.assert_allclose(resultant, np.concatenate([wrench[:3], moment]), atol=1e-11)


def test_an_averaging_interface_adds_no_stiffness(shell):
    plain = flexible_body("strip", shell)
    averaged = flexible_body(
        "strip", shell, [AveragingInterface("tip", "tip"), AveragingInterface("mid", "axis")]
    )
    assert averaged.n == plain.n == shell.n_dofs
    assert abs(averaged.stiffness - plain.stiffness).max() == 0
    assert abs(averaged.mass - plain.mass).max() == 0


def test_a_rigid_interface_stiffens_an_averaging_one_does_not(shell):
    def softest(*interfaces):
        body = flexible_body("strip", shell, interfaces)
        return lowest_modes(body.stiffness, body.mass, 3, constraint=MeanAxisFrame().constraint(body)).values

    free = softest()
    np.testing.assert_allclose(softest(AveragingInterface("tip", "tip")), free, rtol=1e-9)
    assert np.all(softest(RigidInterface("tip", "tip")) > free)


def test_one_shell_node_can_be_rigid(shell):
    body = flexible_body("strip", shell, [RigidInterface("tip", "tip_centre")])
    assert body.n == shell.n_dofs
    plain = flexible_body("strip", shell)
    values = [
        lowest_modes(b.stiffness, b.mass, 5, constraint=MeanAxisFrame().constraint(b)).values
        for b in (plain, body)
    ]
    np.testing.assert_allclose(values[1], values[0], rtol=1e-6)  # thin shell: round-off of the factors


def test_beam_frequencies_in_both_frames():
    # Slender strip, no lateral contraction: omega = (beta L)^2 sqrt(EI / rho A) / L^2 of Euler and Bernoulli.
    length, width, thickness, E, rho = 10.0, 0.2, 0.02, 7e10, 2700.0
    model = shell_model(strip(length, width, 60, 2), HomogeneousSection(Isotropic(E, 0.0, rho), thickness))
    body = flexible_body("beam", model, [RigidInterface("root", "root")])
    wave_speed = np.sqrt(E * thickness**2 / 12 / rho) / length**2
    for frame, beta_length in ((MeanAxisFrame(), 4.730040745), (NodalFixedFrame("root"), 1.875104069)):
        modes = lowest_modes(body.stiffness, body.mass, 1, constraint=frame.constraint(body))
        assert np.sqrt(modes.values[0]) == pytest.approx(beta_length**2 * wave_speed, rel=1e-3)


def test_one_factor_serves_both_frames(body):
    load = body.interface("tip").motion.T @ np.array([0, 0, 100.0, 0, 0, 0])
    for frame in (MeanAxisFrame(), NodalFixedFrame("root")):
        D = frame.constraint(body)
        x, mu = body.constrained(D).solve_with_multipliers(load)
        residual = body.stiffness @ x + D.T @ mu - load
        assert np.max(np.abs(residual)) < 1e-7 * np.max(np.abs(load))
    assert body.constrained(D).grounded is body.grounded_stiffness


def test_the_nonlinear_assembly_starts_from_the_stiffness(body):
    x = np.random.default_rng(0).standard_normal(body.n) * 1e-9
    assert np.linalg.norm(body.assembly.internal_force(x) - body.stiffness @ x) < 1e-5 * np.linalg.norm(
        body.stiffness @ x
    )


def test_a_linearised_body_has_no_nonlinear_force(body):
    linear = body.linearized()
    assert linear.is_linear
    assert linear.model is body.model
    q = np.random.default_rng(2).standard_normal(body.n)
    np.testing.assert_array_equal(linear.force.internal_force(q), body.stiffness @ q)
    assert linear.force.tangent(q) is body.stiffness
    assert linear.stiffness is body.stiffness
    assert linear.grounded_stiffness is body.grounded_stiffness
    with pytest.raises(
        ModelError, match=f"body '{body.name}' is linear: it has matrices but no quadratic strains"
    ):
        _ = linear.assembly


def test_rotations_of_a_rigid_motion(body):
    theta = np.array([0.1, -0.2, 0.3])
    nodal = body.expansion @ (body.rigid_modes[:, 3:] @ theta)
    rotations = (body.rotation_operator @ nodal).reshape(-1, 3)
    np.testing.assert_allclose(rotations, np.broadcast_to(theta, rotations.shape), atol=1e-12)


def test_a_body_travels_between_processes(body):
    _ = body.assembly
    again = pickle.loads(pickle.dumps(body))
    load = np.random.default_rng(1).standard_normal(body.n)
    D = MeanAxisFrame().constraint(body)
    np.testing.assert_array_equal(again.constrained(D).solve(load), body.constrained(D).solve(load))


def test_unknown_names_are_told_with_the_known_ones(body, shell):
    with pytest.raises(ModelError, match=f"body '{body.name}' has no interface 'hub'; there are: root, tip"):
        body.interface("hub")
    with pytest.raises(ModelError, match="has no interface 'hub'; there are: none"):
        flexible_body("strip", shell).interface("hub")
    with pytest.raises(MeshError, match="no node set 'hub' in this mesh"):
        flexible_body("strip", shell, [RigidInterface("root", "hub")])


def test_a_body_that_is_all_rigid_is_no_flexible_body(shell):
    with pytest.raises(ModelError, match="its interfaces tie every node rigidly; use a RigidBody"):
        flexible_body("strip", shell, [RigidInterface("all", np.arange(shell.mesh.n_nodes))])


def test_what_it_holds_is_read_only(body):
    for array in (
        body.nodes,
        body.rigid_modes,
        body.interface("tip").position,
        body.interface("tip").node_ids,
    ):
        assert not array.flags.writeable


def test_frequencies_are_those_of_the_modes_and_are_sought_once(body, monkeypatch):
    """Held and in mean axes apart; more than were found are sought anew; a copy knows none."""
    held, mean = (frame.constraint(body) for frame in (NodalFixedFrame("root"), MeanAxisFrame()))
    expected = np.sqrt(body.lowest_modes(4, held).values)
    in_mean_axes = body.lowest_frequencies(4, mean)
    assert abs(in_mean_axes / expected - 1).min() > 0.1
    np.testing.assert_allclose(body.lowest_frequencies(6, held)[:4], expected, rtol=1e-9)
    copy = pickle.loads(pickle.dumps(body))
    monkeypatch.setattr(sys.modules["supple.body.flexible_body"], "lowest_modes", None)
    np.testing.assert_allclose(body.lowest_frequencies(2, held), expected[:2], rtol=1e-9)
    np.testing.assert_array_equal(body.lowest_frequencies(4, mean), in_mean_axes)
    with pytest.raises(TypeError):
        copy.lowest_frequencies(2, held)
