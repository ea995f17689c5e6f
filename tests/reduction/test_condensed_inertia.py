"""Inertia of the condensed motion: its moments, where it acts, and the stiffness that it lacks elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg

from supple.body import MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.equations.floating_inertia import floating_mass
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, NormalModes, Rubin, SteadyLoads, reduce
from supple.reduction.condensed_inertia import condensed_gram, missing_centrifugal_stiffness

pytestmark = pytest.mark.filterwarnings("ignore::supple.errors.LockingWarning")

LENGTH, BENDING, MASS_PER_LENGTH = 10.0, 1.4e4, 1.2
ROOT = NodalFixedFrame("root")
WRIGHT = {2.0: 4.1373, 4.0: 5.5850, 8.0: 9.2568}
"""First flap frequency of a uniform cantilever by its speed of rotation, both over sqrt(EI / (rho A L^4)):
A. D. Wright, C. E. Smith, R. W. Thresher, J. L. C. Wang, J. Appl. Mech. 49 (1982) 197-202."""


@pytest.fixture(scope="module")
def beam():
    """The rotating beam of [Wu2019]."""
    thickness = 0.006**0.5
    material = Isotropic(2.8e7 / thickness, 0.0, MASS_PER_LENGTH / thickness)
    model = shell_model(strip(LENGTH, 1.0, 20, 2), HomogeneousSection(material, thickness))
    return flexible_body("beam", model, [RigidInterface("root", "root")])


def without_derivatives(beam, frame, recipe):
    return reduce(beam, frame, recipe, derivatives=NoDerivatives(), loads=NoLoads)


@pytest.fixture(scope="module")
def clamped(beam):
    return without_derivatives(beam, ROOT, CraigBampton(n_modes=10))


@pytest.fixture(scope="module")
def floating(beam):
    return without_derivatives(beam, MeanAxisFrame(), Rubin(n_columns=10))


def moments_at(body, gamma):
    """s, c and packed J (12,) of coordinates."""
    first, second = np.triu_indices(body.r)
    weights = np.where(first == second, 0.5, 1.0) * gamma[first] * gamma[second]
    return body.condensed.moments @ weights


@pytest.mark.parametrize("name", ["clamped", "floating"])
def test_moments_are_sums_over_the_nodes(request, beam, name):
    body = request.getfixturevalue(name)
    gamma = np.random.default_rng(0).standard_normal(body.r) / body.frequencies
    z = (body.condensed.fields @ body.condensed.amplitudes_at(gamma)).reshape(-1, 6)
    momentum = (beam.nodal_mass @ z.ravel()).reshape(-1, 6)
    s, c, packed = np.split(moments_at(body, gamma), [3, 6])
    size = np.abs(momentum).sum() * LENGTH
    np.testing.assert_allclose(s, momentum[:, :3].sum(axis=0), atol=1e-10 * size)
    about = np.cross(body.nodes, momentum[:, :3]) + momentum[:, 3:]
    np.testing.assert_allclose(c, about.sum(axis=0), atol=1e-10 * size)
    # sum m (2 x.z I - x z^T - z x^T): the inertia tensor of moved nodes, to first order. Nodes that turn
    # change nothing: the rotary inertia of a shell is the same about all axes.
    product = body.nodes.T @ momentum[:, :3]
    tensor = 2 * np.trace(product) * np.eye(3) - product - product.T
    np.testing.assert_allclose(packed, tensor[np.triu_indices(3)], atol=1e-10 * size)


def test_beside_mean_axes_the_motion_moves_no_centre_and_turns_nothing(floating):
    s, c, J = np.split(np.abs(floating.condensed.moments), [3, 6])
    assert s.max() * LENGTH < 1e-6 * J.max()
    assert c.max() < 1e-6 * J.max()


def test_kinetic_energy_of_a_rotation_gains_its_change_of_inertia(floating):
    gamma = np.random.default_rng(1).standard_normal(floating.r) / floating.frequencies
    spin = np.array([0.3, -0.5, 0.8])
    z = np.concatenate([np.zeros(3), spin, np.outer(gamma, spin).ravel(), np.zeros(floating.r)])
    gained = z @ (condensed_gram(floating) - floating.gram) @ z / 2
    xx, xy, xz, yy, yz, zz = moments_at(floating, gamma)[6:]
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    np.testing.assert_allclose(gained, spin @ J @ spin / 2, rtol=1e-12)


def test_the_mass_matrix_stays_definite_at_half_a_radian(floating):
    rng = np.random.default_rng(2)
    gram = condensed_gram(floating)
    for _ in range(10):
        gamma = rng.standard_normal(floating.r) / floating.frequencies
        gamma *= 0.5 / np.linalg.norm(floating.rotations(gamma), axis=1).max()
        alone, whole = (np.asarray(floating_mass(each, gamma)) for each in (floating.gram, gram))
        assert linalg.eigvalsh(whole, alone)[0] > 0.8


@pytest.mark.parametrize("speed", WRIGHT)
def test_the_stiffness_missing_is_that_of_a_rotating_beam(clamped, speed):
    """The flap mode, stiffened by what is said to be missing, against the rotating beam's frequency."""
    unit = np.sqrt(BENDING / (MASS_PER_LENGTH * LENGTH**4))
    flap = np.argmax(np.abs(clamped.displacement_basis[:, 2]).max(axis=0) > 0.1)
    first, second = np.triu_indices(clamped.r)
    J = np.zeros((clamped.r, clamped.r))
    J[first, second] = J[second, first] = clamped.condensed.moments[11]
    frequency = np.sqrt(linalg.eigvalsh(clamped.stiffness - (speed * unit) ** 2 * J / 2)) / unit
    assert flap == 0
    np.testing.assert_allclose(frequency[0], WRIGHT[speed], rtol=2e-3)
    softest = missing_centrifugal_stiffness(clamped)[2] * clamped.frequencies[0] ** 2
    at_rest = 3.51602
    assert softest == pytest.approx((WRIGHT[2.0] ** 2 - at_rest**2) / 4.0, rel=0.05)


def test_where_it_has_inertia_nothing_is_missing(floating, clamped):
    assert not missing_centrifugal_stiffness(floating).any()
    assert condensed_gram(clamped) is clamped.gram
    assert missing_centrifugal_stiffness(clamped)[2] > 0.05


def test_columns_that_hold_steady_loads_miss_nothing(beam, clamped):
    steady = without_derivatives(beam, ROOT, SteadyLoads(CraigBampton(n_modes=10)))
    assert missing_centrifugal_stiffness(steady).max() < 1e-4 * missing_centrifugal_stiffness(clamped).max()


def test_mean_axes_without_static_shapes_have_none(beam):
    body = without_derivatives(beam, MeanAxisFrame(), NormalModes(6))
    assert condensed_gram(body) is body.gram
    assert missing_centrifugal_stiffness(body).max() > 0


def test_a_body_made_linear_has_none(floating, clamped):
    for body in (floating, clamped):
        linear = replace(body, cubic=None, quartic=None)
        assert condensed_gram(linear) is linear.gram
        assert not missing_centrifugal_stiffness(linear).any()
