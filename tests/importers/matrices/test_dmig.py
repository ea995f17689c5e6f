"""DMIG cards, against another program that writes them, and with every rule broken."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ImportFormatError
from supple.importers.matrices.dmig import read_dmig
from supple.importers.matrices.labelled_matrix import MatrixRole

GOOD = """\
DMIG,KAAX,0,6,2,0
DMIG,KAAX,1,1,,1,1,2.5
,2,3,-1.0
DMIG,KAAX,2,3,,2,3,4.0
DMIG,MAAX,0,6,1,0
DMIG,MAAX,1,1,,1,1,1.0
"""


@pytest.fixture
def read(tmp_path):
    def read_text(text, role=MatrixRole.STIFFNESS, **options):
        path = tmp_path / "arm.pch"
        path.write_text(text)
        return read_dmig(path, role, **options)

    return read_text


def test_the_stiffness_and_the_mass_of_a_file(read):
    K = read(GOOD)
    np.testing.assert_array_equal(K.freedoms, [[1, 1], [2, 3]])
    np.testing.assert_array_equal(K.matrix.toarray(), [[2.5, -1], [-1, 4]])
    assert read(GOOD, MatrixRole.MASS).matrix.toarray() == [[1.0]]
    assert read(GOOD, MatrixRole.MASS).resolution == 0.05  # printed as 1.0
    assert (
        read(GOOD.replace("1,1,1.0", "1,1,1.00000000000D0"), MatrixRole.MASS).resolution == np.finfo("f").eps
    )
    assert read(GOOD, name="maax").matrix.toarray() == [[1.0]]


@pytest.mark.slow
def test_a_file_of_another_program(tmp_path):
    """pyyeti writes symmetric and general matrices; both come back, bit for bit."""
    bulk = pytest.importorskip("pyyeti.nastran.bulk")
    import pandas as pd

    root = np.random.default_rng(0).normal(size=(9, 9))
    index = pd.MultiIndex.from_product([[30, 10, 20], [1, 2, 3]], names=["id", "dof"])
    for name, matrix in (("KAAX", root + root.T), ("MAAX", root @ root.T)):
        path = tmp_path / f"{name}.pch"
        bulk.wtdmig(str(path), {name: pd.DataFrame(matrix, index=index, columns=index)})
        role = MatrixRole.STIFFNESS if name[0] == "K" else MatrixRole.MASS
        made = read_dmig(path, role)
        theirs = bulk.rddmig(str(path))[name.lower()]
        order = [(int(node), int(component)) for node, component in made.freedoms]
        np.testing.assert_allclose(made.matrix.toarray(), theirs.loc[order, order].to_numpy(), rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("GRID,1\n", r"arm\.pch: 0 DMIG whose name begins with K, for the stiffness.*the file has none"),
        (
            GOOD + GOOD.replace("KAAX", "K2GG"),
            "2 DMIG whose name begins with K.*the file has KAAX, MAAX, K2GG",
        ),
        (GOOD.replace("DMIG,KAAX,0,6,2,0\n", ""), "line 1: DMIG: 0 header cards for KAAX; a DMIG has one"),
        (GOOD.replace("0,6,2,0", "0,2,2,0"), "line 1: DMIG: KAAX has form 2; stiffness and mass are square"),
        (
            GOOD.replace("0,6,2,0", "0,6,4,0"),
            "line 1: DMIG: KAAX has type 4, which is complex; export it as real",
        ),
        ("DMIG,KAAX,0,6,2,0\n", "DMIG KAAX has no entries; is the file cut short"),
        (GOOD.replace("-1.0", "-1.0.0"), r"line 2: DMIG: an entry \(field 4\) is '-1\.0\.0', not a number"),
        (
            GOOD.replace("0,6,2,0", "0,1,2,0"),
            r"line 1: DMIG: KAAX has form 1 \(square\), but entries on one side of its diagonal only",
        ),
        (GOOD.replace(",2,3,-1.0", ",,3,-1.0"), r"line 2: DMIG: the grid of a row \(field 2\) is blank"),
        (GOOD.replace(",2,3,-1.0", ",2,3"), r"line 2: DMIG: an entry \(field 4\) is blank"),
        (
            GOOD.replace(",2,3,-1.0", ",1,1,-1.0"),
            "DMIG KAAX: the entry of node 1 ux with node 1 ux is given twice",
        ),
        (GOOD + "DMIG,KAAX,2,3,,1,1,7.0\n", "DMIG KAAX: not symmetric: the two entries of node"),
        (GOOD.replace("DMIG,KAAX,2,3,,2,3", "DMIG,KAAX,9,7,,9,7"), "component 7 of node 9; only 1 to 6"),
    ],
)
def test_what_breaks_the_rules(read, text, message):
    with pytest.raises(ImportFormatError, match=message):
        read(text)


def test_a_matrix_that_is_not_there(read):
    with pytest.raises(ImportFormatError, match=r"arm\.pch: no DMIG 'KGG'; the file has KAAX, MAAX"):
        read(GOOD, name="KGG")
