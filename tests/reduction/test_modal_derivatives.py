"""Static modal derivatives: second derivatives of the nonlinear static motion [Wu2019] (39)-(43)."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import frame_projector
from supple.errors import ModelError
from supple.reduction import CraigBampton, NormalModes, Rubin, modal_derivatives, vibrating_basis
from supple.reduction.interface_columns import motion_rows


def linear_basis(body, frame, recipe):
    return vibrating_basis(body, frame, recipe.build(body, frame))


def nonlinear_static(body, D, load):
    """Newton's method on f(q) + D^T mu = F, D q = 0, dense."""
    n, m = D.shape[1], D.shape[0]
    scale = body.stiffness.diagonal().mean()
    q, mu = np.zeros(n), np.zeros(m)
    for _ in range(30):
        residual = np.concatenate([body.assembly.internal_force(q) + scale * D.T @ mu - load, scale * D @ q])
        tangent = np.block([[body.assembly.tangent(q).toarray(), scale * D.T], [scale * D, np.zeros((m, m))]])
        step = np.linalg.solve(tangent, -residual)
        q, mu = q + step[:n], mu + step[n:]
        if np.abs(step[:n]).max() < 1e-12 * np.abs(q).max():
            return q
    raise AssertionError("Newton's method did not converge")


@pytest.mark.parametrize("body_name", ["cantilever", "solid_body"])
def test_derivatives_are_second_differences_of_the_nonlinear_static_motion(body_name, frame, request):
    """f(q) + D^T mu = zeta_j K X_j + zeta_k K X_k; central differences converge with h^2."""
    body = request.getfixturevalue(body_name)
    D = frame.constraint(body)
    basis = linear_basis(body, frame, NormalModes(2))
    derivatives = modal_derivatives(body, frame, basis)
    loads = body.stiffness @ basis.vectors
    size = 1.0 / np.abs(body.expansion @ basis.vectors).max()

    def motion(zeta):
        return nonlinear_static(body, D, loads @ zeta)

    errors = []
    for h in (2e-2 * size, 1e-2 * size):
        e0, e1 = h * np.eye(2)
        difference = (
            np.column_stack(
                [
                    motion(e0) + motion(-e0),
                    (motion(e0 + e1) - motion(e0 - e1) - motion(e1 - e0) + motion(-e0 - e1)) / 4,
                    motion(e1) + motion(-e1),
                ]
            )
            / h**2
        )
        errors.append(np.abs(difference - derivatives.vectors).max() / np.abs(derivatives.vectors).max())
    assert errors[1] < 1e-3
    assert 3.0 < errors[0] / errors[1] < 5.0


def test_derivative_of_two_bending_modes_of_a_strip_is_the_foreshortening(cantilever, root_frame):
    """theta_jk = d2u/dzeta_j dzeta_k = -int_0^x w_j' w_k' dx along the strip, and nothing else.

    Poisson's ratio is zero, and the membrane strain sees the slopes of linear triangles: the sum below is exact.
    """
    basis = linear_basis(cantilever, root_frame, NormalModes(2))
    derivatives = modal_derivatives(cantilever, root_frame, basis)
    axis = np.flatnonzero(np.abs(cantilever.nodes[:, 1]) < 1e-9)
    axis = axis[np.argsort(cantilever.nodes[axis, 0])]

    def field(vectors):
        return (cantilever.expansion @ vectors).reshape(len(cantilever.nodes), 6, -1)

    x, w = cantilever.nodes[axis, 0], field(basis.vectors)[axis, 2]
    slopes = np.diff(w, axis=0) / np.diff(x)[:, None]
    theta = field(derivatives.vectors)
    for column, (j, k) in enumerate(derivatives.pairs):
        shortening = -np.cumsum(slopes[:, j] * slopes[:, k] * np.diff(x))
        np.testing.assert_allclose(
            theta[axis[1:], 0, column], shortening, atol=2e-3 * np.abs(shortening).max()
        )
        bending = np.abs(theta[:, 2:5, column]).max()
        assert bending < 1e-9 * np.abs(theta[:, 0, column]).max()


def test_bending_modes_of_a_cantilever_shorten_as_the_beam_does(cantilever, root_frame):
    """The first clamped-free mode, unit tip deflection: int_0^L w'^2 dx = 4.6478 / (4 L) ... in closed form."""
    basis = linear_basis(cantilever, root_frame, NormalModes(1))
    derivatives = modal_derivatives(cantilever, root_frame, basis)
    tip = np.argmax(cantilever.nodes[:, 0] - np.abs(cantilever.nodes[:, 1]))
    deflection = (cantilever.expansion @ basis.vectors).reshape(-1, 6)[tip, 2]
    shortening = (cantilever.expansion @ derivatives.vectors).reshape(-1, 6)[tip, 0]
    b = 1.8751040687
    x = np.linspace(0.0, 1.0, 20001)
    sigma = (np.sinh(b) - np.sin(b)) / (np.cosh(b) + np.cos(b))
    w = np.cosh(b * x) - np.cos(b * x) - sigma * (np.sinh(b * x) - np.sin(b * x))
    slope = b * (np.sinh(b * x) + np.sin(b * x) - sigma * (np.cosh(b * x) - np.cos(b * x))) / w[-1]
    expected = -np.trapezoid(slope**2, x) / 10.0
    np.testing.assert_allclose(shortening / deflection**2, expected, rtol=0.01)


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
    derivatives = modal_derivatives(
        cantilever, root_frame, linear_basis(cantilever, root_frame, NormalModes(3))
    )
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
