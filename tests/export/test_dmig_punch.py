"""DMIG punch files are read back as they were written, to ten digits."""

import numpy as np
import pytest

from supple.errors import ModelError
from supple.export.dmig_punch import write_dmig_punch
from supple.fem import Isotropic, solid_model
from supple.importers.matrices.dmig import read_dmig
from supple.importers.matrices.labelled_matrix import MatrixRole
from supple.mesh import CellType, block


@pytest.fixture(scope="module")
def model():
    return solid_model(block(2, 1, 1, 2, 1, 1, CellType.TETRA4), Isotropic(100.0, 0.3, 1.0))


def test_stiffness_and_mass_are_read_back(model, tmp_path):
    ids = np.arange(1, model.mesh.n_nodes + 1) * 7
    path = write_dmig_punch(tmp_path / "b.pch", ids, 3, KAAX=model.stiffness, MAAX=model.mass)
    for role, expected in ((MatrixRole.STIFFNESS, model.stiffness), (MatrixRole.MASS, model.mass)):
        read = read_dmig(path, role)
        assert read.matrix.toarray() == pytest.approx(expected.toarray(), abs=1e-9 * abs(expected).max())


def test_numbers_fill_their_columns_at_most(tmp_path):
    K = np.array(
        [[1.0, -1.23456789e-100, 0], [-1.23456789e-100, 1.23456789e-100, 0], [0, 0, -1.23456789e100]]
    )
    path = write_dmig_punch(tmp_path / "small.pch", [7], 3, KAAX=K)
    assert max(map(len, path.read_text().splitlines())) == 56
    np.testing.assert_allclose(read_dmig(path, MatrixRole.STIFFNESS).matrix.toarray(), K, rtol=1e-8)


def test_matrices_that_no_dmig_holds_are_refused(model, tmp_path):
    ids = np.arange(model.mesh.n_nodes)
    skew = np.triu(np.ones((model.n_dofs,) * 2))
    with pytest.raises(ModelError, match="symmetric"):
        write_dmig_punch(tmp_path / "b.pch", ids, 3, KAAX=skew)
    with pytest.raises(ModelError, match="shape"):
        write_dmig_punch(tmp_path / "b.pch", ids[:-1], 3, KAAX=model.stiffness)
    with pytest.raises(ModelError, match="needs a matrix"):
        write_dmig_punch(tmp_path / "b.pch", ids, 3)
