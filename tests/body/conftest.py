from __future__ import annotations

import numpy as np
import pytest

from supple.body import AveragingInterface, FlexibleBody, RigidInterface, flexible_body
from supple.fem import (
    FiniteElementModel,
    HomogeneousSection,
    Isotropic,
    shell_model,
    solid_model,
)
from supple.mesh import CellType, block, strip

ALUMINIUM = Isotropic(7e10, 0.3, 2700.0)


@pytest.fixture(scope="session")
def shell() -> FiniteElementModel:
    """A strip of 2 x 0.4 m, 20 mm thick, along x."""
    return shell_model(strip(2.0, 0.4, 8, 2), HomogeneousSection(ALUMINIUM, 0.02))


@pytest.fixture(scope="session")
def solid() -> FiniteElementModel:
    """A block of 1 x 0.3 x 0.2 m."""
    return solid_model(block(1.0, 0.3, 0.2, 4, 2, 2, CellType.HEXA8), ALUMINIUM)


def ends(model: FiniteElementModel) -> tuple[np.ndarray, np.ndarray]:
    x = model.mesh.nodes[:, 0]
    return np.flatnonzero(x == x.min()), np.flatnonzero(x == x.max())


@pytest.fixture(scope="session", params=["shell", "solid"])
def body(request, shell, solid) -> FlexibleBody:
    """Either body, its first end rigid (about a point off its centroid), its last end averaged."""
    model = shell if request.param == "shell" else solid
    first, last = ends(model)
    return flexible_body(
        request.param,
        model,
        [RigidInterface("root", first, position=(-0.1, 0.05, 0.02)), AveragingInterface("tip", last)],
    )


@pytest.fixture(scope="session")
def rigid_field():
    """rigid_field(nodes, dofs_per_node, u, theta): nodal values u + theta x x_a, node by node."""

    def make(nodes, dofs_per_node, u, theta):
        motion = u + np.cross(theta, nodes)
        if dofs_per_node == 6:
            motion = np.hstack([motion, np.broadcast_to(theta, nodes.shape)])
        return motion.ravel()

    return make
