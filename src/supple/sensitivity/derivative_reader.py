"""Derivatives of observables of a run, from the derivatives of its motion and of the machine.

    d Q(machine(p), motion(p)) / dp = dQ/dmachine machine' + dQ/dmotion motion'

A prime denotes the derivative with respect to p. Sensors are cheap functions of NumPy arrays. Both terms are
central differences of fourth order: the first between machines with neighbouring parameter values at constant
motion, the second between motions displaced along motion'.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.integrate import Solution, Statistics
from supple.machine import System
from supple.methods.floating.compiled.engine import as_solution
from supple.methods.floating.compiled.sensitivity_step import StateChange
from supple.methods.floating.compiled.state import State
from supple.sensitivity.differences import OFFSETS, central_difference, looks_smooth
from supple.sensitivity.moved_motion import displaced_states, small_step
from supple.sensitivity.observable import Observables, observables_of, reads_elements
from supple.sensitivity.parameter_changes import ParameterChanges

_STEPS = (1.0, 1e-2, 1e-4)
"""Steps along motion', relative to the smaller of `small_step` and the parameter's step: the next one is
tried for observables that are not smooth."""


def read(observables: Observables, system: System, solution: Solution) -> dict[str, FloatArray]:
    """Values of observables, by name."""
    found = observables_of(observables, system)
    return {name: np.asarray(each.values(system, solution), dtype=float) for name, each in found.items()}


@dataclass(frozen=True, eq=False)
class DerivativeReader:
    """Derivatives of observables of a run.

    states : states at the output times (t, ..);   changes : derivatives of the states (t, p, ..)
    """

    machine: ParameterChanges
    states: State
    changes: StateChange
    observables: Observables

    def derivatives(
        self, parameter: str, number: int, values: Mapping[str, FloatArray]
    ) -> dict[str, FloatArray]:
        """Derivatives of all observables with respect to a parameter.

        number : position of the parameter;   values : values of the run itself, by observable
        Raises ModelError for an observable that is not a smooth function of the parameter.
        """
        own = self.machine.neighbours[number]
        self._check_elements(parameter, own.systems)
        around = [self._read(system, self.states) for system in own.systems]
        by_machine = self._smooth(values, around, own.step)
        by_motion = self._by_motion(number, values)
        for name in values:
            if name not in by_machine or name not in by_motion:
                raise ModelError(
                    f"'{name}' does not follow parameter '{parameter}' smoothly: it has a jump or a kink "
                    "there, such as the extreme of two equal peaks; use a smooth observable"
                )
        return {name: by_machine[name] + by_motion[name] for name in values}

    def _check_elements(self, parameter: str, systems: Sequence[System]) -> None:
        """ModelError for observables of finite elements if the parameter creates elastic bodies again."""
        bodies = {id(placed.body) for placed in self.machine.system.bodies}
        others = (placed.body for system in systems for placed in system.bodies)
        if all(body.kind == "rigid" or id(body) in bodies for body in others):
            return
        for name, each in observables_of(self.observables, self.machine.system).items():
            if reads_elements(each):
                raise ModelError(
                    f"'{name}' uses the elements of one body, and parameter '{parameter}' creates elastic "
                    "bodies again: keep the body for all parameters, or use a deflection or a force"
                )

    def _by_motion(self, number: int, values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        # A parameter that does not affect the motion, such as the mass of a pendulum, may affect forces.
        of_motion = small_step(self.machine.model, self.states, self.changes, number)
        largest = min(of_motion, self.machine.neighbours[number].step)
        found: dict[str, FloatArray] = {}
        for part in _STEPS:
            left = {name: own for name, own in values.items() if name not in found}
            if left:
                step = part * largest
                around = [
                    self._read(
                        self.machine.system,
                        displaced_states(self.states, self.changes, number, offset * step),
                    )
                    for offset in OFFSETS
                ]
                found |= self._smooth(left, around, step)
        return found

    def _read(self, system: System, states: State) -> dict[str, FloatArray]:
        solution = as_solution(system, self.machine.model, states, Statistics())
        return read(self.observables, system, solution)

    @staticmethod
    def _smooth(
        values: Mapping[str, FloatArray], around: Sequence[Mapping[str, FloatArray]], step: float
    ) -> dict[str, FloatArray]:
        """Derivatives of the observables that are smooth; others are left out."""
        found = {name: [own[name] for own in around] for name in values}
        return {
            name: central_difference(own, step)
            for name, own in found.items()
            if looks_smooth(values[name], own)
        }
