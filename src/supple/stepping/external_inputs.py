"""Inputs of a step program: external values in place of laws of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import jax
import numpy as np

from supple.arrays import AnyArray, Tree
from supple.errors import ModelError, SuppleError
from supple.machine import Joint, System
from supple.machine.laws.constant import Constant
from supple.machine.laws.law_numbers import SmoothLaw
from supple.machine.laws.time_law import as_time_law
from supple.machine.system import Load
from supple.quantities import ElementEnergySensor, Quantity, SpringForceSensor
from supple.stepping.variables import Variable

Driven = Joint | Load
"""An element of a machine that may have a law of time."""
_Laws = TypeVar("_Laws")
"""A pytree that contains laws of time."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class _External(SmoothLaw):
    """Placeholder of a law: index of each component in the input vector, and initial value."""

    places: np.ndarray
    start: np.ndarray

    def __call__(self, time: AnyArray) -> np.ndarray:  # noqa: ARG002 - the interface of laws
        return self.start


@dataclass(frozen=True)
class ExternalInputs:
    """A machine in which inputs replace some laws of time.

    system : the machine; a placeholder with the initial value replaces the law of each input
    variables : the inputs in the order of the input vector
    changed : elements of the given machine whose laws are inputs, each with the one that replaces it
    """

    system: System
    variables: tuple[Variable, ...]
    changed: tuple[tuple[Driven, Driven], ...]

    @property
    def jump(self) -> bool:
        """Whether accelerations follow from the inputs; not from prescribed motions, of unknown rate."""
        return bool(self.changed) and not any(isinstance(old, Joint) for old, _ in self.changed)

    @property
    def start(self) -> np.ndarray:
        """Initial values (k,) of the inputs."""
        return np.array([variable.start for variable in self.variables])

    def sensors(self, sensors: Sequence[Quantity]) -> list[Quantity]:
        """The sensors of the given machine as sensors of this one: those of its changed elements."""
        result = []
        for sensor in sensors:
            if isinstance(sensor, SpringForceSensor | ElementEnergySensor):
                own = (new for old, new in self.changed if old is sensor.element)
                sensor = replace(sensor, element=next(own, sensor.element))  # noqa: PLW2901
            result.append(sensor)
        return result

    def given(self, model: _Laws, inputs: AnyArray) -> _Laws:
        """The model of the machine, or functions that read its outputs, with constant inputs (k,)."""

        def constant(law: Tree) -> Tree:
            return Constant(inputs[np.asarray(law.places)]) if _is_external(law) else law

        return jax.tree.map(constant, model, is_leaf=_is_external)

    def check_read(self, arrays: Tree) -> None:
        """ModelError for an input whose placeholder is not in the arrays of the equations."""
        laws = [leaf for leaf in jax.tree.leaves(arrays, is_leaf=_is_external) if _is_external(leaf)]
        read = {int(place) for law in laws for place in np.ravel(law.places)}
        for place, variable in enumerate(self.variables):
            if place not in read:
                raise ModelError(
                    f"'{variable.name}' cannot be an input: its law is evaluated when the equations of its "
                    "body are built; drive another element, or reduce the body"
                )

    def unset(self, model: _Laws) -> _Laws:
        """The model, or functions that read its outputs, with zeros as initial values of the inputs."""

        def without(law: Tree) -> Tree:
            return replace(law, start=np.zeros_like(law.start)) if _is_external(law) else law

        return jax.tree.map(without, model, is_leaf=_is_external)


def external_inputs(
    system: System, elements: Mapping[str, Driven], units: Mapping[str, str], time: float
) -> ExternalInputs:
    """The machine with inputs in place of the laws of some joints and loads.

    elements : joints and loads of the machine that have a law of time, by the name of the input
    units : units of the inputs, by the same names
    time : time at which the laws give the initial values

    Raises ModelError for an element without a law of time, or with a law that cannot be replaced.
    """
    variables: list[Variable] = []
    joints, loads, pairs = list(system.joints), list(system.loads), []
    for name, element in elements.items():
        law, changed = _with_input(name, element, len(variables), time)
        letters = "xyz" if law.start.shape == (3,) else [str(number) for number in range(law.start.size)]
        names = [f"{name}.{letter}" for letter in letters] if law.start.shape else [name]
        what = f"prescribed motion of joint '{name}'" if isinstance(element, Joint) else f"law of '{name}'"
        variables += [
            Variable(own, units.get(name, ""), what, float(value))
            for own, value in zip(names, law.start.reshape(-1), strict=True)
        ]
        pairs.append((element, changed))
        joints = [changed if each is element else each for each in joints]
        loads = [changed if each is element else each for each in loads]
    changed_system = replace(system, joints=tuple(joints), loads=tuple(loads))
    return ExternalInputs(changed_system, tuple(variables), tuple(pairs))


def _with_input(name: str, element: Driven, first: int, time: float) -> tuple[_External, Driven]:
    """Placeholder for the law of an element, with input indices from `first`, and the element with it."""
    if getattr(element, "law", None) is None:
        raise ModelError(f"nothing in '{name}' varies with time, so it has no input: give it a law")
    for field in fields(element):
        try:
            start = np.asarray(as_time_law(getattr(element, field.name))(time), dtype=float)
            law = _External(first + np.arange(start.size).reshape(start.shape), start)
            changed = replace(element, **{field.name: law})
        except (SuppleError, TypeError, ValueError):  # this field is not the law
            continue
        # The set-point of a servo is a part of its law.
        if any(leaf is law for leaf in jax.tree.leaves(changed.law, is_leaf=_is_external)):
            return law, changed
    raise ModelError(
        f"the law of '{name}' cannot be an input: {type(element).__name__} computes it; choose another "
        "element"
    )


def _is_external(leaf: Tree) -> bool:
    return isinstance(leaf, _External)
