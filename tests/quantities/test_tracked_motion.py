"""Tracked places against their definitions: r = R + A (x + u), deflection A_p^T (r - r_p) - (x - x_p)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.integrate import FloatingMotion
from supple.quantities import deflections, node_positions, observer, tracked_motion

T = 4


@pytest.fixture
def motion_of():
    """A motion of so many coordinates, their sizes up to a hundredth."""

    def make(r, size=0.01):
        rng = np.random.default_rng(2)
        three, many = np.zeros((T, 3)), size * rng.uniform(-1, 1, (T, r))
        rotation = Rotation.random(T, rng=rng).as_matrix()
        return FloatingMotion(rng.normal(size=(T, 3)), rotation, many, three, three, many, three, three, many)

    return make


def test_an_interface_of_a_rigid_body_goes_with_its_frame(rod, motion_of):
    motion = motion_of(0)
    tracked = tracked_motion(rod("rod", 2.0), motion, "right")
    np.testing.assert_allclose(tracked.position, motion.position + motion.rotation[:, :, 0], rtol=1e-13)
    assert not tracked.deflection.any()
    assert tracked.seen_from == ""


def test_a_body_that_only_moves_has_no_deflection(floating_blade, motion_of):
    tracked = tracked_motion(floating_blade, motion_of(floating_blade.n_coordinates, size=0.0), "tip")
    np.testing.assert_allclose(tracked.deflection, 0.0, atol=1e-14)
    assert tracked.seen_from == "root"


def test_the_deflection_of_a_node_is_that_of_all_nodes_there(floating_blade, motion_of):
    motion = motion_of(floating_blade.n_coordinates)
    everywhere = deflections(floating_blade, motion)
    for node in (0, 9, 20):
        tracked = tracked_motion(floating_blade, motion, [node])
        np.testing.assert_allclose(tracked.position, node_positions(floating_blade, motion, [node])[:, 0])
        np.testing.assert_allclose(tracked.deflection, everywhere[:, node], atol=1e-14)
    both = tracked_motion(floating_blade, motion, [9, 20]).deflection
    np.testing.assert_allclose(both, everywhere[:, [9, 20]].mean(axis=1), atol=1e-14)


def test_the_first_interface_does_not_move_against_itself(floating_blade, motion_of):
    tracked = tracked_motion(floating_blade, motion_of(floating_blade.n_coordinates), "root")
    np.testing.assert_allclose(tracked.deflection, 0.0, atol=1e-14)


def test_what_is_seen_from_another_body_does_not_depend_on_where_both_fly(floating_blade, motion_of):
    """A_p^T (r - r_p) - (x - x_p) of the definition, p an interface of another body that shares the axes."""
    r = floating_blade.n_coordinates
    motion, other = motion_of(r), motion_of(r, size=0.004)
    seen_from = observer(floating_blade, other, "root")
    tracked = tracked_motion(floating_blade, motion, "tip", seen_from)
    tip, root = floating_blade.interface("tip"), floating_blade.interface("root")
    for t in range(T):
        phi = root.motion[3:] @ other.coordinates[t]
        phi = phi * (1 + root.cubic_turn * phi @ phi)
        axes = other.rotation[t] @ Rotation.from_rotvec(phi).as_matrix()
        r_p = other.position[t] + other.rotation[t] @ (root.position + root.motion[:3] @ other.coordinates[t])
        place = motion.position[t] + motion.rotation[t] @ (
            tip.position + tip.motion[:3] @ motion.coordinates[t]
        )
        expected = axes.T @ (place - r_p) - (tip.position - root.position)
        np.testing.assert_allclose(tracked.deflection[t], expected, atol=1e-13)
    everywhere = deflections(floating_blade, motion, seen_from)
    node = tracked_motion(floating_blade, motion, [9], seen_from)
    np.testing.assert_allclose(everywhere[:, 9], node.deflection, atol=1e-13)


def test_an_observer_turns_by_the_angle_that_a_joint_there_has(floating_blade, motion_of):
    """theta (1 + c theta.theta), c of the interface."""
    motion = motion_of(floating_blade.n_coordinates)
    root = replace(floating_blade.interfaces[0], cubic_turn=-1 / 3)
    body = replace(floating_blade, interfaces=(root, *floating_blade.interfaces[1:]))
    theta = motion.coordinates @ root.motion[3:].T
    phi = theta * (1 - np.sum(theta**2, axis=1, keepdims=True) / 3)
    expected = motion.rotation @ Rotation.from_rotvec(phi).as_matrix()
    np.testing.assert_allclose(observer(body, motion, "root").axes, expected, atol=1e-14)
