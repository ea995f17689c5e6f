"""Cases of a batch one by one, by the program of a single case.

Where a run keeps the tangent of its steps, cases that are mapped together would each make one at every
iterate: which case needs a new one is a branch that a map does not have. Of a body with 25 coordinates that
costs up to three times a case alone. So they stay alone, and share the program.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import jax
import numpy as np

from supple.multibody.compiled.programs import COMPILED_MARCH
from supple.multibody.compiled.state import Controls, State
from supple.multibody.equations.model import Model

__all__ = ["one_by_one"]


def one_by_one(
    models: Sequence[Model], settings: Controls, starts: Sequence[State], stops: np.ndarray
) -> Callable[[], tuple[State, State]]:
    """The march of cases, compiled: to their final states and those at the stops, stacked, cases in front."""
    program = COMPILED_MARCH.compiled(models[0], settings, starts[0], stops)

    def march() -> tuple[State, State]:
        ends = [
            jax.device_get(program(model, settings, start, stops))
            for model, start in zip(models, starts, strict=True)
        ]
        return jax.tree.map(lambda *leaves: np.stack(leaves), *ends)

    return march
