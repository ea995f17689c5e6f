"""Static modal derivatives: second derivatives of the nonlinear static motion [Wu2019] (39)-(43)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import frame_projector
from supple.errors import ModelError
from supple.reduction import CraigBampton, NormalModes, Rubin, modal_derivatives, rayleigh_ritz
from supple.reduction.bases.interface_columns import motion_rows


def linear_basis(body, frame, recipe):
    return rayleigh_ritz(body, frame, recipe.build(body, frame))


@pytest.mark.parametrize("body_name", ["cantilever", "solid_body"])
def test_derivatives_are_second_differences_of_the_nonlinear_static_motion(
    body_name, frame, request, nonlinear_static
):
    """f(q) + D^T mu = K (zeta_j X_j + zeta_k X_k): differences converge with h^2, extrapolate to theta."""
    body = request.getfixturevalue(body_name)
    D = frame.constraint(body)
    basis = linear_basis(body, frame, NormalModes(2))
    theta = modal_derivatives(body, frame, basis).vectors
    loads = body.stiffness @ basis.vectors
    length = np.ptp(body.nodes[:, 0])

    def second_differences(h):
        signs = (-1, 0, 1)
        q = {(a, b): nonlinear_static(body, D, h * loads @ (a, b)) for a in signs for b in signs if a or b}
        mixed = (q[1, 1] - q[1, -1] - q[-1, 1] + q[-1, -1]) / 4
        return np.column_stack([q[1, 0] + q[-1, 0], mixed, q[0, 1] + q[0, -1]]) / h**2

    h = 1e-3 * length / np.abs(body.expansion @ basis.vectors).max()
    coarse, fine = second_differences(2 * h), second_differences(h)
    scale = np.abs(theta).max()
    assert 3.5 < np.abs(coarse - theta).max() / np.abs(fine - theta).max() < 4.5
    np.testing.assert_allclose((4 * fine - coarse) / 3, theta, atol=1e-4 * scale)


def nodal_fields(body, vectors):
    return (body.expansion @ vectors).reshape(len(body.nodes), 6, -1)


def test_derivative_of_two_bending_modes_of_a_strip_is_the_foreshortening(cantilever, root_frame):
    """theta_jk = d2u/dzeta_j dzeta_k = -int_0^x w_j' w_k' dx along the strip, and no bending.

    Poisson's ratio is zero and membrane strains see the slopes of linear triangles, so the sum below is
    exact but for the small difference of slopes across the width.
    """
    modes = linear_basis(cantilever, root_frame, NormalModes(3))
    bending = replace(modes, vectors=modes.vectors[:, [0, 2]], frequencies=modes.frequencies[[0, 2]])
    derivatives = modal_derivatives(cantilever, root_frame, bending)
    axis = np.flatnonzero(np.abs(cantilever.nodes[:, 1]) < 1e-9)
    axis = axis[np.argsort(cantilever.nodes[axis, 0])]
    x = cantilever.nodes[axis, 0]
    w = nodal_fields(cantilever, bending.vectors)[axis, 2]
    slopes = np.diff(w, axis=0) / np.diff(x)[:, None]
    theta = nodal_fields(cantilever, derivatives.vectors)
    for column, (j, k) in enumerate(derivatives.pairs):
        shortening = -np.cumsum(slopes[:, j] * slopes[:, k] * np.diff(x))
        largest = np.abs(shortening).max()
        np.testing.assert_allclose(theta[axis[1:], 0, column], shortening, atol=2e-3 * largest)
        # The modes' own membrane strain is round-off, but membranes are 2000 times as stiff as bending.
        assert np.abs(theta[:, 2:5, column]).max() < 1e-5 * largest


def test_first_bending_mode_shortens_as_the_beam_does(cantilever, root_frame):
    """u(L) / w(L)^2 = -int_0^L w'^2 dx for the first mode of a clamped-free beam with w(L) = 1."""
    basis = linear_basis(cantilever, root_frame, NormalModes(1))
    theta = modal_derivatives(cantilever, root_frame, basis).vectors
    tip = np.argmax(cantilever.nodes[:, 0])
    deflection = nodal_fields(cantilever, basis.vectors)[tip, 2, 0]
    shortening = nodal_fields(cantilever, theta)[tip, 0, 0]
    b = 1.8751040687
    sigma = (np.sinh(b) - np.sin(b)) / (np.cosh(b) + np.cos(b))
    x = np.linspace(0.0, 1.0, 20001)
    slope = b * (np.sinh(b * x) + np.sin(b * x) - sigma * (np.cosh(b * x) - np.cos(b * x))) / 2
    np.testing.assert_allclose(shortening / deflection**2, -np.trapezoid(slope**2, x) / 10.0, rtol=0.01)


def test_derivatives_stay_in_the_frame_and_are_symmetric(solid_body, frame):
    basis = linear_basis(solid_body, frame, Rubin(n_modes=2))
    derivatives = modal_derivatives(solid_body, frame, basis)
    projected = frame_projector(solid_body, frame)(derivatives.vectors)
    scale = np.abs(derivatives.vectors).max()
    np.testing.assert_allclose(projected, derivatives.vectors, atol=1e-10 * scale)
    swapped = solid_body.assembly.tangent_derivative(basis.vectors[:, 1]) @ basis.vectors[:, 0]
    direct = solid_body.assembly.tangent_derivative(basis.vectors[:, 0]) @ basis.vectors[:, 1]
    np.testing.assert_allclose(swapped, direct, atol=1e-9 * np.abs(direct).max())
    theta = derivatives.vectors[:, 1]
    assert tuple(derivatives.pairs[1]) == (0, 1)
    D = frame.constraint(solid_body)
    residual = solid_body.stiffness @ theta + direct
    multipliers = np.linalg.lstsq(D.T, residual, rcond=None)[0]
    np.testing.assert_allclose(residual, D.T @ multipliers, atol=1e-7 * np.abs(direct).max())


def test_derivatives_of_a_craig_bampton_basis_hold_the_interfaces(strip_body, root_frame):
    basis = linear_basis(strip_body, root_frame, CraigBampton(n_modes=3))
    derivatives = modal_derivatives(strip_body, root_frame, basis)
    motion = motion_rows(strip_body.interfaces) @ derivatives.vectors
    assert np.abs(motion).max() < 1e-9 * np.abs(derivatives.vectors).max()


def test_every_pair_once_and_in_packed_order(cantilever, root_frame):
    basis = linear_basis(cantilever, root_frame, NormalModes(3))
    derivatives = modal_derivatives(cantilever, root_frame, basis)
    assert derivatives.pairs.tolist() == [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]]
    assert derivatives.labels[1] == "derivative 1-2"
    assert derivatives.multiplicity.tolist() == [1, 2, 2, 1, 2, 1]


def test_linear_body_has_no_derivatives(cantilever, root_frame):
    linear = cantilever.linearized()
    basis = linear_basis(linear, root_frame, NormalModes(2))
    with pytest.raises(
        ModelError, match=r"no quadratic strains .* reduce it with derivatives=NoDerivatives\(\)"
    ):
        modal_derivatives(linear, root_frame, basis)
