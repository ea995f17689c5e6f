"""HDF5 files without a seal are copied by a process of their own, which has limits of time and memory.

endless.h5 is a small file of groups and arrays with 200 zeros inserted among its metadata: HDF5 follows them
for ever, and the process that asked would too.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from supple.cases import read_case
from supple.copied_hdf5 import open_copied
from supple.errors import CaseError, ImportFormatError, ResultFileError
from supple.importers import MatrixRole, NodeTable, read_labelled_matrix, read_nodes
from supple.storage import holds_reduced_body, read_interface_names, read_reduced_body, write_reduced_body

ENDLESS = Path(__file__).with_name("endless.h5")
NODES = NodeTable("m", np.array([1]), np.zeros((1, 3)))


@pytest.fixture
def soon(monkeypatch):
    monkeypatch.setattr("supple.copied_hdf5.SECONDS", 2.0)
    began = time.perf_counter()
    yield
    assert time.perf_counter() - began < 60.0


@pytest.mark.slow
@pytest.mark.usefixtures("soon")
def test_a_reduced_body_over_which_hdf5_never_ends():
    assert not holds_reduced_body(ENDLESS)
    for read in (read_reduced_body, read_interface_names):
        with pytest.raises(ResultFileError, match=r"endless\.h5 is damaged \(HDF5 does not finish"):
            read(ENDLESS)


@pytest.mark.slow
@pytest.mark.usefixtures("soon")
def test_matrices_over_which_hdf5_never_ends():
    # In both, the damage lies where the names of the root are.
    message = r"endless\.h5: not readable as HDF5 \(HDF5 does not finish within 2 s"
    with pytest.raises(ImportFormatError, match=message):
        read_nodes(ENDLESS)
    with pytest.raises(ImportFormatError, match=message):
        read_labelled_matrix(ENDLESS, MatrixRole.MASS, NODES)


@pytest.mark.usefixtures("soon")
@pytest.mark.slow
def test_a_case_that_names_such_a_file(tmp_path):
    (tmp_path / "case.toml").write_text(
        f'title = "t"\n[[body]]\nname = "b"\nreduced = "{ENDLESS}"\n'
        "[simulation]\nduration = 1.0\noutput_step = 0.1\nstep = 0.1\n"
    )
    with pytest.raises(CaseError, match=r"line 4, body\[1\]\.reduced: .*HDF5 does not finish"):
        read_case(tmp_path / "case.toml")


def test_what_takes_too_much_memory_is_refused(tmp_path):
    path = tmp_path / "k.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("nodes", shape=(10**9, 3), dtype=float, chunks=(1024, 3))
    with pytest.raises(ImportFormatError, match=r"/nodes should have 24000000000 bytes; the limit .* is \d+"):
        read_nodes(path)


def test_links_that_lead_in_a_circle_are_refused(tmp_path):
    path = tmp_path / "k.h5"
    with h5py.File(path, "w") as file:
        file["node_sets/again"] = h5py.SoftLink("/node_sets")
    with pytest.raises(OSError, match="recursion"), open_copied(path):
        pass


def test_a_process_that_ends_at_once_is_told_of(tmp_path, monkeypatch):
    with h5py.File(tmp_path / "k.h5", "w") as file:
        file["nodes"] = np.eye(3)
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "h5py.py").write_text("import os\nos.abort()\n")
    monkeypatch.setattr("sys.path", [str(broken), *sys.path])
    with (
        pytest.raises(OSError, match=r"HDF5 crashes on this file \(exit code -6\)"),
        open_copied(tmp_path / "k.h5"),
    ):
        pass


@pytest.mark.parametrize("libver", ["earliest", pytest.param("latest", marks=pytest.mark.slow)])
def test_a_body_without_a_seal_is_read_bit_by_bit(tmp_path, linear, libver):
    """As another program leaves it that writes the file anew, or as it was before there were seals."""
    path = write_reduced_body(tmp_path / "body.h5", linear)
    with h5py.File(path, "r") as file, h5py.File(tmp_path / "bare.h5", "w", libver=libver) as bare:
        bare.attrs.update(file.attrs)
        for name in file:
            file.copy(name, bare)
    sealed, again = read_reduced_body(path), read_reduced_body(tmp_path / "bare.h5")
    assert holds_reduced_body(tmp_path / "bare.h5")
    assert read_interface_names(tmp_path / "bare.h5") == read_interface_names(path)
    for name in ("gram", "stiffness", "damping", "frequencies", "nodes", "nodal_basis"):
        assert getattr(again, name).tobytes() == getattr(sealed, name).tobytes()
    assert again.report == sealed.report or str(again.report) == str(sealed.report)


def test_compressed_matrices_and_links_are_read(tmp_path):
    with h5py.File(tmp_path / "elsewhere.h5", "w") as file:
        file.create_dataset("x", data=np.arange(300.0).reshape(100, 3), compression="gzip")
    with h5py.File(tmp_path / "k.h5", "w") as file:
        file["nodes"] = h5py.ExternalLink("elsewhere.h5", "x")
        file.create_dataset("node_sets/all", data=np.arange(1, 101), compression="gzip", shuffle=True)
    nodes = read_nodes(tmp_path / "k.h5")
    np.testing.assert_array_equal(nodes.positions, np.arange(300.0).reshape(100, 3))
    assert len(nodes.node_sets["all"]) == 100


def test_nothing_is_left_behind(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    with pytest.raises(OSError, match=r"signature|HDF5"), open_copied(Path(__file__)):
        pass
    assert not list(tmp_path.iterdir())
