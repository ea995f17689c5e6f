"""Every law is a pytree of numbers, and differentiable twice in time."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.machine import Constant, Ramp, Scaled, Sine, SpinUp, Spline, Table, Turning

ROWS = np.array([0.0, 0.7, 1.5, 3.0])
Z = (0.0, 0.0, 1.0)

# Each law twice, with other numbers: one program must serve both.
PAIRS = {
    "constant": (Constant(2.0), Constant(-1.0)),
    "constant vector": (Constant([1.0, 2.0, 3.0]), Constant([0.0, 1.0, 0.0])),
    "table": (Table(ROWS, ROWS**2), Table(1.1 * ROWS, -ROWS)),
    "spline": (Spline(ROWS, np.sin(ROWS)), Spline(1.1 * ROWS, ROWS**2)),
    "ramp": (Ramp(4.0, 2.5), Ramp(-1, 3)),
    "sine": (Sine(2.0, 0.3), Sine(1, 1)),
    "spin-up": (SpinUp(6.0, 2.0), SpinUp(-2, 4)),
    "scaled": (Scaled([1.0, 2.0, 0.0], Sine(2.0, 0.3)), Scaled([0.0, 2.0, 1.0], Sine(1.0, 1.0))),
    "turning": (
        Turning(Table([0.0, 3.0], np.eye(3)[:2]), Z, SpinUp(6.0, 2.0)),
        Turning(Table([0.0, 3.3], np.eye(3)[1:]), (1.0, 0.0, 0.0), SpinUp(1.0, 2.0)),
    ),
}
each_pair = pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS.keys())
# Away from rows and ends, where a difference over both sides would straddle two pieces.
TIMES = np.array([0.35, 1.1, 1.9, 2.2])


@each_pair
def test_other_numbers_are_other_leaves_of_one_structure(pair):
    first, second = pair
    assert jax.tree.structure(first) == jax.tree.structure(second)
    shapes = [[(np.shape(leaf), np.result_type(leaf)) for leaf in jax.tree.leaves(law)] for law in pair]
    assert shapes[0] == shapes[1]
    assert any(not np.array_equal(a, b) for a, b in zip(*map(jax.tree.leaves, pair), strict=True))


@each_pair
def test_one_compiled_program_serves_laws_that_differ_in_numbers(pair):
    program = jax.jit(lambda law, time: law(time))
    values = [np.asarray(program(law, 1.1)) for law in pair]
    assert program._cache_size() == 1
    for law, value in zip(pair, values, strict=True):
        np.testing.assert_allclose(value, law(1.1), atol=1e-14)
    assert not np.allclose(*values)


@each_pair
def test_laws_go_through_flattening_unchanged(pair):
    law = pair[0]
    leaves, structure = jax.tree.flatten(law)
    again = jax.tree.unflatten(structure, leaves)
    assert type(again) is type(law)
    np.testing.assert_array_equal(again(1.1), law(1.1))
    assert (again.begin, again.end) == (law.begin, law.end)


@pytest.mark.parametrize(
    "pair",
    [
        pytest.param(PAIRS[name], marks=() if name == "turning" else pytest.mark.slow, id=name)
        for name in PAIRS
    ],
)
def test_laws_can_be_mapped_over(pair):
    stacked = jax.tree.map(lambda *leaves: jnp.stack(leaves), *pair)
    np.testing.assert_allclose(
        jax.jit(jax.vmap(lambda law: law(1.1)))(stacked), np.stack([law(1.1) for law in pair]), atol=1e-14
    )


@pytest.mark.slow
@each_pair
def test_derivatives_are_those_of_finite_differences(pair):
    """Central differences of step h are off by O(h^2) and round-off/h."""
    step = 1e-5
    for law in pair:
        rate = jax.jacfwd(lambda time, law=law: jnp.asarray(law(time)))
        acceleration = jax.jacfwd(rate)
        for time in TIMES:
            difference = (np.asarray(law(time + step)) - np.asarray(law(time - step))) / (2 * step)
            np.testing.assert_allclose(rate(time), difference, rtol=1e-7, atol=1e-7)
            difference = (np.asarray(rate(time + step)) - np.asarray(rate(time - step))) / (2 * step)
            np.testing.assert_allclose(acceleration(time), difference, rtol=1e-6, atol=1e-6)


def test_gradients_reach_the_numbers_of_a_law():
    """d/dA A sin(2 pi f t) = sin(2 pi f t), and of a ramp's value its polynomial."""
    gradient = jax.jit(jax.grad(lambda law: law(0.2)))(Sine(3.0, 0.7))
    assert float(gradient.amplitude) == pytest.approx(np.sin(2 * np.pi * 0.7 * 0.2), abs=1e-15)
    assert float(jax.jit(jax.grad(lambda law: law(1.0)))(Ramp(3.0, 2.0)).value) == pytest.approx(
        0.5, abs=1e-15
    )
