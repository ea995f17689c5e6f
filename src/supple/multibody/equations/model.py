"""A system as arrays: what the compiled equations of motion read.

Every class here is a JAX pytree. Velocities of all bodies form one vector: per body `(dR/dt, omega, dg/dt)`,
the frame's velocity in global, its spin in body components.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import jax
import numpy as np

from supple.body import RigidBody
from supple.body.full_body import FullBody
from supple.errors import ModelError
from supple.machine import GROUND, At, DeadForce, ForceElement
from supple.machine.joints.joint import Joint
from supple.machine.system import Placed, System
from supple.multibody.equations.floating_inertia import InertiaArrays, inertia_arrays
from supple.multibody.full.full_inertia import cross_matrix
from supple.reduction import ReducedBody

__all__ = [
    "BodyArrays",
    "DeadForceArrays",
    "End",
    "ForceArrays",
    "JointArrays",
    "Model",
    "build_model",
    "is_nodal_load_on_full_body",
    "joint_ends",
]


_STATIC = {"static": True}
"""Marks what belongs to the structure of a compiled program, not to its data."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class BodyArrays:
    """A rigid (r = 0) or reduced body."""

    gram: Any
    """(6 + 4r, 6 + 4r)"""
    inertia: InertiaArrays
    """The same, as the equations of motion read it."""
    stiffness: Any
    cubic: Any
    quartic: Any
    damping: Any
    coordinate_scale: Any
    """Size of a coordinate that moves the body by the system's length: `length sqrt(mass)`."""

    @property
    def r(self) -> int:
        """Number of deformation coordinates."""
        return self.stiffness.shape[0]


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class End:
    """A marker of a joint or force: its body (-1: ground) and how the body's coordinates move it."""

    body: int = field(metadata=_STATIC)
    motion: Any
    """(6, r): displacement and rotation of the interface from the coordinates of its body"""
    offset: Any
    axes: Any


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class JointArrays:
    """A joint: its equations, its law, its ends."""

    constraint: Callable[..., Any] = field(metadata=_STATIC)
    n_constraints: int = field(metadata=_STATIC)
    law: Any
    first: End
    second: End


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ForceArrays:
    """A force between two markers."""

    wrenches: Callable[..., Any] = field(metadata=_STATIC)
    law: Any
    parameters: tuple[Any, ...]
    first: End
    second: End


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class DeadForceArrays:
    """Forces in global components at k points of one body."""

    body: int = field(metadata=_STATIC)
    law: Any
    """(3,) or (k, 3) over time"""
    positions: Any
    """(k, 3) rest positions"""
    basis: Any
    """(k, 3, r) displacements per coordinate"""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Model:
    """The whole system."""

    bodies: tuple[BodyArrays, ...]
    joints: tuple[JointArrays, ...]
    forces: tuple[ForceArrays, ...]
    dead_forces: tuple[DeadForceArrays, ...]
    gravity: Any
    length: Any
    """Size of the system, the scale of translations."""
    mass: Any
    """Mass of the system, the scale that balances multipliers against accelerations."""
    active: tuple[int, ...] = field(metadata=_STATIC)
    """The constraint equations kept: all but the redundant ones."""

    @property
    def slices(self) -> tuple[slice, ...]:
        """Where each body's velocities stand in the common vector."""
        ends = np.cumsum([0] + [6 + body.r for body in self.bodies])
        return tuple(slice(int(a), int(b)) for a, b in pairwise(ends))

    @property
    def n_velocities(self) -> int:
        """Length of the common velocity vector."""
        return sum(6 + body.r for body in self.bodies)

    @property
    def n_equations(self) -> int:
        """Number of constraint equations, redundant ones included."""
        return sum(joint.n_constraints for joint in self.joints)


def rigid_gram(body: RigidBody) -> np.ndarray:
    """Inertia Gram matrix of a rigid body about its frame origin, (6, 6)."""
    mass, centre = float(body.mass), np.asarray(body.centre)
    cross = cross_matrix(centre)
    inertia = np.asarray(body.inertia) - mass * cross @ cross
    return np.block([[mass * np.eye(3), -mass * cross], [mass * cross, inertia]])


def body_mass(placed: Placed) -> float:
    """Mass of a body."""
    body = placed.body
    if isinstance(body, RigidBody):
        return float(body.mass)
    if isinstance(body, FullBody):
        along_x = body.body.rigid_modes[:, 0]
        return float(along_x @ (body.body.mass @ along_x))
    return float(body.gram[0, 0])


def _body_arrays(placed: Placed, length: float) -> BodyArrays:
    body = placed.body
    if isinstance(body, RigidBody):
        empty = np.zeros((0, 0))
        gram = rigid_gram(body)
        return BodyArrays(gram, inertia_arrays(gram), empty, None, None, empty, length * np.sqrt(body.mass))
    if isinstance(body, FullBody):
        # Only the interfaces' motions enter here; inertia and elasticity are the sparse engine's.
        r = 6 * len(body.interfaces)
        none = np.zeros((r, r))
        gram = np.zeros((6 + 4 * r, 6 + 4 * r))
        return BodyArrays(gram, inertia_arrays(gram), none, None, None, none, length)
    return BodyArrays(
        body.gram,
        inertia_arrays(body.gram),
        body.stiffness,
        body.cubic,
        body.quartic,
        body.damping,
        length * np.sqrt(body.gram[0, 0]),
    )


def interface_motion(placed: Placed, interface: str) -> tuple[np.ndarray, Any]:
    """Rest position (3,) and motion (6, r) of an interface of a body."""
    body = placed.body
    if isinstance(body, RigidBody):
        return body.interface(interface).position, np.zeros((6, 0))
    names = [i.name for i in body.interfaces]
    index = names.index(interface)
    found = body.interfaces[index]
    if isinstance(body, FullBody):
        return np.asarray(found.position), np.eye(6 * len(names))[6 * index : 6 * index + 6]
    return np.asarray(found.position), found.motion


def _end(system: System, end: At, axes: np.ndarray, ground_point: np.ndarray) -> End:
    if end == GROUND:
        return End(body=-1, motion=np.zeros((6, 0)), offset=ground_point, axes=axes)
    index = system.body_index(end.body)
    placed = system.bodies[index]
    position, motion = interface_motion(placed, end.interface)
    return End(body=index, motion=motion, offset=position, axes=placed.rotation.T @ axes)


def initial_point(system: System, end: At) -> np.ndarray:
    """Global position of an interface at the start, bodies undeformed, (3,)."""
    placed = system.bodies[system.body_index(end.body)]
    position, _ = interface_motion(placed, end.interface)
    return placed.position + placed.rotation @ position


def initial_points(system: System, element: Joint | ForceElement) -> tuple[np.ndarray, np.ndarray]:
    """Global positions of both ends at the start; the ground's, unless given, is where the other one is."""
    own = [None if end == GROUND else initial_point(system, end) for end in (element.first, element.second)]
    given = element.ground_point if isinstance(element, ForceElement) else None
    on_ground = given if given is not None else next(point for point in own if point is not None)
    first, second = (on_ground if point is None else point for point in own)
    return first, second


def joint_ends(system: System, element: Joint | ForceElement) -> tuple[End, End]:
    """Both markers of a joint or force."""
    first, second = initial_points(system, element)
    axes = element.initial_axes
    return (
        _end(system, element.first, axes, first),
        _end(system, element.second, axes, second),
    )


def is_nodal_load_on_full_body(system: System, load: DeadForce) -> bool:
    """True for loads that only the sparse engine can apply."""
    body = system.bodies[system.body_index(load.body)].body
    return isinstance(body, FullBody) and not isinstance(load.at, str)


def _dead_force(system: System, load: DeadForce) -> DeadForceArrays:
    index = system.body_index(load.body)
    body = system.bodies[index].body
    if isinstance(load.at, str):
        position, motion = interface_motion(system.bodies[index], load.at)
        positions, basis = position[None], motion[None, :3]
    else:
        if not isinstance(body, ReducedBody):
            raise ModelError(f"{load.label}: only flexible bodies have nodes")
        nodes = np.asarray(load.at, dtype=int)
        positions, basis = body.nodes[nodes], body.displacement_basis[nodes]
    return DeadForceArrays(body=index, law=load.law, positions=positions, basis=basis)


def _check_apart(system: System, load: ForceElement) -> None:
    first, second = initial_points(system, load)
    if load.acts_along_line and np.array_equal(first, second):
        raise ModelError(
            f"{load.label}: both ends start at {first.tolist()}, so it has no direction: move one of them"
        )


def system_length(system: System) -> float:
    """Size of the system: the largest distance between interfaces, nodes and frame origins at the start."""
    points = [placed.position[None] for placed in system.bodies]
    for placed in system.bodies:
        body = placed.body
        if len(body.nodes):
            points.append(placed.position + body.nodes @ placed.rotation.T)
    extent = np.ptp(np.concatenate(points), axis=0)
    return float(np.linalg.norm(extent)) or 1.0


def build_model(system: System, active: tuple[int, ...] | None = None) -> Model:
    """The arrays of a system; `active` leaves out redundant constraint equations.

    A full body is represented by the motions of its interfaces alone, six coordinates each, without inertia
    or stiffness: what joints and forces see of it.
    """
    length = system_length(system)
    bodies = tuple(_body_arrays(placed, length) for placed in system.bodies)
    joints, forces, dead = [], [], []
    for joint in system.joints:
        first, second = joint_ends(system, joint)
        joints.append(JointArrays(type(joint).constraint, joint.n_constraints, joint.law, first, second))
    for load in system.loads:
        if isinstance(load, DeadForce):
            if not is_nodal_load_on_full_body(system, load):
                dead.append(_dead_force(system, load))
        else:
            _check_apart(system, load)
            first, second = joint_ends(system, load)
            forces.append(ForceArrays(type(load).wrenches, load.law, load.parameters, first, second))
    n_equations = sum(joint.n_constraints for joint in system.joints)
    return Model(
        bodies=bodies,
        joints=tuple(joints),
        forces=tuple(forces),
        dead_forces=tuple(dead),
        gravity=system.gravity,
        length=length,
        mass=sum(body_mass(placed) for placed in system.bodies),
        active=tuple(range(n_equations)) if active is None else active,
    )
