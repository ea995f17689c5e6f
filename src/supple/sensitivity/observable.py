"""Observables of a run with derivatives: sensors, and statistics of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Protocol

import numpy as np

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem import FiniteElementModel
from supple.integrate import Solution
from supple.machine import ForceElement, Joint, Placed, System

__all__ = ["Observable", "Observables", "Statistic"]


class Observable(Protocol):
    """Named values of a run; every sensor is an observable."""

    @property
    def name(self) -> str:
        """Name, unique among the observables of a call."""
        ...

    def values(self, system: System, solution: Solution, /) -> FloatArray:
        """Values of any shape; for a sensor (t, c) at the output times."""
        ...


@dataclass(frozen=True)
class Statistic:
    """A statistic over time of every column of a sensor, (c,).

    sensor : Observable     with values (t, c)
    of : callable           function of a column (t,), such as `np.max`, `np.mean`, `np.std`

    Extremes are taken over the output times; the derivative of an extreme is that of the value at the time of
    the extreme.
    """

    name: str
    sensor: Observable
    of: Callable[[FloatArray], float]

    def __post_init__(self) -> None:
        check_fields(self)

    def values(self, system: System, solution: Solution) -> FloatArray:
        """The statistic of each column, (c,)."""
        columns = np.asarray(self.sensor.values(system, solution)).T
        return np.array([self.of(column) for column in columns], dtype=float)


Observables = Sequence[Observable] | Callable[[System], Sequence[Observable]]
"""Observables; if they refer to parts of the machine, a function that creates them from the machine"""


def observables_of(observables: Observables, system: System) -> dict[str, Any]:
    """Observables by name, for a machine.

    Raises ModelError for two observables of equal name, and for a list with observables that refer to parts
    of one machine: these parts would not change with the parameters.
    """
    is_list = isinstance(observables, Sequence)
    found = observables if is_list else observables(system)
    names = [each.name for each in found]
    if len(set(names)) < len(names):
        raise ModelError(f"observables must have different names, got {', '.join(names)}")
    for each in found:
        if is_list and _holds(each, (ForceElement, Joint, Placed, System)):
            raise ModelError(
                f"observable '{each.name}' refers to an element or joint of one machine, whose numbers would "
                "not change with the parameters: give a function, `lambda system: [..]`, that takes it from "
                "the system"
            )
    return {each.name: each for each in found}


def reads_elements(observable: Observable) -> bool:
    """Whether an observable uses finite elements, whose material determines the stress."""
    return _holds(observable, (FiniteElementModel,))


def _holds(value: Any, kinds: tuple[type, ...]) -> bool:
    if isinstance(value, kinds):
        return True
    return is_dataclass(value) and any(_holds(getattr(value, each.name), kinds) for each in fields(value))
