"""Packed tensors against the full internal force, f_r = V^T f(V gamma) [Wu2019] (49)."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse

from supple.errors import ModelError
from supple.fem import QuadraticStrain
from supple.reduction import (
    InternalForceTensors,
    internal_force_tensors,
    tensors,
    unpack_symmetric,
)


def random_tensors(r: int) -> InternalForceTensors:
    """Tensors of random strains; one constitutive matrix per element, as a laminate may have."""
    return internal_force_tensors(random_body(), np.random.default_rng(1).standard_normal((30, r)))


def assert_close(actual, expected):
    """Equal to 1e-12 of the largest entry."""
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def random_body():
    rng = np.random.default_rng(0)
    E, g, s, d, n_e, n = 7, 2, 3, 6, 9, 30
    form = rng.standard_normal((s, d, d))
    D = rng.standard_normal((E, s, s))
    block = QuadraticStrain(
        dofs=np.array([rng.choice(n, n_e, replace=False) for _ in range(E)]),
        B=rng.standard_normal((E, g, s, n_e)),
        G=rng.standard_normal((E, g, d, n_e)),
        N=form + form.swapaxes(1, 2),
        D=D @ D.swapaxes(1, 2),
        w=rng.random((E, g)),
    )
    gathered = np.eye(n)[block.dofs]
    strain = np.einsum("egsa,ean->egsn", block.B, gathered)
    stiffness = np.einsum("eg,egsn,est,egtm->nm", block.w, strain, block.D, strain)
    return SimpleNamespace(
        name="random",
        is_linear=False,
        force=SimpleNamespace(blocks=(block,), expansion=sparse.eye_array(n, format="csc")),
        stiffness=sparse.csc_array(stiffness),
        n=n,
    )


@pytest.mark.parametrize("body_name", ["strip_body", "solid_body"])
def test_force_and_tangent_are_those_of_the_full_body_projected(body_name, request):
    body = request.getfixturevalue(body_name)
    rng = np.random.default_rng(2)
    # Amplitudes at which the linear, quadratic and cubic forces are of one size.
    V = rng.standard_normal((body.n, 5)) * 0.1
    reduced = internal_force_tensors(body, V)
    for gamma in rng.standard_normal((3, 5)):
        q = V @ gamma
        force = V.T @ body.assembly.internal_force(q)
        tangent = V.T @ (body.assembly.tangent(q) @ V)
        assert_close(reduced.internal_force(gamma), force)
        assert_close(reduced.tangent(gamma), tangent)
        np.testing.assert_allclose(reduced.energy(gamma), body.assembly.energy(q), rtol=1e-12)


@pytest.mark.parametrize("body_name", ["strip_body", "solid_body"])
def test_material_stiffness_is_that_of_the_full_body_projected(body_name, request):
    """K_mat of the tensors before folding, and of the elements: the tangent without its geometric term."""
    body = request.getfixturevalue(body_name)
    rng = np.random.default_rng(3)
    V = rng.standard_normal((body.n, 5)) * 0.1
    products = tensors.strain_products(body, V)
    cubic, quartic = products.material(products.internal_force())
    j, k = np.triu_indices(5)
    for gamma in rng.standard_normal((3, 5)):
        gained = cubic @ gamma + quartic @ (gamma[j] * gamma[k])
        K_mat = products.stiffness + unpack_symmetric(gained, 5)
        assert_close(K_mat, V.T @ np.array([body.assembly.strain_rate_force(V @ gamma, v) for v in V.T]).T)
        assert np.linalg.eigvalsh(K_mat).min() > 0


def test_linear_body_has_no_material_tensors(strip_body):
    products = tensors.strain_products(strip_body.linearized(), np.eye(strip_body.n)[:, :2])
    assert products.material(products.internal_force()) == (None, None)


def test_force_is_the_gradient_of_energy_and_tangent_that_of_force():
    reduced = random_tensors(4)
    gamma = np.random.default_rng(3).standard_normal(4)
    steps = gamma + 1e-30j * np.eye(4)
    force = reduced.internal_force(gamma)
    tangent = reduced.tangent(gamma)
    np.testing.assert_allclose(reduced.energy(steps).imag / 1e-30, force, rtol=1e-12)
    np.testing.assert_allclose(reduced.internal_force(steps).imag / 1e-30, tangent, rtol=1e-11)
    np.testing.assert_array_equal(tangent, tangent.T)


def test_random_strains_give_their_own_energy():
    body = random_body()
    (block,) = body.force.blocks
    V = np.random.default_rng(1).standard_normal((30, 4))
    gamma = np.random.default_rng(4).standard_normal(4)
    q = (V @ gamma)[block.dofs]
    a = np.einsum("egdn,en->egd", block.G, q)
    strain = np.einsum("egsn,en->egs", block.B, q) + np.einsum("sdf,egd,egf->egs", block.N, a, a) / 2
    energy = np.einsum("eg,egs,est,egt->", block.w, strain, block.D, strain) / 2
    np.testing.assert_allclose(internal_force_tensors(body, V).energy(gamma), energy, rtol=1e-12)


def test_tangent_is_the_packed_formula_of_the_engine():
    reduced = random_tensors(4)
    gamma = np.random.default_rng(5).standard_normal(4)
    j, k = np.triu_indices(4)
    A3 = unpack_symmetric(reduced.cubic @ gamma, 4)
    A4 = unpack_symmetric(reduced.quartic @ (gamma[j] * gamma[k]), 4)
    np.testing.assert_allclose(reduced.stiffness + A3 + A4, reduced.tangent(gamma), rtol=1e-13)


def test_tensors_are_fully_symmetric():
    r = 3
    reduced = random_tensors(r)
    third = unpack_symmetric(reduced.cubic.T, r)
    j, k = np.triu_indices(r)
    fourth = unpack_symmetric((reduced.quartic * np.where(j == k, 2.0, 1.0)).T, r)
    fourth = unpack_symmetric(np.moveaxis(fourth, 0, -1), r)
    for axes in [(1, 0, 2), (0, 2, 1)]:
        assert_close(third, third.transpose(axes))
    for axes in [(1, 0, 2, 3), (0, 2, 1, 3), (0, 1, 3, 2)]:
        assert_close(fourth, fourth.transpose(axes))


def test_symmetrized_tensors_have_the_energy_of_the_published_ones_and_a_potential():
    r = 4
    rng = np.random.default_rng(8)
    n2 = r * (r + 1) // 2
    given = InternalForceTensors(np.eye(r), rng.standard_normal((n2, r)), rng.standard_normal((n2, n2)))
    symmetric = given.symmetrized()
    gamma = rng.standard_normal(r)
    np.testing.assert_allclose(symmetric.energy(gamma), given.energy(gamma), rtol=1e-12)
    gradient = given.energy(gamma + 1e-30j * np.eye(r)).imag / 1e-30
    np.testing.assert_allclose(symmetric.internal_force(gamma), gradient, rtol=1e-12)
    assert np.abs(given.internal_force(gamma) - gradient).max() > 0.1 * np.abs(gradient).max()
    again = symmetric.symmetrized()
    assert_close(again.quartic, symmetric.quartic)
    assert_close(again.cubic, symmetric.cubic)


def test_chunks_do_not_change_the_sum(monkeypatch):
    whole = random_tensors(4)
    monkeypatch.setattr(tensors, "CHUNK_BYTES", 1)
    np.testing.assert_allclose(random_tensors(4).quartic, whole.quartic, rtol=1e-12)


def test_linear_body_has_a_linear_force(strip_body):
    V = np.random.default_rng(6).standard_normal((strip_body.n, 3))
    reduced = internal_force_tensors(strip_body.linearized(), V)
    gamma = np.array([0.1, -2.0, 3.0])
    assert reduced.cubic is None
    assert reduced.quartic is None
    np.testing.assert_allclose(reduced.internal_force(gamma), reduced.stiffness @ gamma)
    np.testing.assert_allclose(reduced.energy(gamma), gamma @ reduced.stiffness @ gamma / 2)


def test_a_batch_of_coordinates_gives_a_batch_of_forces():
    reduced = random_tensors(4)
    batch = np.random.default_rng(7).standard_normal((2, 3, 4))
    forces = reduced.internal_force(batch)
    assert forces.shape == (2, 3, 4)
    np.testing.assert_allclose(forces[1, 2], reduced.internal_force(batch[1, 2]))
    assert reduced.tangent(batch).shape == (2, 3, 4, 4)


def test_basis_that_does_not_fit_is_refused():
    with pytest.raises(
        ModelError, match=r"basis of shape \(4, 2\) does not fit body 'random' with 30 freedoms"
    ):
        internal_force_tensors(random_body(), np.zeros((4, 2)))
