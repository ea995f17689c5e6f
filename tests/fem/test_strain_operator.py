"""The force by sparse products is the sum over elements, for every kind of quadratic strain."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import RigidInterface, flexible_body
from supple.fem import GREEN_LAGRANGE, VON_KARMAN, HomogeneousSection, Isotropic, shell_model, solid_model
from supple.fem.strain_operator import strain_operator
from supple.mesh import CellType, block, plate

STEEL = Isotropic(2.1e11, 0.3, 7850.0)


def shell(kinematics):
    model = shell_model(plate(1.0, 0.4, 3, 2), HomogeneousSection(STEEL, 0.01), kinematics=kinematics)
    return flexible_body("plate", model)


def solid():
    """With a rigid interface, whose tie to second order has a strain of its own."""
    model = solid_model(block(1.0, 0.3, 0.3, 2, 1, 1, CellType.TETRA10), STEEL)
    return flexible_body(
        "block", model, (RigidInterface("root", np.flatnonzero(model.mesh.nodes[:, 0] == 0)),)
    )


BODIES = {
    "Green-Lagrange shell": lambda: shell(GREEN_LAGRANGE),
    "von Karman shell": lambda: shell(VON_KARMAN),
    "tied solid": solid,
}


@pytest.mark.parametrize("kind", BODIES)
@pytest.mark.parametrize("time", [0.0, 0.3])
def test_it_is_the_sum_over_the_elements(kind, time):
    assembly = BODIES[kind]().assembly
    rng = np.random.default_rng(0)
    q, rates = 1e-2 * rng.standard_normal((2, assembly.n))
    expected = assembly.internal_force(q) + time * assembly.strain_rate_force(q, rates)
    found = strain_operator(assembly).force(q, rates, time)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
