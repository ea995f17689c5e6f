"""Solutions of the cases of a batch from their states, with joint forces for many cases at once."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import jax
import numpy as np

from supple.equations.floating_solution import floating_solution
from supple.equations.machine_model import Model
from supple.integrate import Solution, Statistics
from supple.machine import System
from supple.methods.floating.compiled.engine import engine_state, system_motion
from supple.methods.floating.compiled.state import State

__all__ = ["MarchedCase", "solutions_of"]


@dataclass(frozen=True)
class MarchedCase:
    """The computed part of a case."""

    system: System
    model: Model
    states: State
    """States at the output times reached; the first axis is time."""
    statistics: Statistics


def solutions_of(cases: Sequence[MarchedCase]) -> list[Solution]:
    """The solutions of cases.

    Cases with the same bodies and joints are concatenated in time: one call computes their joint forces,
    which takes less time than a call for each case.
    """
    alike: dict[Hashable, list[int]] = {}
    for number, case in enumerate(cases):
        alike.setdefault(_bodies_and_joints(case), []).append(number)
    found: dict[int, Solution] = {}
    for numbers in alike.values():
        together = _found_together([cases[number] for number in numbers])
        found |= dict(zip(numbers, together, strict=True))
    return [found[number] for number in range(len(cases))]


def _bodies_and_joints(case: MarchedCase) -> Hashable:
    """Key by identity of bodies and joints: cases with equal starts share joint arrays (`batch_start`)."""
    return (
        tuple(id(placed.body) for placed in case.system.bodies),
        tuple(joint.name for joint in case.system.joints),
        id(case.model.joints),
        case.model.active,
    )


def _found_together(cases: Sequence[MarchedCase]) -> list[Solution]:
    first = cases[0]
    states = jax.tree.map(lambda *own: np.concatenate(own), *(case.states for case in cases))
    whole = floating_solution(
        first.system, first.model.slices, first.model.active, system_motion(states), Statistics()
    )
    ends = np.cumsum([len(case.states.time) for case in cases])
    return [
        replace(
            whole.at(slice(end - len(case.states.time), end)),
            statistics=case.statistics,
            engine_state=engine_state(case.model, case.states),
        )
        for case, end in zip(cases, ends, strict=True)
    ]
