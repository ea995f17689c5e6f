"""Forces and moments in joints and springs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_fields
from supple.equations.build_model import initial_points
from supple.integrate import JOINT_AXES, Solution
from supple.machine import System
from supple.machine.forces import ForceElement
from supple.quantities.end_motion import both_ends, check_ends
from supple.quantities.joint_motion_sensor import joint_named
from supple.quantities.reading import Channel, Quantity

__all__ = ["JointForceSensor", "SpringForceSensor"]

Array = NDArray[np.float64]


def six_channels(axes: str) -> tuple[Channel, ...]:
    """Of a force and a moment."""
    parts = (("F", Quantity.FORCE), ("M", Quantity.MOMENT))
    return tuple(Channel(f"{letter}{axis}", quantity, axes) for letter, quantity in parts for axis in "xyz")


@dataclass(frozen=True)
class JointForceSensor:
    """Force and moment of a joint on its second end, along its axes on the first end, (t, 6).

    joint : its name
    """

    name: str
    joint: str

    def __post_init__(self) -> None:
        check_fields(self)

    def channels(self, system: System) -> Sequence[Channel]:
        """Fx, Fy, Fz, Mx, My, Mz."""
        joint_named(system, self.joint, self.name)
        return six_channels(JOINT_AXES)

    def values(self, system: System, solution: Solution) -> Array:
        """(t, 6)."""
        joint_named(system, self.joint, self.name)
        return np.asarray(solution.joint_forces[self.joint])


@dataclass(frozen=True, eq=False)
class SpringForceSensor:
    """Force and moment of a spring, damper or torque on its second end, global components, (t, 6).

    element : ForceElement      of the machine's loads, or one that is only imagined there
    """

    name: str
    element: ForceElement

    def __post_init__(self) -> None:
        check_fields(self)

    def channels(self, system: System) -> Sequence[Channel]:
        """Fx, Fy, Fz, Mx, My, Mz."""
        check_ends(system, self.name, self.element)
        return six_channels("global")

    def values(self, system: System, solution: Solution) -> Array:
        """(t, 6)."""
        element = self.element.assembled(*initial_points(system, self.element))
        ends = both_ends(system, solution, element, self.name)
        law, parameters = element.law, jax.tree.map(jnp.asarray, element.parameters)
        return np.asarray(
            _on_second(type(element).wrenches, law, parameters, *ends, jnp.asarray(solution.times))
        )


@partial(jax.jit, static_argnums=0)
def _on_second(wrenches: Any, law: Any, parameters: Any, first: Any, second: Any, times: Any) -> jax.Array:
    def at(one: Any, other: Any, time: Any) -> jax.Array:
        value = None if law is None else law(time)
        return jnp.concatenate(wrenches(one, other, value, parameters)[1])

    return jax.vmap(at)(first, second, times)
