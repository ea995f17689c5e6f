"""Beams and rods of decks: sections, orientation, offsets, pins; against closed forms and other cards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.errors import ImportFormatError
from supple.importers.deck import BeamProperty, BeamValues, IsotropicMaterial, RodProperty
from supple.mesh import SectionGeometry

MATERIAL = "MAT1,5,2.1+11,,.3,7850.\n"
STEEL = IsotropicMaterial(2.1e11, 0.3, 7850.0)
# The axes CD of grid 1 are turned about z: its x is the basic y.
GRIDS = """\
CORD2R,3,,0.,0.,0.,0.,0.,1.
,0.,1.,0.
GRID,1,,0.,0.,0.,3
GRID,2,,2.,0.,0.
GRID,9,,0.,0.,7.
"""


def beam(deck, text, element="CBAR,1,4,1,2,1.,0.,0."):
    (made,) = deck(GRIDS + MATERIAL + element + "\n" + text).properties.values()
    assert isinstance(made, BeamProperty)
    return made


# --- sections


def test_a_bar_and_a_beam_of_one_section(deck):
    bar = beam(deck, "PBAR,4,5,.01,2.-5,1.-5,3.-5,6.\n,,,,,,,,\n,.8,.7,1.-6\n")
    mass = 7850 * 0.01 + 6
    assert bar == BeamProperty(STEEL, BeamValues(0.01, 2e-5, 1e-5, 3e-5, 0.8, 0.7, mass, 1e-6))
    same = "PBEAM,4,5,.01,2.-5,1.-5,1.-6,3.-5,6.\n"
    assert beam(deck, same + ",NO,1.0\n,.8,.7\n", "CBEAM,1,4,1,2,1.,0.,0.") == bar
    bar = replace(bar, first=replace(bar.first, geometry=SectionGeometry(((0.1, 0.2),))))
    for text in (
        same + ",.1,.2\n,.8,.7\n",
        same + ",.1,.2,,,,,,\n,YES,1.0,.01,2.-5,1.-5,1.-6,3.-5,6.\n,.1,.2\n,.8,.7\n",
    ):
        assert beam(deck, text, "CBEAM,1,4,1,2,1.,0.,0.") == bar
    assert beam(deck, same, "CBEAM,1,4,1,2,1.,0.,0.").first.K1 == 1.0


def test_a_tapered_beam(deck):
    """Values at B, those it leaves blank as at A; stations off the line between the ends are left out."""
    text = "PBEAM,4,5,.01,2.-5,1.-5,0.,3.-5,6.\n,NO,.5,.02\n,NO,1.,.04,8.-5\n"
    made = beam(deck, text, "CBEAM,1,4,1,2,1.,0.,0.")
    assert made.second is not None
    assert (made.second.area, made.second.I1, made.second.I2, made.second.J) == (0.04, 8e-5, 1e-5, 3e-5)
    assert made.second.mass_per_length == pytest.approx(7850 * 0.04 + 6)
    shaped = beam(deck, "PBEAML,4,5,,ROD\n,.1,6.,NO,1.0,.2\n", "CBEAM,1,4,1,2,1.,0.,0.")
    assert shaped.second is not None
    assert shaped.second.area == pytest.approx(4 * shaped.first.area) == pytest.approx(np.pi * 0.04)
    assert shaped.second.mass_per_length == pytest.approx(7850 * np.pi * 0.04 + 6)
    start, end = "PBEAM,4,5,.01,2.-5,1.-5,0.,3.-5,6.\n", ",NO,1.,.04,8.-5,1.-5,0.,3.-5,6.\n"
    for middle, left in [
        (",NO,.5,.025,5.-5\n", []),
        (",NO,.5\n", []),
        (",NO,.5,.02\n", ["PBEAM"]),
    ]:
        given = GRIDS + MATERIAL + "CBEAM,1,4,1,2,1.,0.,0.\n" + start + middle + end
        assert [each.card for each in deck(given).left_out] == left
    relief = GRIDS + MATERIAL + "CBEAM,1,4,1,2,1.,0.,0.\n" + start + end
    assert "shear relief" in deck(relief + ",.8,.8,.2\n").left_out[0].meaning
    assert not deck(relief + ",0.,0.,.2\n").left_out
    stations = "PBEAML,4,5,,ROD\n,.1,6.,NO,.5,.15,,NO,1.0\n,.2\n"
    (half_way,) = deck(GRIDS + MATERIAL + "CBEAM,1,4,1,2,1.,0.,0.\n" + stations).left_out
    assert half_way.card == "PBEAML"


def test_masses_beside_the_neutral_axis(deck):
    """The centre of steel at N and of NSM at M; moments about it by the parallel-axis theorem, with NSI."""
    text = "PBEAM,4,5,.01,2.-5,1.-5,0.,3.-5,78.5\n,,,,,,,,\n,1.,1.,,,4.\n,.3,.1,,,.1,.3\n"
    values = beam(deck, text, "CBEAM,1,4,1,2,1.,0.,0.").first
    assert values.neutral == (0.1, 0.3)
    assert values.mass_per_length == pytest.approx(157.0)
    assert values.mass_centre == pytest.approx((0.2, 0.2))
    Iyy, Izz = 7850 * 1e-5 + 157 * 0.1**2, 7850 * 2e-5 + 157 * 0.1**2
    assert values.rotary == pytest.approx((Iyy + Izz + 4.0, Iyy, Izz))


def test_sections_by_their_shape(deck):
    """Of a bar the shear centre is the centroid; of a beam the grids carry the shear centre."""
    bar = beam(deck, "PBARL,4,5,,T\n,.2,.3,.02,.01,6.\n")
    shaped = beam(deck, "PBEAML,4,5,,T\n,.2,.3,.02,.01,6.\n", "CBEAM,1,4,1,2,1.,0.,0.")
    assert bar.first.neutral == (0.0, 0.0)
    area = 0.2 * 0.02 + 0.28 * 0.01
    assert bar.first.area == shaped.first.area == pytest.approx(area)
    assert shaped.first.neutral == pytest.approx((-0.28 * 0.01 * 0.15 / area, 0.0))
    own = 7850 * area
    assert shaped.first.mass_centre[0] == pytest.approx(own / (own + 6) * shaped.first.neutral[0])


def test_rods_tubes_and_what_carries_its_own_values(deck):
    area, J = np.pi * (0.05**2 - 0.04**2), np.pi / 2 * (0.05**4 - 0.04**4)
    text = GRIDS + MATERIAL + "CTUBE,1,6,1,2\nPTUBE,6,5,.1,.01,2.\nCROD,2,7,1,2\n"
    text += f"PROD,7,5,{area:.9f},{J * 1e5:.8f}-5,,2.\nCONROD,3,1,2,5,{area:.9f},{J * 1e5:.8f}-5,,2.\n"
    read = deck(text)
    assert [found.name for found in read.elements] == ["CROD", "CTUBE", "CONROD"]
    for found in read.elements:
        made = read.properties[found.property]
        assert isinstance(made, RodProperty)
        assert (made.area, made.J) == (pytest.approx(area, rel=1e-6), pytest.approx(J, rel=1e-6))
        assert made.mass_per_length == pytest.approx(7850 * area + 2, rel=1e-6)
        np.testing.assert_array_equal(found.nodes, [[0, 1]])
    solid = deck(GRIDS + MATERIAL + "CTUBE,1,6,1,2\nPTUBE,6,5,.1\n").properties["ptube_6"]
    assert solid.area == pytest.approx(np.pi * 0.05**2)


# --- elements


PBAR = "PBAR,4,5,.01,2.-5,1.-5,3.-5\n" + MATERIAL


@pytest.mark.parametrize(
    ("words", "direction", "offsets"),
    [
        ("1.,0.,0.", (0, 1, 0), None),  # in the axes of grid 1
        ("9", (0, 0, 1), None),
        ("0.,1.,1.,BGG", (0, 1 / np.sqrt(2), 1 / np.sqrt(2)), None),
        ("1.,0.,0.,,,\n,,,1.,2.,3.,4.,5.,6.", (0, 1, 0), ((-2, 1, 3), (4, 5, 6))),
        ("0.,0.,1.,GOO,,\n,,,1.,2.,3.,4.,5.,6.", (0, 0, 1), ((1, -3, 2), (4, -6, 5))),
        ("9,,,GGO,,\n,,,1.,2.,3.,4.,5.,6.", (0, 0, 1), ((-2, 1, 3), (4, -6, 5))),
    ],
)
def test_orientation_and_offsets_in_the_axes_that_the_flag_names(deck, words, direction, offsets):
    words = words.replace(",,\n,,,", "\n,,,")
    (found,) = deck(GRIDS + PBAR + f"CBAR,1,4,1,2,{words}\n").elements
    np.testing.assert_allclose(found.directions, [direction], atol=1e-12)
    if offsets is None:
        assert found.offsets is None
    else:
        np.testing.assert_allclose(found.offsets, [offsets], atol=1e-12)


def test_pins(deck):
    (found,) = deck(GRIDS + PBAR + "CBAR,1,4,1,2,1.,0.,0.\n,46,5\nCBAR,2,4,1,2,1.,0.,0.\n").elements
    np.testing.assert_array_equal(np.argwhere(found.released), [[0, 3], [0, 5], [0, 10]])


@pytest.mark.parametrize(("element", "default"), [("CBAR", "BAROR"), ("CBEAM", "BEAMOR")])
def test_what_beams_leave_blank(deck, element, default):
    made = (
        PBAR if element == "CBAR" else PBAR.replace("PBAR,4,5,.01,2.-5,1.-5,", "PBEAM,4,5,.01,2.-5,1.-5,0.,")
    )
    short = deck(GRIDS + made + f"{default},,4,,,0.,0.,1.,BGG\n{element},1,,1,2\n{element},2,,1,2,0.,1.,0.\n")
    long = deck(GRIDS + made + f"{element},1,4,1,2,0.,0.,1.,BGG\n{element},2,4,1,2,0.,1.,0.,BGG\n")
    np.testing.assert_allclose(short.elements[0].directions, long.elements[0].directions)


@pytest.mark.parametrize(
    ("words", "bend"),
    [
        ("0.,3.,0.,1", "PBEND,4,5,.01,2.-5,1.-5,3.-5\n"),  # the centre lies along the vector
        ("1.,0.,0.,2", "PBEND,4,5,.01,2.-5,1.-5,3.-5\n"),  # the vector is the tangent
        ("1.,0.,0.,3", "PBEND,4,5,.01,2.-5,1.-5,3.-5,3.\n"),  # opposite the vector, with a radius
        ("1.,0.,0.,4", "PBEND,4,5,.01,2.-5,1.-5,3.-5,,90.\n"),  # opposite the vector, with an angle
    ],
)
def test_a_quarter_of_a_circle(deck, words, bend):
    """All forms of the arc from (0, 0) to (3, 3) about (0, 3); its mass is that of the arc."""
    text = "GRID,1,,0.,0.,0.\nGRID,2,,3.,3.,0.\n" + MATERIAL + bend
    read = deck(text + f"CBEND,1,4,1,2,{words}\n")
    (found,) = read.elements
    np.testing.assert_allclose(np.linalg.norm(read.nodes - [0, 3, 0], axis=1), 3.0)
    ends = read.nodes[found.nodes]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    np.testing.assert_array_equal(found.nodes[0, 0], 0)
    np.testing.assert_array_equal(found.nodes[-1, 1], 1)
    made = read.properties[found.property]
    assert isinstance(made, BeamProperty)
    assert made.first.mass_per_length * lengths.sum() == pytest.approx(78.5 * 3 * np.pi / 2)
    # Plane 1 is that of the arc.
    assert np.abs(found.directions[:, 2]).max() < 1e-12


@pytest.mark.parametrize(("geometry", "words"), [(2, ""), (3, "1."), (4, ",180.")])
def test_half_a_circle(deck, geometry, words):
    """The ends do not give its plane, but the vector does."""
    text = "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\n" + MATERIAL + f"PBEND,4,5,.01,2.-5,1.-5,3.-5,{words}\n"
    read = deck(text + f"CBEND,1,4,1,2,0.,0.,1.,{geometry}\n")
    assert len(read.elements[0].nodes) == 32
    np.testing.assert_allclose(np.linalg.norm(read.nodes - [1, 0, 0], axis=1), 1.0)
    assert read.nodes[:, 1] == pytest.approx(0)
    assert (read.nodes[2:, 2] > 0).all()


def test_offsets_of_a_curved_beam_are_left_out(deck):
    text = GRIDS + MATERIAL + "CBEND,1,4,1,2,1.,0.,0.,4\n"
    for bend in ("1,.1,.02,,,90.\n,,,,.1\n", ".01,2.-5,1.-5,3.-5,,90.\n,,,,,,,,\n,,,,.1\n"):
        (left,) = deck(text + f"PBEND,4,5,{bend}").left_out
        assert left.meaning.startswith("the offsets RC, ZC")


def test_a_bent_pipe_is_a_tube(deck):
    text = "GRID,1,,0.,0.,0.\nGRID,2,,3.,3.,0.\n" + MATERIAL
    read = deck(text + "CBEND,1,4,1,2,0.,3.,0.,1\nPBEND,4,5,1,.1,.02\n")
    made = next(iter(read.properties.values()))
    assert isinstance(made, BeamProperty)
    assert made.first.area == pytest.approx(2 * np.pi * 0.1 * 0.02)
    assert not read.left_out
    assert deck(text + "CBEND,1,4,1,2,0.,3.,0.,1\nPBEND,4,5,2,.1,.02\n").left_out[0].card == "PBEND"


# --- what is left out, what is wrong


WARPING = "PBEAM,4,5,1.,1.,1.,0.,1.\n,.1\n,1.,1.,,,,,2.\n"


def test_warping_acts_through_its_scalar_points(deck):
    assert not deck(GRIDS + MATERIAL + "CBEAM,1,4,1,2,1.,0.,0.\n" + WARPING).left_out


@pytest.mark.parametrize(
    ("text", "card", "meaning"),
    [
        ("CBAR,1,4,1,2,1.,0.,0.\nPBARL,4,5,,NEW\n,1.\n", "CBAR", "its section NEW is not read"),
        ("CBAR,1,4,1,2,1.,0.,0.\nPBARL,4,5,,BOX\n,1.,1.,.6,.1\n", "CBAR", "do not make a section BOX"),
        (
            "CBAR,1,4,1,2,1.,0.,0.\nPBCOMP,4,5,1.\n",
            "CBAR",
            "their property 4 is not defined or not supported",
        ),
        ("CROD,1,4,1,2\nPROD,4,6,1.\n", "CROD", "its material 6 is not defined"),
        ("CONROD,1,1,2,6,1.\n", "CONROD", "its material 6 is not defined"),
        ("CBEND,1,4,1,2,1.,0.,0.,3\nPBEND,4,5,1.,1.,1.,1.\n", "CBEND", "their arc"),
        ("CBEND,1,4,1,2,1.,0.,0.,4\nPBEND,4,5,1.,1.,1.,1.,,270.\n", "CBEND", "over 180 degrees"),
        ("CBEND,1,4,1,2,0.,1.,1.,2\nPBEND,4,5,1.,1.,1.,1.\n", "CBEND", "over 180 degrees"),
        ("CBEND,1,4,1,2,0.,0.,1.,1\nPBEND,4,5,1.,1.,1.,1.\n", "CBEND", "their arc"),
        (
            "CBEND,1,4,1,2,1.,0.,0.,4\nPBEND,4,5,1,1.,3.,,,90.\n",
            "CBEND",
            "RM = 1 and thickness T = 3 do not make a pipe",
        ),
        ("CBAR,1,4,1,2,1.,0.,0.\nPBARL,4,5,,TUBE2\n,1.,1.2\n", "CBAR", "do not make a section TUBE2"),
        ("CTUBE,1,6,1,2\nPTUBE,6,5,.1,.06\n", "CTUBE", "T = 0.06 is not between 0 and half"),
        ("CTUBE,1,6,1,2\nPTUBE,6,5,.1,.04,,.05\n", "CTUBE", "T = 0.04 is not between 0 and half"),
        (f"CBEAM,1,4,1,2,1.,0.,0.\n,,,,,,,,\n,77,78\n{WARPING}", "CBEAM", "its warping"),
    ],
)
def test_beams_that_are_left_out(deck, text, card, meaning):
    left = {each.card: each for each in deck(GRIDS + MATERIAL + text).left_out}
    assert meaning in left[card].meaning


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("2,1.,0.,0.", None),
        ("2,0.,1.,0.", "line 8: CBAR: its orientation .* lies along the beam"),
        ("2", "line 8: CBAR: its orientation .* is missing"),
        ("2,99", "line 8: CBAR: names grid 99"),
        ("1,1.,0.,0.", "line 8: CBAR: its orientation .* or the beam has no length"),
        ("2,1.,0.,0.\n,78", "line 8: CBAR: a pin flag is '78'"),
    ],
)
def test_what_is_wrong_with_beams(deck, words, message):
    text = GRIDS + PBAR + f"CBAR,1,4,1,{words}\n"
    if message is None:
        deck(text)
        return
    with pytest.raises(ImportFormatError, match=message):
        deck(text)


# --- points of stress recovery


def test_points_of_stress_recovery(deck):
    """C, D, E, F of PBAR, PBEND and PBEAM as (y, z); those that the card leaves blank are no points."""
    bar = beam(deck, "PBAR,4,5,.01,2.-5,1.-5,3.-5\n,.1,.05,-.1,,,,.1,-.05\n")
    assert bar.first.geometry == SectionGeometry(((0.1, 0.05), (-0.1, 0.0), (0.1, -0.05)))
    assert beam(deck, "PBAR,4,5,.01,2.-5,1.-5,3.-5\n").first.geometry is None
    text = "PBEAM,4,5,.01,2.-5,1.-5,0.,3.-5\n,.1,.05\n,YES,.5,.01\n,.9,.9\n,YES,1.,.02\n,.2,.1\n"
    tapered = beam(deck, text, "CBEAM,1,4,1,2,1.,0.,0.")
    assert tapered.first.geometry == SectionGeometry(((0.1, 0.05),))
    assert tapered.second.geometry == SectionGeometry(((0.2, 0.1),))
    blank = beam(deck, text.replace("\n,.2,.1", "\n,"), "CBEAM,1,4,1,2,1.,0.,0.")
    assert blank.second.geometry == blank.first.geometry
    as_at_a = beam(deck, text.replace("YES", "YESA").replace("\n,.9,.9", "").replace("\n,.2,.1", ""))
    assert as_at_a.second.geometry == as_at_a.first.geometry


def test_shapes_bring_their_points(deck):
    """Of a bar from the centroid; of a beam from the shear centre, which its grids carry."""
    bar = beam(deck, "PBARL,4,5,,T\n,.2,.3,.02,.01\n").first
    shaped = beam(deck, "PBEAML,4,5,,T\n,.2,.3,.02,.01\n", "CBEAM,1,4,1,2,1.,0.,0.").first
    assert shaped.geometry == bar.geometry.moved(*shaped.neutral)
    assert len(shaped.geometry.points) == 6
    assert max(y for y, _ in shaped.geometry.points) == pytest.approx(0.01)


def test_rods_have_an_arm_of_torsion(deck):
    """C of PROD and CONROD, the outer radius of PTUBE."""
    text = GRIDS + MATERIAL + "CTUBE,1,6,1,2\nPTUBE,6,5,.1,.01\nCROD,2,7,1,2\nPROD,7,5,1.-3,2.-7,.02\n"
    read = deck(text + "CONROD,3,1,2,5,1.-3,2.-7,.03\n")
    arms = {each.name: read.properties[each.property].torsion_arm for each in read.elements}
    assert arms == {"CTUBE": 0.05, "CROD": 0.02, "CONROD": 0.03}
