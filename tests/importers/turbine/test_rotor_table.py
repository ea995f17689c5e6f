"""Rotor tables of one's own, the shipped rotor, and the error messages."""

import numpy as np
import pytest

from supple.errors import ImportFormatError, ModelError
from supple.importers import nrel5mw_rotor, read_polar, read_rotor

HEAD = "radius_m,chord_m,twist_deg,polar"


@pytest.fixture
def read(tmp_path):
    (tmp_path / "flat.csv").write_text("alpha_deg,cl,cd\n-180,0,1\n0,0,0.01\n180,0,1\n")

    def of(text):
        (tmp_path / "rotor.txt").write_text(text)
        return read_rotor(tmp_path / "rotor.txt", polars=str(tmp_path), n_blades=2)

    return of


def test_a_table_of_ones_own(read):
    rotor = read(f"{HEAD}\n1,0.3,18,flat\n5,0.1,0,flat\n")
    np.testing.assert_allclose(rotor.twist, [np.pi / 10, 0])
    np.testing.assert_allclose(rotor.polars[0].angle, [-np.pi, 0, np.pi])
    assert rotor.polars[0] is rotor.polars[1]
    assert (rotor.n_blades, rotor.tip_radius) == (2, 5.0)


def test_the_shipped_rotor():
    """[Jonkman2009]: three blades, 126 m, and polars over the whole circle."""
    rotor = nrel5mw_rotor()
    assert (rotor.n_blades, rotor.tip_radius, rotor.radius.size) == (3, 63.0, 19)
    for polar in rotor.polars:
        np.testing.assert_allclose(polar.angle[[0, -1]], [-np.pi, np.pi])
    assert {polar.name for polar in rotor.polars} >= {"Cylinder1", "DU40_A17", "NACA64_A17"}


def test_file_errors(read, tmp_path):
    with pytest.raises(ImportFormatError, match=r"line 3: unknown polar 'bent'; .* has flat"):
        read(f"{HEAD}\n1,0.3,18,flat\n5,0.1,0,bent\n")
    with pytest.raises(ImportFormatError, match=r"line 2: unknown polar 'flat'; there is no folder .*gone"):
        read_rotor(tmp_path / "rotor.txt", polars=tmp_path / "gone", n_blades=2)
    with pytest.raises(ImportFormatError, match="no such file"):
        read_polar(tmp_path / "none.csv", name="none")


def test_tables_that_describe_no_rotor(read):
    with pytest.raises(ModelError, match="radius 1 of station 1 is out of order"):
        read(f"{HEAD}\n5,0.3,18,flat\n1,0.1,0,flat\n")
