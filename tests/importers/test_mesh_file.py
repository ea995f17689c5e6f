"""The reader of a mesh file follows from its suffix."""

import pytest

from supple.errors import ImportFormatError
from supple.importers import read_abaqus, read_mesh

TRIANGLE = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n*ELEMENT, TYPE=S3, ELSET=all\n1, 1, 2, 3\n"


def test_abaqus_by_suffix_of_any_case(tmp_path):
    path = tmp_path / "one.INP"
    path.write_text(TRIANGLE)
    assert repr(read_mesh(path)) == repr(read_abaqus(path))


def test_gmsh_by_suffix(tmp_path):
    (tmp_path / "one.msh").write_text(TRIANGLE)
    with pytest.raises(ImportFormatError, match="is this a Gmsh mesh"):
        read_mesh(tmp_path / "one.msh")


def test_unknown_suffix():
    with pytest.raises(ImportFormatError, match=r"wing\.stl: no reader for this suffix; .* \.inp, \.msh"):
        read_mesh("wing.stl")
