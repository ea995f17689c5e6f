"""Controllers: their readings, their outputs, and the law between them.

They read positions and velocities; not accelerations, which depend on the outputs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from supple.arguments import check_fields, check_instance, check_number
from supple.errors import ModelError
from supple.machine.ends import GROUND, At, as_end
from supple.machine.forces.force_element import ForceElement

__all__ = ["Controller", "EndReading", "JointReading", "SampledController"]


@dataclass(frozen=True)
class JointReading:
    """`AxialMotion` of a joint: angle, rate, slide and speed, as in `JointMotionSensor`.

    The angle continues beyond pi if each step rotates the joint by less than half a revolution.
    """

    joint: str
    """Name of the joint"""
    near: float = 0.0
    """Angle, rad, within half a revolution of which the initial angle lies; set by `Start`"""


@dataclass(frozen=True)
class EndReading:
    """`Pose` of an interface in global components: point, axes, velocity, angular velocity."""

    at: At | Any
    """"BODY.INTERFACE" or `At(body, interface)`; its axes coincide with the global axes at assembly"""

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", as_end(self.at))
        if self.at == GROUND:
            raise ModelError(
                "a controller reads the ground, which does not move: give an interface of a body"
            )


Reading = JointReading | EndReading


@dataclass(frozen=True, eq=False, kw_only=True)
class Controller:
    """A control law, a function of time, readings and controller states z, evaluated in the compiled step.

        dz/dt = rates(t, readings, z),     u = outputs(t, readings, z)

    Each output adds to the law of time of a force element: the torque of a `TorqueBetween`, the command of a
    `MotorCurve`, and so on. The states are integrated together with the motion, by the trapezoidal rule
    (second order, unconditionally stable). Outputs and motion of a step are at the same instant.

    `rates` and `outputs` are written with `jax.numpy`, and are part of the compiled program, like the
    function of a `TimeFunction`.

    reads : JointReading or EndReading, by name
    drives : force elements with a law of time, by name; they must not be among the machine's loads
    outputs : `(time, readings, states) -> {name: value}`, a value for every driven element;
        `readings` is a dictionary of `AxialMotion` and `Pose`, `states` an array (k,)
    rates : `(time, readings, states) -> (k,)`; None without states
    initial : (k,) states at the start
    Raises ModelError for no element or one without a law of time, states that are not finite numbers (k,),
    states without rates, or rates without states.
    """

    reads: Mapping[str, Reading]
    drives: Mapping[str, ForceElement]
    outputs: Callable[[Any, Any, Any], Mapping[str, Any]]
    rates: Callable[[Any, Any, Any], Any] | None = None
    initial: Any = ()
    name: str = "controller"

    def __post_init__(self) -> None:
        check_fields(self)
        _check_ends(self)
        try:
            states = np.array(self.initial, dtype=float)
        except (TypeError, ValueError):
            states = np.full(1, np.nan)
        if states.ndim != 1 or not np.isfinite(states).all():
            raise ModelError(f"controller '{self.name}': its initial states must be (k,) finite numbers")
        if (self.rates is None) != (states.size == 0):
            function = "no function" if self.rates is None else "a function"
            raise ModelError(
                f"controller '{self.name}': states and rates must be given together; it has {states.size} "
                f"initial states and {function} of their rates"
            )
        states.setflags(write=False)
        object.__setattr__(self, "initial", states)


@dataclass(frozen=True, eq=False, kw_only=True)
class SampledController:
    """A control law in plain Python; its outputs are constant until the next sampling instant.

    The sampling instants of a run are `start + i every`, i = 0, 1, .... At each of them, the time integration
    stops, the law is called once, and the accelerations are computed again for the new outputs. Result files
    contain the memory, so that an interrupted run continues exactly.

    reads, drives : as in `Controller`; readings are NumPy arrays and numbers
    law : `(time, readings, memory) -> (outputs, memory)`, outputs `{name: value}` for every driven element
    memory : initial memory: numbers and arrays by name, whose shapes are fixed
    every : sampling period
    Raises ModelError for no element or one without a law of time, a period that is not positive and finite,
    or a memory that is not a dictionary of numbers and arrays.
    """

    reads: Mapping[str, Reading]
    drives: Mapping[str, ForceElement]
    law: Callable[[float, Any, dict[str, Any]], tuple[Any, Any]]
    every: float
    memory: Mapping[str, Any] = field(default_factory=dict)
    name: str = "controller"

    def __post_init__(self) -> None:
        check_fields(self)
        _check_ends(self)
        check_number(f"controller '{self.name}': every", self.every)
        if not (np.isfinite(self.every) and self.every > 0):
            raise ModelError(f"controller '{self.name}': every must be a positive time, got {self.every}")
        object.__setattr__(self, "memory", as_memory(self.name, self.memory))


def as_memory(name: str, memory: Any) -> dict[str, np.ndarray]:
    """The memory of a controller as arrays of floats; ModelError unless it is a dictionary of numbers."""
    if not isinstance(memory, Mapping) or not all(isinstance(key, str) for key in memory):
        raise ModelError(
            f"controller '{name}': its memory must be a dictionary of numbers and arrays by name, got "
            f"{type(memory).__name__}"
        )
    try:
        return {key: np.array(value, dtype=float) for key, value in sorted(memory.items())}
    except (TypeError, ValueError) as error:
        raise ModelError(
            f"controller '{name}': its memory must contain numbers and arrays, because it is stored in "
            f"result files ({error})"
        ) from error


def _check_ends(controller: Controller | SampledController) -> None:
    what = f"controller '{controller.name}'"
    if not controller.drives:
        raise ModelError(f"{what} drives nothing: give force elements, drives={{'motor': TorqueBetween(..)}}")
    for reading in controller.reads.values():
        expected = "JointReading(joint) or EndReading(at)"
        check_instance(f"{what}, reads", reading, (JointReading, EndReading), expected)
    for element in controller.drives.values():
        check_instance(f"{what}, drives", element, ForceElement, "force elements such as TorqueBetween(..)")
        if element.law is None:
            raise ModelError(
                f"{what} cannot drive {element.label}, which has no law of time; drive an element such as "
                "TorqueBetween, ForceBetween, MotorCurve, FollowerForce or a servo"
            )
