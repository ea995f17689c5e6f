"""Split bodies whose springs, masses, dashpots and ties belong to the parts that have their nodes."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import deck_model, flexible_body
from supple.errors import MeshError, ModelError
from supple.fem import FiniteElementModel, parts_of_model
from supple.importers import read_deck
from supple.machine import split_body
from supple.machine.split_body import frequency_changes
from supple.mesh import ByCellSets, divided

# Ten beams along x in two superelements of five; the cut, grid 6, is a single node.
BEAM = "\n".join(
    [
        *(f"GRID,{i + 1},,{i / 10},0.,0.,,,{1 if i < 5 else 2}" for i in range(11)),
        *(f"CBAR,{i + 1},7,{i + 1},{i + 2},0.,0.,1." for i in range(10)),
        "PBAR,7,5,4.-4,1.3-8,1.3-8,2.-8",
        "MAT1,5,2.1+11,,.3,7850.",
        "",
    ]
)
SETS = ByCellSets(("super_1", "super_2"))


@pytest.fixture
def model(tmp_path):
    """The model of the beam with further cards."""

    def made(cards: str) -> FiniteElementModel:
        path = tmp_path / "beam.bdf"
        path.write_text(BEAM + cards)
        return deck_model(read_deck(path))

    return made


EVERYTHING = """\
GRID,21,,.5,.2,.1
GRID,22,,.1,.2,.1
GRID,23,,1.,0.,0.
CONM2,31,6,,.4
CONM2,32,11,,.3,.01,.02,.03
CONM2,33,21,,.2
CELAS2,34,1.+5,11,3,23,3
CELAS2,39,1.+4,11,2,23,2
CELAS2,40,1.+4,11,1,23,1
CONM2,35,23,,.01
CDAMP2,36,9.,11,3,23,3
RBE2,37,8,123456,21
RBE3,38,,22,123456,1.,123,1,2
,3
CONM2,41,22,,.05
MPC,9,4,6,1.,3,6,-1.
"""


def total(parts, mesh, name):
    n = len(mesh.whole.nodes) * 6
    found = np.zeros((n, n))
    for part, own in zip(mesh.parts, parts, strict=True):
        dofs = (6 * part.nodes[:, None] + np.arange(6)).ravel()
        matrix = getattr(own.attached if name == "damping" else own, name)
        if matrix is not None:
            found[np.ix_(dofs, dofs)] += matrix.toarray()
    return found


@pytest.mark.filterwarnings("ignore::supple.errors.SuppleWarning")
def test_what_stands_beside_the_elements_is_in_one_part_each(model):
    whole = model(EVERYTHING.replace(",22,123456,1.,123", ",22,123,1.,123"))
    mesh = divided(whole.mesh, SETS)
    parts = parts_of_model(whole, mesh)
    for name in ("stiffness", "mass", "damping"):
        given = getattr(whole.attached if name == "damping" else whole, name).toarray()
        np.testing.assert_allclose(total(parts, mesh, name), given, atol=1e-14 * abs(given).max())
    first, second = (own.attached for own in parts)
    assert [len(own.springs) > 0 for own in (first, second)] == [False, True]
    assert [piece.name for piece in second.rigid] == ["rbe2_37"]
    assert first.rigid == ()
    ids = [part.mesh.node_ids for part in mesh.parts]
    np.testing.assert_array_equal(ids[0], [1, 2, 3, 4, 5, 6, 22])
    np.testing.assert_array_equal(ids[1], [6, 7, 8, 9, 10, 11, 21, 23])
    assert second.constraints is None
    assert first.constraints is not None
    assert [label.rpartition(": ")[2] for label in first.constraints.labels] == ["the constraint"] + 3 * [
        "rbe3_38"
    ]
    # The constraint of the first part in the numbers of the part: grids 3 and 4.
    row = first.constraints.matrix[[0]].toarray().ravel()
    np.testing.assert_array_equal(np.flatnonzero(row), [6 * 2 + 5, 6 * 3 + 5])
    assert first.constraints.dependent[0] == 6 * 3 + 5
    (piece,) = second.rigid
    np.testing.assert_array_equal(ids[1][piece.nodes], [8, 21])


def test_a_beam_with_masses_split_at_one_node_is_the_beam(model):
    """A section of one node keeps its shape by itself: the joint is exact."""
    whole = model(
        "CONM2,31,6,,.4\nCONM2,32,11,,.3,,.02\nRBE2,37,9,123456,21\nGRID,21,,.8,.2,.1\nCONM2,33,21,,.2\n"
    )
    body = flexible_body("beam", whole)
    assert abs(frequency_changes(body, split_body("beam", whole, SETS))).max() < 1e-9
    light = flexible_body("beam", model(""))
    count = light.lowest_modes(1, (light.mass @ light.rigid_modes).T).values
    assert body.lowest_modes(1, (body.mass @ body.rigid_modes).T).values < 0.7 * count


@pytest.mark.parametrize(
    ("cards", "message"),
    [
        ("CELAS2,34,1.+5,3,1,9,1\n", r"a spring \(one of 1\) acts between nodes of several parts: 3, 9"),
        ("CMASS2,34,1.,3,1,9,1\n", r"a concentrated mass \(one of 1\) acts between .* 3, 9"),
        ("CDAMP2,34,1.,3,1,9,1\n", r"a dashpot \(one of 1\) acts between nodes of several parts: 3, 9"),
        ("RBE2,34,3,123456,9\n", r"rigid tie rbe2_34 \(one of 1\) acts between nodes of several parts"),
        ("MPC,9,4,1,1.,9,1,-1.\n", "the constraint .* acts between nodes of several parts: 4, 9"),
    ],
)
def test_what_joins_parts_is_refused_by_name(model, cards, message):
    with pytest.raises(ModelError, match=message):
        split_body("beam", model(cards), SETS)


def test_a_node_without_cells_between_parts_is_refused(model):
    text = "GRID,21,,.5,.2,.1\nRBE2,34,21,123456,4,9\nCONM2,35,21,,1.\n"
    with pytest.raises((MeshError, ModelError), match="several parts"):
        split_body("beam", model(text), SETS)
