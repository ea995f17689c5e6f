"""Cases that take turns: the same numbers, and a branch that only those take that need it."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.methods.floating.compiled.newton import sequential_vmap


class Weighted(NamedTuple):
    values: jax.Array
    weight: float


def halved_or_not(given, wanted):
    return jax.lax.cond(wanted, lambda: given.values * given.weight, lambda: jnp.zeros_like(given.values))


def one_case(values, wanted):
    return sequential_vmap(halved_or_not, Weighted(values, 0.5), wanted)


def test_mapped_cases_have_the_answers_of_single_ones():
    values, wanted = jnp.arange(6.0).reshape(3, 2), jnp.array([True, False, True])
    answers = jax.jit(jax.vmap(one_case))(values, wanted)
    np.testing.assert_array_equal(answers, [[0.0, 0.5], [0.0, 0.0], [2.0, 2.5]])
    np.testing.assert_array_equal(one_case(values[2], wanted[2]), answers[2])


def test_a_condition_stays_a_branch():
    values, wanted = jnp.ones((3, 2)), jnp.array([True, False, True])
    assert "cond[" in str(jax.make_jaxpr(jax.vmap(one_case))(values, wanted))
    mapped = jax.vmap(lambda v, w: halved_or_not(Weighted(v, 0.5), w))
    assert "cond[" not in str(jax.make_jaxpr(mapped)(values, wanted)), "without, both sides are computed"
