"""The way from a floating frame and the coordinates in it to the nodes in space, r = R + A (x + u)."""

from dataclasses import dataclass

import numpy as np
import pytest

from supple.body import floating_kinematics, floating_positions, in_space, node_displacements
from supple.errors import ModelError


@dataclass(frozen=True)
class Strip:
    """Nodes with a displacement basis (N, 3, r)."""

    nodes: np.ndarray
    basis: np.ndarray

    def expand(self, gamma, nodes=slice(None)):
        return np.einsum("kir,...r->...ki", self.basis[nodes], gamma)


BEAM = "beam/left 100%"


@pytest.fixture
def strip():
    rng = np.random.default_rng(4)
    return Strip(rng.normal(size=(6, 3)), rng.normal(size=(6, 3, 5)))


def test_places_in_a_frame_are_turned_then_moved(solution):
    motion = solution.bodies[BEAM]
    local = np.random.default_rng(5).normal(size=(len(solution.times), 2, 3))
    r = in_space(motion.position, motion.rotation, local)
    np.testing.assert_allclose(r[3, 1], motion.position[3] + motion.rotation[3] @ local[3, 1], rtol=1e-12)


def test_displacements_follow_the_basis(strip, solution):
    gamma = solution.bodies[BEAM].coordinates
    u = node_displacements(strip, gamma)
    np.testing.assert_allclose(u[3, 2], strip.basis[2] @ gamma[3], rtol=1e-13)
    np.testing.assert_array_equal(node_displacements(strip, gamma, [4, 1]), u[:, [4, 1]])
    np.testing.assert_array_equal(node_displacements(strip, gamma, 4), u[:, [4]])


def test_positions_are_frame_plus_turned_local_position(strip, solution):
    motion = solution.bodies[BEAM]
    r = floating_positions(strip, motion)
    local = strip.nodes[5] + strip.basis[5] @ motion.coordinates[2]
    np.testing.assert_allclose(r[2, 5], motion.position[2] + motion.rotation[2] @ local, rtol=1e-12)


def test_long_runs_are_recovered_in_parts(strip, solution, monkeypatch):
    motion = solution.bodies[BEAM]
    whole = floating_positions(strip, motion)
    monkeypatch.setattr(floating_kinematics, "_FIELD_NUMBERS", 2 * strip.nodes.size)
    np.testing.assert_array_equal(floating_positions(strip, motion), whole)


def test_node_numbers_are_checked(strip, solution):
    with pytest.raises(ModelError, match="node numbers -1 to 6; the body has 6 nodes"):
        node_displacements(strip, solution.bodies[BEAM].coordinates, [-1, 6])
