"""Stress that cannot be shown is a mistake of the case, known before anything is simulated."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from supple.cases import read_case
from supple.errors import CaseError
from supple.fem import has_stress_on_faces
from supple.mesh import CellType, strip

MESH = strip(1.0, 0.1, 4, 2)
N_NODES = len(MESH.nodes)

BODY = """
[[body]]
name = "NAME"
mesh = "NAME.bdf"
nastran = {}
frame = { kind = "mean-axis" }
reduction = { basis = "normal-modes", modes = 2 }
LINEAR
"""

REST = """
[simulation]
duration = 1.0
output_step = 0.1
step = 0.1

[output]
colour = "von-mises"
"""


@pytest.fixture
def write(tmp_path, bulk):
    """Writes a case of bodies of bulk data: 'plate', 'beams', 'with_points', 'stiffened', 'flapped'."""
    plate, wall = [*bulk.grids(MESH.nodes), *bulk.elements(MESH)], bulk.shell(0.01)
    along = np.flatnonzero(MESH.nodes[:, 1] == MESH.nodes[:, 1].min())[:5] + 1
    bars = [bulk.card("CBEAM", 900 + i, 9, *pair, 0.0, 0.0, 1.0) for i, pair in enumerate(pairwise(along))]
    section = ["PBEAM,9,5,1.-4,2.-9,1.-9,0.,3.-9", ",", ",.5,.8"]
    line = [bulk.card("GRID", i, None, *map(repr, map(float, MESH.nodes[i - 1]))) for i in along]
    (tmp_path / "plate.bdf").write_text(bulk.deck(*plate, *wall))
    flap = [bulk.card("GRID", 700, None, -0.2, 0.0, 0.0), bulk.card("CTRIA3", 800, 2, 1, 2, 700)]
    (tmp_path / "flapped.bdf").write_text(bulk.deck(*plate, *flap, *wall, "PSHELL,2,5,.01,5,2."))
    (tmp_path / "stiffened.bdf").write_text(bulk.deck(*plate, *bars, *wall, *section))
    (tmp_path / "beams.bdf").write_text(bulk.deck(*line, *bars, *section, bulk.steel()))
    points = [section[0], ",.01,.005,-.01,.005", section[2]]
    (tmp_path / "with_points.bdf").write_text(bulk.deck(*line, *bars, *points, bulk.steel()))

    def write(*names, linear=False):
        bodies = [
            BODY.replace("NAME", name).replace("LINEAR", "linear = true" if linear else "") for name in names
        ]
        (tmp_path / "case.toml").write_text("\n".join(['title = "t"', *bodies, REST]))
        return read_case(tmp_path / "case.toml")

    return write


def build(case):
    assert case.system.bodies
    return case


def mistake(case):
    with pytest.raises(CaseError) as caught:
        build(case)
    line = case.path.read_text().splitlines().index('colour = "von-mises"') + 1
    (row,) = (row for row in str(caught.value).splitlines() if row.startswith("  "))
    assert row.startswith(f"  line {line}, output.colour: ")
    assert row.endswith("remove the key")
    return row


def test_a_plate_has_stress(write):
    assert list(build(write("plate")).flexible) == ["plate"]


@pytest.mark.parametrize("linear", [False, True])
def test_beams_alone_that_do_not_say_where_their_stress_acts(write, linear):
    assert "body 'beams': no stress recovery for beams" in mistake(write("beams", linear=linear))


def test_beams_without_points_beside_others_are_drawn_plain(write):
    assert list(build(write("plate", "beams", "stiffened")).flexible) == ["plate", "beams", "stiffened"]


def test_a_wall_by_stiffnesses_beside_a_plate_is_drawn_plain(write):
    look = build(write("flapped")).drawn["flapped"]
    assert np.flatnonzero(~has_stress_on_faces(look)).tolist() == [N_NODES]


def test_beams_with_points_have_stress(write):
    assert list(build(write("with_points")).flexible) == ["with_points"]


SENSOR = '[[sensor]]\nname = "strut"\nkind = "beam-force"\nbody = "BODY"\nbeam = BEAM\nend = 2\n'


def test_a_beam_is_sensed_by_its_id(write):
    """The element's id in the deck; one that is not there, or a body without elements, is a mistake."""
    path = write("with_points").path
    text = path.read_text()

    def sensed(body, beam):
        path.write_text(text + SENSOR.replace("BODY", body).replace("BEAM", str(beam)))
        return read_case(path)

    (sensor,) = sensed("with_points", 901).sensors
    assert (sensor.beam, sensor.end, sensor.model.mesh.cell_ids[CellType.LINE2].tolist()) == (
        901,
        2,
        [900, 901, 902, 903],
    )
    with pytest.raises(CaseError, match=r"there is no beam 17; the body has ids 900 to 903"):
        _ = sensed("with_points", 17).sensors
    with pytest.raises(CaseError, match="body 'mast' has no elements"):
        _ = sensed("mast", 901).sensors
