"""Sensors of joint and element forces, of the energy and power of elements, and of machine energies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.equations import balances
from supple.equations.build_model import initial_points
from supple.equations.control_series import added_to_law
from supple.errors import ModelError
from supple.integrate import JOINT_AXES, Solution
from supple.machine import ForceElement, Joint, JointFriction, System
from supple.machine.pose import Pose, Wrench
from supple.quantities.end_motion import OfJoint, both_ends, check_ends, joint_named
from supple.quantities.reading import LOAD, Channel, QuantityKind, vector_channels
from supple.value_content import UserFunction

__all__ = [
    "ElementEnergySensor",
    "EnergySensor",
    "JointForceSensor",
    "SpringForceSensor",
    "joint_loads",
    "joint_meanings",
]


@dataclass(frozen=True)
class JointForceSensor(OfJoint):
    """Force and moment of a joint on its second end, (t, 6), in joint axes that rotate with the first end.

    As a quantity of interest, only the force is used.

    joint : name of the joint
    """

    quantity: ClassVar[QuantityKind] = QuantityKind.FORCE
    body: ClassVar[None] = None  # a joint connects two bodies

    def channels(self, system: System) -> Sequence[Channel]:
        """Fx, Fy, Fz, Mx, My, Mz."""
        joint_named(system, self.joint, self.name)
        return vector_channels(JOINT_AXES, LOAD)

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, 6)."""
        joint_named(system, self.joint, self.name)
        return np.asarray(solution.joint_forces[self.joint])

    @property
    def words(self) -> str:
        """Description of the quantity and its norm."""
        return f"force of joint '{self.joint}': largest over the run"

    def at_points(self, system: System, solution: Solution) -> FloatArray:
        """Force (t, 1, 3)."""
        return self.values(system, solution)[:, None, :3]

    def size(self, system: System, solution: Solution) -> float:
        """Largest magnitude of the force over the run."""
        return float(np.linalg.norm(self.at_points(system, solution), axis=2).max())


@dataclass(frozen=True, eq=False)
class _OfElement:
    """A sensor of a force element between two ends."""

    name: str
    element: ForceElement

    def __post_init__(self) -> None:
        check_fields(self)

    def _read(self, system: System, solution: Solution) -> FloatArray:
        """The six of `SpringForceSensor`, stored energy, and power on both ends, (t, 8)."""
        element = self.element.assembled(*initial_points(system, self.element))
        ends = both_ends(system, solution, element, self.name)
        law, parameters = element.law, jax.tree.map(jnp.asarray, element.parameters)
        times = jnp.asarray(solution.times)
        added = added_to_law(system, solution, self.element)
        carried = jnp.zeros((len(times), 2))
        if isinstance(element, JointFriction):
            carried = jnp.asarray(solution.joint_forces[element.joint.name])[:, :2]
        kind = UserFunction(type(element))
        return np.asarray(_of_element(kind, law, parameters, *ends, times, carried, added))


class SpringForceSensor(_OfElement):
    """Force and moment of a force element on its second end, global components, (t, 6).

    For an element that acts on its first end alone, such as an `Unbalance`, they are those on the first end.

    element : ForceElement      a load of the machine, one that a controller drives, or a hypothetical element
    """

    def channels(self, system: System) -> Sequence[Channel]:
        """Fx, Fy, Fz, Mx, My, Mz."""
        check_ends(system, self.name, self.element)
        return vector_channels("global", LOAD)

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, 6)."""
        self.channels(system)
        return self._read(system, solution)[:, :6]


class ElementEnergySensor(_OfElement):
    """Energy stored in a force element, and the power of its forces on both of its ends, (t, 2).

    `-power - d(stored)/dt` is the dissipated power minus the power supplied by a law of time or a controller.

    element : ForceElement      a load of the machine, one that a controller drives, or a hypothetical element
    """

    def channels(self, system: System) -> Sequence[Channel]:
        """stored, power."""
        check_ends(system, self.name, self.element)
        return (Channel("stored", QuantityKind.ENERGY, ""), Channel("power", QuantityKind.POWER, ""))

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, 2)."""
        return self._read(system, solution)[:, 6:]


@partial(jax.jit, static_argnums=0)
def _of_element(
    of: UserFunction,
    law: Any,
    parameters: Any,
    first: Pose,
    second: Pose,
    times: jax.Array,
    carried: jax.Array,
    added: jax.Array | None,
) -> jax.Array:
    kind: Any = of.function

    def at(one: Pose, other: Pose, time: jax.Array, reaction: jax.Array, more: jax.Array | None) -> jax.Array:
        value: Any = (reaction if kind.reads_reaction else None) if law is None else law(time)
        value = value if more is None else value + more
        loads = kind.wrenches(one, other, value, parameters)
        stored = jnp.asarray(kind.energy(one, other, value, parameters), dtype=float)
        power = _power(one, loads[0]) + _power(other, loads[1])
        return jnp.concatenate([*loads[0 if kind.acts_on_first_alone else 1], jnp.stack([stored, power])])

    return jax.vmap(at)(first, second, times, carried, added)


def _power(end: Pose, load: Wrench) -> jax.Array:
    return load.force @ end.velocity + load.moment @ end.angular_velocity


@dataclass(frozen=True)
class EnergySensor:
    """Kinetic energy, strain energy of the bodies, potential energy of gravity, and their sum, (t, 4).

    The energy of springs is not included. The potential energy is zero at the global origin.
    """

    name: str

    def channels(self, system: System) -> Sequence[Channel]:
        """kinetic, strain, potential, total."""
        for body in (placed.body for placed in system.bodies):
            if not body.has_frame:
                raise ModelError(
                    f"sensor '{self.name}': body '{body.name}' has explicit finite elements, whose energies "
                    "are recorded with the run: remove the sensor, and use the tables of the run or "
                    "solution.series['energies']"
                )
        return [
            Channel(each, QuantityKind.ENERGY, "") for each in ("kinetic", "strain", "potential", "total")
        ]

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, 4)."""
        self.channels(system)
        found = balances(system, solution)
        return np.column_stack([found.kinetic, found.strain, found.potential, found.total])


def joint_loads(system: System, solution: Solution) -> dict[str, dict[str, FloatArray]]:
    """Loads on the second end of each joint, along the joint axes that rotate with its first end.

    Returns
    -------
    by joint name: "force" (t, 3) and "moment" (t, 3) at the point of the second end, in the units of the
    model. A joint that fixes no position has no "force"; a joint that fixes no rotation has no "moment"
    """
    return {
        joint.name: {
            what: solution.joint_forces[joint.name][:, part]
            for what, part, is_held in (
                ("force", slice(0, 3), any(_holds_a_place(joint))),
                ("moment", slice(3, 6), not all(_holds_a_place(joint))),
            )
            if is_held
        }
        for joint in system.joints
    }


def joint_meanings(system: System) -> dict[str, dict[str, str]]:
    """By joint name: descriptions of the end on which its forces act, and of their axes."""
    return {joint.name: {"acts on": str(joint.second), "axes": JOINT_AXES} for joint in system.joints}


def _holds_a_place(joint: Joint) -> list[bool]:
    return [row.startswith("position") for row in joint.rows]
