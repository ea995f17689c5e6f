"""Cases of a batch in shares, each computed by one call of a compiled program.

The cases of a share, at most a chunk, are mapped together (`jax.vmap`). From 16 velocities on, a CPU solves
Newton's linear equations case by case, and only for cases not yet converged (`sequential_vmap`). A smaller
last share repeats its last case, so that all shares use one compiled program.

With a frozen tangent, all mapped cases would compute a new tangent at every iterate: a map cannot branch for
the case that needs one. For a body with 25 coordinates, a mapped case would cost up to three times as much as
a single run. Such cases are therefore not mapped, and use the program of a single case.

The cases are not the innermost axis of the arrays. If they were, vector instructions could work on several
cases at once, but the most expensive part, the inverse of a tangent, would be slower: with 31 unknowns it
took 33 us per case for 8 or 16 cases together, and 18 us for one case after the other. One matrix stays in
the nearest cache, the matrices of many cases do not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import jax
import numpy as np

from supple.equations.compiler_options import MARCHING
from supple.equations.machine_model import Model
from supple.methods.floating.compiled.batch_start import Axes, BatchStart, stacked
from supple.methods.floating.compiled.programs import COMPILED_MARCH
from supple.methods.floating.compiled.state import Controls, State
from supple.programs.program_cache import Arguments, CachedProgram
from supple.programs.worker_processes import Task


@dataclass(frozen=True)
class SharesOfCases:
    """The cases of each share, and the arguments of the program call that computes the share."""

    program: CachedProgram
    cases: tuple[Sequence[int], ...]
    arguments: tuple[Task, ...]
    alone: bool
    """Whether the program computes one case, so that its result has no axis of cases."""

    def of_each(self, share: int, result: tuple[State, State]) -> Iterator[tuple[int, State, State]]:
        """Number, last state and states at the stops of each case of a share."""
        for place, number in enumerate(self.cases[share]):
            last, states = result if self.alone else jax.tree.map(lambda leaf, i=place: leaf[i], result)
            yield number, last, states


def shares_of(
    starts: BatchStart, axes: Axes, settings: Controls, stops: np.ndarray, chunk: int
) -> SharesOfCases:
    """Shares of the march from the starts to the stops; `axes` mark numbers that differ between models."""
    models, states = starts
    if states[0].kept is None:
        return _mapped(starts, axes, settings, stops, chunk)
    return SharesOfCases(
        COMPILED_MARCH,
        tuple((number,) for number in range(len(models))),
        tuple(
            lambda model=model, state=state: (model, settings, state, stops)
            for model, state in zip(models, states, strict=True)
        ),
        alone=True,
    )


def _mapped(
    starts: BatchStart, axes: Axes, settings: Controls, stops: np.ndarray, chunk: int
) -> SharesOfCases:
    models, states = starts
    size = min(chunk, len(models))
    begun = range(0, len(models), size)

    def arguments(begin: int) -> Arguments:
        numbers = [min(number, len(models) - 1) for number in range(begin, begin + size)]
        start = jax.tree.map(lambda *leaves: np.stack(leaves), *(states[number] for number in numbers))
        leaves = stacked([models[number] for number in numbers], axes)
        own = [None if axis is None else leaf for leaf, axis in zip(leaves, axes, strict=True)]
        return models[0], own, settings, start, stops

    return SharesOfCases(
        _MAPPED_MARCH,
        tuple(range(begin, min(begin + size, len(models))) for begin in begun),
        tuple(partial(arguments, begin) for begin in begun),
        alone=False,
    )


def _march_of_cases(
    first: Model, differing: list[jax.Array | None], settings: Controls, states: State, stops: jax.Array
) -> tuple[State, State]:
    """The run, mapped over cases. Where `differing` has None, a case's model has the number of `first`."""
    leaves, structure = jax.tree.flatten(first)

    def of_case(own: list[jax.Array | None], state: State) -> tuple[State, State]:
        chosen = [shared if each is None else each for shared, each in zip(leaves, own, strict=True)]
        return COMPILED_MARCH(jax.tree.unflatten(structure, chosen), settings, state, stops)

    return jax.vmap(of_case)(differing, states)


_MAPPED_MARCH = CachedProgram(_march_of_cases, MARCHING)
