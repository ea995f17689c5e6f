"""The superelement is the reduced body in other coordinates: nothing is left out."""

import numpy as np
import pytest
from scipy import linalg

from supple.body import MeanAxisFrame, NodalFixedFrame
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError
from supple.export import floating_frequencies, interface_form
from supple.reduction import CraigBampton, Guyan, NoDerivatives, NoLoads, NormalModes, reduce


def reduced(flexible, frame, basis):
    return reduce(flexible.linearized(), frame, basis, derivatives=NoDerivatives(), loads=NoLoads)


def test_rigid_motion_costs_no_energy_and_has_the_inertia_of_the_body(form, craig_bampton):
    rigid = np.vstack([nodal_rigid_modes(form.positions, 6), np.zeros((form.n_modal, 6))])
    assert abs(form.stiffness @ rigid).max() < 1e-12 * abs(form.stiffness).max()
    expected = craig_bampton.gram[:6, :6]
    np.testing.assert_allclose(rigid.T @ form.mass @ rigid, expected, atol=1e-11 * abs(expected).max())


def test_interfaces_move_as_their_freedoms_say(form, craig_bampton):
    motion = np.concatenate([interface.motion for interface in craig_bampton.interfaces])
    B = np.hstack([nodal_rigid_modes(form.positions, 6), motion])
    expected = np.eye(form.n_boundary, len(form.mass))
    np.testing.assert_allclose(B @ form.to_body, expected, atol=1e-9 * abs(form.to_body).max())


def test_boundary_matrices_are_those_of_static_condensation(flexible, form):
    """Constraint modes of the mesh itself: K_bb is Guyan's, whatever the modes beside them are."""
    guyan = interface_form(reduced(flexible, MeanAxisFrame(), Guyan()))
    b = slice(form.n_boundary)
    scale = np.sqrt(np.diag(guyan.stiffness))
    difference = (form.stiffness[b, b] - guyan.stiffness) / np.outer(scale, scale)
    assert abs(difference).max() < 1e-9
    assert guyan.n_modal == 0


def test_the_frame_of_the_body_does_not_matter(flexible, form):
    other = interface_form(reduced(flexible, NodalFixedFrame("root"), CraigBampton(n_modes=5)))
    b = slice(form.n_boundary)
    for name in ("stiffness", "mass"):
        mine, its = getattr(form, name)[b, b], getattr(other, name)[b, b]
        np.testing.assert_allclose(its, mine, atol=1e-10 * abs(mine).max())
    for (words, mine), (same, its) in zip(form.stated_frequencies(), other.stated_frequencies(), strict=True):
        assert words == same
        np.testing.assert_allclose(its, mine, rtol=1e-8)


def test_stated_frequencies_are_those_of_the_reduced_body(flexible, form, craig_bampton):
    """Free in its mean axes; clamped at the root by the same basis seen from the root."""
    stated = dict(form.stated_frequencies())
    np.testing.assert_allclose(stated["free"], craig_bampton.frequencies[:6] / (2 * np.pi), rtol=1e-9)
    at_root = reduced(flexible, NodalFixedFrame("root"), CraigBampton(n_modes=5))
    np.testing.assert_allclose(stated["clamped at root"], at_root.frequencies[:6] / (2 * np.pi), rtol=1e-8)
    modes = np.sqrt(np.diag(form.stiffness)[form.n_boundary :]) / (2 * np.pi)
    np.testing.assert_allclose(stated["clamped at all interfaces"], np.sort(modes)[:6], rtol=1e-10)


def test_damping_goes_along(form):
    """Proportional to the stiffness, as it was before."""
    np.testing.assert_allclose(form.damping, 1e-5 * form.stiffness, atol=1e-12 * abs(form.damping).max())
    assert linalg.eigvalsh(form.mass)[0] > 0


def test_interfaces_that_the_basis_does_not_move_are_refused(flexible):
    with pytest.raises(
        ModelError, match=r"of its 12 interface degrees of freedom only \d+ are independent in 3"
    ):
        interface_form(reduced(flexible, MeanAxisFrame(), NormalModes(3)))
    with pytest.raises(ModelError, match="has no interface 'tap'"):
        interface_form(reduced(flexible, MeanAxisFrame(), Guyan())).frequencies(["tap"])


def test_a_body_in_its_frame_has_the_frequencies_of_its_basis(craig_bampton, nonlinear):
    """In mean axes the free ones; a clamped one's own, and the free ones of its interfaces' form."""
    stated = dict(floating_frequencies(craig_bampton))
    for words in ("free", "its frame at rest"):
        np.testing.assert_allclose(stated[words], craig_bampton.frequencies[:6] / (2 * np.pi), rtol=1e-8)
    stated = dict(floating_frequencies(nonlinear))
    np.testing.assert_allclose(
        stated["its frame at rest"], nonlinear.frequencies[:6] / (2 * np.pi), rtol=1e-8
    )
    np.testing.assert_allclose(stated["free"], interface_form(nonlinear).frequencies()[:6], rtol=1e-8)
