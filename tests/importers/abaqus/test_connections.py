"""Masses, springs, supports, constraints and ties of Abaqus decks: closed forms, and other spellings."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.abaqus_decks import STEEL, brick, element_rows, node_rows

from supple.body import deck_frequencies, deck_models, mass_of_models
from supple.errors import ImportFormatError
from supple.importers.abaqus.ties import _projected, _shapes

TWO = "*NODE\n1, 0., 0., 0.\n2, 3., 4., 0.\n"
MASSES = "*ELEMENT, TYPE=MASS, ELSET=m\n10, 1\n11, 2\n*MASS, ELSET=m\n2.\n"
SOLID = "*SOLID SECTION, ELSET=all, MATERIAL=steel\n"


def row(terms, number):
    """{freedom: factor} of a row."""
    return dict(
        zip(terms.freedoms[terms.rows == number].tolist(), terms.factors[terms.rows == number], strict=True)
    )


def rows(given):
    return [row(terms, i) for terms in given for i in range(len(terms.lines))]


# --- masses and springs


def test_a_spring_acts_along_the_line_of_its_nodes(deck):
    """Two masses on a spring: w^2 = k (1 / m + 1 / m)."""
    made = deck(TWO + MASSES + "*ELEMENT, TYPE=SPRINGA, ELSET=s\n1, 1, 2\n*SPRING, ELSET=s\n\n100.\n")
    assert rows(made.springs) == [
        pytest.approx({0: -0.6, 1: -0.8, 2: 0.0, 6: 0.6, 7: 0.8, 8: 0.0} | {})
    ] or rows(made.springs) == [pytest.approx({0: -0.6, 1: -0.8, 6: 0.6, 7: 0.8})]
    np.testing.assert_array_equal(made.springs[0].values, [100])
    found = deck_frequencies(made, 12, held=True)
    assert found[-1] == pytest.approx(np.sqrt(100.0) / (2 * np.pi))
    assert made.left_out == ()


def test_springs_between_freedoms_and_to_the_ground(deck):
    text = TWO + "*ELEMENT, TYPE=SPRING2, ELSET=s\n1, 1, 2\n*SPRING, ELSET=s\n3, 2\n100.\n"
    text += "*ELEMENT, TYPE=SPRING1, ELSET=g\n2, 2\n*SPRING, ELSET=g\n6\n5.\n"
    made = deck(text)
    assert rows(made.springs) == [{2: -1.0, 7: 1.0}, {11: 1.0}]
    np.testing.assert_array_equal(made.springs[0].values, [100, 5])
    np.testing.assert_array_equal(made.springs[0].lines, [5, 10])


def test_dashpots(deck):
    made = deck(TWO + "*ELEMENT, TYPE=DASHPOTA, ELSET=s\n1, 1, 2\n*DASHPOT, ELSET=s\n\n7.\n")
    assert rows(made.dashpots) == [pytest.approx({0: -0.6, 1: -0.8, 6: 0.6, 7: 0.8})]
    np.testing.assert_array_equal(made.dashpots[0].values, [7])


def test_a_nonlinear_spring_has_its_slope_about_zero(deck):
    text = TWO + "*ELEMENT, TYPE=SPRINGA, ELSET=s\n1, 1, 2\n*SPRING, ELSET=s, NONLINEAR\n\n"
    made = deck(text + "-10., -1.\n0., 0.\n3., 0.1\n50., 1.\n")
    np.testing.assert_allclose(made.springs[0].values, [30])
    assert made.notes == ("a nonlinear *SPRING is linearised at zero",)


def test_masses_and_inertias(deck):
    """Two masses of 2 kg 5 m apart; an inertia turned by its axes."""
    axes = "*ORIENTATION, NAME=o\n0., 1., 0., -1., 0., 0.\n"
    inertia = "*ELEMENT, TYPE=ROTARYI, ELSET=r\n12, 1\n*ROTARY INERTIA, ELSET=r, ORIENTATION=o\n1., 2., 3.\n"
    bar = "*ELEMENT, TYPE=B31, ELSET=bar\n1, 1, 2\n*BEAM GENERAL SECTION, ELSET=bar\n"
    bar += "1., 1., 0., 1., 1.\n0., 0., 1.\n1., 1.\n"
    made = deck(TWO + MASSES + axes + inertia + bar)
    np.testing.assert_allclose(made.masses[0].values, np.diag([2.0, 1.0, 3.0]), atol=1e-15)
    np.testing.assert_array_equal(made.masses[0].freedoms, [3, 4, 5])
    whole = mass_of_models(list(deck_models(made).values()))
    assert whole.mass == pytest.approx(4)
    np.testing.assert_allclose(whole.centre, [1.5, 2, 0])
    assert whole.inertia[2, 2] == pytest.approx(4 * 2.5**2 + 3)


def test_a_mass_of_three_values(deck):
    made = deck(TWO + "*ELEMENT, TYPE=MASS, ELSET=m\n1, 2\n*MASS, ELSET=m, TYPE=ANISOTROPIC\n1., 0., 3.\n")
    assert rows(made.inertias) == [{6: 1.0}, {8: 1.0}]
    np.testing.assert_array_equal(made.inertias[0].values, [1, 3])


@pytest.mark.parametrize(
    ("keyword", "row"),
    [
        ("MASS, TYPE=ANISOTROPIC", "*ELEMENT, TYPE=MASS, ELSET=r"),
        ("ROTARY INERTIA", "*ELEMENT, TYPE=ROTARYI, ELSET=r"),
    ],
)
def test_masses_have_the_axes_of_their_instance_or_place(deck, keyword, row):
    """At (3, 4, 0) the radial direction of a cylindrical system is (0.6, 0.8, 0)."""

    def matrix(made):
        first = 6 + 3 * (keyword == "ROTARY INERTIA")
        found = np.zeros((3, 3))
        for each in made.masses:
            found += each.values
        for each in made.inertias:
            for terms, value in zip(rows((each,)), each.values, strict=True):
                vector = np.array([terms.get(first + i, 0.0) for i in range(3)])
                found += value * np.outer(vector, vector)
        return found

    text = TWO + f"{row}\n12, 2\n*{keyword}, ELSET=r{{}}\n1., 2., 3.\n"
    round_axes = "*ORIENTATION, NAME=o, SYSTEM=CYLINDRICAL\n0., 0., 0., 0., 0., 1.\n"
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    found = matrix(deck(round_axes + text.format(", ORIENTATION=o")))
    np.testing.assert_allclose(found, turn @ np.diag([1.0, 2, 3]) @ turn.T, atol=1e-12)
    instance = f"*PART, NAME=p\n{text.format('')}*END PART\n*ASSEMBLY, NAME=m\n*INSTANCE, NAME=a, PART=p\n"
    instance += "0., 0., 0.\n0., 0., 0., 0., 0., 1., 90.\n*END INSTANCE\n*END ASSEMBLY\n"
    np.testing.assert_allclose(matrix(deck(instance)), np.diag([2.0, 1, 3]), atol=1e-12)


# --- supports


def test_supports_of_the_model_and_of_its_first_step(deck):
    text = (
        TWO
        + MASSES
        + "*NSET, NSET=both\n1, 2\n*BOUNDARY\n1, 1, 3\nboth, 3\n2, PINNED\n*STEP\n*BOUNDARY\n1, 6, 6\n"
    )
    made = deck(text + "2, 4, 4, 0.5\n*END STEP\n*STEP\n*BOUNDARY\n2, 5\n*END STEP\n")
    assert [list(each) for each in rows(made.held)] == [[0], [1], [2], [8], [6], [7], [5]]


@pytest.mark.parametrize(
    ("name", "held"), [("ENCASTRE", [6, 7, 8, 9, 10, 11]), ("XSYMM", [6, 10, 11]), ("ZASYMM", [6, 7, 11])]
)
def test_supports_by_name(deck, name, held):
    made = deck(TWO + MASSES + f"*BOUNDARY\n2, {name}\n")
    assert [freedom for each in rows(made.held) for freedom in each] == held


def test_transform_turns_freedoms(deck):
    """Node 2 at (3, 4, 0): its cylindrical freedom 1 is (0.6, 0.8, 0), 2 is (-0.8, 0.6, 0)."""
    text = TWO + MASSES + "*TRANSFORM, NSET=n, TYPE=C\n0., 0., 0., 0., 0., 1.\n*BOUNDARY\n2, 2\n"
    text = text.replace("*TRANSFORM", "*NSET, NSET=n\n2\n*TRANSFORM")
    assert rows(deck(text).held) == [pytest.approx({6: -0.8, 7: 0.6})]
    turned = deck(text.replace("TYPE=C\n0., 0., 0., 0., 0., 1.", "TYPE=R\n0., 1., 0., -1., 0., 0."))
    assert rows(turned.held) == [pytest.approx({6: -1.0})]
    equation = deck(text + "*EQUATION\n2\n2, 1, 1., 1, 1, -2.\n")
    assert rows(equation.constraints) == [pytest.approx({6: 0.6, 7: 0.8, 0: -2.0})]


# --- equations and MPCs


def test_equations(deck):
    """Terms over several lines; of sets, one equation for each node."""
    text = TWO + MASSES + "*NODE\n3, 1., 0., 0.\n4, 2., 0., 0.\n*NSET, NSET=a\n1, 2\n*NSET, NSET=b\n3, 4\n"
    text += "*EQUATION\n5\n1, 1, 1., 2, 2, -0.25, 3, 3, -0.25, 4, 4, -0.25,\n2, 5, 1.D0\n"
    made = deck(text + "2\na, 1, 1., b, 1, -1.\n")
    found = rows(made.constraints)
    assert found[0] == {0: 1.0, 7: -0.25, 14: -0.25, 21: -0.25, 10: 1.0}
    assert found[1:] == [{0: 1.0, 12: -1.0}, {6: 1.0, 18: -1.0}]
    np.testing.assert_array_equal(made.constraints[0].dependent, [0, 0, 6])


@pytest.mark.parametrize(
    ("kind", "found"),
    [
        ("PIN", [{0: 1.0, 6: -1.0}, {1: 1.0, 7: -1.0}, {2: 1.0, 8: -1.0}]),
        ("LINK", [pytest.approx({0: -0.6, 1: -0.8, 6: 0.6, 7: 0.8})]),
    ],
)
def test_mpcs(deck, kind, found):
    made = deck(TWO + MASSES + f"*MPC\n{kind}, 1, 2\n")
    assert rows(made.constraints) == found
    assert made.left_out == ()


def test_mpcs_that_turn(deck):
    made = deck(TWO + MASSES + "*MPC\nTIE, 1, 2\nBEAM, 1, 2\n")
    assert len(made.constraints[0].lines) == 6
    assert [(tie.name, tie.reference, tie.nodes.tolist()) for tie in made.rigid] == [("mpc_2", 1, [0])]


def test_mpcs_that_are_not_read(deck):
    made = deck(TWO + MASSES + "*MPC\nSLIDER, 1, 2\nMEANROT, 1, 1, 1,\n2, 2, 2\n")
    assert [(left.card, left.count, left.line) for left in made.left_out] == [
        ("*MPC, SLIDER", 1, 10), ("*MPC, MEANROT", 1, 11),
    ]  # fmt: skip


# --- rigid bodies and couplings

NODES, CELLS = brick((0.4, 0.1, 0.1), (4, 1, 1))
BAR = node_rows(NODES) + element_rows("C3D8", CELLS) + STEEL + SOLID
HEAD = "*NODE\n100, 0.5, 0.05, 0.05\n*SURFACE, NAME=end\n4, S4\n"
END = np.flatnonzero(NODES[:, 0] > 0.39)


@pytest.mark.parametrize(
    "text",
    [
        "*NSET, NSET=n\n17, 18, 19, 20\n*RIGID BODY, NSET=n, REF NODE=100\n",
        "*NSET, NSET=n\n17, 18, 19, 20\n*NSET, NSET=r\n100\n*RIGID BODY, TIE NSET=n, REFNODE=r\n",
        "*COUPLING, REF NODE=100, SURFACE=end, CONSTRAINT NAME=tip\n*KINEMATIC\n",
        "*COUPLING, REF NODE=100, SURFACE=end, CONSTRAINT NAME=tip\n*KINEMATIC\n1, 3\n",
        "*KINEMATIC COUPLING, REF NODE=100\n17, 1, 6\n18, 1, 6\n19\n20, 1, 6\n",
        "*NSET, NSET=n\n17, 18, 19, 20\n*KINEMATIC COUPLING, REF NODE=100\nn, 1\nn, 2\nn, 3\n",
        "*MPC\nBEAM, 17, 100\nBEAM, 18, 100\nBEAM, 19, 100\nBEAM, 20, 100\n",
    ],
)
def test_rigid_ties_in_every_spelling(deck, text):
    made = deck(BAR + HEAD + text)
    (tie,) = made.rigid
    assert (tie.reference, tie.nodes.tolist()) == (20, END.tolist())
    assert made.left_out == ()
    assert made.constraints == ()


def test_pinned_nodes_follow_as_rigid_ones_of_solids(deck):
    """u = u_ref + theta x r in rows is the same motion as a rigid tie."""
    heavy = "*ELEMENT, TYPE=MASS, ELSET=m\n90, 100\n*MASS, ELSET=m\n5.\n"
    heavy += "*ELEMENT, TYPE=ROTARYI, ELSET=r\n91, 100\n*ROTARY INERTIA, ELSET=r\n0.1, 0.1, 0.1\n"
    heavy += "*NSET, NSET=n\n17, 18, 19, 20\n*NSET, NSET=root\n1, 2, 3, 4\n*BOUNDARY\nroot, 1, 3\n"
    tied = deck(BAR + HEAD + heavy + "*RIGID BODY, NSET=n, REF NODE=100\n")
    pinned = deck(BAR + HEAD + heavy + "*RIGID BODY, PIN NSET=n, REF NODE=100\n")
    assert len(pinned.constraints[0].lines) == 12
    np.testing.assert_allclose(
        deck_frequencies(pinned, 4, held=True), deck_frequencies(tied, 4, held=True), rtol=1e-9
    )


def test_some_freedoms_of_a_coupling(deck):
    """x alone: u_x = u_ref,x + (theta x r)_x = u_ref,x + theta_y r_z - theta_z r_y."""
    text = "*COUPLING, REF NODE=100, SURFACE=end, CONSTRAINT NAME=tip\n*KINEMATIC\n1, 1\n"
    found = rows(deck(BAR + HEAD + text).constraints)
    assert len(found) == 4
    r = NODES[END[0]] - [0.5, 0.05, 0.05]
    assert found[0] == pytest.approx({6 * int(END[0]): 1.0, 120: -1.0, 124: -r[2], 125: r[1]})


@pytest.mark.parametrize(
    "keywords",
    [
        "*COUPLING, REF NODE=100, SURFACE=end, CONSTRAINT NAME=tip{}\n*KINEMATIC\n1, 1\n",
        "*NSET, NSET=n\n17, 18, 19, 20\n*KINEMATIC COUPLING, REF NODE=100{}\nn, 1\n",
    ],
)
def test_freedoms_of_a_coupling_are_in_the_axes_of_its_orientation(deck, keywords):
    """Radial from the axis y = z = 0 along x; *TRANSFORM at the nodes has no effect."""
    turned = "*NSET, NSET=t\n17, 18, 19, 20\n*TRANSFORM, NSET=t, TYPE=C\n0., 0., 0., 0., 0., 1.\n"
    plain = deck(BAR + HEAD + keywords.format(""))
    assert rows(deck(BAR + HEAD + turned + keywords.format("")).constraints) == rows(plain.constraints)
    system = "*ORIENTATION, NAME=o, SYSTEM=CYLINDRICAL\n0., 0., 0., 1., 0., 0.\n"
    made = deck(BAR + HEAD + turned + system + keywords.format(", ORIENTATION=o"))
    assert made.left_out == ()
    corner = next(node for node in END.tolist() if NODES[node, 1] > 0.09 and NODES[node, 2] > 0.09)
    found = next(row for row in rows(made.constraints) if 6 * corner + 1 in row)
    r, c = NODES[corner] - [0.5, 0.05, 0.05], np.array([0.0, 1.0, 1.0]) / np.sqrt(2)
    moment = np.cross(r, c)
    expected = {6 * corner + 1: c[1], 6 * corner + 2: c[2], 121: -c[1], 122: -c[2]}
    expected |= {123 + i: -value for i, value in enumerate(moment.tolist()) if value}
    assert {freedom: value for freedom, value in found.items() if abs(value) > 1e-12} == pytest.approx(
        {freedom: value for freedom, value in expected.items() if abs(value) > 1e-12}
    )


def test_distributing_couplings_weigh_by_area(deck):
    text = (
        HEAD.replace("4, S4", "3, S5\n4, S5") + "*COUPLING, REF NODE=100, SURFACE=end, CONSTRAINT NAME=tip\n"
    )
    (mean,) = deck(BAR + text + "*DISTRIBUTING\n").means
    assert (mean.name, mean.reference, mean.components) == ("tip", 20, (True,) * 6)
    np.testing.assert_allclose(np.sort(mean.weights), [0.0025, 0.0025, 0.0025, 0.0025, 0.005, 0.005])
    (mean,) = deck(BAR + text + "*DISTRIBUTING\n1, 2\n").means
    assert mean.components == (True, True, True, False, False, False)
    (mean,) = deck(BAR + text + "*DISTRIBUTING\n4, 5\n").means
    assert mean.components == (True, True, True, True, True, False)


def test_a_distributing_coupling_of_translations_is_a_pin(deck):
    """The reference node turns freely: its inertia adds no stiffness and no frequency."""
    heavy = "*ELEMENT, TYPE=MASS, ELSET=m\n90, 100\n*MASS, ELSET=m\n5.\n"
    inertia = "*ELEMENT, TYPE=ROTARYI, ELSET=r\n91, 100\n*ROTARY INERTIA, ELSET=r\n50., 50., 50.\n"
    head = HEAD.replace("0.5", "0.4")
    text = (
        BAR
        + head
        + heavy
        + "*COUPLING, REF NODE=100, SURFACE=end, CONSTRAINT NAME=tip\n*DISTRIBUTING\n1, 3\n"
    )
    plain, turning = deck_frequencies(deck(text), 12), deck_frequencies(deck(text + inertia), 12)
    np.testing.assert_allclose(
        turning[turning > 1], plain[plain > 1][: np.count_nonzero(turning > 1)], rtol=1e-9
    )


def test_distributing_couplings_by_nodes(deck):
    text = "*ELEMENT, TYPE=DCOUP3D, ELSET=d\n50, 100\n*DISTRIBUTING COUPLING, ELSET=d\n17, 1.\n18, 3.\n"
    (mean,) = deck(BAR + HEAD + text).means
    assert (mean.name, mean.reference, mean.nodes.tolist()) == ("coupling_100", 20, [16, 17])
    np.testing.assert_array_equal(mean.weights, [1, 3])


def test_rotation_nodes_of_calculix(deck):
    """Translations of ROT NODE are rotations of REF NODE."""
    text = "*NODE\n101, 0., 0., 0.\n*NSET, NSET=n\n17, 18\n*RIGID BODY, NSET=n, REF NODE=100, ROT NODE=101\n"
    made = deck(BAR + HEAD + text + "*BOUNDARY\n101, 1, 2\n")
    assert [list(each) for each in rows(made.held)] == [[6 * 20 + 3], [6 * 20 + 4]]


# --- ties

LEFT, LEFT_CELLS = brick((0.2, 0.1, 0.1), (2, 1, 1))


def two_blocks(counts, gap=0.0, **options):
    """The bar of two blocks with faces at x = 0.2, the right one divided by counts, moved by a gap."""
    right, cells = brick((0.2, 0.1, 0.1), counts, (0.2 + gap, 0.0, 0.0))
    text = node_rows(LEFT) + node_rows(right, len(LEFT) + 1).removeprefix("*NODE\n")
    text += (
        element_rows("C3D8", LEFT_CELLS) + element_rows("C3D8", cells + len(LEFT), first=11) + STEEL + SOLID
    )
    slave = 11 + np.flatnonzero((right[cells][:, :, 0] < 0.201 + gap).any(axis=1))
    text += "*SURFACE, NAME=master\n2, S4\n*SURFACE, NAME=slave\n" + "".join(f"{e}, S6\n" for e in slave)
    more = "".join(f", {name.upper().replace('_', ' ')}={value}" for name, value in options.items())
    root = [i + 1 for i in range(len(LEFT)) if LEFT[i, 0] == 0]
    held = "*NSET, NSET=root\n" + ", ".join(map(str, root)) + "\n*BOUNDARY\nroot, 1, 3\n"
    return text + held + f"*TIE, NAME=t{more}\nslave, master\n"


def test_matching_surfaces_are_one_body(deck):
    held = "*NSET, NSET=root\n1, 2, 3, 4\n*BOUNDARY\nroot, 1, 3\n"
    whole, tied = deck(BAR + held), deck(two_blocks((2, 1, 1)))
    assert len(tied.constraints[0].lines) == 12
    assert tied.left_out == tied.notes == ()
    np.testing.assert_allclose(
        deck_frequencies(tied, 4, held=True), deck_frequencies(whole, 4, held=True), rtol=1e-9
    )


def test_surfaces_that_do_not_match_pass_a_constant_stretch(deck):
    """Slave nodes in the middle of a face follow all four of its corners; rigid motion stays free."""
    tied = deck(two_blocks((2, 2, 3)))
    found = rows(tied.constraints)
    assert len(found) == 36
    assert max(len(each) for each in found) == 5
    values = tied.constraints[0]
    for motion in (np.ones(3), tied.nodes * [1.0, -0.3, -0.3]):
        u = np.zeros((len(tied.nodes), 6))
        u[:, :3] = motion
        sums = np.bincount(values.rows, values.factors * u.ravel()[values.freedoms])
        np.testing.assert_allclose(sums, 0, atol=1e-12)
    free = deck_frequencies(tied, 1)
    assert free[0] > 1000  # no mechanism, and the six rigid motions have no frequency


def test_slave_nodes_are_moved_onto_their_faces(deck):
    """5 % of the faces' size by default; farther ones are not tied."""
    near = deck(two_blocks((2, 1, 1), gap=0.004))
    assert np.count_nonzero(np.isclose(near.nodes[:, 0], 0.2, atol=1e-12)) == 8
    far = deck(two_blocks((2, 1, 1), gap=0.02))
    assert far.constraints == ()
    assert [left.meaning for left in far.left_out] == ["no node of 'slave' lies within 0.005 of 'master'"]
    assert len(deck(two_blocks((2, 1, 1), gap=0.02, position_tolerance=0.03)).constraints[0].lines) == 12


@pytest.mark.parametrize("k", [6, 8])
def test_shape_functions_of_faces(k):
    """They add up to one, take part in linear and quadratic fields, and find a place of a curved face."""
    corners = {6: [[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]],
               8: [[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0]]}[k]  # fmt: skip
    flat = np.array(corners, float)
    xi = np.array([[0.2, 0.3], [0.1, 0.6]])
    N, dN = _shapes(k, xi)
    np.testing.assert_allclose(N @ flat, xi)
    np.testing.assert_allclose(np.einsum("pka,ki->pia", dN, flat), np.tile(np.eye(2), (2, 1, 1)), atol=1e-12)
    curved = np.column_stack([flat, 0.1 * flat[:, 0] ** 2])
    places = np.einsum("pk,ki->pi", N, curved)
    np.testing.assert_allclose(_projected(np.stack([curved, curved]), places), N, atol=1e-9)


def test_nodes_that_a_tie_names_are_tied_alone(deck):
    chosen = "*NSET, NSET=some\n13, 16\n"
    text = two_blocks((2, 1, 1), gap=0.02, tied_nset="some")
    tied = deck(text.replace("*TIE", chosen + "*TIE"))
    assert set((tied.constraints[0].dependent // 6).tolist()) == {12, 15}
    assert tied.left_out == ()
    nowhere = deck(text.replace("*TIE", "*NSET, NSET=some\n1\n*TIE"))
    assert [left.meaning for left in nowhere.left_out] == ["set 'some' has no node of 'slave'"]


def test_nodes_that_a_tie_may_not_move_are_left_out(deck):
    """Where they lie on the face, nothing moves."""
    assert deck(two_blocks((2, 1, 1), adjust="NO")).left_out == ()
    (left,) = deck(two_blocks((2, 1, 1), gap=0.004, adjust="no")).left_out
    assert (left.card, left.meaning) == ("*TIE", "nodes of 'slave' are moved onto 'master', by 0.004 or less")


SHELLS = (
    "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n11, 1., 0., {0}\n12, 2., 0., {0}\n"
)
SHELLS += "13, 2., 1., {0}\n14, 1., 1., {0}\n*ELEMENT, TYPE={1}, ELSET={2}\n2, {3}\n"
SHELLS += "*ELEMENT, TYPE=S4, ELSET=all\n1, 1, 2, 3, 4\n*SURFACE, NAME=m\n1, E2\n"


def test_a_tie_without_rotations_is_a_hinge(deck):
    text = SHELLS.format("0.", "S4", "all", "11, 12, 13, 14") + "*SURFACE, NAME=s\n2, E4\n"
    assert len(deck(text + "*TIE, NAME=t\ns, m\n").constraints[0].lines) == 12
    (hinge,) = deck(text + "*TIE, NAME=t, NO ROTATION\ns, m\n").constraints
    assert set((hinge.dependent % 6).tolist()) == {0, 1, 2}


def test_a_tie_of_beams_moves_no_node_by_default(deck):
    text = SHELLS.format("0.01", "B31", "beam", "11, 14") + "*SURFACE, NAME=s\nbeam,\n*TIE, NAME=t{}\ns, m\n"
    assert "*TIE" in [left.card for left in deck(text.format("")).left_out]
    assert "*TIE" not in [left.card for left in deck(text.format(", ADJUST=YES")).left_out]


def test_cyclic_ties_are_left_out(deck):
    made = deck(two_blocks((2, 1, 1)).replace("*TIE, NAME=t", "*TIE, NAME=t, CYCLIC SYMMETRY"))
    assert made.constraints == ()
    assert [left.card for left in made.left_out] == ["*TIE"]


# --- errors and what is left out


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("*EQUATION\n2\n1, 1, 1.\n", "line 10: an equation of 2 terms has 1"),
        ("*EQUATION\n1, 1, 1.\n", "line 10: *EQUATION begins with its number of terms"),
        ("*BOUNDARY\n1, HELD\n", "line 10: *BOUNDARY fixes freedoms 1 to 6, or ENCASTRE"),
        ("*MASS, ELSET=m\n-1.\n", "line 9: *MASS needs one number of at least zero"),
        ("*MASS, ELSET=m\n", "line 9: *MASS needs one number of at least zero"),
        ("*MASS, ELSET=m, TYPE=ANISOTROPIC\n1., 2.\n", "line 9: *MASS needs three numbers of at least zero"),
        ("*ROTARY INERTIA, ELSET=m\n-1., 1., 1.\n", "line 9: *ROTARY INERTIA: I11, I22"),
        ("*ELEMENT, TYPE=SPRING2, ELSET=s\n1, 1, 2\n*SPRING, ELSET=s\n1\n2.\n", "line 11: *SPRING lacks its"),
        (
            "*ELEMENT, TYPE=SPRINGA, ELSET=s\n1, 1, 2\n*SPRING, ELSET=s, NONLINEAR\n1., 1.\n",
            "line 11: *SPRING needs two points",
        ),
        ("*TRANSFORM, NSET=n\n1., 0., 0., 1., 0., 0.\n", "line 10: *TRANSFORM: its points give no axes"),
        ("*TRANSFORM, NSET=n\n", "line 9: *TRANSFORM without its points"),
        (
            "*SURFACE, NAME=s, TYPE=NODE\n1\n*COUPLING, REF NODE=2, SURFACE=s\n*KINEMATIC\nx\n",
            "line 13: *KINEMATIC takes",
        ),
    ],
)  # fmt: skip
def test_errors_of_connections(deck, text, message):
    with pytest.raises(ImportFormatError) as error:
        deck(TWO + MASSES + text)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("text", "card", "meaning"),
    [
        ("*EQUATION\n2\n1, 1, 1., 7, 1, 1.\n", "*EQUATION", "it names unknown nodes"),
        ("*EQUATION\n1\n1, 11, 1.\n", "*EQUATION", "it names freedoms other than 1 to 6"),
        (
            "*RIGID BODY, NSET=n, REF NODE=7\n",
            "*RIGID BODY",
            "its reference node '7' is not exactly one node",
        ),
        (
            "*KINEMATIC COUPLING, REF NODE=1, ORIENTATION=o\n2, 1, 2\n",
            "*KINEMATIC COUPLING",
            "its freedoms are those of the global axes",
        ),
        ("*RIGID BODY, NSET=n, REF NODE=1\n", "*RIGID BODY", "it ties no node"),
        (
            "*ELEMENT, TYPE=DCOUP3D, ELSET=d\n50, 1\n*DISTRIBUTING COUPLING, ELSET=d\nn, 1.\n",
            "*DISTRIBUTING COUPLING",
            "it ties no node",
        ),
        ("*RIGID BODY, REF NODE=1\n", "*RIGID BODY", "its analytical surface"),
        ("*COUPLING, REF NODE=1, SURFACE=s\n*KINEMATIC\n", "*COUPLING", "its surface 's' is not read"),
        ("*EQUATION, INPUT=other.inp\n", "*EQUATION", "its data lines are in another file"),
        ("*MPC, INPUT=other.inp\n", "*MPC", "its data lines are in another file"),
        (
            "*RIGID BODY, NSET=n, REF NODE=1, POSITION=CENTER OF MASS\n",
            "*RIGID BODY",
            "its reference node is not moved",
        ),
        (
            "*SURFACE, NAME=s, TYPE=NODE\n1\n"
            "*COUPLING, REF NODE=2, SURFACE=s, INFLUENCE RADIUS=1.\n*DISTRIBUTING\n",
            "*COUPLING",
            "it ties no node",
        ),
        ("*DISTRIBUTING COUPLING, ELSET=d\n1, 1.\n", "*DISTRIBUTING COUPLING", "its element is not one"),
        ("*TIE, NAME=t\na, b\n", "*TIE", "surfaces 'a' and 'b' are not joined"),
        ("*EMBEDDED ELEMENT\nall\n", "*EMBEDDED ELEMENT", "embedded elements are not tied"),
        ("*QUANTUM FIELD\n1\n", "*QUANTUM FIELD", "this keyword is not supported"),
        (
            "*CYCLIC SYMMETRY MODEL, N=3\n0., 0., 0., 1., 0., 0.\n",
            "*CYCLIC SYMMETRY MODEL",
            "the body is one",
        ),
    ],
)
def test_what_is_left_out_says_what_it_means(deck, text, card, meaning):
    left = deck(TWO + MASSES + text).left_out[0]
    assert (left.card, left.count, left.line) == (card, 1, left.line)
    assert left.line in (9, 10, 11)
    assert left.meaning.startswith(meaning)


def test_steps_and_what_has_no_effect_are_counted(deck):
    text = "*AMPLITUDE, NAME=a\n0., 0.\n*CONTACT PAIR\na, b\n*STEP\n*STATIC\n*CLOAD\n1, 1, 1.\n*END STEP\n"
    made = deck(TWO + MASSES + 2 * text)
    assert made.left_out == ()
    for keyword in ("AMPLITUDE", "CONTACT PAIR", "STEP", "STATIC", "CLOAD"):
        assert made.passed_over[keyword] == 2
    assert made.read == {"NODE": 1, "ELEMENT": 1, "MASS": 1}
