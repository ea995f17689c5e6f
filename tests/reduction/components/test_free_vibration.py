from __future__ import annotations

import numpy as np
import pytest

from supple.reduction import CraigBamptonFamily, craig_bampton_component


@pytest.fixture(scope="module", params=["solid_body", "averaging_body", "strip_body", "cantilever"])
def family(request):
    return CraigBamptonFamily(request.getfixturevalue(request.param))


@pytest.mark.parametrize("n_kept", [1, 6, 25])
def test_values_are_those_of_craig_and_bamptons_matrices(family, n_kept):
    found = family.vibrations(n_kept, 1000).values
    component = craig_bampton_component(family.component.leading(n_kept))
    exact = component.interfaces_free().spectrum
    assert found.size == exact.size - 6
    np.testing.assert_allclose(found, exact[6:], rtol=1e-6)


def test_vibrations_are_orthonormal_and_free_of_rigid_motion(family):
    body = family.body
    vibrations = family.vibrations(12, 10)
    Phi = family.vectors(vibrations)
    assert np.abs(Phi.T @ (body.mass @ Phi) - np.eye(10)).max() < 1e-9
    stiffness = Phi.T @ (body.stiffness @ Phi) / np.sqrt(np.outer(vibrations.values, vibrations.values))
    assert np.abs(stiffness - np.eye(10)).max() < 1e-6
    momentum = body.rigid_modes.T @ (body.mass @ Phi)
    weight = np.sqrt(np.diag(body.rigid_modes.T @ (body.mass @ body.rigid_modes)))
    assert np.abs(momentum / weight[:, None]).max() < 1e-9
    motion = np.vstack([interface.motion @ Phi for interface in body.interfaces])
    np.testing.assert_allclose(motion, vibrations.interfaces, atol=1e-8 * np.abs(motion).max())


def test_without_modes_one_interface_leaves_nothing_to_vibrate(request):
    family = CraigBamptonFamily(request.getfixturevalue("cantilever"))
    assert family.vibrations(0, 5).values.size == 0
    assert family.vibrations(3, 5).values.size == 3


def test_the_more_modes_the_lower_the_values(family):
    few, many = family.vibrations(8, 6).values, family.vibrations(16, 6).values
    assert np.all(many <= few * (1 + 1e-9))
    assert np.any(many < few * (1 - 1e-6))
