"""Cases of a batch one by one by the program of a single case, on all cores.

Where a run keeps the tangent of its steps, cases that are mapped together would each make one at every
iterate: which case needs a new one is a branch that a map does not have. Of a body with 25 coordinates that
costs three times a case alone. So they stay alone, and share the program and the processor's cores instead.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

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

    def of_case(case: tuple[Model, State]) -> tuple[State, State]:
        model, start = case
        return jax.device_get(program(model, settings, start, stops))

    def march() -> tuple[State, State]:
        with ThreadPoolExecutor(_cores()) as pool:
            ends = list(pool.map(of_case, zip(models, starts, strict=True)))
        return jax.tree.map(lambda *leaves: np.stack(leaves), *ends)

    return march


def _cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
