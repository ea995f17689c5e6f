"""Conversion of a system to the arrays of the equations of motion, equal bodies and joints in groups."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import singledispatch
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.cross import cross_matrix
from supple.body import BodyForm, RigidBody
from supple.equations.floating_inertia import inertia_arrays
from supple.equations.machine_model import (
    Actuator,
    BodyGroup,
    ControlLaw,
    Ends,
    ForceGroup,
    JointGroup,
    Model,
    NodalLoadArrays,
    Reader,
)
from supple.equations.nodal_load import prepared
from supple.equations.places import Places
from supple.errors import ModelError
from supple.machine import (
    GROUND,
    At,
    BaseAcceleration,
    Controller,
    ForceElement,
    Joint,
    JointFriction,
    JointReading,
    NodalLoad,
    Placed,
    SampledController,
    System,
    TimeLaw,
)
from supple.machine.control.controller import Reading
from supple.reduction.condensed_inertia import condensed_gram
from supple.value_content import UserFunction, fixed_function

T = TypeVar("T")


def build_model(
    system: System, active: tuple[int, ...] | None = None, like: tuple[System, Model] | None = None
) -> Model:
    """The arrays of a system.

    active : numbers of the constraint equations in use; by default all
    like : a system and its model. Its arrays of bodies are reused if both systems have the same body objects;
        its arrays of joints, if they also have the same joint objects

    A full body is represented only by the motions of its interfaces, six coordinates each, on which joints
    and forces depend. Its inertia, elasticity and nodal loads belong to the sparse method.
    Raises ModelError for explicit finite elements, and for a force element along a line whose ends coincide.
    """
    system.check_has_frames()
    length, places = system_length(system), _BodyPlaces.of(system)
    n_equations = system.n_constraints
    forces = [load for load in system.loads if isinstance(load, ForceElement)]
    nodal = [load for load in system.loads if isinstance(load, NodalLoad)]
    groups = joints = None
    if like is not None and _are(system.bodies, like[0].bodies):
        groups = like[1].groups
        joints = like[1].joints if _are(system.joints, like[0].joints) else None
    return Model(
        groups=_body_groups(system, places, length) if groups is None else groups,
        joints=_joint_groups(system, places) if joints is None else joints,
        forces=_force_groups(system, forces, places),
        nodal_loads=tuple(
            _nodal_load(system, load, places) for load in nodal if not is_on_full_nodes(system, load)
        ),
        gravity=system.gravity,
        base_accelerations=tuple(load.law for load in system.loads if isinstance(load, BaseAcceleration)),
        length=length,
        mass=sum(placed.body.mass for placed in system.bodies),
        sizes=places.sizes,
        n_equations=n_equations,
        active=tuple(range(n_equations)) if active is None else active,
        controllers=tuple(_control_law(system, controller, places) for controller in system.controllers),
    )


def station_model(seen: System, n_floating: int, active: tuple[int, ...] | None) -> Model:
    """The model of `n_floating` floating bodies followed by stations, which have no mass and no inertia."""
    model = build_model(seen, active)
    return replace(model, groups=tuple(_weightless(group, n_floating) for group in model.groups))


def _weightless(group: BodyGroup, n_floating: int) -> BodyGroup:
    kept = np.array([float(member < n_floating) for member in group.members])
    if kept.all():
        return group
    gram, inertia = jax.tree.map(
        lambda array: np.asarray(array) * kept.reshape(-1, *[1] * (np.ndim(array) - 1)),
        (group.gram, group.inertia),
    )
    return replace(group, gram=gram, inertia=inertia)


def _are(own: Sequence[object], others: Sequence[object]) -> bool:
    return len(own) == len(others) and all(one is other for one, other in zip(own, others, strict=True))


def is_on_full_nodes(system: System, load: NodalLoad) -> bool:
    """True for loads on the nodes of a full body, which only the sparse method can apply."""
    body = system.bodies[system.body_index(load.body)].body
    return body.uses_interface_motions and load.nodes.size > 0


def seen_coordinates(body: BodyForm, coordinates: np.ndarray) -> np.ndarray:
    """Coordinates of a body in the model over time, from its own (t, r).

    They are the motions of the interfaces, six each, for a full body; the own coordinates for other bodies.
    """
    if not body.uses_interface_motions:
        return coordinates
    return np.hstack([coordinates[:, :0], *(coordinates @ each.motion.T for each in body.interfaces)])


@dataclass(frozen=True)
class _BodyPlaces:
    """Positions of the velocities and coordinates of each body in the common vectors."""

    sizes: tuple[int, ...]
    velocities: tuple[int, ...]
    coordinates: tuple[int, ...]

    @classmethod
    def of(cls, system: System) -> _BodyPlaces:
        """Positions for the bodies of a system, one after the other."""
        bodies = [placed.body for placed in system.bodies]
        sizes = tuple(6 * len(b.interfaces) if b.uses_interface_motions else b.n_coordinates for b in bodies)
        ends = np.cumsum([0, *sizes])[:-1]
        return cls(sizes, tuple(int(e) + 6 * i for i, e in enumerate(ends)), tuple(int(e) for e in ends))

    def pair(self, bodies: Sequence[int]) -> tuple[Places, Places]:
        """Positions of the velocities and of the coordinates of bodies of one size."""
        r = self.sizes[bodies[0]]
        return (
            Places(tuple(self.velocities[index] for index in bodies), 6 + r),
            Places(tuple(self.coordinates[index] for index in bodies), r),
        )


def _grouped(items: Sequence[T], key: Callable[[T], Hashable]) -> list[list[T]]:
    """Items of equal keys together, in the order of their first occurrence."""
    groups: dict[Hashable, list[T]] = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    return list(groups.values())


def _stacked(trees: Sequence[T]) -> T:
    """Pytrees of one structure stacked into one, with a leading axis on every leaf."""
    return jax.tree.map(lambda *leaves: np.stack([np.asarray(leaf) for leaf in leaves]), *trees)


def _shared(trees: Sequence[T]) -> T:
    """As `_stacked`; if all trees have the same array objects, one is stored, with a leading axis of one."""
    first = jax.tree.leaves(trees[0])
    same = all(a is b for tree in trees for a, b in zip(jax.tree.leaves(tree), first, strict=True))
    return _stacked(trees[:1] if same else trees)


def _stacked_laws(laws: Sequence[TimeLaw | None]) -> TimeLaw | None:
    """The laws of a group as one law of JAX arrays, whose numbers no law checks; None without laws."""
    if laws[0] is None:
        return None
    return jax.tree.map(lambda *leaves: jnp.asarray(np.stack([np.asarray(leaf) for leaf in leaves])), *laws)


def _structure(tree: object) -> Hashable:
    """The properties that two pytrees must share to be stacked."""
    leaves, structure = jax.tree.flatten(tree)
    return structure, tuple((np.shape(leaf), np.result_type(leaf)) for leaf in leaves)


def rigid_gram(body: RigidBody) -> np.ndarray:
    """Inertia Gram matrix of a rigid body about its frame origin, (6, 6)."""
    mass, cross = float(body.mass), cross_matrix(np.asarray(body.centre))
    inertia = np.asarray(body.inertia) - mass * cross @ cross
    return np.block([[mass * np.eye(3), -mass * cross], [mass * cross, inertia]])


ONE_POINT = 1e-12
"""Largest size of a system that counts as a single point, relative to the largest radius of gyration of its
rigid bodies."""

_TENSORS = ("cubic", "quartic", "damping_cubic", "damping_quartic")


@singledispatch
def _arrays(body: Any, length: float) -> dict[str, Any]:
    """Inertia and elasticity of a body in the form of arrays: fields of `BodyGroup`."""
    elastic = {name: getattr(body, name) for name in ("stiffness", "damping", "cubic", "damping_cubic")}
    elastic |= {"quartic": body.quartic_blocks, "damping_quartic": body.damping_quartic_blocks}
    return _inertia(condensed_gram(body), body.mass, length) | elastic


@_arrays.register
def _(body: RigidBody, length: float) -> dict[str, Any]:
    none = np.zeros((0, 0))
    elastic = dict.fromkeys(_TENSORS) | {"stiffness": none, "damping": none}
    return _inertia(rigid_gram(body), body.mass, length) | elastic


def _inertia(gram: np.ndarray, mass: float, length: float) -> dict[str, Any]:
    return {"gram": gram, "inertia": inertia_arrays(gram), "coordinate_scale": length * np.sqrt(mass)}


def _body_groups(system: System, places: _BodyPlaces, length: float) -> tuple[BodyGroup, ...]:
    found = [
        (index, _arrays(placed.body, length))
        for index, placed in enumerate(system.bodies)
        if not placed.body.uses_interface_motions
    ]
    groups = []
    for group in _grouped(found, lambda each: _structure(each[1])):
        members = tuple(index for index, _ in group)
        velocities, coordinates = places.pair(members)
        arrays = {
            name: (_shared if name in _TENSORS else _stacked)([own[name] for _, own in group])
            for name in group[0][1]
        }
        groups.append(BodyGroup(members, velocities, coordinates, **arrays))
    return tuple(groups)


@dataclass(frozen=True)
class _End:
    """One end of a joint or force."""

    body: int
    motion: np.ndarray
    cubic_turn: float
    offset: np.ndarray
    axes: np.ndarray

    @property
    def key(self) -> Hashable:
        """Ends with equal keys are computed together."""
        return self.body < 0, self.motion.shape


def _ends(places: _BodyPlaces, ends: Sequence[_End]) -> Ends:
    bodies = tuple(end.body for end in ends)
    velocities, coordinates = (None, None) if bodies[0] < 0 else places.pair(bodies)
    return Ends(
        bodies,
        velocities,
        coordinates,
        motion=np.stack([end.motion for end in ends]),
        cubic_turn=np.array([end.cubic_turn for end in ends]),
        offset=np.stack([end.offset for end in ends]),
        axes=np.stack([end.axes for end in ends]),
    )


def interface_motion(placed: Placed, interface: str) -> tuple[np.ndarray, np.ndarray]:
    """Rest position (3,) of an interface, and its motion (6, r) per model coordinate of its body."""
    body = placed.body
    found = body.interface(interface)
    if body.uses_interface_motions:
        index = [own.name for own in body.interfaces].index(interface)
        return np.asarray(found.position), np.eye(6 * len(body.interfaces))[6 * index : 6 * index + 6]
    return np.asarray(found.position), np.asarray(found.motion)


def _end(system: System, end: At, axes: np.ndarray, ground_point: np.ndarray) -> _End:
    if end == GROUND:
        return _End(body=-1, motion=np.zeros((6, 0)), cubic_turn=0.0, offset=ground_point, axes=axes)
    index = system.body_index(end.body)
    placed = system.bodies[index]
    position, motion = interface_motion(placed, end.interface)
    cubic_turn = placed.body.interface(end.interface).cubic_turn
    return _End(index, motion, cubic_turn, offset=position, axes=placed.assembly.rotation.T @ axes)


def initial_points(system: System, element: Joint | ForceElement) -> tuple[np.ndarray, np.ndarray]:
    """Global positions of both ends at assembly; an end on the ground is by default at the other end."""
    own = [None if end == GROUND else system.initial_point(end) for end in (element.first, element.second)]
    given = element.ground_point if isinstance(element, ForceElement) else None
    on_ground = given if given is not None else next(point for point in own if point is not None)
    first, second = (on_ground if point is None else point for point in own)
    return first, second


def _both_ends(system: System, element: Joint | ForceElement) -> tuple[_End, _End]:
    first, second = initial_points(system, element)
    axes = element.initial_axes
    return _end(system, element.first, axes, first), _end(system, element.second, axes, second)


def _joint_groups(system: System, places: _BodyPlaces) -> tuple[JointGroup, ...]:
    rows = system.constraint_slices
    found = [(joint, rows[joint.name].start, *_both_ends(system, joint)) for joint in system.joints]

    def kind(each: tuple[Joint, int, _End, _End]) -> Hashable:
        joint, _, first, second = each
        return type(joint), _structure(joint.law), first.key, second.key

    groups = []
    for group in _grouped(found, kind):
        joint = group[0][0]
        groups.append(
            JointGroup(
                constraint=fixed_function(type(joint).constraint),
                rows=Places(tuple(row for _, row, _, _ in group), joint.n_constraints),
                of_positions=tuple(row.startswith("position") for row in joint.rows),
                law=_stacked_laws([own.law for own, _, _, _ in group]),
                first=_ends(places, [first for _, _, first, _ in group]),
                second=_ends(places, [second for _, _, _, second in group]),
            )
        )
    return tuple(groups)


def _force_groups(
    system: System, loads: Sequence[ForceElement], places: _BodyPlaces
) -> tuple[ForceGroup, ...]:
    for load in loads:
        check_apart(system, load)
    assembled = [load.assembled(*initial_points(system, load)) for load in loads]
    found = [(load, *_both_ends(system, load)) for load in assembled]

    def kind(each: tuple[ForceElement, _End, _End]) -> Hashable:
        load, first, second = each
        return type(load), _structure(load.law), _structure(load.parameters), first.key, second.key

    return tuple(
        ForceGroup(
            wrenches=fixed_function(type(group[0][0]).wrenches),
            law=_stacked_laws([load.law for load, _, _ in group]),
            parameters=_stacked([load.parameters for load, _, _ in group]),
            first=_ends(places, [first for _, first, _ in group]),
            second=_ends(places, [second for _, _, second in group]),
            reaction=_reaction_rows(system, [load for load, _, _ in group]),
        )
        for group in _grouped(found, kind)
    )


def _reaction_rows(system: System, loads: Sequence[ForceElement]) -> Places | None:
    """Places of the first two equations of joints with friction; None for other elements.

    The multipliers of these equations are the joint force normal to the axis.
    """
    if not isinstance(loads[0], JointFriction):
        return None
    rows = system.constraint_slices
    frictions = [load for load in loads if isinstance(load, JointFriction)]
    return Places(tuple(rows[load.joint.name].start for load in frictions), 2)


def _control_law(
    system: System, controller: Controller | SampledController, places: _BodyPlaces
) -> ControlLaw:
    def actuator(name: str, element: ForceElement) -> Actuator:
        (group,) = _force_groups(system, [element], places)
        return Actuator(name, element.value_shape, group)

    sampled = isinstance(controller, SampledController)
    return ControlLaw(
        name=controller.name,
        outputs=None if sampled else UserFunction(controller.outputs),
        rates=None if sampled or controller.rates is None else UserFunction(controller.rates),
        readers=_readers(system, controller.reads, places),
        actuators=tuple(actuator(name, element) for name, element in controller.drives.items()),
        initial=np.zeros(0) if sampled else np.asarray(controller.initial),
    )


def _readers(system: System, reads: Mapping[str, Reading], places: _BodyPlaces) -> tuple[Reader, ...]:
    joints = {joint.name: joint for joint in system.joints}

    def reader(name: str, reading: Reading) -> Reader:
        near = 0.0
        if isinstance(reading, JointReading):
            ends, near = _both_ends(system, joints[reading.joint]), reading.near
        else:
            own = _end(system, reading.at, np.eye(3), np.zeros(3))
            ends = own, own
        first, second = (_ends(places, [end]) for end in ends)
        return Reader(name, isinstance(reading, JointReading), first, second, np.float64(near))

    return tuple(reader(name, reading) for name, reading in reads.items())


def readers_of(system: System, reads: Mapping[str, Reading]) -> tuple[Reader, ...]:
    """Named readings of a machine, as arrays."""
    return _readers(system, reads, _BodyPlaces.of(system))


def force_group_of(system: System, element: ForceElement) -> ForceGroup:
    """One force element as arrays, whether it belongs to the machine or not."""
    (group,) = _force_groups(system, [element], _BodyPlaces.of(system))
    return group


def check_apart(system: System, load: ForceElement) -> None:
    """Raise ModelError for a force element along a line whose ends coincide at assembly."""
    first, second = initial_points(system, load)
    if load.acts_along_line and np.array_equal(first, second):
        raise ModelError(
            f"{load.label}: both ends start at {first.tolist()}, so its line of action is undefined: "
            "move one of the ends"
        )


def _nodal_load(system: System, load: NodalLoad, places: _BodyPlaces) -> NodalLoadArrays:
    index = system.body_index(load.body)
    placed = system.bodies[index]
    if load.nodes.size:
        body: Any = placed.body  # reduced: loads on full bodies belong to the sparse method
        positions, basis = body.nodes[load.nodes], body.displacement_basis[load.nodes]
    else:
        position, motion = interface_motion(placed, str(getattr(load, "at", "")))
        positions, basis = position[None], motion[None, :3]
    velocities, coordinates = places.pair([index])
    return NodalLoadArrays(index, velocities, coordinates, prepared(load), positions, basis)


def row_scales(system: System, length: float | None = None) -> np.ndarray:
    """Scale of each constraint equation: a length for positions, 1 for angles, (m,).

    length : by default the system's size
    """
    length = system_length(system) if length is None else length
    return np.array(
        [length if row.startswith("position") else 1.0 for joint in system.joints for row in joint.rows]
    )


def system_length(system: System) -> float:
    """Size of the system: diagonal of the box around all nodes and frame origins at assembly.

    For a system with a single point: the largest radius of gyration of its rigid bodies, or 1 without rigid
    bodies.
    """
    assemblies = [(placed.body.nodes, *placed.assembly) for placed in system.bodies]
    points = [position[None] for _, position, _ in assemblies]
    points += [position + nodes @ rotation.T for nodes, position, rotation in assemblies]
    extent = float(np.linalg.norm(np.ptp(np.concatenate(points), axis=0)))
    rigid = system.bodies_of(RigidBody).values()
    gyration = max((float(np.sqrt(np.trace(body.inertia) / body.mass)) for body in rigid), default=1.0)
    return extent if extent > ONE_POINT * gyration else gyration
