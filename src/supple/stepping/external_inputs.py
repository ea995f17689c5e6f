"""Laws of time that become inputs of a step program: their values come from outside."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import jax
import numpy as np

from supple.equations.machine_model import Model
from supple.errors import ModelError, SuppleError
from supple.machine import Joint, System
from supple.machine.laws.constant import Constant
from supple.machine.laws.time_law import as_time_law
from supple.machine.laws.unbounded_law import UnboundedLaw
from supple.stepping.variables import Variable

__all__ = ["ExternalInputs", "external_inputs"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class _External(UnboundedLaw):
    """The place of each component in the vector of inputs, and its value at the start."""

    places: Any
    start: Any

    def __call__(self, time: Any) -> Any:  # noqa: ARG002 - a law is called with the time, needed or not
        return self.start

    def instants(self, begin: float, end: float) -> np.ndarray:  # noqa: ARG002
        return np.zeros(0)

    def shortest_scale(self, begin: float, end: float) -> float:  # noqa: ARG002
        return float("inf")


@dataclass(frozen=True)
class ExternalInputs:
    """A machine some of whose laws are inputs.

    system : with their values at the start in their place
    variables : by their places in the vector of inputs
    """

    system: System
    variables: tuple[Variable, ...]

    @property
    def start(self) -> np.ndarray:
        """(k,) values at the start."""
        return np.array([variable.start for variable in self.variables])

    def given(self, model: Model, inputs: Any) -> Model:
        """The model of the machine with inputs (k,) as they are within a step."""

        def constant(law: Any) -> Any:
            return Constant(inputs[np.asarray(law.places)]) if _is_external(law) else law

        return jax.tree.map(constant, model, is_leaf=_is_external)

    def check_read(self, arrays: Any) -> None:
        """ModelError for an input that the numbers of the equations do not read."""
        laws = [leaf for leaf in jax.tree.leaves(arrays, is_leaf=_is_external) if _is_external(leaf)]
        read = {int(place) for law in laws for place in np.ravel(law.places)}
        for place, variable in enumerate(self.variables):
            if place not in read:
                raise ModelError(
                    f"'{variable.name}' cannot be an input: the equations of its body read its law when they "
                    "are made; drive another element, or reduce the body"
                )

    def unset(self, model: Model) -> Model:
        """The model without the values at the start, which only stand in the place of inputs."""

        def without(law: Any) -> Any:
            return replace(law, start=np.zeros_like(law.start)) if _is_external(law) else law

        return jax.tree.map(without, model, is_leaf=_is_external)


def external_inputs(
    system: System, elements: Mapping[str, Any], units: Mapping[str, str], time: float
) -> ExternalInputs:
    """The machine with inputs instead of the laws of some joints and loads.

    elements : by the name of the input, joints and loads of the machine that have a law of time
    units : of the inputs, by the same names
    time : at which the laws give the values at the start

    Raises ModelError for an element in which nothing varies with time.
    """
    variables: list[Variable] = []
    joints, loads = list(system.joints), list(system.loads)
    for name, element in elements.items():
        law, changed = _with_input(name, element, len(variables), time)
        letters = "xyz" if law.start.shape == (3,) else [str(number) for number in range(law.start.size)]
        names = [f"{name}.{letter}" for letter in letters] if law.start.shape else [name]
        what = f"prescribed motion of joint '{name}'" if isinstance(element, Joint) else f"law of '{name}'"
        variables += [
            Variable(own, units.get(name, ""), what, float(value))
            for own, value in zip(names, law.start.reshape(-1), strict=True)
        ]
        joints = [changed if each is element else each for each in joints]
        loads = [changed if each is element else each for each in loads]
    return ExternalInputs(replace(system, joints=tuple(joints), loads=tuple(loads)), tuple(variables))


def _with_input(name: str, element: Any, first: int, time: float) -> tuple[_External, Any]:
    """The law of an element as an input whose places begin at `first`, and the element with it."""
    if getattr(element, "law", None) is None:
        raise ModelError(f"nothing in '{name}' varies with time, so that there is no input")
    for field in fields(element):
        try:
            start = np.asarray(as_time_law(getattr(element, field.name))(time), dtype=float)
            law = _External(first + np.arange(start.size).reshape(start.shape), start)
            changed = replace(element, **{field.name: law})
        except (SuppleError, TypeError, ValueError):  # not the field of its law
            continue
        # A servo has its target within its law.
        if any(leaf is law for leaf in jax.tree.leaves(changed.law, is_leaf=_is_external)):
            return law, changed
    raise ModelError(f"the law of '{name}' cannot be an input: {type(element).__name__} computes it")


def _is_external(leaf: Any) -> bool:
    return isinstance(leaf, _External)
