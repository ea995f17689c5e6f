"""What CalculiX and Abaqus accept beyond the letter of their manuals, and generation of nodes."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ImportFormatError
from supple.importers.abaqus.mesh_view import read_abaqus
from supple.mesh import CellType

TETRAHEDRON = """*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 0, 1, 0
4, 0, 0, 1
"""
STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n6000\n"


def test_numbers_behind_the_last_node_are_a_note(deck, tmp_path):
    """CalculiX does not read them; a mesh alone, without notes, refuses them."""
    text = TETRAHEDRON + "*ELEMENT, TYPE=C3D4, ELSET=E\n7, 1, 2, 3, 4, 9, 8,\n"
    read = deck(text + STEEL + "*SOLID SECTION, ELSET=E, MATERIAL=STEEL\n")
    np.testing.assert_array_equal(read.elements[0].nodes, [[0, 1, 2, 3]])
    assert "2 more numbers" in read.notes[0]
    (tmp_path / "mesh.inp").write_text(text)
    with pytest.raises(ImportFormatError, match="2 more numbers"):
        read_abaqus(tmp_path / "mesh.inp")


def test_two_elements_on_a_line_are_refused(deck):
    with pytest.raises(ImportFormatError, match="on lines of its own"):
        deck(TETRAHEDRON + "*ELEMENT, TYPE=C3D4\n7, 1, 2, 3, 4, 8, 1, 2, 3, 4\n")
