"""Blocks of the quartic tensor: the matrix without its zeros, of which a symmetric body has many."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from supple.body import MeanAxisFrame
from supple.equations.polynomial_force import polynomial_energy, polynomial_force
from supple.reduction import CompressedDerivatives, NoLoads, Rubin, reduce
from supple.reduction.pair_blocks import PairBlocks, pair_blocks

R = 16
N2 = R * (R + 1) // 2


def products(blocks, g):
    """(r, r): each pair's product with the matrix."""
    by_pair = [
        matrix @ (g[first] * g[second])
        for first, second, matrix in zip(blocks.first, blocks.second, blocks.matrices, strict=True)
    ]
    return np.concatenate([*by_pair, [0.0]])[blocks.position]


def split(packed) -> PairBlocks:
    blocks = pair_blocks(packed)
    assert isinstance(blocks, PairBlocks)
    return blocks


@pytest.fixture
def mixed():
    """Three classes of 60, 50 and 5 pairs in an order of chance, and pairs without a number."""
    rng = np.random.default_rng(4)
    order = rng.permutation(N2)
    packed = np.zeros((N2, N2))
    for members in np.split(order, [60, 110, 115])[:3]:
        packed[np.ix_(members, members)] = rng.standard_normal((len(members), len(members)))
    return packed


def test_blocks_multiply_as_the_matrix_does(mixed):
    blocks = split(mixed)
    assert sorted(len(matrix) for matrix in blocks.matrices) == [5, 50, 60]
    g = np.random.default_rng(5).standard_normal(R)
    first, second = np.triu_indices(R)
    whole = np.zeros((R, R))
    whole[first, second] = whole[second, first] = mixed @ (g[first] * g[second])
    np.testing.assert_allclose(products(blocks, g), whole, rtol=1e-13)


def test_a_matrix_without_zeros_stays_whole(mixed):
    full = mixed + 1.0
    assert pair_blocks(full) is full
    few = np.eye(6)
    assert pair_blocks(few) is few


def test_a_matrix_of_zeros_has_no_blocks():
    blocks = split(np.zeros((N2, N2)))
    assert blocks.matrices == ()
    np.testing.assert_array_equal(products(blocks, np.ones(R)), 0.0)


@pytest.fixture(scope="module")
def symmetric(strip_body):
    return reduce(
        strip_body, MeanAxisFrame(), Rubin(n_columns=12), derivatives=CompressedDerivatives(8), loads=NoLoads
    )


def test_two_planes_of_symmetry_leave_a_quarter(symmetric):
    """Even or odd in two planes: four classes of pairs."""
    blocks = symmetric.quartic_blocks
    assert isinstance(blocks, PairBlocks)
    assert sum(matrix.size for matrix in blocks.matrices) < 0.4 * symmetric.quartic.size


def test_blocks_give_force_tangent_and_energy_of_the_tensors(symmetric):
    body = symmetric
    g = 0.1 * np.random.default_rng(6).standard_normal(body.r)
    force, tangent = polynomial_force(body.stiffness, body.cubic, body.quartic_blocks, g)
    expected, matrix = body.tensors.internal_force(g), body.tensors.tangent(g)
    np.testing.assert_allclose(force, expected, rtol=0, atol=1e-13 * np.abs(expected).max())
    np.testing.assert_allclose(tangent, matrix, rtol=0, atol=1e-13 * np.abs(matrix).max())
    energy = polynomial_energy(body.stiffness, body.cubic, body.quartic_blocks, g)
    np.testing.assert_allclose(energy, body.tensors.energy(g), rtol=1e-12)

    def strain_energy(q):
        return polynomial_energy(body.stiffness, body.cubic, body.quartic_blocks, q)

    gradient = jax.jit(jax.grad(strain_energy))(g)
    np.testing.assert_allclose(force, gradient, rtol=0, atol=1e-12 * np.abs(expected).max())
