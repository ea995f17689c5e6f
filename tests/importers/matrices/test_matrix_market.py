"""Matrix Market: matrices come back as written; what is no stiffness or mass is rejected."""

import numpy as np
import pytest
from scipy.io import mmwrite
from scipy.sparse import coo_array, csc_array, random_array

from supple.errors import ImportFormatError
from supple.importers import read_matrix


@pytest.fixture
def spd():
    half = random_array((8, 8), density=0.3, rng=np.random.default_rng(5))
    return csc_array(half + half.T)


@pytest.mark.parametrize("symmetry", ["symmetric", "general"])
def test_sparse_matrix_comes_back(spd, symmetry, tmp_path):
    mmwrite(tmp_path / "k.mtx", coo_array(spd), symmetry=symmetry, precision=17)
    read = read_matrix(tmp_path / "k.mtx")
    assert isinstance(read, csc_array)
    np.testing.assert_array_equal(read.toarray(), spd.toarray())


def test_dense_and_integer_matrices_become_sparse_float(tmp_path):
    mmwrite(tmp_path / "m.mtx", np.array([[2, 0], [0, 3]]))
    read = read_matrix(tmp_path / "m.mtx")
    assert read.dtype == np.float64
    np.testing.assert_array_equal(read.toarray(), [[2.0, 0.0], [0.0, 3.0]])


def test_missing_file(tmp_path):
    with pytest.raises(ImportFormatError, match=r"k\.mtx: no such file"):
        read_matrix(tmp_path / "k.mtx")


HEADER = "%%MatrixMarket matrix coordinate real general\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("not a matrix\n", "not readable as Matrix Market"),
        (HEADER + "2 2 2\n1 1 1.0\n", "not readable as Matrix Market"),
        (HEADER + "2 2 1\n3 1 1.0\n", "not readable as Matrix Market"),
        (HEADER + "2 2 1\n1 1 nan\n", "infinite or not a number"),
        (HEADER + "2 2 3\n1 1 1.0\n2 2 1.0\n1 1 1.0\n", "an entry is given twice; write the matrix again"),
        (HEADER.replace("real", "complex") + "1 1 1\n1 1 1.0 2.0\n", "complex entries"),
    ],
)
def test_unusable_files(text, message, tmp_path):
    path = tmp_path / "k.mtx"
    path.write_text(text)
    with pytest.raises(ImportFormatError, match=rf"k\.mtx: .*{message}"):
        read_matrix(path)
