"""DMIG and OUTPUT4 files are read back, by this library and by pyYeti."""

import numpy as np
import pytest

from supple.body import NodalFixedFrame
from supple.body.labelled_superelement import MatrixFiles, read_labelled_superelement
from supple.errors import ModelError
from supple.export import write_dmig_superelement, write_output4, write_output4_superelement
from supple.reduction import CompleteBasis, NoDerivatives, NoLoads, reduce


def clamped_frequencies(files):
    body = read_labelled_superelement("again", files)
    seen = reduce(
        body, NodalFixedFrame("grid_1"), CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads
    )
    return seen.frequencies[:6] / (2 * np.pi)


@pytest.mark.slow
def test_matrices_of_output4_are_read_back_bit_by_bit_by_pyyeti(form, tmp_path):
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    matrices, _ = write_output4_superelement(tmp_path / "body.op4", form)
    read = op4.read(str(matrices))
    for name, expected in (("kaa", form.stiffness), ("maa", form.mass), ("baa", form.damping)):
        np.testing.assert_array_equal(read[name], expected)


def test_a_superelement_of_output4_has_the_frequencies_it_states(form, tmp_path):
    pytest.importorskip("pyyeti")
    matrices, cards = write_output4_superelement(tmp_path / "body.op4", form)
    found = clamped_frequencies(MatrixFiles(nodes=cards, stiffness=matrices, mass=matrices))
    np.testing.assert_allclose(found, form.frequencies(["root"])[:6], rtol=1e-9)
    assert f"{form.frequencies(['root'])[0]:.6g}" in cards.read_text()


def test_a_superelement_of_dmig_has_the_frequencies_it_states(form, tmp_path):
    """To the ten digits of its entries."""
    punch = write_dmig_superelement(tmp_path / "body.pch", form)
    found = clamped_frequencies(MatrixFiles(nodes=punch, stiffness=punch, mass=punch))
    np.testing.assert_allclose(found, form.frequencies(["root"])[:6], rtol=1e-5)


def test_dmig_cards_are_read_by_pyyeti(form, tmp_path):
    bulk = pytest.importorskip("pyyeti.nastran.bulk")
    punch = write_dmig_superelement(tmp_path / "body.pch", form)
    read = bulk.rddmig(str(punch))
    for name, expected in (("kaax", form.stiffness), ("maax", form.mass)):
        frame = read[name]
        assert frame.shape == expected.shape
        np.testing.assert_allclose(frame.to_numpy(), expected, atol=1e-9 * abs(expected).max())
    grids = bulk.rdgrids(str(punch))
    np.testing.assert_allclose(grids[:, 2:5], form.positions, atol=1e-9)


def test_matrices_that_no_output4_holds_are_refused(tmp_path):
    path = tmp_path / "x.op4"
    for matrices, message in (
        ({}, "needs a matrix"),
        ({"ninechars": np.eye(2)}, "at most eight"),
        ({"K": np.ones((2, 3))}, "square"),
        ({"K": np.full((1, 1), np.nan)}, "not finite"),
    ):
        with pytest.raises(ModelError, match=message):
            write_output4(path, matrices)
    assert not path.exists()


def test_an_unsymmetric_matrix_with_empty_columns_is_read_back(tmp_path):
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    matrix = np.zeros((7, 7))
    matrix[2:6, 1], matrix[0, 4] = [1.0, 0.0, -2.5e-300, 1 / 3], np.pi
    read = op4.read(str(write_output4(tmp_path / "a.op4", {"A": matrix})))
    np.testing.assert_array_equal(read["a"], matrix)
