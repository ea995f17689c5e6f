"""Whole decks: what is counted, ignored and left out; supports, matrices, parts, parameters."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import deck_frequencies
from supple.errors import ImportFormatError
from supple.importers.deck import LeftOut

SQUARE = """\
GRID,10,,0.,0.,0.
GRID,20,,1.,0.,0.
GRID,30,,1.,1.,0.
GRID,40,,0.,1.,0.
CTRIA3,1,7,10,20,30
CTRIA3,2,7,10,30,40
PSHELL,7,5,0.1,5
MAT1,5,2.1+11,,.3,7850.
"""


def held(read):
    """Freedoms that a deck's supports hold, as (grid id, component); of axes of the basic system."""
    if not read.held:
        return set()
    (terms,) = read.held
    assert set(terms.factors) <= {1.0}
    return {(int(read.node_ids[f // 6]), int(f % 6) + 1) for f in terms.freedoms}


def scalar_points(read, freedoms):
    """Ids of the scalar points among some freedoms of a deck."""
    n = len(read.node_ids)
    return [int(read.scalar_points[f // 6 - n]) for f in freedoms if f >= 6 * n]


# --- the table


def test_reading_is_not_refusing(deck):
    read = deck(
        SQUARE
        + "FORCE,1,10,,1.,1.\nFORCE,1,20,,1.,1.\nCAERO1,9\nCGAP,5,6,10\nCGAP,6,6,10\nNEWCARD,1\nEIGRL,1\n"
    )
    assert read.read == {"GRID": 4, "CTRIA3": 2, "PSHELL": 1, "MAT1": 1}
    assert read.passed_over == {"FORCE": 2, "CAERO1": 1, "EIGRL": 1}
    assert read.left_out[0].card == "CGAP"
    assert (read.left_out[0].count, read.left_out[0].line) == (2, 12)
    assert read.left_out[1] == LeftOut("NEWCARD", 1, 14, "a card that is not supported")
    np.testing.assert_array_equal(read.node_ids, [10, 20, 30, 40])


@pytest.mark.parametrize(
    "name",
    [
        *("AESURF", "CAERO5", "SPLINE7", "DRESP1", "DVPREL2", "TABLED1", "TABLEM4", "TEMPD", "MAT4", "MATT1"),
        *("FREQ3", "BCTSET", "BSURFS", "MONPNT1", "SET3", "PLOTEL", "PLOAD4", "QSET1", "SESUP", "CHBDYG"),
    ],
)
def test_cards_that_describe_no_body(deck, name):
    read = deck(SQUARE + f"{name},1,2,3,4,5,6,7,8,9,10,11,12\n")
    assert read.passed_over == {name: 1}
    assert not read.left_out


@pytest.mark.parametrize("name", ["CGAP", "CFAST", "BGSET", "GENEL", "MATS1", "CSUPER", "CYSYM", "CYJOIN"])
def test_cards_that_would_change_the_body(deck, name):
    (left,) = deck(SQUARE + f"{name},1,2,3\n").left_out
    assert left.card == name
    assert len(left.meaning) > 5


@pytest.mark.parametrize(
    ("card", "glues"),
    [
        ("BCONPRG,1,,IGLUE,1\n", True),
        ("BCONPRG,1,,FRIC,1.,,,,\n,IGLUE,0\n", False),
        ("BCTABLE,1,,,1\n,SLAVE,5,,,,,1\n,MASTERS,6\n", True),
        ("BCTABLE,1,,,1\n,SLAVE,5,,,,,0\n,MASTERS,6\n", False),
        ("BCTABL1,1,1\nBCONECT,1\n", False),
    ],
)
def test_contact_that_glues_joins_parts(deck, card, glues):
    assert [each.card for each in deck(SQUARE + card).left_out] == [card.split(",")[0]] * glues


@pytest.mark.parametrize("name", ["PELAST", "PBRSECT", "PGAP", "PBCOMP"])
def test_properties_that_an_element_has(deck, name):
    """Those that none has change no body."""
    assert not deck(SQUARE + f"{name},6,2,3\n").left_out
    left = deck(SQUARE + f"{name},6,2,3\nCGAP,3,6,10,20\n").left_out
    assert [each.card for each in left] == [name, "CGAP"]


def test_a_file_that_is_not_there_is_left_out(deck):
    """All that the rest describes is read; without the grids of an element, nothing but the table."""
    read = deck(SQUARE + "INCLUDE 'gone.bdf'\nCTRIA3,3,8,10,20,40\n")
    assert [(each.card, each.line) for each in read.left_out] == [("INCLUDE", 9), ("CTRIA3", 10)]
    assert "gone.bdf" in read.left_out[0].meaning
    assert sum(len(found.nodes) for found in read.elements) == 2
    bare = deck(SQUARE + "INCLUDE 'gone.bdf'\nCTRIA3,3,7,10,20,99\nPELAST,5\n")
    assert [(each.card, each.count) for each in bare.left_out] == [("INCLUDE", 1), ("CTRIA3", 3)]
    assert bare.read["GRID"] == 4
    assert not len(bare.nodes)
    assert "names grid 99" in bare.notes[0]


def test_a_file_of_case_control_that_is_not_there(deck, tmp_path):
    """It may select sets; one of executive control, above CEND, selects none. Errors stay errors."""
    cards = "MPC,5,10,1,1.,20,1,-1.\n"
    (left,) = deck("CEND\nINCLUDE 'case.inc'\nBEGIN BULK\n" + SQUARE + cards + "ENDDATA\n").left_out
    assert (left.card, left.line) == ("INCLUDE", 2)
    assert "case.inc: the sets that case control selects in it are not known" in left.meaning
    (tmp_path / "there.inc").write_text("INCLUDE 'case.inc'\n")
    (nested,) = deck("CEND\nINCLUDE 'there.inc'\nBEGIN BULK\n" + SQUARE + "ENDDATA\n").left_out
    assert nested.meaning == left.meaning
    with pytest.raises(ImportFormatError, match="names grid 99"):
        deck("CEND\nINCLUDE 'case.inc'\nBEGIN BULK\n" + SQUARE + "CTRIA3,3,7,10,20,99\nENDDATA\n")
    assert not deck("SOL 103\nINCLUDE 'a.dmap'\nCEND\nBEGIN BULK\n" + SQUARE + "ENDDATA\n").left_out
    parts = (
        "BEGIN BULK\nINCLUDE 'cards.inc'\n" + SQUARE + "BEGIN SUPER=2\n" + SQUARE + "ENDDATA\nINCLUDE 'z'\n"
    )
    assert [each.meaning[-22:] for each in deck(parts).left_out] == ["its cards are not read"]


def test_a_file_without_grids_has_its_table(deck):
    read = deck("MAT1,5,1.\nCAERO1,9\nCTRIA3,1,7,10,20,30\nCGAP,2,6,10\n")
    assert (read.read, read.passed_over) == ({"MAT1": 1, "CTRIA3": 1}, {"CAERO1": 1})
    assert [each.card for each in read.left_out] == ["CGAP", "CTRIA3"]
    assert "no GRID card" in read.notes[0]


def test_cards_given_twice_alike_are_one(deck):
    read = deck(
        SQUARE + "GRID,10,,0,0.,0.0\nCTRIA3,1,7,10,20,30,,,\nPSHELL,7,5,.1,5\nMAT1,5,2.1E11,,.3,7850\n"
    )
    assert len(read.node_ids) == 4
    assert sum(len(found.nodes) for found in read.elements) == 2
    cards = "CONM2,3,10,,2.\nCELAS2,4,5.,10,3\nCMASS2,5,1.,20,1\n"
    twice = deck(SQUARE + cards + cards + "CELAS2,5,1.,20,3\n")
    assert len(twice.masses) == len(twice.inertias[0].lines) == 1
    assert twice.springs[0].values.tolist() == [5.0, 1.0]
    with pytest.raises(ImportFormatError, match="line 10: CONM2: element 3 is defined a second time"):
        deck(SQUARE + "CONM2,3,10,,2.\nCONM2,3,10,,3.\n")


# --- supports and sets


def test_supports_of_all_forms(deck):
    """SPC, SPC1 with ranges, PS of grids, in the set of case control; further sets are only named."""
    cards = "SPC,1,10,12,0.,20,3\nSPC1,1,6,20,THRU,35,40\nSPC1,2,123456,40\nGRID,50,,5.,0.,0.,,4\n"
    read = deck("SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n" + SQUARE + cards + "ENDDATA\n")
    assert held(read) == {(10, 1), (10, 2), (20, 3), (20, 6), (30, 6), (40, 6), (50, 4)}
    sets = {name: read.node_ids[nodes].tolist() for name, nodes in read.node_sets.items()}
    assert sets == {
        "spc_4": [50],
        "spc1_12": [10],
        "spc1_3": [20],
        "spc1_6": [20, 30, 40],
        "spc2_123456": [40],
    }


@pytest.mark.parametrize(
    ("control", "expected"),
    [
        ("SOL 103\nCEND\nSPC = 1\nSUBCASE 1\n SPC = 2\nSUBCASE 2\n SPC = 3\nBEGIN BULK\n", {2}),
        ("SOL 103\nCEND\nSPC = 1\nSUBCASE 1\nSUBCASE 2\n SPC = 2\nBEGIN BULK\n", {1}),
        ("SOL 103\nCEND\nSPC = 3\nBEGIN BULK\n", {1, 2}),
        ("SOL 103\nCEND\nSUBCASE 1\n SPC = 2\nSUBCASE 2\n SPC = 1\nBEGIN BULK\n", {2}),
        ("SOL 103\nCEND\nBEGIN BULK\n", set()),
        ("", set()),
    ],
)
def test_which_supports_hold(deck, control, expected):
    """SPCADD joins; the first subcase goes before what stands above it; none where sets compete."""
    read = deck(control + SQUARE + "SPC1,1,1,10\nSPC1,2,2,10\nSPCADD,3,1,2\nENDDATA\n")
    assert held(read) == {(10, component) for component in expected}
    only = deck(SQUARE + "SPC1,1,1,10\n")
    assert held(only) == {(10, 1)}


def test_subcases_that_differ_are_noted(deck):
    """Also where only a later subcase has a set."""
    cards = SQUARE + "SPC1,1,1,10\nENDDATA\n"
    read = deck("SOL 101\nCEND\nSUBCASE 1\n LOAD = 1\nSUBCASE 2\n SPC = 1\nBEGIN BULK\n" + cards)
    assert held(read) == {(10, 1)}
    assert read.notes == ("Subcases differ in their SPC set; 1, the first one, is read.",)


def test_sets_of_which_nothing_chooses_one(deck):
    """Of constraints and masses they are left out without case control; with it Nastran takes none."""
    cards = "MPC,4,10,1,1.,20,1,-1.\nMPC,5,10,2,1.,20,2,-1.\nNSM1,6,PSHELL,1.,7\nNSM1,7,PSHELL,1.,7\n"
    assert [(each.card, each.count) for each in deck(SQUARE + cards).left_out] == [("NSM1", 2), ("MPC", 2)]
    assert not deck("SOL 103\nCEND\nBEGIN BULK\n" + SQUARE + cards + "ENDDATA\n").left_out


@pytest.mark.parametrize(
    ("command", "modulus", "left"),
    [
        ("TEMP(INIT) = 4", 1.5e11, 0),
        ("TEMPERATURE(MATERIAL)=4", 1.5e11, 0),
        ("TEMP = 4", 1.5e11, 0),
        ("TEMP = 5", 2.1e11, 1),
        ("TEMP = 6", 2.1e11, 1),
        ("TEMP = 7", 2.1e11, 1),
        ("TEMP(LOAD) = 4", 2.1e11, 0),
        ("", 2.1e11, 0),
    ],
)
def test_materials_at_a_temperature(deck, command, modulus, left):
    """E half-way between two points of its table; outside, at unequal or no temperatures left out."""
    cards = (
        "TEMPD,4,20.,5,200.\nTEMPD,6,20.\nTEMP,6,10,30.\nMATT1,5,3\n"
        "TABLEM1,3\n,0.,2.+11,40.,1.+11,100.,.5+11,ENDT\n"
    )
    control = f"SOL 103\nCEND\n{command}\nBEGIN BULK\n"
    read = deck(control + SQUARE + cards + "ENDDATA\n")
    assert read.properties["pshell_7"].material.youngs_modulus == pytest.approx(modulus)
    assert [each.card for each in read.left_out] == ["MATT1"] * left
    assert not deck(control + SQUARE + "MATT1,5,,,,,3\nENDDATA\n").left_out


@pytest.mark.parametrize(
    ("axes", "points", "expected"),
    [
        ("", "10.,2.+11,1000.,1.+11", 2e11 - 1e11 * 90 / 990),
        ("LOG", "10.,2.+11,1000.,1.+11", 1.5e11),
        ("LOG", "1000.,1.+11,10.,2.+11", 1.5e11),
        ("LOG,LOG", "10.,4.+11,1000.,1.+11", 2e11),
        ("LOG", "0.,4.+11,1000.,1.+11", None),
    ],
)
def test_tables_of_materials(deck, axes, points, expected):
    """At 100 degrees, with linear and logarithmic axes, ascending or descending."""
    cards = f"TEMPD,4,100.\nMATT1,5,3\nTABLEM1,3,{axes}\n,{points},ENDT\n"
    read = deck("SOL 103\nCEND\nTEMP = 4\nBEGIN BULK\n" + SQUARE + cards + "ENDDATA\n")
    assert len(read.left_out) == (expected is None)
    assert read.properties["pshell_7"].material.youngs_modulus == pytest.approx(expected or 2.1e11)


def test_supports_in_local_axes(deck):
    read = deck("CORD2C,3,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nGRID,60,,3.,4.,0.,3\nSPC1,1,2,60\n" + SQUARE)
    (terms,) = read.held
    found = dict(zip(terms.freedoms.tolist(), terms.factors.tolist(), strict=True))
    assert found == pytest.approx({0: -0.8, 1: 0.6})


def test_analysis_set(deck):
    read = deck(SQUARE + "ASET1,123,10,THRU,25\nASET,40,3\n")
    assert sorted(read.node_ids[read.node_sets["aset"]]) == [10, 20, 40]


def test_supports_of_scalar_points(deck):
    """Those of the selected set only, also of a range; a range with components has grids only."""
    control = "SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n"
    points = "SPOINT,101,THRU,103\nSPOINT,15\n"
    for support in ("SPC1,2,0,101\n", "SPC,2,101,0\n"):
        assert not deck(control + SQUARE + points + support + "ENDDATA\n").held
    for support, ids in (("SPC1,1,0,101,THRU,102\n", [101, 102]), ("SPC,1,103,0\n", [103])):
        read = deck(control + SQUARE + points + support + "ENDDATA\n")
        assert scalar_points(read, read.held[0].freedoms) == ids
    read = deck(control + SQUARE + points + "SPC1,1,3,10,THRU,20\nENDDATA\n")
    assert read.held[0].freedoms.tolist() == [2, 8]


def test_a_wrong_analysis_set_is_noted(deck):
    read = deck(SQUARE + "ASET1,123,99\n")
    assert "aset" not in read.node_sets
    assert any("analysis set is not read: " in note and "names 99" in note for note in read.notes)


# --- matrices


def test_matrices_beside_elements(deck):
    """K2GG and M2GG of case control, with factors; one triangle of a symmetric one stands for both."""
    cards = (
        "DMIG,KADD,0,6,1,0\nDMIG,KADD,10,1,,10,1,4.\n,20,2,-2.\nDMIG,KADD,20,2,,20,2,3.\n"
        "DMIG,MADD,0,6,1,0\nDMIG,MADD,30,3,,30,3,5.\n"
    )
    control = "SOL 103\nCEND\nK2GG = 2.0*KADD\nM2GG = MADD\nBEGIN BULK\n"
    read = deck(control + SQUARE + cards + "ENDDATA\n")
    (K,), (M,) = read.stiffnesses, read.masses
    assert K.freedoms.tolist() == [0, 7]
    np.testing.assert_array_equal(K.values, [[8, -4], [-4, 6]])
    assert (M.freedoms.tolist(), M.values.tolist()) == ([14], [[5.0]])
    assert not read.left_out
    left = deck(SQUARE + cards).left_out
    assert [each.meaning for each in left] == [
        f"no case control states the use of the matrix {name}; add K2GG, M2GG or B2GG = {name}, or give "
        "matrices alone as a matrices body"
        for name in ("KADD", "MADD")
    ]
    direct = deck(control.replace("K2GG = 2.0*", "K2PP = ") + SQUARE + cards + "ENDDATA\n")
    assert "K2PP = KADD" in direct.left_out[0].meaning
    (absent,) = deck(control + SQUARE + cards.replace("KADD", "KSUM") + "ENDDATA\n").left_out
    assert (absent.card, absent.meaning) == ("K2GG", "case control adds KADD, and the file has no such DMIG")


def test_a_matrix_with_scalar_points(deck):
    """They are numbered after the nodes, as those of springs, also beside a superelement."""
    control = "SOL 103\nCEND\nK2GG = K\nBEGIN BULK\n"
    cards = "SPOINT,101\nDMIG,K,0,6,2,0\nDMIG,K,10,3,,10,3,2.\n,101,,-2.\nDMIG,K,101,,,101,,2.\n"
    read = deck(control + SQUARE + cards + "ENDDATA\n")
    (K,) = read.stiffnesses
    assert K.freedoms.tolist() == [2, 6 * 4]
    np.testing.assert_array_equal(K.values, [[2, -2], [-2, 2]])
    assert "K also acts on scalar points, which a free body omits" in read.left_out[0].meaning
    same = deck(SQUARE + "SPOINT,101\nCELAS2,9,2.,10,3,101\nENDDATA\n")
    np.testing.assert_allclose(
        *(deck_frequencies(each, 6, held=True) for each in (read, same)), rtol=1e-9, atol=1e-3
    )
    parts = deck(control + SQUARE + cards + "CELAS2,9,2.,10,3,101\nSESET,1,20\nENDDATA\n").superelements
    (K,), (terms,) = parts["super_0"].stiffnesses, parts["super_0"].springs
    n = len(parts["super_0"].node_ids)
    assert K.freedoms.tolist() == terms.freedoms.tolist() == [2, 6 * n]
    joined = deck(control + SQUARE + cards + "BEGIN SUPER=2\n" + SQUARE + "ENDDATA\n")
    assert joined.stiffnesses[0].freedoms.tolist() == [2, 6 * 4]
    assert [each.card for each in joined.left_out] == ["DMIG"]


def test_a_symmetric_matrix_has_one_triangle(deck):
    control = "SOL 103\nCEND\nK2GG = K\nBEGIN BULK\n"
    cards = "DMIG,K,0,6,1\nDMIG,K,10,1,,20,1,-2.\nDMIG,K,20,1,,10,1,-2.\nENDDATA\n"
    with pytest.raises(
        ImportFormatError, match=r"line 15: DMIG: K has form 6 .* points 10 and 20 is on both"
    ):
        deck(control + SQUARE + cards)
    (K,) = deck(control + SQUARE + cards.replace("0,6", "0,1")).stiffnesses
    np.testing.assert_array_equal(K.values, [[0, -2], [-2, 0]])


def test_a_matrix_has_one_header_and_its_imaginary_part_is_noted(deck):
    control = "SOL 103\nCEND\nB2GG = K\nBEGIN BULK\n"
    cards = "DMIG,K,0,6,3\nDMIG,K,10,1,,10,1,2.,{imaginary}\n"
    assert not deck(control + SQUARE + cards.format(imaginary="") + "ENDDATA\n").left_out
    read = deck(control + SQUARE + cards.format(imaginary="0.5") + "ENDDATA\n")
    assert read.dampings[0].values.tolist() == [[2.0]]
    assert [each.meaning for each in read.left_out] == [
        "K is complex: its imaginary part (structural damping) is not read"
    ]
    with pytest.raises(ImportFormatError, match="2 header cards for K; a DMIG has one"):
        deck(control + SQUARE + 2 * cards.format(imaginary="") + "ENDDATA\n")


# --- parameters


def test_parameters_that_scale(deck):
    plain = deck(SQUARE + "CELAS2,9,4.,10,3\nCONM2,8,10,,2.\n")
    scaled = deck(SQUARE + "CELAS2,9,4.,10,3\nCONM2,8,10,,2.\nPARAM,WTMASS,.5\nPARAM,CK1,3.\nPARAM,POST,-1\n")
    a, b = (each.properties["pshell_7"] for each in (plain, scaled))
    assert b.material.density == pytest.approx(a.material.density / 2)
    assert b.material.youngs_modulus == pytest.approx(3 * a.material.youngs_modulus)
    assert scaled.springs[0].values[0] == 12.0
    assert scaled.masses[0].values[0, 0] == 1.0
    control = "SOL 103\nCEND\nK2GG = K\nM2GG = M\nBEGIN BULK\n"
    cards = "".join(f"DMIG,{name},0,6,1\nDMIG,{name},10,1,,10,1,4.\n" for name in "KM")
    factors = "PARAM,WTMASS,.5\nPARAM,CK1,5.\nPARAM,CK2,3.\nPARAM,CM2,.25\n"
    added = deck(control + SQUARE + cards + factors + "ENDDATA\n")
    assert (added.stiffnesses[0].values[0, 0], added.masses[0].values[0, 0]) == (12.0, 1.0)


# --- parts


def test_parts_are_decks_of_their_own(deck):
    part = SQUARE.replace("2.1+11", "7.+10")
    read = deck(
        "SOL 101\nCEND\nSPC = 1\nBEGIN BULK\nPARAM,WTMASS,.5\n"
        + SQUARE
        + "BEGIN SUPER=4\n"
        + part
        + "ENDDATA\n"
    )
    assert list(read.superelements) == ["super_0", "super_4"]
    inner = read.superelements["super_4"]
    assert inner.properties["pshell_7"].material.youngs_modulus == 7e10
    assert inner.properties["pshell_7"].material.density == 7850 / 2
    assert read.properties["pshell_7"].material.youngs_modulus == 2.1e11


def test_parts_that_are_no_models_are_left_out(deck):
    read = deck("BEGIN BULK\n" + SQUARE + "BEGIN SUPER=4\nMAT1,5,1.\nBEGIN AUXMODEL=2\nGRID,1\nENDDATA\n")
    assert not read.superelements
    assert [(each.card, each.line) for each in read.left_out] == [("BEGIN SUPER", 11), ("BEGIN AUXMODEL", 13)]


# --- what is unreadable


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("LAYERS,5,1.\n", r"deck\.bdf: no GRID card"),
        (SQUARE + "PARAM,WTMASS,0.\n", "line 9: PARAM: WTMASS is 0; it must be positive"),
        (SQUARE + "PARAM,WTMASS,1.\nPARAM,WTMASS,.5\n", "line 10: PARAM: WTMASS is 0.5, and 1 above"),
        (SQUARE + "SPC1,1,127,10\n", "line 9: SPC1: components '127' are not some of 123456"),
        (SQUARE + "SPC1,1,1,THRU,20\n", "line 9: SPC1: a grid .* is 'THRU', not a whole number"),
        (SQUARE + "SPOINT,1,THRU,9999999\n", "line 9: SPOINT: 1 THRU 9999999 are over a million points"),
        (SQUARE + "DMIG,K,0,6,1\nDMIG,K,99,1,,99,1,4.\n", None),
        (
            "SOL 101\nCEND\nK2GG=K\nBEGIN BULK\n" + SQUARE + "DMIG,K,0,6,1\nDMIG,K,99,1,,99,1,4.\nENDDATA\n",
            "DMIG: names grid 99",
        ),
        ("GRID,1\nINCLUDE 'deck.bdf'\n", "does a file include itself"),
    ],
)
def test_what_makes_a_deck_unreadable(deck, text, message):
    if message is None:
        deck(text)
        return
    with pytest.raises(ImportFormatError, match=message):
        deck(text)


def test_what_a_deck_notes(deck):
    read = deck(SQUARE + "SPC1,1,3,10,99\nSPC,1,20,3,.5\n")
    assert held(read) == {(10, 3), (20, 3)}
    for words in ("name grids that the file does not define", "Enforced displacements", "No ENDDATA"):
        assert any(words in note for note in read.notes), words
