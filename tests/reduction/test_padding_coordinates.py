"""Bodies filled up with padding coordinates: the same body, and nothing that tells how many it had."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest

from supple.body import MeanAxisFrame, RayleighDamping
from supple.equations.build_model import build_model
from supple.machine import Placed, System
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    InternalForceTensors,
    NoLoads,
    PlainQuartic,
    filled_up,
    padded,
    reduce,
)


@pytest.fixture(scope="module")
def reduced(averaging_body):
    """Damped by strain rate, so that it has all tensors there are."""
    damping = RayleighDamping(alpha=0.1, beta=1e-3)
    return {
        n: reduce(
            averaging_body,
            MeanAxisFrame(),
            CraigBampton(n),
            derivatives=CompressedDerivatives(3),
            quartic=PlainQuartic(),
            damping=damping,
            loads=NoLoads,
        )
        for n in (2, 3)
    }


@pytest.fixture(scope="module")
def pair(reduced):
    body = padded(reduced[2])
    assert body.padding == 24 - body.r > 0
    return body, filled_up(body)


def wide(body, gamma):
    return np.pad(gamma, [(0, 0), (0, body.padding)])


def test_forces_energy_and_tangent_are_those_of_the_body(pair):
    body, filled = pair
    gamma = 0.1 * np.random.default_rng(0).standard_normal((5, body.r))
    np.testing.assert_allclose(
        filled.tensors.energy(wide(body, gamma)), body.tensors.energy(gamma), rtol=1e-13
    )
    force = filled.tensors.internal_force(wide(body, gamma))
    np.testing.assert_allclose(force[:, : body.r], body.tensors.internal_force(gamma), rtol=1e-12)
    assert not force[:, body.r :].any()
    tangent = filled.tensors.tangent(wide(body, gamma))
    np.testing.assert_allclose(tangent[:, : body.r, : body.r], body.tensors.tangent(gamma), rtol=1e-12)
    assert not tangent[:, : body.r, body.r :].any()


def test_damping_is_that_of_the_body(pair):
    body, filled = pair
    gamma = 0.1 * np.random.default_rng(1).standard_normal((5, body.r))

    def resisting(one, at):
        return InternalForceTensors(one.damping, one.damping_cubic, one.damping_quartic).tangent(at)

    damped = resisting(filled, wide(body, gamma))
    np.testing.assert_allclose(damped[:, : body.r, : body.r], resisting(body, gamma), rtol=1e-12)
    assert not damped[:, body.r :].any()


def test_inertia_is_that_of_the_body_and_of_unit_masses(pair):
    body, filled = pair
    r, size = body.r, filled.r
    own = np.r_[: 6 + 3 * r, 6 + 3 * size : 6 + 3 * size + r]
    np.testing.assert_array_equal(filled.gram[np.ix_(own, own)], body.gram)
    rest = np.setdiff1d(np.arange(len(filled.gram)), own)
    carried = filled.gram[rest].sum(axis=1)
    np.testing.assert_array_equal(carried, np.repeat([0.0, 1.0], [3 * body.padding, body.padding]))


def test_shapes_and_interfaces_move_as_the_body(pair):
    body, filled = pair
    gamma = np.random.default_rng(2).standard_normal((2, body.r))
    np.testing.assert_allclose(filled.expand(wide(body, gamma)), body.expand(gamma), rtol=1e-13)
    for own, other in zip(body.interfaces, filled.interfaces, strict=True):
        np.testing.assert_allclose(other.motion @ wide(body, gamma).T, own.motion @ gamma.T, rtol=1e-12)


def test_arrays_of_nearby_sizes_have_one_structure(reduced):
    def structure(body):
        model = build_model(System((Placed(filled_up(padded(body))),)))
        leaves, tree = jax.tree.flatten(model)
        return tree, [np.shape(leaf) for leaf in leaves]

    two, three = (structure(reduced[n]) for n in (2, 3))
    assert reduced[2].r != reduced[3].r
    assert two == three


def test_bodies_are_padded_to_24_or_32_coordinates(reduced):
    body = reduced[2]
    filled = filled_up(padded(body))
    assert filled.padding == 0
    assert filled.r == 24
    wider = filled_up(padded(filled))
    assert wider.r == 32
    assert padded(wider) is wider
    assert filled_up(replace(body, padding=0)).r == body.r
