"""Copied elements, axes by distributions, released ends of beams, constraints on edges and lines."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.abaqus_decks import STEEL

from supple.body import deck_frequencies, deck_mass
from supple.errors import ImportFormatError

TETRAHEDRON = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n*NSET, NSET=n\n1, 2, 3, 4\n"
SOLID = "*SOLID SECTION, ELSET=all, MATERIAL=steel\n"

# --- *ELCOPY


@pytest.mark.parametrize(
    ("copied", "reflect"),
    [
        ("SHIFT\n2, 0, 0\n0, 0, 0, 0, 0, 1, 30\n", ""),
        ("REFLECT=MIRROR\n0, 0, 0, 0, 1, 0\n0, 0, 1\n", ", REFLECT"),
    ],
)
@pytest.mark.parametrize("by_list", [True, False])
def test_copied_elements(deck, copied, reflect, by_list):
    """Copies have the volume of the first, also where their nodes are reflected."""
    text = TETRAHEDRON + f"*NCOPY, CHANGE NUMBER=10, OLD SET=n, {copied}"
    text += "*ELEMENT, TYPE=C3D4, ELSET=all\n1, 1, 2, 3, 4\n"
    text += "*ELSET, ELSET=old\n1\n" if by_list else ""
    old = "old" if by_list else "all"
    text += f"*ELCOPY, OLD SET={old}, ELEMENT SHIFT=100, SHIFT NODES=10, NEW SET=new{reflect}\n"
    made = deck(text + "*ELSET, ELSET=all\nnew\n" + STEEL + SOLID)
    assert made.left_out == ()
    np.testing.assert_array_equal(made.element_sets["new"], [101])
    assert sorted(made.node_ids[made.elements[1].nodes[0]]) == [11, 12, 13, 14]
    assert deck_mass(made).mass == pytest.approx(2 * 7850.0 / 6, rel=1e-12)


@pytest.mark.parametrize("kind", ["C3D6", "C3D8", "C3D10", "C3D15", "C3D20", "S3", "S4", "S6", "S8"])
def test_every_reflected_kind_is_sound(deck, kind):
    """Cells that turn inside out have no volume that the mesh takes."""
    from supple.importers.abaqus.element_types import CELLS
    from supple.mesh import CellType
    from supple.mesh.reference_cell import reference_nodes

    n = int(kind.lstrip("C3D").rstrip("R") or 3) if kind[0] == "C" else int(kind[1:])
    if kind[0] == "C":
        places = np.array(reference_nodes(CellType[CELLS[n]]))
    else:
        corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)[
            -(4 if n in (4, 8) else 3) :
        ]
        edges = 0.5 * (corners + np.roll(corners, -1, axis=0))
        places = np.concatenate([corners, edges])[:n]
    text = "*NODE\n" + "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(places, 1))
    text += (
        f"*NSET, NSET=n, GENERATE\n1, {n}\n*NCOPY, CHANGE NUMBER=100, OLD SET=n, REFLECT=POINT\n-3, -3, -3\n"
    )
    text += (
        f"*ELEMENT, TYPE={kind}, ELSET=all\n" + ", ".join(map(str, range(1 + n))).replace("0", "1", 1) + "\n"
    )
    text += "*ELCOPY, OLD SET=all, ELEMENT SHIFT=1, SHIFT NODES=100, NEW SET=all, REFLECT\n" + STEEL
    text += SOLID if kind[0] == "C" else "*SHELL SECTION, ELSET=all, MATERIAL=steel\n0.1\n"
    made = deck(text)
    first, second = (each.nodes for each in made.elements)
    ids = [np.unique(made.node_ids[nodes]) for nodes in (first, second)]
    np.testing.assert_array_equal(ids[1] - 100, ids[0])
    if kind[0] == "C":
        assert deck_mass(made).mass > 0
    else:  # in its plane a point reflection is a turn: the copy, turned round, looks the other way
        corners = made.nodes[np.concatenate([first, second])]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
        assert (normals * np.repeat([1, -1], len(first)) > 0).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            "OLD SET=all, ELEMENT SHIFT=1, SHIFT NODES=7",
            "makes an element with node 8, which the file does not",
        ),
        ("OLD SET=none, ELEMENT SHIFT=1, SHIFT NODES=7", "there are no elements of set 'NONE' above it"),
        ("ELEMENT SHIFT=1", "takes OLD SET, ELEMENT SHIFT and SHIFT NODES"),
    ],
)
def test_copies_that_cannot_be(deck, options, message):
    text = TETRAHEDRON + "*ELEMENT, TYPE=C3D4, ELSET=all\n1, 1, 2, 3, 4\n"
    with pytest.raises(ImportFormatError, match=message):
        deck(f"{text}*ELCOPY, {options}\n")


# --- *DISTRIBUTION

TWO = TETRAHEDRON + "*NODE\n5, 1., 1., 1.\n*ELEMENT, TYPE=C3D4, ELSET=all\n7, 1, 2, 3, 4\n9, 2, 3, 4, 5\n"
WOOD = (
    "*MATERIAL, NAME=wood\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n1e10, 1e9, 1e9, .3, .3, .3, 1e9, 1e9,\n1e9\n"
)
AXES = "*DISTRIBUTION, NAME=D, LOCATION=ELEMENT\n, 1., 0., 0., 0., 1., 0.\n9, 0., 0., 1., 1., 0., 0.\n"


def test_axes_of_each_element(deck):
    text = TWO + WOOD + AXES + "*ORIENTATION, NAME=O\nD\n3, 90.\n"
    made = deck(text + "*SOLID SECTION, ELSET=all, MATERIAL=wood, ORIENTATION=O\n")
    assert made.left_out == ()
    assert made.read["DISTRIBUTION"] == 1
    turned = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])  # about the third axis by 90 degrees
    np.testing.assert_allclose(made.elements[0].directions[0], turned, atol=1e-12)
    own = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]])  # z, x, y as columns
    np.testing.assert_allclose(made.elements[0].directions[1], own @ turned, atol=1e-12)


def test_distributions_of_two_parts_may_have_one_name(deck):
    """And those of two instances of a part, which turn with them."""
    part = "*PART, NAME={0}\n" + TWO + AXES.replace("9,", "{1},") + "*ORIENTATION, NAME=O\nD\n"
    part += "*SOLID SECTION, ELSET=all, MATERIAL=wood, ORIENTATION=O\n*END PART\n"
    text = part.format("p", 9) + part.format("q", 7) + "*ASSEMBLY, NAME=m\n"
    text += "*INSTANCE, NAME=a, PART=p\n*END INSTANCE\n*INSTANCE, NAME=b, PART=q\n*END INSTANCE\n"
    text += "*INSTANCE, NAME=c, PART=p\n\n0., 0., 0., 0., 0., 1., 90.\n*END INSTANCE\n*END ASSEMBLY\n" + WOOD
    made = deck(text)
    assert made.left_out == ()
    own, turn = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]), np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    expected = [[np.eye(3), own], [own, np.eye(3)], [turn, turn @ own]]
    np.testing.assert_allclose([each.directions for each in made.elements], expected, atol=1e-12)


def test_other_distributions_are_left_out(deck):
    text = TWO + WOOD + AXES + "*ORIENTATION, NAME=O\nD\n*DISTRIBUTION, NAME=T, LOCATION=ELEMENT\n, .1\n"
    made = deck(text + "*SOLID SECTION, ELSET=all, MATERIAL=wood, ORIENTATION=O\n")
    assert [each.card for each in made.left_out] == ["*DISTRIBUTION"]
    with pytest.raises(ImportFormatError, match="without a line of values for all other elements"):
        deck(text.replace(", 1., 0., 0., 0., 1., 0.\n", ""))
    angles = AXES + "*ORIENTATION, NAME=O\n1, 0, 0, 0, 1, 0\n3, D\n"
    assert "*ORIENTATION" in {each.card for each in deck(TWO + STEEL + SOLID + angles).left_out}


# --- *RELEASE


def beam(kind, release, count=10):
    """Elements along x, clamped at both ends."""
    per = 2 if kind == "B32" else 1
    n = count * per + 1
    text = "*NODE\n" + "".join(f"{i + 1}, {i / (n - 1)}, 0., 0.\n" for i in range(n))
    text += f"*ELEMENT, TYPE={kind}, ELSET=all\n"
    for e in range(count):
        text += ", ".join(str(per * e + i + 1) for i in range(per + 1)).join([f"{e + 1}, ", "\n"])
    text += "*BEAM SECTION, ELSET=all, MATERIAL=steel, SECTION=RECT\n.01, .02\n0., 1., 0.\n"
    return text + f"*RELEASE\n{release}" + STEEL + f"*BOUNDARY\n1, 1, 6\n{n}, 1, 6\n"


@pytest.mark.parametrize("kind", ["B31", "B32", "B33"])
def test_released_ends(deck, kind):
    made = deck(beam(kind, "5, S2, M2\n2, S1, ALLM, S2, M1-T\n"))
    assert made.left_out == ()
    (elements,) = made.elements
    released = elements.released
    assert released is not None
    places = [np.flatnonzero(elements.ids == number) for number in (5, 2)]
    np.testing.assert_array_equal(np.flatnonzero(released[places[0][-1]]), [11])
    assert released[places[0]].sum() == 1
    assert set(np.flatnonzero(released[places[1][0]][:6])) == {3, 4, 5}
    assert set(np.flatnonzero(released[places[1][-1]][6:])) == {3, 4}
    assert released.sum() == 6


def test_a_hinge_amid_a_clamped_beam(deck):
    """Two cantilevers joined by a hinge, in one plane alone: 1.8751^2 over half the length, not 4.7300^2."""
    found = deck_frequencies(deck(beam("B33", "20, S2, M2\n", 40)), 2, held=True)
    # M2 turns about n2: n1 = y bends in plane x y, over the width 0.01 of the section.
    EI = 2.1e11 * 0.02 * 0.01**3 / 12
    first = 1.8751041**2 / (2 * np.pi) * np.sqrt(EI / (7850.0 * 2e-4 * 0.5**4))
    assert found[0] == pytest.approx(first, rel=1e-3)
    whole = deck_frequencies(deck(beam("B33", "20, S2, M1\n", 40)), 1, held=True)[0]
    assert whole == pytest.approx(4.7300407**2 / (2 * np.pi) * np.sqrt(EI / (7850.0 * 2e-4)), rel=1e-3)


@pytest.mark.parametrize("line", ["5, S3, M1\n", "5, S1, M4\n", "5, S1\n", "5\n"])
def test_releases_that_are_not_read(deck, line):
    (left,) = deck(beam("B31", line)).left_out
    assert left.card == "*RELEASE"


# --- *MPC on edges and lines

EDGE = "*NODE\n1, 1., 1., 1.\n2, 1., 1., 2.\n3, 1., 1., 4.\n4, 1., 1., 3.\n5, 1., 1., 2.5\n"
POINTS = "*ELEMENT, TYPE=MASS, ELSET=m\n1, 1\n2, 2\n3, 3\n4, 4\n5, 5\n*MASS, ELSET=m\n2.\n"


@pytest.mark.parametrize(
    ("line", "shares"),
    [
        ("LINEAR, 5, 1, 3", {0: 0.5, 2: 0.5}),
        ("LINEAR, 5, 2, 3", {1: 0.75, 2: 0.25}),
        ("QUADRATIC, 2, 1, 3, 5", {0: 2 / 9, 2: -1 / 9, 4: 8 / 9}),  # the middle node last, or between
        ("QUADRATIC, 2, 1, 5, 3", {0: 2 / 9, 2: -1 / 9, 4: 8 / 9}),
    ],
)
def test_edges_interpolate(deck, line, shares):
    (terms,) = deck(EDGE + POINTS + f"*MPC\n{line}\n").constraints
    assert len(terms.lines) == 6
    node = int(line.split(", ")[1]) - 1
    np.testing.assert_array_equal(terms.dependent, 6 * node + np.arange(6))
    first = terms.rows == 0
    found = dict(zip((terms.freedoms[first] // 6).tolist(), terms.factors[first].tolist(), strict=True))
    assert found.pop(node) == 1.0
    assert found == pytest.approx({node: -share for node, share in shares.items()})
    polynomial = np.array([1.0, 2.0, 4.0, 3.0, 2.5]) ** (2 if "QUAD" in line else 1)
    assert sum(share * polynomial[node] for node, share in shares.items()) == pytest.approx(polynomial[node])


def test_a_curved_edge_with_its_middle_node_off_the_middle_turns_rigidly(deck):
    """The place is on the edge, x = sum N(s) x_i with s = 0.3; so rigid motion keeps the constraint."""
    ends = np.array([[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [2.0, 1.5, 0.3]])
    s = 0.3
    N = np.array([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)])
    places = np.vstack([ends, N @ ends])
    text = "*NODE\n" + "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(places, 1))
    text += "*ELEMENT, TYPE=MASS, ELSET=m\n1, 1\n2, 2\n3, 3\n4, 4\n*MASS, ELSET=m\n2.\n"
    (terms,) = deck(text + "*MPC\nQUADRATIC, 4, 1, 2, 3\n").constraints
    C = np.zeros((6, 24))
    np.add.at(C, (terms.rows, terms.freedoms), terms.factors)
    for omega in np.eye(3):
        rigid = np.hstack([np.cross(omega, places), np.tile(omega, (4, 1))]).ravel()
        np.testing.assert_allclose(C @ rigid, 0, atol=1e-12)
    np.testing.assert_allclose(C[0, [0, 6, 12]], -N, atol=1e-12)


def test_a_slider_stays_on_its_line(deck):
    """Across the line it is interpolated, along it free; rigid motion meets no force."""
    (terms,) = deck(EDGE + POINTS + "*MPC\nSLIDER, 5, 1, 3\n").constraints
    C = np.zeros((2, 30))
    np.add.at(C, (terms.rows, terms.freedoms), terms.factors)
    along = np.zeros(30)
    along[24 + 2] = 1.0
    np.testing.assert_allclose(C @ along, 0, atol=1e-14)
    across = np.zeros((2, 30))
    across[:, 24:26] = np.eye(2)
    assert np.linalg.matrix_rank(C @ across.T) == 2
    places = np.array([[1, 1, 1], [1, 1, 2], [1, 1, 4], [1, 1, 3], [1, 1, 2.5]])
    for omega in np.eye(3):
        rigid = np.hstack([np.cross(omega, places), np.tile(omega, (5, 1))]).ravel()
        np.testing.assert_allclose(C @ rigid, 0, atol=1e-12)
