"""Damaged files of reduced bodies and of bases: an error with the path and the place, never a traceback."""

from __future__ import annotations

import io

import h5py
import numpy as np
import pytest

from supple.error import CorrectionFolder
from supple.errors import ResultFileError
from supple.storage import holds_reduced_body, read_interface_names, read_reduced_body, write_reduced_body
from supple.storage.file_seal import sealed

ARRAYS = [
    "gram",
    "stiffness",
    "damping",
    "frequencies",
    "nodes",
    "nodal_basis",
    "interfaces/0/position",
    "interfaces/0/motion",
]


@pytest.fixture(scope="module")
def written(linear, tmp_path_factory):
    """Writes the file of a linear body."""
    image = write_reduced_body(tmp_path_factory.mktemp("body") / "body.h5", linear).read_bytes()

    def to(path):
        path.write_bytes(image)
        return path

    return to


def forged(path, name, array):
    """The file with another array, without a seal."""
    with h5py.File(path, "r+") as file:
        del file[name]
        file[name] = array


def seal_again(path):
    with h5py.File(path, "r"):
        content = path.read_bytes()
    path.write_bytes(sealed(content))


@pytest.mark.parametrize(
    ("name", "value", "again"),
    [
        pytest.param(
            name,
            value,
            again,
            # Of each array one kind of damage, of one array all of them.
            marks=() if name == "nodes" or (np.isnan(value) and not again) else pytest.mark.slow,
        )
        for name in ARRAYS
        for value in (np.nan, np.inf, 1j)
        for again in (False, True)
    ],
)
@pytest.mark.usefixtures("hdf5_copied_here")
def test_numbers_that_no_body_has_are_refused_with_and_without_a_seal(tmp_path, written, name, value, again):
    path = written(tmp_path / "body.h5")
    with h5py.File(path, "r") as file:
        array = file[name][()].astype(complex if value == 1j else float)
    array[(-1,) * array.ndim] = value
    forged(path, name, array)
    if again:
        seal_again(path)
    what = name.rpartition("/")[2]
    expected = "complex128 instead of real numbers" if value == 1j else "NaN or infinity"
    with pytest.raises(ResultFileError, match=rf"body\.h5 is damaged \(.*{what} .*{expected}"):
        read_reduced_body(path)


@pytest.mark.parametrize("name", ["gram", "nodes", "report/linear"])
def test_shapes_that_a_file_cannot_hold_are_refused_before_memory_is_taken(tmp_path, written, name):
    path = written(tmp_path / "body.h5")
    with h5py.File(path, "r+") as file:
        kind = file[name].dtype
        del file[name]
        file.create_dataset(name, shape=(2_000_000_000, 3), dtype=kind, chunks=(1, 3))
    seal_again(path)
    with pytest.raises(
        ResultFileError, match=r"is damaged \(.* has \d+ bytes, more than the \d+ bytes of the file"
    ):
        read_reduced_body(path)


PARTS = [*ARRAYS, "interfaces", "interfaces/0", "report", "report/linear", "report/seconds"]


@pytest.mark.parametrize("instead", ["nothing", "a group", "words", "a number"])
@pytest.mark.parametrize("part", PARTS)
def test_parts_of_another_kind_never_give_a_traceback(tmp_path, written, part, instead):
    path = written(tmp_path / "body.h5")
    with h5py.File(path, "r+") as file:
        del file[part]
        match instead:
            case "a group":
                file.create_group(part)
            case "words":
                file[part] = "words"
            case "a number":
                file[part] = 1.0
    seal_again(path)
    for read in (read_reduced_body, read_interface_names):
        try:
            read(path)
        except ResultFileError as error:
            assert f"{path} is damaged (" in str(error)  # noqa: PT017
    assert holds_reduced_body(path)


@pytest.mark.parametrize("value", [1.5, np.arange(3.0), b"\xff", "words", h5py.Empty("f")])
@pytest.mark.parametrize("name", ["name", "frame", "frame_interface", "rotation_limit", "version"])
def test_attributes_of_another_kind_never_give_a_traceback(tmp_path, written, name, value):
    path = written(tmp_path / "body.h5")
    with h5py.File(path, "r+") as file:
        file.attrs[name] = value
    seal_again(path)
    try:
        read_reduced_body(path)
    except ResultFileError as error:
        assert str(path) in str(error)  # noqa: PT017


def npz(**arrays):
    image = io.BytesIO()
    np.savez(image, **arrays)
    return image.getvalue()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"PK not a zip file",
        npz(seconds=1.0),
        sealed(b"PK not a zip file"),
        sealed(npz(seconds=1.0)[:-30]),
        sealed(npz(seconds=np.array("soon"))),
        sealed(npz(seconds=1.0)).replace(b"seconds", b"sekonds"),
    ],
)
def test_damaged_bases_of_a_round_are_named(tmp_path, content):
    (tmp_path / "round-0.npz").write_bytes(content)
    with pytest.raises(ResultFileError, match=r"round-0\.npz is damaged"):
        CorrectionFolder.resume(tmp_path, case="a").read_bases(0, {})
