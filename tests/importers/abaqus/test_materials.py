"""Materials of Abaqus decks: one material in several spellings, and what is taken of others."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.abaqus_decks import STEEL, brick, element_rows, node_rows

from supple.errors import ImportFormatError
from supple.importers.deck import AnisotropicMaterial, IsotropicMaterial

CUBE = node_rows(brick((1, 1, 1), (1, 1, 1))[0]) + element_rows("C3D8", brick((1, 1, 1), (1, 1, 1))[1])
SECTION = "*SOLID SECTION, ELSET=all, MATERIAL=M\n"
E, NU = 200.0, 0.25
G, LAMBDA = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
P = LAMBDA + 2 * G
ISOTROPIC = np.block(
    [[LAMBDA * np.ones((3, 3)) + 2 * G * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), G * np.eye(3)]]
)


def material(deck, below):
    return deck(CUBE + SECTION + "*MATERIAL, NAME=m\n" + below).properties["all"].material


@pytest.mark.parametrize(
    "below",
    [
        f"*ELASTIC, TYPE=ENGINEERING CONSTANTS\n{E}, {E}, {E}, {NU}, {NU}, {NU}, {G}, {G},\n{G}\n",
        f"*ELASTIC, TYPE=ORTHOTROPIC\n{P}, {LAMBDA}, {P}, {LAMBDA}, {LAMBDA}, {P}, {G}, {G},\n{G}\n",
        f"*ELASTIC, TYPE=ANISO\n{P}, {LAMBDA}, {P}, {LAMBDA}, {LAMBDA}, {P}, 0., 0.,\n"
        f"0., {G}, 0., 0., 0., 0., {G}, 0.,\n0., 0., 0., 0., {G}\n",
    ],
)
def test_an_isotropic_material_by_other_constants(deck, below):
    made = material(deck, "*DENSITY\n7.\n" + below)
    assert isinstance(made, AnisotropicMaterial)
    np.testing.assert_allclose(made.elasticity, ISOTROPIC, rtol=1e-12, atol=1e-12 * P)
    assert made.density == 7.0


def test_orthotropic_constants_stand_in_their_places(deck):
    """Compliances 1 / E_i, -nu_ij / E_i, 1 / G_ij, in our order xx yy zz yz xz xy."""
    made = material(deck, "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n10., 20., 30., .1, .2, .3, 4., 5.,\n6.\n")
    S = np.linalg.inv(made.elasticity)
    np.testing.assert_allclose(np.diag(S), [1 / 10, 1 / 20, 1 / 30, 1 / 6, 1 / 5, 1 / 4])
    np.testing.assert_allclose([S[0, 1], S[0, 2], S[1, 2]], [-0.1 / 10, -0.2 / 10, -0.3 / 20])


def test_anisotropic_constants_stand_in_their_places(deck):
    """D1112 couples xx with xy, D1323 xz with yz."""
    constants = 21 * ["0."]
    for i, value in ((0, 10), (2, 20), (5, 30), (6, 1.5), (9, 4), (14, 5), (19, 0.5), (20, 6)):
        constants[i] = str(float(value))
    rows = "\n".join(", ".join(constants[i : i + 8]) + "," for i in (0, 8, 16))
    C = material(deck, f"*ELASTIC, TYPE=ANISOTROPIC\n{rows}\n").elasticity
    np.testing.assert_array_equal(np.diag(C), [10, 20, 30, 6, 5, 4])
    assert C[0, 5] == C[5, 0] == 1.5
    assert C[4, 3] == C[3, 4] == 0.5
    assert np.count_nonzero(C) == 10


def test_the_first_temperature_is_taken(deck):
    made = deck(CUBE + SECTION + "*MATERIAL, NAME=M\n*ELASTIC\n200., .25, 20.\n100., .25, 500.\n")
    assert made.properties["all"].material == IsotropicMaterial(200.0, 0.25, 0.0)
    assert made.notes == ("material 'M' depends on temperature; its first row is used",)


@pytest.mark.parametrize(
    ("below", "mu", "bulk"),
    [
        ("*HYPERELASTIC, NEO HOOKE\n1.5, 0.1\n", 3.0, 20.0),
        ("*HYPERELASTIC, MOONEY-RIVLIN\n1., 0.5, 0.1\n", 3.0, 20.0),
        ("*HYPERELASTIC, YEOH\n1.5, 0.2, 0.3, 0.1, 0., 0.\n", 3.0, 20.0),
        ("*HYPERELASTIC, NEO HOOKE\n1.5, 0.\n", 3.0, 60.0),
    ],
)
def test_hyperelastic_materials_have_the_moduli_of_small_strain(deck, below, mu, bulk):
    made = material(deck, below)
    E, nu = made.youngs_modulus, made.poissons_ratio
    np.testing.assert_allclose([E / (2 * (1 + nu)), E / (3 * (1 - 2 * nu))], [mu, bulk])


def test_plastic_materials_are_elastic(deck):
    made = deck(
        CUBE + SECTION + "*MATERIAL, NAME=M\n*ELASTIC\n200., .25\n*PLASTIC\n1., 0.\n*EXPANSION\n1e-5\n"
    )
    assert made.left_out == ()
    assert made.passed_over["EXPANSION"] == 1
    assert made.notes == ("*PLASTIC of material 'M' is ignored: bodies are elastic",)


@pytest.mark.parametrize(
    "below",
    ["*USER MATERIAL, CONSTANTS=2\n1., 2.\n", "*ELASTIC, TYPE=TRACTION\n1., 2., 3.\n",
     "*ELASTIC\n-1., 0.3\n", "*ELASTIC\n1., 0.5\n", "*ELASTIC, TYPE=LAMINA\n1., 0., 0.1, 1., 1., 1.\n",
     "*HYPERELASTIC, NEO HOOKE\n0., 1.\n", "*HYPERELASTIC, OGDEN\n1., 2., 3.\n", "",
     "*ELASTIC, TYPE=ORTHO\n0., 0., 0., 0., 0., 0., 0., 0.,\n0.\n"],
)  # fmt: skip
def test_elements_of_materials_that_are_not_read_are_left_out(deck, below):
    made = deck(CUBE + SECTION + "*MATERIAL, NAME=M\n" + below)
    assert made.elements == ()
    assert made.left_out[-1].card == "*ELEMENT, TYPE=C3D8"
    cause = "which has no elasticity that is read"
    assert made.left_out[-1].meaning == f"elements of material 'M', {cause}, are missing"


def test_a_section_of_a_material_that_is_not_defined(deck):
    made = deck(CUBE + SECTION.replace("MATERIAL=M", "MATERIAL=STEAL") + STEEL)
    assert made.left_out[-1].meaning == "elements of material 'STEAL', which is not defined, are missing"


def test_the_elastic_law_that_calculix_brings_as_a_program(deck):
    law = "*MATERIAL, NAME=LIN_ISO_EL\n*USER MATERIAL, CONSTANTS=2\n2., .25\n"
    made = deck(CUBE + SECTION.replace("MATERIAL=M", "MATERIAL=lin_iso_el") + law)
    assert made.properties["all"].material == IsotropicMaterial(2.0, 0.25, 0.0)


def test_elements_without_a_section_are_left_out(deck):
    made = deck(CUBE + STEEL)
    (left,) = made.left_out
    assert (left.card, left.count, left.line) == ("*ELEMENT, TYPE=C3D8", 1, 11)
    assert left.meaning == "elements without a section are missing"


@pytest.mark.parametrize(
    ("below", "message"),
    [
        ("*ELASTIC\n1.\n", "line 14: *ELASTIC, TYPE=ISOTROPIC has 2 constants, not 1"),
        ("*ELASTIC, TYPE=LAMINA\n1., 1., 0., 1.\n", "*ELASTIC, TYPE=LAMINA has 6 constants, not 4"),
        ("*ELASTIC\n1., x\n", "line 15: 'X' is not a number"),
        ("*DEFORMATION PLASTICITY\n1.\n", "line 14: *DEFORMATION PLASTICITY begins with E, nu"),
    ],
)
def test_errors_of_materials(deck, below, message):
    with pytest.raises(ImportFormatError) as error:
        material(deck, below)
    assert message in str(error.value)
