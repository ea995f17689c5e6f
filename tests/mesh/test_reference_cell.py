"""Shape functions on the reference cells: exact for the polynomials they span."""

import numpy as np
import pytest

from supple.mesh import CellType
from supple.mesh.reference_cell import reference_nodes, shape_gradients

SOLIDS = [kind for kind in CellType if kind.dimension == 3]


@pytest.mark.parametrize("kind", SOLIDS)
def test_gradients_reproduce_those_of_a_polynomial(kind):
    """sum_a grad N_a p(xi_a) = grad p for every linear p, and for every quadratic p on quadratic cells."""
    rng = np.random.default_rng(1)
    points = rng.uniform(-1, 1, (7, 3))
    linear = rng.standard_normal(3)
    quadratic = rng.standard_normal((3, 3)) * (kind.n_nodes > kind.n_corners)
    quadratic += quadratic.T
    x = reference_nodes(kind)
    values = 3.0 + x @ linear + 0.5 * np.einsum("ai,ij,aj->a", x, quadratic, x)
    gradient = np.einsum("pai,a->pi", shape_gradients(kind, points), values)
    np.testing.assert_allclose(gradient, linear + points @ quadratic, atol=1e-13)


@pytest.mark.parametrize("kind", SOLIDS)
def test_middle_nodes_halve_the_edges(kind):
    x = reference_nodes(kind)
    middles = x[kind.n_corners :]
    if len(middles):
        np.testing.assert_array_equal(middles, [(x[a] + x[b]) / 2 for a, b in kind.edges])
    lengths = [np.linalg.norm(x[a] - x[b]) for a, b in kind.edges]
    assert max(lengths) <= 2.0  # no diagonal of the cube, sqrt(8), among its edges
