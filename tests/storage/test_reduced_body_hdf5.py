"""A reduced body comes back from its file bit by bit, and files that are none say so."""

from dataclasses import dataclass, replace

import h5py
import numpy as np
import pytest

from supple.body import Frame, MeanAxisFrame, RayleighDamping, flexible_body
from supple.errors import ModelError, ResultFileError
from supple.integrate import Run
from supple.machine import Placed, System
from supple.reduction import AttachmentModes, NoDerivatives, NoLoads, NormalModes, ReductionReport, reduce
from supple.simulation import simulate
from supple.storage import (
    holds_reduced_body,
    read_interface_names,
    read_reduced_body,
    write_reduced_body,
)


@pytest.fixture(params=["nonlinear", "linear", "loose", "damped"])
def body(request, flexible, model):
    if request.param == "loose":
        free = flexible_body("loose", model).linearized()
        return reduce(free, MeanAxisFrame(), NormalModes(2), derivatives=NoDerivatives(), loads=NoLoads)
    if request.param == "damped":
        damping = RayleighDamping(0.3, 1e-4)
        basis = AttachmentModes(NormalModes(2))
        return reduce(
            flexible, MeanAxisFrame(), basis, derivatives=NoDerivatives(), damping=damping, loads=NoLoads
        )
    return request.getfixturevalue(request.param)


def test_what_is_read_is_what_was_written(tmp_path, body, assert_same):
    path = write_reduced_body(tmp_path / "new folder" / "body.h5", body)
    again = read_reduced_body(path)
    assert again.full is None  # the elements are not in the file
    assert_same(replace(body, full=None), again)
    assert not again.gram.flags.writeable
    assert read_interface_names(path) == tuple(interface.name for interface in body.interfaces)
    assert holds_reduced_body(path)
    assert [file.name for file in path.parent.iterdir()] == ["body.h5"]


def test_a_body_from_a_file_moves_as_the_body_itself(tmp_path, nonlinear, assert_same):
    again = read_reduced_body(write_reduced_body(tmp_path / "body.h5", nonlinear))
    one, other = (
        simulate(
            System(bodies=(Placed(body, angular_velocity=(0.0, 3.0, 1.0)),), gravity=(0.0, 0.0, -9.81)),
            Run(duration=0.02, output_step=0.01),
        )
        for body in (nonlinear, again)
    )
    assert_same(one.bodies[nonlinear.name], other.bodies[nonlinear.name])


def test_fields_that_the_file_does_not_have_take_their_default(tmp_path, linear):
    path = write_reduced_body(tmp_path / "body.h5", linear)
    with h5py.File(path, "r+") as file:
        del file["report/corrections"]
        file.create_group("report/from the future")
    assert read_reduced_body(path).report.corrections == ReductionReport(()).corrections


# --- files that are none


def test_files_that_hold_no_reduced_body(tmp_path):
    with pytest.raises(ResultFileError, match="no such file; check the path"):
        read_reduced_body(tmp_path / "a.h5")
    (tmp_path / "a.h5").write_text("a,b\n1,2\n")
    with pytest.raises(ResultFileError, match="not an HDF5 file, so not a reduced body"):
        read_interface_names(tmp_path / "a.h5")
    assert not holds_reduced_body(tmp_path / "a.h5")
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file.attrs["format"] = "supple-result"
    with pytest.raises(ResultFileError, match="not a reduced body of supple"):
        read_reduced_body(tmp_path / "b.h5")
    assert not holds_reduced_body(tmp_path / "b.h5")


def test_a_newer_version_is_refused(tmp_path, linear):
    path = write_reduced_body(tmp_path / "body.h5", linear)
    with h5py.File(path, "r+") as file:
        file.attrs["version"] = 3
    with pytest.raises(
        ResultFileError, match="format version 3, and this version of supple reads up to 2: use the"
    ):
        read_reduced_body(path)


def test_one_flipped_bit_is_found(tmp_path, nonlinear):
    path = write_reduced_body(tmp_path / "body.h5", nonlinear)
    data = bytearray(path.read_bytes())
    place = data.find(nonlinear.quartic.tobytes()[:64])
    data[place + 8] ^= 1
    path.write_bytes(data)
    with pytest.raises(ResultFileError, match=r"is damaged .*: copy it again, or reduce the body again"):
        read_reduced_body(path)


@pytest.mark.parametrize("share", np.linspace(0.0, 1.0, 21))
def test_a_flipped_bit_anywhere_is_found(tmp_path, nonlinear, share):
    """Also in names, attributes, texts, and what ties the file together: HDF5 alone misses some of them."""
    path = write_reduced_body(tmp_path / "body.h5", nonlinear)
    data = bytearray(path.read_bytes())
    data[int(share * (len(data) - 1))] ^= 4
    path.write_bytes(data)
    with pytest.raises(ResultFileError, match=r"is damaged .*copy it again|not an HDF5 file.*check the path"):
        read_reduced_body(path)


def test_a_damaged_file_is_still_known_for_what_it_is(tmp_path, linear):
    path = write_reduced_body(tmp_path / "body.h5", linear)
    data = bytearray(path.read_bytes())
    data[3000] ^= 1
    path.write_bytes(data)
    assert holds_reduced_body(path)


@pytest.mark.parametrize(
    ("version", "message"), [(0, "there is no format version 0"), ("x", "invalid literal")]
)
def test_a_version_that_never_was(tmp_path, linear, version, message):
    path = write_reduced_body(tmp_path / "body.h5", linear)
    with h5py.File(path, "r+") as file:
        file.attrs["version"] = version
    with pytest.raises(ResultFileError, match=f"is damaged .*{message}"):
        read_reduced_body(path)


def test_a_half_copied_file_is_found(tmp_path, nonlinear):
    path = write_reduced_body(tmp_path / "body.h5", nonlinear)
    path.write_bytes(path.read_bytes()[:-5000])
    with pytest.raises(ResultFileError, match=r"truncated.*copy it again"):
        read_reduced_body(path)


@pytest.mark.parametrize("part", ["gram", "report", "interfaces/0/motion"])
def test_a_missing_part_is_named(tmp_path, linear, part):
    path = write_reduced_body(tmp_path / "body.h5", linear)
    with h5py.File(path, "r+") as file:
        del file[part]
    with pytest.raises(ResultFileError, match=f"is damaged .*{part.split('/')[-1]}"):
        read_reduced_body(path)


def test_parts_that_do_not_fit_are_damage(tmp_path, linear):
    path = write_reduced_body(tmp_path / "body.h5", linear)
    with h5py.File(path, "r+") as file:
        del file["damping"]
        file["damping"] = np.zeros((1, 1))
        file.attrs["frame"] = "mean-axis"
    with pytest.raises(ResultFileError, match=r"damping has shape \(1, 1\)"):
        read_reduced_body(path)
    with h5py.File(path, "r+") as file:
        file.attrs["frame"] = "rolling"
    with pytest.raises(ResultFileError, match="frame 'rolling' is unknown"):
        read_reduced_body(path)


@dataclass(frozen=True)
class OwnFrame(Frame):
    def constraint(self, body):
        raise NotImplementedError


def test_a_frame_without_a_name_cannot_be_written(tmp_path, linear):
    with pytest.raises(ModelError, match="its frame is OwnFrame; a file can contain only MeanAxisFrame"):
        write_reduced_body(tmp_path / "a.h5", replace(linear, frame=OwnFrame()))
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written(tmp_path, linear):
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultFileError, match="cannot write"):
        write_reduced_body(tmp_path / "file" / "a.h5", linear)
