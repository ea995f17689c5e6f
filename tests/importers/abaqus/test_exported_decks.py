"""What `supple export` writes is read back: the same stiffness and mass, the clamped nodes held."""

from __future__ import annotations

import numpy as np
import pytest

import supple as sp
from supple.body import deck_model
from supple.export import ABAQUS, CALCULIX, write_static_deck
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.importers.abaqus.abaqus_deck import read_abaqus_deck
from supple.mesh import CellType, block, strip

STEEL = Isotropic(2.1e11, 0.3, 7850.0)


def written(path, model, program):
    clamped = np.flatnonzero(model.mesh.nodes[:, 0] == 0)
    loads = np.zeros((model.mesh.n_nodes, 3))
    loads[-1] = 1.0
    write_static_deck(path, model, loads, clamped, program=program)
    return read_abaqus_deck(path), clamped


@pytest.mark.parametrize(
    "model",
    [
        *(
            solid_model(block(2.0, 1.0, 1.0, 2, 1, 1, kind), STEEL)
            for kind in (CellType.TETRA4, CellType.TETRA10, CellType.HEXA8, CellType.HEXA20)
        ),
        # The shells of both programs shear.
        shell_model(strip(1.0, 0.1, 4, 2), HomogeneousSection(STEEL, 0.01, shear_factor=5 / 6)),
    ],
    ids=["TETRA4", "TETRA10", "HEXA8", "HEXA20", "TRIANGLE3"],
)
def test_the_same_matrices_come_back(tmp_path, model):
    made, clamped = written(tmp_path / "deck.inp", model, ABAQUS)
    assert made.left_out == ()
    again = deck_model(made)
    for name in ("stiffness", "mass"):
        first, second = getattr(model, name), getattr(again, name)
        assert abs(first - second).max() < 1e-9 * abs(first).max()
    np.testing.assert_array_equal(np.unique(made.held[0].freedoms // 6), clamped)
    assert set(model.mesh.node_sets) <= {name.lower() for name in made.node_sets}


def test_six_node_shells_for_calculix_come_back_refined(tmp_path):
    """Each becomes four triangles over its middle nodes: the same mass, a finer mesh."""
    model = sp.shell_model(strip(1.0, 0.1, 4, 2), HomogeneousSection(STEEL, 0.01))
    made, _ = written(tmp_path / "deck.inp", model, CALCULIX)
    assert made.left_out == ()
    again = deck_model(made)
    assert sum(map(len, again.mesh.cells.values())) == 4 * sum(map(len, model.mesh.cells.values()))
    rigid = np.zeros((again.mesh.n_nodes, 6))
    rigid[:, 2] = 1
    assert rigid.ravel() @ (again.mass @ rigid.ravel()) == pytest.approx(7850 * 0.001, rel=1e-9)
