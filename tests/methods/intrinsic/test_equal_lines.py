"""Lines of equal structure are evaluated together, with the results of each alone."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.methods.intrinsic import CLAMPED, intrinsic_body
from supple.methods.intrinsic.equal_lines import EqualLines, for_each_line

SECTION = {"EA": 1e4, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.05}


@pytest.fixture(scope="module")
def models():
    """Lines 0, 2 and 3 differ in numbers only."""
    sizes = ((1.0, 4), (1.0, 3), (1.5, 4), (2.0, 4))
    return [
        intrinsic_body(beam_line(straight(length, n), **SECTION), CLAMPED, 4).model for length, n in sizes
    ]


def test_models_keep_their_order(models):
    lines = EqualLines.of(models)
    assert lines.members == ((0, 2, 3), (1,))
    for own, other in zip(lines, models, strict=True):
        jax.tree.map(np.testing.assert_array_equal, own, other)


@pytest.mark.parametrize("odd", [None, 2])
def test_each_line_has_the_result_of_its_own_evaluation(models, odd):
    calls = []

    def function(model, state, load):
        calls.append(model)
        sum_ = model.omega @ state
        return {"sum": sum_ if load is None else sum_ + load, "strains": model.strains @ state}

    states = [jnp.arange(1.0, 1 + len(model.omega)) * k for k, model in enumerate(models, 1)]
    loads = [None if line == odd else jnp.asarray(float(line)) for line in range(4)]
    alone = for_each_line(function, models, states, loads)
    assert len(calls) == 4
    together = for_each_line(function, EqualLines.of(models), states, loads)
    # Line 1 has another size; the line without a load is evaluated by itself.
    assert len(calls) - 4 == (2 if odd is None else 3)
    for own, other in zip(together, alone, strict=True):
        jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-14), own, other)
