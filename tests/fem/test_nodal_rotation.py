"""Rotation operator: exact for rigid and for affine motion."""

import numpy as np
import pytest

from supple.fem import HomogeneousSection, nodal_rotation_operator, shell_model, solid_model
from supple.mesh import CellType, block, box_beam


def test_shell_rotations_are_the_rotational_freedoms(material, rigid_modes, rng):
    model = shell_model(box_beam(1.0, 0.6, 0.4, 2, 1, 1), HomogeneousSection(material, 0.02))
    operator = nodal_rotation_operator(model)
    omega = rng.normal(size=6)
    rotation = (operator @ rigid_modes(model) @ omega).reshape(-1, 3)
    np.testing.assert_allclose(rotation, np.tile(omega[3:], (model.mesh.n_nodes, 1)), rtol=1e-13)


@pytest.mark.parametrize(
    "cell_type",
    [CellType.TETRA4, CellType.TETRA10, CellType.HEXA8, CellType.HEXA20],
    ids=lambda kind: kind.name,
)
def test_solid_rotations_are_half_the_curl(cell_type, material, distorted, rng):
    """u = H x turns every cell by the axial vector of the skew part of H."""
    model = solid_model(distorted(block(1.0, 0.9, 0.8, 2, 1, 1, cell_type), 0.05), material)
    H = rng.normal(size=(3, 3))
    rotation = (nodal_rotation_operator(model) @ (model.mesh.nodes @ H.T).ravel()).reshape(-1, 3)
    axial = 0.5 * np.array([H[2, 1] - H[1, 2], H[0, 2] - H[2, 0], H[1, 0] - H[0, 1]])
    np.testing.assert_allclose(rotation, np.tile(axial, (model.mesh.n_cells, 1)), rtol=1e-11)
