"""Velocities and accelerations of nodes against derivatives of their positions in time."""

from __future__ import annotations

import numpy as np

from supple.algebra.rotation import rotation_exp
from supple.body import floating_positions
from supple.body.point_motion import floating_node_motion
from supple.integrate import FloatingMotion

RNG = np.random.default_rng(4)
NODES, SHAPES = RNG.standard_normal((5, 3)), RNG.standard_normal((5, 3, 2))
PAIRS = RNG.standard_normal((5, 3, 2, 2))
PAIRS += PAIRS.swapaxes(2, 3)
SPIN, TURN = np.array([0.4, -0.9, 0.3]), np.array([0.2, 0.5, -0.7])


class Body:
    """Displacements quadratic in the coordinates, as of a body whose tensors are condensed."""

    nodes = NODES
    positions = floating_positions

    @staticmethod
    def expand(gamma, nodes=slice(None)):
        linear = np.einsum("nir,...r->...ni", SHAPES[nodes], gamma)
        return linear + np.einsum("nirs,...r,...s->...ni", PAIRS[nodes], gamma, gamma)

    @staticmethod
    def expand_rates(gamma, rates, nodes=slice(None)):
        linear = np.einsum("nir,...r->...ni", SHAPES[nodes], rates)
        return linear + 2 * np.einsum("nirs,...r,...s->...ni", PAIRS[nodes], gamma, rates)


def motion(times):
    """A rotation that spins up about a fixed axis of the body, a path, and two growing deformations."""
    t = np.asarray(times)[:, None]
    angle = 0.7 * t + 0.2 * t**2
    axis = SPIN / np.linalg.norm(SPIN)
    start = np.asarray(rotation_exp(TURN))
    rotation = np.array([start @ np.asarray(rotation_exp(a * axis)) for a in angle])
    return FloatingMotion(
        position=np.hstack([t**2, np.sin(t), t]),
        rotation=rotation,
        coordinates=np.hstack([0.3 * t**3, np.cos(2 * t)]),
        velocity=np.hstack([2 * t, np.cos(t), 1 + 0 * t]),
        angular_velocity=(0.7 + 0.4 * t) * axis,
        coordinate_rates=np.hstack([0.9 * t**2, -2 * np.sin(2 * t)]),
        acceleration=np.hstack([2 + 0 * t, -np.sin(t), 0 * t]),
        angular_acceleration=np.broadcast_to(0.4 * axis, (len(t), 3)),
        coordinate_accelerations=np.hstack([1.8 * t, -4 * np.cos(2 * t)]),
    )


def test_node_motion_is_the_derivative_of_node_positions():
    h, nodes = 1e-4, [3, 0]
    around = motion([0.8 - h, 0.8, 0.8 + h])
    before, now, after = Body().positions(around, nodes)
    found = floating_node_motion(Body(), around, nodes)
    np.testing.assert_array_equal(found.position[1], now)
    np.testing.assert_allclose(found.velocity[1], (after - before) / (2 * h), atol=1e-7)
    np.testing.assert_allclose(found.acceleration[1], (after - 2 * now + before) / h**2, atol=1e-6)
