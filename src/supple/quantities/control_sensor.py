"""Sensor of the outputs of a controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.equations.control_series import added_to_law, series_name
from supple.errors import ModelError, did_you_mean
from supple.integrate import Solution
from supple.machine import Controller, SampledController, System
from supple.quantities.reading import Channel, QuantityKind

__all__ = ["ControlSensor", "control_sensors"]


@dataclass(frozen=True)
class ControlSensor:
    """Outputs (t, c) of a controller, without the values of the laws to which they are added.

    At a sample time the outputs of a sampled controller are those before its call. `SpringForceSensor`
    returns the total force and moment of a driven element.

    controller : name of the controller
    Raises ModelError for an unknown controller, or for a solution without outputs of controllers, such as an
    equilibrium.
    """

    name: str
    controller: str

    def __post_init__(self) -> None:
        check_fields(self)

    def channels(self, system: System) -> Sequence[Channel]:
        """One for each value, named as in `drives`; several values of an element are numbered from 1."""
        return tuple(
            Channel(name if not each.value_shape else f"{name}.{number + 1}", QuantityKind.NUMBER, "")
            for name, each in self._found(system).drives.items()
            for number in range(int(np.prod(each.value_shape)))
        )

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, c)."""
        columns = []
        for each in self._found(system).drives.values():
            values = added_to_law(system, solution, each)
            assert values is not None
            columns.append(values.reshape(len(values), -1))
        return np.concatenate(columns, axis=1)

    def _found(self, system: System) -> Controller | SampledController:
        known = {each.name: each for each in system.controllers}
        if self.controller not in known:
            raise ModelError(
                f"sensor '{self.name}': the machine has no controller '{self.controller}'"
                f"{did_you_mean(self.controller, known)}"
            )
        return known[self.controller]


def control_sensors(system: System, solution: Solution) -> list[ControlSensor]:
    """Sensors of all controllers whose outputs are in a solution, named as their series."""
    named = {series_name(each.name): each.name for each in system.controllers}
    return [ControlSensor(name, own) for name, own in named.items() if name in solution.series]
