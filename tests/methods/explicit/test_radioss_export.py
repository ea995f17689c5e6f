"""Radioss' flexible-body file: what is written is read, and its matrices are those of the frame."""

import numpy as np
import pytest
from fixtures.spinning_box import modal_box

from supple.errors import ImportFormatError
from supple.importers.radioss import FlexibleBodyFile, read_flexible_body_file, write_flexible_body_file
from supple.methods.explicit.radioss_export import flexible_body_file


def test_a_sub_domain_is_read_back_to_nine_digits(tmp_path):
    wrote = flexible_body_file(modal_box())
    read = read_flexible_body_file(write_flexible_body_file(tmp_path / "box.fxb", wrote))
    assert read.damping is None
    for name in FlexibleBodyFile.__dataclass_fields__:
        if name != "damping":
            expected = np.asarray(getattr(wrote, name))
            assert np.asarray(getattr(read, name)) == pytest.approx(
                expected, rel=1e-9, abs=1e-9 * np.abs(expected).max()
            )


def test_its_coupling_mass_is_that_of_the_frame_at_rest():
    """M_C = sum_il P_il M_C^il vanishes on rigid motion, for the modes are M-orthogonal to it."""
    box = modal_box()
    file = flexible_body_file(box)
    coupling = np.tensordot(file.frame.ravel(), file.coupling_mass, axes=1)
    whole = np.einsum(
        "mni,nj,kji->mk",
        file.frame_modes[:, :, :3],
        box.body.nodal_mass[::3][:, ::3].toarray(),
        file.modes[:, :, :3],
    )
    assert coupling.T == pytest.approx(whole, abs=1e-10)
    rigid = np.zeros(12)
    rigid[0::3] = 1
    assert coupling @ rigid == pytest.approx(np.zeros(12), abs=1e-9)


def test_static_modes_have_full_rows(tmp_path):
    rng = np.random.default_rng(0)
    K = np.diag([0.0, 0, 3, 4])
    block = rng.standard_normal((2, 4))
    K[:2] = block
    K[:2, :2] = 0.5 * (block[:, :2] + block[:, :2].T)
    K[:, :2] = K[:2, :].T
    wrote = FlexibleBodyFile(
        np.arange(1, 13),
        np.eye(3),
        7.0,
        rng.standard_normal((4, 12, 6)),
        np.ones(4),
        K,
        2,
        damping=(0.1, 2.0),
    )
    read = read_flexible_body_file(write_flexible_body_file(tmp_path / "blocked.fxb", wrote))
    assert read.stiffness == pytest.approx(K, rel=1e-9)
    assert read.damping == (0.1, 2.0)
    assert read.frame_modes is None


def test_numbers_at_the_limits_of_their_columns(tmp_path):
    """Ids of eight digits; negative numbers whose exponent has three digits have one decimal less."""
    modes = np.zeros((2, 1, 6))
    modes[0, 0] = [-1.23456789e-100, 1.23456789e-100, -1.23456789e100, 1.0, -2.0, 0.0]
    wrote = FlexibleBodyFile(np.array([99_999_999]), np.eye(3), 7.0, modes, np.ones(2), np.diag([3.0, 4.0]))
    path = write_flexible_body_file(tmp_path / "small.fxb", wrote)
    assert max(map(len, path.read_text().splitlines())) == 80
    read = read_flexible_body_file(path)
    assert read.node_ids.tolist() == [99_999_999]
    np.testing.assert_allclose(read.modes, modes, rtol=1e-8)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"node_ids": np.array([100_000_000])}, "node ids from 0 to 99999999; got 100000000"),
        (
            {"stiffness": np.array([[3.0, 0.1], [0.1, 4.0]])},
            "diagonal except for rows and columns of its static",
        ),
        ({"stiffness": np.array([[3.0, 0.1], [0.2, 4.0]]), "n_static": 1}, "needs a symmetric stiffness"),
    ],
)
def test_contents_that_no_file_holds_are_refused(changed, message):
    given = {"node_ids": np.array([1]), "frame": np.eye(3), "highest_frequency": 7.0, "mass": np.ones(2)}
    given |= {"modes": np.zeros((2, 1, 6)), "stiffness": np.diag([3.0, 4.0])}
    FlexibleBodyFile(**given)
    with pytest.raises(ImportFormatError, match=message):
        FlexibleBodyFile(**given | changed)


def test_a_file_that_is_cut_or_spoiled_is_named(tmp_path):
    with pytest.raises(ImportFormatError, match=r"gone\.fxb: no such file"):
        read_flexible_body_file(tmp_path / "gone.fxb")
    path = write_flexible_body_file(tmp_path / "box.fxb", flexible_body_file(modal_box()))
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:-3]))
    with pytest.raises(ImportFormatError, match="ends too early"):
        read_flexible_body_file(path)
    lines[30] = "x" * 16 + lines[30][16:]
    path.write_text("\n".join(lines))
    with pytest.raises(ImportFormatError, match="line 31"):
        read_flexible_body_file(path)
