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
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray
from supple.equations.configuration import Configuration
from supple.equations.machine_model import Model
from supple.errors import ModelError
from supple.integrate import Solution, Statistics
from supple.machine import System
from supple.methods.floating.compiled.engine import as_solution
from supple.methods.floating.compiled.sensitivity_step import StateChange
from supple.methods.floating.compiled.state import State
from supple.sensitivity.differences import OFFSETS, central_difference, looks_smooth
from supple.sensitivity.observable import Observables, observables_of, reads_elements
from supple.sensitivity.parameter_changes import ParameterChanges

_STEPS = (1.0, 1e-2, 1e-4)
"""Steps along motion', relative to the smaller of `_small_step` and the parameter's step: the next one is
tried for observables that are not smooth."""
_SMALL = 1e-3
"""Largest change of the motion by `_small_step`: rotations in rad, positions relative to the length of the
machine, deformations relative to the largest one of the body."""
_UNDEFORMED = 1e-8
"""Least reference value of a deformation, relative to the machine's length."""


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
        of_motion = _small_step(self.machine.model, self.states, self.changes, number)
        largest = min(of_motion, self.machine.neighbours[number].step)
        found: dict[str, FloatArray] = {}
        for part in _STEPS:
            left = {name: own for name, own in values.items() if name not in found}
            if left:
                step = part * largest
                around = [
                    self._read(
                        self.machine.system,
                        _displaced(self.states, self.changes, number, offset * step),
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


def _displaced(states: State, change: StateChange, parameter: int, step: float) -> State:
    """States (t, ..) displaced by a step of a parameter along derivatives (t, p, ..).

    Displaced rotation matrices are orthogonal: A exp(step [w]).
    """
    carried = change.carried
    of_configuration = carried.configuration

    def along(name: str) -> np.ndarray:
        return getattr(states, name) + step * getattr(carried, name)[:, parameter]

    configuration = states.configuration
    turn = _rotation_vectors(configuration.rotations, of_configuration.rotations[:, parameter])
    turned = Rotation.from_rotvec(step * turn.reshape(-1, 3)).as_matrix().reshape(*turn.shape, 3)
    return states._replace(
        configuration=Configuration(
            configuration.origins + step * of_configuration.origins[:, parameter],
            configuration.rotations @ turned,
            configuration.coordinates + step * of_configuration.coordinates[:, parameter],
        ),
        velocity=along("velocity"),
        acceleration=along("acceleration"),
        multipliers=states.multipliers + step * change.multipliers[:, parameter],
    )


def _rotation_vectors(rotations: np.ndarray, changes: np.ndarray) -> np.ndarray:
    """`w` (.., 3) of `dA = A [w]`, in body axes; [w] is the skew matrix of w."""
    skew = np.swapaxes(rotations, -1, -2) @ changes
    skew = (skew - np.swapaxes(skew, -1, -2)) / 2
    return np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)


def _small_step(model: Model, states: State, change: StateChange, parameter: int) -> float:
    """The step of a parameter that changes the configuration by at most `_SMALL`; inf without any effect."""
    configuration, of = states.configuration, change.carried.configuration
    turn = _rotation_vectors(configuration.rotations, of.rotations[:, parameter])
    sizes = [np.abs(turn).max(), np.abs(of.origins[:, parameter]).max() / float(model.length)]
    for group in model.groups:
        if not group.r:
            continue
        places = group.coordinates.index
        scale = np.asarray(group.coordinate_scale)[:, None]
        deformed = np.abs(configuration.coordinates[:, places] / scale).max()
        change_of = np.abs(of.coordinates[:, parameter][:, places] / scale).max()
        sizes.append(change_of / max(deformed, _UNDEFORMED))
    largest = max(sizes)
    return _SMALL / largest if largest > 0 else np.inf
