from __future__ import annotations

import numpy as np
import pytest

from supple.body.rigid_motion import averaged_motion, nodal_rigid_modes

RNG = np.random.default_rng(0)
CLOUD = RNG.standard_normal((7, 3)) + np.array([10.0, 0, -5])
LINE = np.array([10.0, 0, -5]) + np.outer([0, 1, 2.5, 4], [1, -2, 0.3])
WEIGHTS = RNG.uniform(0.5, 3.0, 7)
POSITION = np.array([9.0, 2.0, 1.0])
CASES = {
    "solid": (CLOUD, 3),
    "shell": (CLOUD, 6),
    "shell edge": (LINE, 6),
    "shell corner": (LINE[:1], 6),
}


@pytest.fixture(params=CASES)
def case(request):
    points, dofs_per_node = CASES[request.param]
    weights = WEIGHTS[: len(points)]
    return points, weights, averaged_motion(points, weights, POSITION, dofs_per_node)


def test_a_rigid_motion_is_reproduced_exactly(case):
    points, _, motion = case
    about_position = nodal_rigid_modes(points - POSITION, motion.shape[2])
    np.testing.assert_allclose(motion.reshape(6, -1) @ about_position, np.eye(6), atol=1e-13)


def test_the_force_it_spreads_has_the_same_resultant(case):
    # F_a = motion^T (f, m): sum F_a = f, sum (x_a - position) x F_a + M_a = m.
    points, _, motion = case
    wrench = np.array([1.0, -2, 3, 0.5, -0.7, 0.9])
    nodal = np.einsum("iad,i->ad", motion, wrench)
    np.testing.assert_allclose(nodal[:, :3].sum(axis=0), wrench[:3], atol=1e-13)
    moment = np.cross(points - POSITION, nodal[:, :3]).sum(axis=0)
    if nodal.shape[1] == 6:
        moment += nodal[:, 3:].sum(axis=0)
    np.testing.assert_allclose(moment, wrench[3:], atol=1e-12)


@pytest.mark.parametrize("dofs_per_node", [3, 6])
def test_it_is_the_weighted_least_squares_fit(dofs_per_node):
    displacement = RNG.standard_normal((7, 3))
    nodal = np.hstack([displacement, RNG.standard_normal((7, dofs_per_node - 3))])
    fitted = np.einsum("iad,ad->i", averaged_motion(CLOUD, WEIGHTS, POSITION, dofs_per_node), nodal)
    fields = nodal_rigid_modes(CLOUD - POSITION, 3)
    root = np.sqrt(np.repeat(WEIGHTS, 3))
    expected = np.linalg.lstsq(root[:, None] * fields, root * displacement.ravel())[0]
    np.testing.assert_allclose(fitted, expected, atol=1e-13)


def test_swelling_does_not_turn_it():
    swollen = CLOUD - WEIGHTS @ CLOUD / WEIGHTS.sum()
    motion = averaged_motion(CLOUD, WEIGHTS, CLOUD.mean(axis=0), 3)
    np.testing.assert_allclose(np.einsum("iad,ad->i", motion, swollen)[3:], 0, atol=1e-13)


def test_nodes_on_a_line_turn_about_it_by_their_own_mean_rotation():
    axis = (LINE[1] - LINE[0]) / np.linalg.norm(LINE[1] - LINE[0])
    own = np.array([0.1, 0.3, -0.2, 0.6])
    nodal = np.zeros((4, 6))
    nodal[:, 3:] = own[:, None] * axis
    motion = averaged_motion(LINE, np.ones(4), LINE.mean(axis=0), 6)
    np.testing.assert_allclose(
        np.einsum("iad,ad->i", motion, nodal), [0, 0, 0, *(own.mean() * axis)], atol=1e-13
    )
