"""A matrix kept in blocks of columns: the products of the whole."""

from __future__ import annotations

import numpy as np

from supple.algebra import TallMatrix


def test_products_are_those_of_the_whole_matrix():
    rng = np.random.default_rng(0)
    blocks = tuple(rng.standard_normal((50, k)) for k in (3, 0, 1, 4))
    tall, whole = TallMatrix(blocks[:3]).with_block(blocks[3]), np.hstack(blocks)
    amounts, vectors = rng.standard_normal((8, 2)), rng.standard_normal((50, 5))
    assert tall.n_columns == 8
    np.testing.assert_allclose(tall.times(amounts), whole @ amounts, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(tall.transposed_times(vectors), whole.T @ vectors, rtol=1e-13, atol=1e-13)


def test_growing_copies_nothing():
    first = np.ones((4, 2))
    assert TallMatrix((first,)).with_block(np.zeros((4, 1))).blocks[0] is first
