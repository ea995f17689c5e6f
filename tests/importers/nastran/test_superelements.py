"""Superelements of Nastran decks: placed, joined at common grids, and each a deck of its own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.errors import ImportFormatError
from supple.importers import read_nastran, read_nodes
from supple.mesh import CellType

MATERIAL = "MAT1,5,2.1+11,,.3,7850.\nPSHELL,7,5,0.1,5\n"
LEFT = """\
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
CTRIA3,1,7,1,2,3
CTRIA3,2,7,1,3,4
"""
# The right half, with ids of its own: grids 1 and 4 are 2 and 3 of the left one.
RIGHT = """\
GRID,1,,1.,0.,0.
GRID,2,,2.,0.,0.
GRID,3,,2.,1.,0.
GRID,4,,1.,1.,0.
CTRIA3,1,7,1,2,3
CTRIA3,2,7,1,3,4
"""


def halves(main="", *, left=LEFT, right=RIGHT):
    """Two superelements, 1 and 2, beside a residual structure."""
    return (
        f"SOL 103\nCEND\nBEGIN BULK\n{main}BEGIN SUPER=1\n{left}{MATERIAL}"
        f"BEGIN SUPER=2\n{right}{MATERIAL}ENDDATA\n"
    )


def placed(points):
    """GRID cards of three points from id 101 on, in free fields of full precision."""
    return "".join(f"GRID*,{101 + i},,{x:.12g},{y:.12g}\n*,{z:.12g}\n" for i, (x, y, z) in enumerate(points))


def same_places(read, wanted):
    """Whether the nodes that elements use are the wanted places, each once."""
    used = np.unique(np.concatenate([each.nodes.ravel() for each in read.elements]))
    found = read.nodes[used]
    return len(found) == len(wanted) and all(
        np.linalg.norm(found - place, axis=1).min() < 1e-9 for place in wanted
    )


PLATE = [(x, y, 0.0) for x in (0, 1, 2) for y in (0, 1)]


def test_parts_are_joined_where_their_grids_are_in_one_place(deck):
    read = deck(halves())
    assert same_places(read, PLATE)
    assert read.left_out == ()
    assert {name: len(own.nodes) for name, own in read.superelements.items()} == {"super_1": 4, "super_2": 4}
    np.testing.assert_array_equal(read.element_sets["super_1"], [1, 2])
    np.testing.assert_array_equal(read.element_sets["super_2"], [3, 4])  # whose own ids were taken
    assert len(np.unique(read.node_ids)) == len(read.node_ids)
    assert set(read.properties) == {"super_1.pshell_7", "super_2.pshell_7"}
    np.testing.assert_array_equal(read.superelements["super_2"].node_ids, [1, 2, 3, 4])


def test_grids_farther_apart_than_the_tolerance_are_not_joined(deck):
    right = RIGHT.replace("GRID,1,,1.", "GRID,1,,1.00002")
    assert len(deck(halves(right=right)).nodes) == 7
    assert len(deck(halves("SEBULK,2,PRIMARY,,AUTO,3.-5\n", right=right)).nodes) == 6


def test_the_boundary_search_is_limited_and_replaced_by_cards(deck):
    assert len(deck(halves("SEBULK,2,PRIMARY,,MANUAL\n")).nodes) == 8
    assert len(deck(halves("SEBNDRY,1,2,3\n")).nodes) == 7
    assert len(deck(halves("SEEXCLD,2,ALL,4\n")).nodes) == 7
    assert len(deck(halves("SEEXCLD,2,1,ALL\n")).nodes) == 8
    by_hand = "SEBULK,2,PRIMARY,,MANUAL\nSECONCT,1,2\n,2,1,3,4\n"
    assert same_places(deck(halves(by_hand)), PLATE)
    ranges = "SEBULK,2,PRIMARY,,MANUAL\nSECONCT,1,2\n,2,THRU,2,1,THRU,1\n"
    assert len(deck(halves(ranges)).nodes) == 7


def test_grids_joined_by_hand_lie_in_one_place(deck):
    read = deck(halves("SECONCT,1,2\n,2,2\n"))
    (left,) = read.left_out
    assert (left.card, left.line) == ("SECONCT", 4)
    assert left.meaning.startswith("grids 2 and 2 lie 1 apart, more than 1e-05")


def test_a_grid_with_two_partners_in_one_place_is_left_out(deck):
    right = RIGHT + "GRID,9,,1.,0.,0.\nCONM2,9,9,,1.\n"
    (left,) = deck(halves(right=right)).left_out
    assert (left.card, left.count) == ("BEGIN SUPER", 2)
    assert "grid 2 of super_1 and super_2 has several coincident partners" in left.meaning


def test_a_part_is_moved_to_grids_of_the_main_bulk_data(deck):
    Q, shift = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix(), np.array([4.0, 5.0, -6.0])
    away = np.array(PLATE[2:]) @ Q.T + shift  # of (1, 0), (1, 1), (2, 0), (2, 1)
    grids = "".join(
        f"GRID*,{number},,{x:.12g},{y:.12g}\n*,{z:.12g}\n"
        for number, (x, y, z) in zip((1, 4, 2, 3), away, strict=True)
    )
    moved = grids + "CTRIA3,1,7,1,2,3\nCTRIA3,2,7,1,3,4\n"
    main = placed([(1, 0, 0), (2, 0, 0), (2, 1, 0)])
    assert len(deck(halves(right=moved)).nodes) == 8
    read = deck(halves(main + "SELOC,2,1,2,3,101,102,103\n", right=moved))
    assert same_places(read, PLATE)
    assert read.left_out == ()


def test_a_part_whose_triangle_differs_from_that_of_its_place_is_left_out(deck):
    main = placed([(1, 0, 0), (2, 0, 0), (1, 1.5, 0)])
    (left,) = deck(halves(main + "SELOC,2,1,2,4,101,102,103\n")).left_out
    assert left.card == "SELOC"
    assert "differ by 0.5" in left.meaning


def test_a_mirror_image_and_a_copy_need_no_grids_of_their_own(deck):
    points = "POINT,11,,1.,0.,0.\nPOINT,12,,1.,1.,0.\nPOINT,13,,1.,0.,1.\n"
    mirrored = f"{points}SEBULK,2,MIRROR,1\nSEMPLN,2,PLANE,11,12,13\n"
    read = deck(halves(mirrored, right="LOAD,1\n").replace(MATERIAL + "ENDDATA", "ENDDATA"))
    assert same_places(read, PLATE)
    image = read.superelements["super_2"]
    corners = image.nodes[image.elements[0].nodes]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normals[:, 2] > 0).all()  # the mirrored normal, not its opposite
    main = placed([(1, 0, 0), (2, 0, 0), (2, 1, 0)])
    copied = f"{main}SEBULK,2,REPEAT,1\nSELOC,2,1,2,3,101,102,103\n"
    assert same_places(deck(f"BEGIN BULK\n{copied}BEGIN SUPER=1\n{LEFT}{MATERIAL}ENDDATA\n"), PLATE)


def test_what_is_elsewhere_is_left_out_by_name(deck):
    cards = [each.card for each in deck(halves("SEBULK,2,EXTOP4\n")).left_out]
    assert cards == ["SEBULK"]
    cases = halves().replace("ENDDATA", "BEGIN SUPER=1 MASSID=300\nCONM2,7,1,,5.\nENDDATA")
    read = deck(cases)
    assert [each.card for each in read.left_out] == ["BEGIN MASSID"]
    assert len(read.superelements["super_1"].nodes) == 4
    assert [each.card for each in deck(halves("RELEASE,1,35,2\n")).left_out] == ["RELEASE"]


@pytest.mark.parametrize(
    ("main", "message"),
    [
        ("SEBULK,3,PRIMARY\n", "SEBULK: names superelement 3, which the file does not define"),
        ("SEBULK,3,MIRROR,4\n", "SEBULK: repeats superelement 4, which the file does not define"),
        ("SEBULK,3,MIRROR,1\n", "SEBULK: superelement 3 is a mirror image, and no SEMPLN"),
        ("SELOC,2,1,2,3,101,102,103\n", "SELOC: names grid 101, which the main bulk data do not define"),
        ("SECONCT,1,2\n,2,77\n", "SECONCT: names grid 77 of superelement 2"),
        ("SECONCT,1,2\n,2,1,3\n", "SECONCT: lists an odd number of grids"),
        ("SECONCT,1,5\n,2,1\n", "SECONCT: names superelement 5"),
        ("SECONCT,1,2\n,1,THRU,4,1,THRU,2\n", "1 to 4 and 1 to 2 are ranges of different length"),
    ],
)
def test_mistakes_name_their_card(deck, main, message):
    with pytest.raises(ImportFormatError, match=message):
        deck(halves(main))


# --- within one bulk data section

ROW = LEFT + "GRID,5,,2.,0.,0.\nGRID,6,,2.,1.,0.\nCTRIA3,3,7,2,5,6\nCTRIA3,4,7,2,6,3\n" + MATERIAL


@pytest.mark.parametrize("interior", ["SESET,1,5,6\n", "SESET,1,5,THRU,6\n", None])
def test_interior_grids_make_a_superelement_of_what_touches_them(deck, interior):
    text = (
        ROW + interior
        if interior
        else ROW.replace("2.,0.,0.\n", "2.,0.,0.,,,1\n").replace("2.,1.,0.\n", "2.,1.,0.,,,1\n")
    )
    read = deck(text + "CONM2,9,2,,3.\nCONM2,10,5,,4.\nRBE2,11,5,123456,6\n")
    assert len(read.nodes) == 6
    np.testing.assert_array_equal(read.element_sets["super_0"], [1, 2])
    np.testing.assert_array_equal(read.element_sets["super_1"], [3, 4])
    own = read.superelements["super_1"]
    np.testing.assert_array_equal(own.node_ids, [2, 3, 5, 6])
    assert [each.values[0, 0] for each in own.masses] == [4.0]
    assert [each.name for each in own.rigid] == ["rbe2_11"]
    rest = read.superelements["super_0"]
    np.testing.assert_array_equal(rest.node_ids, [1, 2, 3, 4])
    assert [each.values[0, 0] for each in rest.masses] == [3.0]


def test_springs_to_a_scalar_point_belong_to_their_superelement(deck):
    """The point has the number behind the nodes of each part."""
    text = ROW.replace("2.,0.,0.\n", "2.,0.,0.,,,1\n").replace("2.,1.,0.\n", "2.,1.,0.,,,1\n") + "SPOINT,90\n"
    read = deck(text + "CELAS2,9,4.,5,1,90\nCMASS2,10,2.,90\nCELAS2,11,3.,1,2,90\n")
    own, rest = read.superelements["super_1"], read.superelements["super_0"]
    for part, node, component, stiffness in ((own, 5, 0, 4.0), (rest, 1, 1, 3.0)):
        (spring,) = part.springs
        assert spring.values.tolist() == [stiffness]
        place = 6 * part.node_ids.tolist().index(node) + component
        assert sorted(spring.freedoms.tolist()) == [place, 6 * len(part.node_ids)]
        assert part.scalar_points.tolist() == [90]
    assert own.inertias == ()
    assert rest.inertias[0].freedoms.tolist() == [6 * len(rest.node_ids)]


def test_boundary_elements_go_where_seelt_puts_them(deck):
    read = deck(ROW + "SESET,1,5,6\nSEELT,1,1\n")
    np.testing.assert_array_equal(read.element_sets["super_1"], [1, 3, 4])
    np.testing.assert_array_equal(read.element_sets["super_0"], [2])


def test_a_deck_without_interior_grids_has_no_superelements(deck):
    assert not deck(ROW).superelements
    assert not deck(ROW + "SESET,1,77\n").superelements


def test_the_mesh_of_superelements_has_their_cell_sets(deck):
    read = deck(halves())
    mesh = read_nastran(read.path)
    assert set(mesh.cell_sets) == {"super_1", "super_1.pshell_7", "super_2", "super_2.pshell_7"}
    np.testing.assert_array_equal(mesh.cells_of("super_2")[CellType.TRIANGLE3], [2, 3])
    with pytest.raises(ImportFormatError, match="its main bulk data have no GRID, only its superelements"):
        read_nodes(read.path)
