"""Clamped frequencies of a reduced free body, against the clamped mesh and the cantilever's closed form."""

from __future__ import annotations

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import HomogeneousWall, Isotropic, shell_model
from supple.mesh import strip
from supple.reduction import NoDerivatives, Rubin, reduce
from supple.reduction.held_frequencies import held_frequencies

LENGTH, THICKNESS = 2.0, 0.01
STEEL = Isotropic(2.1e11, 0.0, 7850.0)


@pytest.fixture(scope="module")
def body():
    model = shell_model(strip(LENGTH, 0.2, 20, 2), HomogeneousWall(STEEL, THICKNESS))
    return flexible_body("strip", model, [RigidInterface("root", "root")])


@pytest.mark.parametrize(
    "frame", [MeanAxisFrame(), NodalFixedFrame("root")], ids=["mean-axis", "nodal-fixed"]
)
def test_both_frames_give_the_frequencies_of_the_clamped_mesh(body, frame):
    reduced = reduce(body, frame, Rubin(n_modes=12), derivatives=NoDerivatives())
    clamped = lowest_modes(body.stiffness, body.mass, 4, constraint=body.interface("root").motion.toarray())
    found = held_frequencies(reduced, "root")[:4]
    # A thin shell's stiffness fixes its lowest frequencies to about six digits.
    np.testing.assert_allclose(found, np.sqrt(clamped.values), rtol=1e-5)


def test_lowest_frequency_is_that_of_a_cantilever(body):
    reduced = reduce(body, MeanAxisFrame(), Rubin(n_modes=12), derivatives=NoDerivatives())
    stiffness_over_mass = STEEL.youngs_modulus * THICKNESS**2 / (12 * STEEL.density)
    cantilever = 1.875104**2 / LENGTH**2 * np.sqrt(stiffness_over_mass)
    assert held_frequencies(reduced, "root")[0] == pytest.approx(cantilever, rel=5e-3)


def test_an_unknown_interface_is_named(body):
    reduced = reduce(body, MeanAxisFrame(), Rubin(n_modes=2), derivatives=NoDerivatives())
    with pytest.raises(ModelError, match="'strip' has no interface 'tip'"):
        held_frequencies(reduced, "tip")
