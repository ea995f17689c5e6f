"""Stages of a compiled step: the same numbers, and what they share is worked out once."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.methods.explicit.fusion_barrier import fusion_barrier


@pytest.mark.parametrize("first", [1.0, 0.0, -1e300, np.inf, np.nan])
def test_a_stage_answers_as_the_function_does_also_to_what_is_no_number(first):
    given = (jnp.array([first, 2.0]), jnp.array(3.0))
    found = jax.jit(lambda of: fusion_barrier(lambda both: (both[0] * both[1], both[1]), of))(given)
    np.testing.assert_array_equal(found[0], np.array([first, 2.0]) * 3.0)
    assert found[1] == 3.0


def test_what_follows_a_stage_does_not_repeat_its_work():
    """Sines that ten sums share: once in the program, where the stage stands."""

    def program(apart):
        def sums(x):
            return [jnp.sin(x + i) for i in range(3)]

        def many(x):
            shared = fusion_barrier(sums, x) if apart else sums(x)
            return [sum(weight * one for one in shared) for weight in range(1, 5)]

        return jax.jit(many).lower(jnp.ones(1000)).compile().as_text()

    apart = program(apart=True)
    assert "conditional(" in apart
    assert apart.count(" sine(") == 3
