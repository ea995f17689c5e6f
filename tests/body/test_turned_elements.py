"""Elements in axes of their own feel no rigid turn, and small motion as the body does."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from supple.body import RigidInterface, flexible_body
from supple.body.turned_elements import turned_force
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.mesh import CellType, block, strip

RUBBER = Isotropic(1e9, 0.3, 1000.0)
ENDS = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
BODIES = {
    "shell": lambda: flexible_body(
        "b", shell_model(strip(1.0, 0.1, 4, 2), HomogeneousSection(RUBBER, 0.01)), ENDS
    ),
    "solid": lambda: flexible_body(
        "b", solid_model(block(1.0, 0.2, 0.2, 3, 1, 1, CellType.TETRA4), RUBBER), ENDS
    ),
}


@pytest.fixture(params=BODIES)
def body(request):
    return BODIES[request.param]()


def turned(body, vector):
    """Coordinates of a rigid turn; rigid interfaces by the freedom whose turn is the vector's."""
    turn = Rotation.from_rotvec(vector)
    nodal = np.zeros((len(body.nodes), body.dofs_per_node))
    nodal[:, :3] = turn.apply(np.array(body.nodes)) - body.nodes
    nodal[:, 3:] = vector[: body.dofs_per_node - 3]
    held = np.concatenate([interface.node_ids for interface in body.interfaces])
    free = np.setdiff1d(np.arange(len(body.nodes)), held)
    q = np.zeros(body.n)
    q[: nodal[free].size] = nodal[free].ravel()
    angle = np.linalg.norm(vector)
    for interface in body.interfaces:
        size = brentq(lambda t, c=interface.cubic_turn: t + c * t**3 - angle, 0.0, 0.99)
        moved = turn.apply(np.array(interface.position)) - interface.position
        q[interface.motion.indices] = np.concatenate([moved, np.array(vector) * size / angle])
    return q


@pytest.mark.parametrize("vector", [(0.01, 0.1, -0.02), (0.2, -0.3, 0.25)])
def test_a_rigid_turn_leaves_no_force(body, vector):
    q = turned(body, vector)
    scale = np.abs(body.stiffness @ q).max()
    assert np.abs(turned_force(body, q)).max() < 1e-11 * scale
    assert np.abs(body.force.internal_force(q)).max() > 1e-8 * scale


def test_small_motion_is_felt_as_the_body_feels_it(body):
    """To first order by the same stiffness: the difference is of second order in the motion."""
    rng = np.random.default_rng(1)
    direction = rng.standard_normal(body.n)
    apart = []
    for size in (1e-7, 1e-6):
        q = size * direction
        force = body.stiffness @ q
        apart.append(np.abs(turned_force(body, q) - force).max() / np.abs(force).max())
    assert apart[1] < 1e-3
    assert apart[1] / apart[0] == pytest.approx(10.0, rel=0.05)


def test_a_body_without_elements_is_refused(body):
    from dataclasses import replace

    with pytest.raises(ModelError, match="no elements"):
        turned_force(replace(body, model=None), np.zeros(body.n))
