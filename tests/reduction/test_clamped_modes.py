"""Clamped modes of a reduced free body, against the clamped mesh and the cantilever's closed form."""

from __future__ import annotations

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip
from supple.reduction import NoDerivatives, NoLoads, Rubin, clamped_modes, reduce

LENGTH, THICKNESS = 2.0, 0.01
STEEL = Isotropic(2.1e11, 0.0, 7850.0)


@pytest.fixture(scope="module")
def body():
    model = shell_model(strip(LENGTH, 0.2, 20, 2), HomogeneousSection(STEEL, THICKNESS))
    return flexible_body("strip", model, [RigidInterface("root", "root"), RigidInterface("tip", "tip")])


@pytest.mark.parametrize(
    "frame", [MeanAxisFrame(), NodalFixedFrame("root")], ids=["mean-axis", "nodal-fixed"]
)
def test_both_frames_give_the_frequencies_of_the_clamped_mesh(body, frame):
    reduced = reduce(body, frame, Rubin(n_modes=12), derivatives=NoDerivatives(), loads=NoLoads)
    clamped = lowest_modes(body.stiffness, body.mass, 4, constraint=body.interface("root").motion.toarray())
    found = clamped_modes(reduced, "root", n_modes=4).frequencies
    # A thin shell's stiffness fixes its lowest frequencies to about six digits.
    np.testing.assert_allclose(found, np.sqrt(clamped.values), rtol=1e-5)


def test_lowest_frequency_is_that_of_a_cantilever(body):
    reduced = reduce(body, MeanAxisFrame(), Rubin(n_modes=12), derivatives=NoDerivatives(), loads=NoLoads)
    stiffness_over_mass = STEEL.youngs_modulus * THICKNESS**2 / (12 * STEEL.density)
    cantilever = 1.875104**2 / LENGTH**2 * np.sqrt(stiffness_over_mass)
    assert clamped_modes(reduced, "root").frequencies[0] == pytest.approx(cantilever, rel=5e-3)


def test_a_symmetric_strip_has_the_same_frequencies_held_at_either_end(body):
    reduced = reduce(body, MeanAxisFrame(), Rubin(n_modes=12), derivatives=NoDerivatives(), loads=NoLoads)
    ends = [clamped_modes(reduced, end, n_modes=4).frequencies for end in ("root", "tip")]
    np.testing.assert_allclose(*ends, rtol=1e-5)


def test_shapes_leave_the_held_nodes_in_place_and_bend_as_a_cantilever(body):
    reduced = reduce(body, MeanAxisFrame(), Rubin(n_modes=12), derivatives=NoDerivatives(), loads=NoLoads)
    (shape,) = clamped_modes(reduced, "root", n_modes=1).shapes
    mesh = body.model.mesh
    tip = shape[mesh.nodes_of("tip"), 2].mean()
    np.testing.assert_allclose(shape[mesh.nodes_of("root")], 0.0, atol=1e-9 * abs(tip))
    k = 1.875104 / LENGTH
    x = mesh.nodes[:, 0]
    ratio = (np.sinh(k * LENGTH) - np.sin(k * LENGTH)) / (np.cosh(k * LENGTH) + np.cos(k * LENGTH))
    curve = np.cosh(k * x) - np.cos(k * x) - ratio * (np.sinh(k * x) - np.sin(k * x))
    np.testing.assert_allclose(shape[:, 2] / tip, curve / 2.0, atol=5e-3)
    # Unit modal mass, to the accuracy of lumping along the beam: m L / 4 times the tip's square.
    assert 7850.0 * 0.2 * THICKNESS * LENGTH / 4 * tip**2 == pytest.approx(1.0, rel=5e-3)


def test_an_unknown_interface_is_named(body):
    reduced = reduce(body, MeanAxisFrame(), Rubin(n_modes=2), derivatives=NoDerivatives(), loads=NoLoads)
    with pytest.raises(ModelError, match="'strip' has no interface 'middle'"):
        clamped_modes(reduced, "middle")
