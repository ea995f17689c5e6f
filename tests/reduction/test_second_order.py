"""The energy to second order in some coordinates: its remainder is of third order in them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import MeanAxisFrame, RayleighDamping
from supple.reduction import CompressedDerivatives, NoLoads, Rubin, reduce
from supple.reduction.second_order import second_order_beyond

LEADING = 6


@pytest.fixture(scope="module")
def body(strip_body):
    """A strip in coordinates without symmetry: every entry of its tensors is present."""
    return reduce(
        strip_body,
        MeanAxisFrame(),
        Rubin(n_columns=12),
        derivatives=CompressedDerivatives(8),
        damping=RayleighDamping(0.0, 1e-3),
        loads=NoLoads,
    )


def at(body, size):
    """Coordinates of one size, those beyond the first scaled by `size`, and their rates."""
    g = np.random.default_rng(3).standard_normal((2, body.r)) / body.frequencies
    g[:, LEADING:] *= size
    return g


def test_the_remainder_is_of_third_order(body):
    """Energy and dissipation lose terms of third order: halved coordinates leave an eighth."""
    short = second_order_beyond(body, LEADING)

    def left(size):
        g, rates = at(body, size)
        lost = body.tensors.energy(g) - short.tensors.energy(g)
        damping = [
            replace(each.tensors, cubic=each.damping_cubic, quartic=each.damping_quartic).tangent(g)
            for each in (body, short)
        ]
        return np.array([lost, rates @ (damping[0] - damping[1]) @ rates])

    np.testing.assert_allclose(left(2e-3) / left(1e-3), 8.0, rtol=0.02)
    assert np.all(left(0.0) == 0.0)


def test_its_force_is_the_gradient_of_its_energy(body):
    """The truncated tensors are symmetric: the body is checked when it is built."""
    short = second_order_beyond(body, LEADING)
    g, change = at(body, 0.5)
    step = 1e-20
    slope = short.tensors.energy(g + 1j * step * change).imag / step
    np.testing.assert_allclose(short.tensors.internal_force(g) @ change, slope, rtol=1e-12)


def test_its_blocks_are_those_of_the_present_orders(body):
    """(aa|all), (ad|aa), (ad|ad) and (dd|aa): the whole matrix has also (ad|dd), (dd|ad) and (dd|dd)."""
    first, second = np.triu_indices(body.r)
    dense = replace(body, quartic=np.ones_like(body.quartic) * np.where(first == second, 0.5, 1.0))
    blocks = second_order_beyond(dense, LEADING).quartic_blocks
    aa, ad, dd = 21, 6 * 14, 105
    assert [matrix.shape for matrix in blocks.matrices] == [(dd, aa), (ad, aa + ad), (aa, aa + ad + dd)]


def test_nothing_changes_without_coordinates_beyond_or_tensors(body):
    for name in ("cubic", "quartic", "damping_cubic", "damping_quartic"):
        np.testing.assert_array_equal(getattr(second_order_beyond(body, body.r), name), getattr(body, name))
    linear = replace(body, cubic=None, quartic=None, damping_cubic=None, damping_quartic=None)
    assert second_order_beyond(linear, LEADING) is linear
