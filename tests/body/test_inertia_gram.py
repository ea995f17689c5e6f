from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.body import flexible_body, inertia_gram
from supple.errors import ModelError

R_COLUMNS = 4


@pytest.fixture
def motion():
    rng = np.random.default_rng(0)
    return {
        "v": rng.standard_normal(3),
        "omega": rng.standard_normal(3),
        "gamma": rng.standard_normal(R_COLUMNS),
        "rate": rng.standard_normal(R_COLUMNS),
    }


def coefficients(v, omega, gamma, rate):
    """z = (v, w, gamma_1 w, ..., gamma_r w, gamma')."""
    return np.concatenate([v, omega, np.outer(gamma, omega).ravel(), rate])


def basis(body):
    return np.random.default_rng(1).standard_normal((body.n, R_COLUMNS))


@pytest.mark.parametrize("model", ["shell", "solid"])
def test_kinetic_energy_of_any_motion(request, model, motion):
    # Node by node: V_a = v + w x (x_a + u_a) + u'_a, and nodes that turn to second order in theta_a.
    body = flexible_body(model, request.getfixturevalue(model))
    V = basis(body)
    d, w = body.dofs_per_node, motion["omega"]
    q, rate = ((V @ motion[name]).reshape(-1, d) for name in ("gamma", "rate"))
    velocity = rate.copy()
    velocity[:, :3] += motion["v"] + np.cross(w, body.nodes + q[:, :3])
    second = 0.0
    if d == 6:
        theta = q[:, 3:]
        velocity[:, 3:] += w + np.cross(w, theta)
        rotary = body.nodal_mass.toarray().reshape(-1, 6, len(theta), 6)[:, 3:, :, 3:]
        for (a, b), inertia in zip(
            np.ndindex(len(theta), len(theta)), rotary.swapaxes(1, 2).reshape(-1, 3, 3), strict=True
        ):
            turned = np.cross(theta[a], np.cross(theta[b], w)) - np.cross(theta[a], rate[b, 3:])
            second += w @ inertia @ turned / 2
    energy = 0.5 * velocity.ravel() @ (body.nodal_mass @ velocity.ravel()) + second
    z = coefficients(**motion)
    assert 0.5 * z @ inertia_gram(body, V) @ z == pytest.approx(energy, rel=1e-12)


def test_the_energy_is_the_same_in_global_components(solid, motion):
    # r_a = R + A (x_a + u_a), r'_a by central difference of the true finite motion.
    body = flexible_body("block", solid)
    V = basis(body)
    A0 = Rotation.from_rotvec([0.3, -1.0, 0.7])

    def positions(t):
        A = A0 * Rotation.from_rotvec(t * motion["omega"])
        u = (V @ (motion["gamma"] + t * motion["rate"])).reshape(-1, 3)
        return t * A0.apply(motion["v"]) + A.apply(body.nodes + u)

    h = 1e-5
    velocity = (positions(h) - positions(-h)).ravel() / (2 * h)
    energy = 0.5 * velocity @ (body.nodal_mass @ velocity)
    z = coefficients(**motion)
    assert 0.5 * z @ inertia_gram(body, V) @ z == pytest.approx(energy, rel=1e-8)


def test_the_rigid_block_is_mass_first_moment_and_inertia(solid):
    body = flexible_body("block", solid)
    gram = inertia_gram(body, np.zeros((body.n, 0)))
    low, high = body.nodes.min(axis=0), body.nodes.max(axis=0)
    size, centre = high - low, (low + high) / 2
    mass = 2700.0 * np.prod(size)
    np.testing.assert_allclose(gram[:3, :3], mass * np.eye(3), atol=1e-9 * mass)
    x, y, z = mass * centre
    np.testing.assert_allclose(gram[:3, 3:], [[0, z, -y], [-z, 0, x], [y, -x, 0]], atol=1e-9 * mass)
    second = mass * (np.diag(size**2) / 12 + np.outer(centre, centre))
    np.testing.assert_allclose(gram[3:, 3:], np.trace(second) * np.eye(3) - second, atol=1e-9 * mass)


def test_blocks_stand_in_their_order(body):
    V = basis(body)
    gram = inertia_gram(body, V)
    assert gram.shape == (6 + 4 * R_COLUMNS,) * 2
    np.testing.assert_array_equal(gram, gram.T)
    np.testing.assert_allclose(gram[-R_COLUMNS:, -R_COLUMNS:], V.T @ body.mass @ V, rtol=1e-12)
    np.testing.assert_allclose(gram[:6, -R_COLUMNS:], body.rigid_modes.T @ body.mass @ V, rtol=1e-10)


def test_a_basis_of_the_wrong_length(body):
    with pytest.raises(
        ModelError, match=rf"the basis has shape \(5, 2\); body '{body.name}' has {body.n} coordinates"
    ):
        inertia_gram(body, np.ones((5, 2)))
