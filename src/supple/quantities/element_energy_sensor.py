"""Energy that an element between two ends has stored, and the power that it gives the machine."""

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
from supple.integrate import Solution
from supple.machine import System
from supple.machine.forces import ForceElement, JointFriction
from supple.machine.pose import Pose, Wrench
from supple.quantities.end_motion import both_ends, check_ends
from supple.quantities.reading import Channel, Quantity

__all__ = ["ElementEnergySensor"]


@dataclass(frozen=True, eq=False)
class ElementEnergySensor:
    """Energy stored in a spring, stop, contact, ..., and the power of its forces on both of its ends, (t, 2).

    What the element dissipates is `-power - d(stored)/dt`; of one that is driven by a law of time or by a
    controller this is what it is fed with as well. Of an element that a controller drives only the law of
    time is known here.

    element : ForceElement      of the machine's loads, or one that is only imagined there
    """

    name: str
    element: ForceElement

    def __post_init__(self) -> None:
        check_fields(self)

    def channels(self, system: System) -> Sequence[Channel]:
        """stored, power."""
        check_ends(system, self.name, self.element)
        return (Channel("stored", Quantity.ENERGY, ""), Channel("power", Quantity.POWER, ""))

    def values(self, system: System, solution: Solution) -> NDArray[np.float64]:
        """(t, 2)."""
        element = self.element.assembled(*initial_points(system, self.element))
        ends = both_ends(system, solution, element, self.name)
        law, parameters = element.law, jax.tree.map(jnp.asarray, element.parameters)
        times = jnp.asarray(solution.times)
        carried = jnp.zeros((len(times), 2))
        if isinstance(element, JointFriction):
            carried = jnp.asarray(solution.joint_forces[element.joint.name])[:, :2]
        return np.asarray(_values(type(element), law, parameters, *ends, times, carried))


@partial(jax.jit, static_argnums=0)
def _values(
    kind: type[ForceElement], law: Any, parameters: Any, first: Any, second: Any, times: Any, carried: Any
) -> jax.Array:
    def at(one: Pose, other: Pose, time: Any, reaction: Any) -> jax.Array:
        value = (reaction if kind.reads_reaction else None) if law is None else law(time)
        loads = kind.wrenches(one, other, value, parameters)
        stored = jnp.asarray(kind.energy(one, other, value, parameters), dtype=float)
        return jnp.stack([stored, _power(one, loads[0]) + _power(other, loads[1])])

    return jax.vmap(at)(first, second, times, carried)


def _power(end: Pose, load: Wrench) -> Any:
    return load.force @ end.velocity + load.moment @ end.angular_velocity
