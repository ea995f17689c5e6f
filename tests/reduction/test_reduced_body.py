"""The reduced body as data: shapes, names, the way back, and what it refuses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from supple.errors import ModelError
from supple.reduction import CompressedDerivatives, NoDerivatives, NoLoads, NormalModes, reduce


@pytest.fixture(scope="module")
def reduced(strip_body, root_frame):
    return reduce(strip_body, root_frame, NormalModes(3), derivatives=CompressedDerivatives(2), loads=NoLoads)


def test_expand_gives_nodal_displacements_of_one_or_many_states(reduced):
    gamma = np.random.default_rng(0).standard_normal((2, 4, 5))
    field = reduced.expand(gamma)
    assert field.shape == (2, 4, len(reduced.nodes), 3)
    condensed = reduced.condensed.fields @ reduced.condensed.amplitudes_at(gamma[1, 2])
    nodal = (reduced.nodal_basis @ gamma[1, 2] + condensed).reshape(len(reduced.nodes), 6)
    np.testing.assert_allclose(field[1, 2], nodal[:, :3])
    np.testing.assert_allclose(reduced.expand(gamma[1, 2]), nodal[:, :3])
    np.testing.assert_allclose(reduced.expand(gamma, [3, 0]), field[..., [3, 0], :])


def test_rates_are_the_derivatives_of_displacements(reduced):
    gamma, rates = np.random.default_rng(3).standard_normal((2, 5))
    difference = reduced.expand(gamma + 0.5 * rates) - reduced.expand(gamma - 0.5 * rates)  # exact: quadratic
    scale = np.abs(difference).max()
    np.testing.assert_allclose(reduced.expand_rates(gamma, rates, [4]), difference[[4]], atol=1e-12 * scale)
    linear = (reduced.nodal_basis @ rates).reshape(-1, 6)[:, :3]
    np.testing.assert_allclose(reduced.expand_rates(0 * gamma, rates), linear)


def test_what_follows_the_columns_is_in_the_displacements(cantilever, root_frame):
    """No column stretches the strip or draws its edges in; its neutral line keeps its length all the same.

    Bent by w(x), the tip comes nearer by the integral of w'^2 / 2 over the length.
    """
    reduced = reduce(cantilever, root_frame, NormalModes(1), derivatives=NoDerivatives(), loads=NoLoads)
    assert reduced.condensed is not None
    middle = np.flatnonzero(np.isclose(reduced.nodes[:, 1], np.median(reduced.nodes[:, 1])))
    middle = middle[np.argsort(reduced.nodes[middle, 0])]
    gamma = np.array([0.05 / np.abs(reduced.displacement_basis[middle, 2]).max()])
    bent = reduced.expand(gamma, middle)
    x, w = reduced.nodes[middle, 0], CubicSpline(reduced.nodes[middle, 0], bent[:, 2], bc_type="natural")
    points = np.linspace(x[0], x[-1], 2001)
    shortening = np.trapezoid(w(points, 1) ** 2, points) / 2
    assert np.abs(bent[-1, 0] + shortening) < 0.01 * shortening


def test_rotations_of_a_shell_are_its_rotational_freedoms(reduced):
    gamma = np.random.default_rng(1).standard_normal(5)
    nodal = (reduced.nodal_basis @ gamma).reshape(len(reduced.nodes), 6)
    np.testing.assert_allclose(reduced.rotations(gamma), nodal[:, 3:])


def test_interface_motion_is_that_of_its_nodes(reduced):
    """A rigid interface: u_a = u_v + theta_v x (x_a - x_v)."""
    gamma = np.random.default_rng(2).standard_normal(5)
    tip = reduced.interface("tip")
    motion = tip.motion @ gamma
    node = int(np.argmax(reduced.nodes[:, 0] + reduced.nodes[:, 1]))
    expected = motion[:3] + np.cross(motion[3:], reduced.nodes[node] - tip.position)
    np.testing.assert_allclose(reduced.expand(gamma)[node], expected, atol=1e-12)


def test_arrays_cannot_be_written(reduced):
    with pytest.raises(ValueError, match="read-only"):
        reduced.stiffness[0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        reduced.displacement_basis[0, 0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        reduced.report.singular_values_kept[0] = 1.0


def test_unknown_interface_is_refused_with_the_known_ones(reduced):
    with pytest.raises(ModelError, match="body 'strip' has no interface 'hub'; there are: root, tip"):
        reduced.interface("hub")


def test_body_without_rotations_says_so(reduced):
    with pytest.raises(ModelError, match="body 'strip' has no rotations"):
        replace(reduced, rotation_basis=None).rotations(np.zeros(5))


def test_shapes_that_disagree_are_refused(reduced):
    with pytest.raises(ModelError, match=r"damping has shape \(2, 2\), but 5 coordinates need \(5, 5\)"):
        replace(reduced, damping=np.eye(2))
    with pytest.raises(ModelError, match="give both cubic and quartic tensors, or neither"):
        replace(reduced, quartic=None)
    bad = replace(reduced.interface("tip"), motion=np.zeros((6, 4)))
    with pytest.raises(ModelError, match=r"motion of interface 'tip' has shape \(6, 4\)"):
        replace(reduced, interfaces=(bad,))


def test_values_that_are_not_finite_are_refused(reduced):
    with pytest.raises(ModelError, match="gram contains NaN or infinity"):
        replace(reduced, gram=np.full_like(reduced.gram, np.nan))


def test_tensors_without_a_potential_are_refused(reduced):
    lopsided = reduced.quartic.copy()
    lopsided[0, 5] *= 1.1  # of (00, 11), not of (01, 01)
    with pytest.raises(ModelError, match=r"its quartic tensor deviates from symmetry .*\.symmetrized\(\)"):
        replace(reduced, quartic=lopsided)
