from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg, sparse

from supple.algebra import GrowingModes, RitzModes, constrained_factor, lowest_modes
from supple.errors import AccuracyError, ModelError


@pytest.fixture(scope="module")
def held(truss):
    """The truss held at one end: its inverse, its mass, and all its eigenvalues, dense."""
    n = truss.stiffness.shape[0]
    rows = np.eye(48, n)
    free = np.arange(48, n)
    exact = linalg.eigh(
        truss.mass[free][:, free].toarray(), truss.stiffness[free][:, free].toarray(), eigvals_only=True
    )
    inverse = constrained_factor(truss.stiffness, rows, truss.rigid_modes)
    return inverse, truss.mass, 1 / exact[::-1]


def test_the_modes_are_those_of_the_held_structure(held):
    inverse, mass, exact = held
    modes = GrowingModes(inverse, mass).at_least(40)
    k = modes.values.size
    assert 40 <= k < 200
    np.testing.assert_allclose(modes.values, exact[:k], rtol=1e-10)
    X = modes.vectors
    assert np.max(np.abs(X.T @ (mass @ X) - np.eye(k))) < 1e-12
    assert np.max(np.abs(inverse.constraint @ X)) < 1e-10 * np.max(np.abs(X))
    residual = inverse.solve(mass @ X) * modes.values - X
    assert np.max(np.sum(residual * (mass @ residual), axis=0)) < 1e-12


def test_more_modes_continue_the_same_space(held):
    inverse, mass, exact = held
    growing = GrowingModes(inverse, mass)
    few = growing.at_least(10)
    assert growing.at_least(10) is few
    many = growing.at_least(2 * few.values.size)
    # The very same arrays: a space that grows is not copied.
    assert few.basis.blocks == many.basis.blocks[: len(few.basis.blocks)]
    assert many.basis.n_columns > few.basis.n_columns
    np.testing.assert_allclose(many.values, exact[: many.values.size], rtol=1e-10)


def test_a_space_cut_down_to_its_modes_keeps_them_and_grows_on(held):
    inverse, mass, exact = held
    growing = GrowingModes(inverse, mass)
    before = growing.at_least(10)
    k = before.values.size
    growing.keep_modes_only()
    assert growing.basis.n_columns == k < before.basis.n_columns
    np.testing.assert_array_equal(growing.at_least(k).vectors, before.vectors)
    more = growing.at_least(40)
    assert k < more.values.size < 200
    np.testing.assert_allclose(more.values, exact[: more.values.size], rtol=1e-10)
    X = more.vectors
    assert np.max(np.abs(X.T @ (mass @ X) - np.eye(more.values.size))) < 1e-12
    residual = inverse.solve(mass @ X) * more.values - X
    assert np.max(np.sum(residual * (mass @ residual), axis=0)) < 1e-12


def test_all_modes_of_a_small_structure_are_found_at_last(held):
    inverse, mass, exact = held
    growing = GrowingModes(inverse, mass)
    everything = growing.at_least(growing.available)
    np.testing.assert_allclose(everything.values, exact, rtol=1e-9)
    with pytest.raises(ModelError, match="529 modes requested of a structure with 528 freedoms"):
        growing.at_least(529)


def test_every_copy_of_a_multiple_mode_is_found(chain):
    stiffness, _ = chain(401)
    three = sparse.block_diag([stiffness[1:, 1:]] * 3, format="csc")
    inverse = constrained_factor(three, np.zeros((0, 1200)))
    values = GrowingModes(inverse, sparse.eye_array(1200, format="csc")).at_least(30).values
    exact = 4 * np.sin((2 * np.arange(10) + 1) * np.pi / 1602) ** 2
    np.testing.assert_allclose(values[:30], np.repeat(exact, 3), rtol=1e-9)


@pytest.mark.parametrize("spread", [0.0, 1e-7, 1e-4])
def test_more_copies_than_a_block_has_columns_are_all_found(chain, spread):
    """Twenty chains, alike or nearly so: a Krylov space of eight columns holds eight copies and no more."""
    factors = 1 + spread * np.linspace(0, 1, 20)
    one = chain(101)[0][1:, 1:]
    twenty = sparse.block_diag([factor * one for factor in factors], format="csc")
    inverse = constrained_factor(twenty, np.zeros((0, 2000)))
    growing = GrowingModes(inverse, sparse.eye_array(2000, format="csc"))
    exact = np.outer(4 * np.sin((2 * np.arange(100) + 1) * np.pi / 402) ** 2, factors).ravel()
    for n_modes in (5, 30):
        values = growing.at_least(n_modes).values
        np.testing.assert_allclose(values, np.sort(exact)[: values.size], rtol=1e-9)


@pytest.mark.parametrize("n", [1, 7, 9])
def test_a_structure_smaller_than_a_block(chain, n):
    held_chain = sparse.csc_array(chain(n + 1)[0][1:, 1:])
    growing = GrowingModes(
        constrained_factor(held_chain, np.zeros((0, n))), sparse.eye_array(n, format="csc")
    )
    exact = 4 * np.sin((2 * np.arange(n) + 1) * np.pi / (4 * n + 2)) ** 2
    np.testing.assert_allclose(growing.at_least(1).values, exact, rtol=1e-9)


def test_modes_need_not_be_formed_to_be_used(held):
    inverse, mass, _ = held
    rng = np.random.default_rng(1)
    modes = GrowingModes(inverse, mass).at_least(12)
    loads, amounts = rng.standard_normal((inverse.n, 3)), rng.standard_normal((modes.values.size, 2))
    np.testing.assert_allclose(modes.participation(loads), modes.vectors.T @ loads, atol=1e-10)
    np.testing.assert_allclose(modes.combine(amounts), modes.vectors @ amounts, atol=1e-12)


def test_modes_known_as_vectors(held):
    inverse, mass, _ = held
    known = lowest_modes(inverse.grounded.stiffness, mass, 5, constraint=inverse.constraint)
    modes = RitzModes.of(known)
    np.testing.assert_array_equal(modes.vectors, known.vectors)
    np.testing.assert_array_equal(modes.values, known.values)


def test_motions_without_mass_are_refused(held):
    inverse, _, _ = held
    few = np.zeros(inverse.n)
    few[-3:] = 1.0
    with pytest.raises(AccuracyError, match="some motion has no mass"):
        GrowingModes(inverse, sparse.diags_array(few, format="csc")).at_least(5)
