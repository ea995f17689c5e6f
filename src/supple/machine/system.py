"""A machine: bodies placed in space, joints between them, loads on them, gravity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import sparray
from scipy.spatial.transform import Rotation

from supple.arguments import check_instance, check_members, check_numbers, check_sequence
from supple.body import BodyForm, FlexibleBody, FullBody
from supple.errors import ModelError, did_you_mean
from supple.machine.contacts import Contact, Support, SurfaceContact
from supple.machine.control.controller import Controller, EndReading, SampledController
from supple.machine.ends import GROUND, At
from supple.machine.forces.force_element import AxialElement, ForceElement
from supple.machine.forces.joint_friction import JointFriction
from supple.machine.joints.joint import Joint
from supple.machine.laws.time_law import check_law_shape
from supple.machine.nodal_loads.base_acceleration import BaseAcceleration
from supple.machine.nodal_loads.nodal_load import NodalLoad
from supple.machine.ties.tie import Tie
from supple.mesh import Mesh
from supple.summary import N_LINES, Summarized, Summary, listed, place_text

__all__ = ["Placed", "System"]

_Form = TypeVar("_Form")


_ACROSS = 1e-3
"""Smallest component, along the free directions of a joint, of the unit axis of a servo at this joint."""
# Attributes that every type of body needs in a machine.
_BODY = ("name", "kind", "n_coordinates", "interfaces")
_EXPLICIT = ("modal", "explicit")
"""Kinds of bodies that only explicit runs support: modal parts and finite-element parts."""
_OF_PARTS = {
    "ties": ((Tie,), "ties such as Tie(At(part, node set), on=part)"),
    "contacts": (
        (Contact, SurfaceContact),
        "a Contact(At(part, node set), obstacle) or a SurfaceContact(..)",
    ),
    "supports": ((Support,), "supports such as Support(At(part, node set), axes)"),
}
"""Fields of `System` for explicit parts only, with the types of their members and a description."""


class AssembledPose(NamedTuple):
    """Pose of a body's frame at assembly, where the body is undeformed."""

    position: np.ndarray
    """(3,) global"""
    rotation: np.ndarray
    """(3, 3) body to global"""


def space_vector(what: str, value: object) -> np.ndarray:
    """The value as an array (3,), read-only.

    Raises ModelError unless it consists of three finite numbers; `what` names the quantity in the message.
    """
    check_numbers(what, value)
    array = np.array(value, dtype=float)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ModelError(f"{what} must be three finite numbers, got {value}")
    array.setflags(write=False)
    return array


def rotation_matrix(what: str, value: object) -> np.ndarray:
    """Rotation matrix (3, 3), read-only, from a rotation vector (3,), rad, or a matrix.

    Raises ModelError for another shape, or a matrix that is not orthonormal or has a negative determinant.
    """
    check_numbers(what, value)
    matrix = np.array(value, dtype=float)
    if matrix.shape == (3,):
        space_vector(what, matrix)
        matrix = Rotation.from_rotvec(matrix).as_matrix()
    if matrix.shape != (3, 3) or not np.allclose(matrix.T @ matrix, np.eye(3), atol=1e-9):
        raise ModelError(f"{what} must be a rotation vector (3,) or an orthonormal matrix (3, 3)")
    if np.linalg.det(matrix) < 0:
        raise ModelError(f"{what} mirrors the body (determinant -1): swap two columns")
    matrix.setflags(write=False)
    return matrix


@dataclass(frozen=True, eq=False, repr=False)
class Placed(Summarized):
    """A body with the initial position and velocity of its floating frame.

    position : (3,)           position of the frame origin, global components
    rotation : (3,) or (3, 3) rotation vector (rad) or rotation matrix, from body to global components
    velocity : (3,)           velocity of the frame origin, global components. The frame origin of an elastic
        body is the origin of its mesh. To give the velocity of the centre of mass, use `with_centre_velocity`
    angular_velocity : (3,)   rad/s, body components
    coordinates, coordinate_rates : (r,) reduced coordinates at the start, and their rates; default zero
    assembled : AssembledPose pose in which points and axes of joints and forces are defined; default: the
        initial pose. The two poses differ, for example, after `equilibrium`
    is_moving : whether velocities and rates are those of an earlier motion (`Start`). Joints that do not
        allow them then act as an impact, which changes the velocities of all coordinates

    If velocity or angular_velocity is None, it is computed from the joints, their laws and the other bodies;
    components that these do not determine are zero. If it is given, even as zero, it is changed only as far
    as the joints require.
    Raises ModelError for a vector of the wrong size, a matrix that is not a rotation, or a FlexibleBody,
    which must first be reduced, or made a FullBody.
    """

    body: BodyForm
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rotation: np.ndarray = field(default_factory=lambda: np.zeros(3))
    velocity: np.ndarray | None = None
    angular_velocity: np.ndarray | None = None
    coordinates: np.ndarray = field(default_factory=lambda: np.zeros(0))
    coordinate_rates: np.ndarray = field(default_factory=lambda: np.zeros(0))
    assembled: AssembledPose | None = None
    is_moving: bool = False

    def summary(self) -> Summary:
        """Initial position and velocity of the body."""
        angles = Rotation.from_matrix(self.rotation).as_rotvec()
        rows = [
            ("position", place_text(self.position)),
            ("rotation vector, rad", place_text(angles)),
        ]
        for name, value in (("velocity", self.velocity), ("angular velocity", self.angular_velocity)):
            rows.append((name, "by the joints, or zero" if value is None else place_text(value)))
        rows.append(("deformed", "yes" if np.any(self.coordinates) else "no"))
        return Summary(
            f"Placed body '{self.body.name}' ({self.body.kind}) at {place_text(self.position)}", rows
        )

    def __post_init__(self) -> None:
        if isinstance(self.body, FlexibleBody):
            raise ModelError(
                f"body '{self.body.name}' is a FlexibleBody, which has no floating frame yet: place "
                "reduce(body, frame, basis), or FullBody(body, frame) for all freedoms"
            )
        check_members("Placed, body", self.body, _BODY, "a RigidBody, a ReducedBody or a FullBody")
        name = self.body.name
        for item in ("position", "velocity", "angular_velocity"):
            if item == "position" or getattr(self, item) is not None:
                object.__setattr__(self, item, space_vector(f"{item} of body '{name}'", getattr(self, item)))
        object.__setattr__(self, "rotation", rotation_matrix(f"rotation of body '{name}'", self.rotation))
        r = self.body.n_coordinates
        for item in ("coordinates", "coordinate_rates"):
            check_numbers(f"{item} of body '{name}'", getattr(self, item))
            value = np.array(getattr(self, item), dtype=float)
            array = value if value.size else np.zeros(r)
            if array.shape != (r,) or not np.isfinite(array).all():
                raise ModelError(
                    f"{item} of body '{name}' must be {r} finite numbers, got shape {array.shape}"
                )
            array.setflags(write=False)
            object.__setattr__(self, item, array)

    @property
    def assembly(self) -> AssembledPose:
        """Pose in which joints and forces are defined: `assembled`, or the initial pose if this is None."""
        return self.assembled or AssembledPose(self.position, self.rotation)

    @property
    def twist(self) -> np.ndarray:
        """Given velocity and angular velocity (6,); zero in place of None."""
        given = (self.velocity, self.angular_velocity)
        return np.concatenate([np.zeros(3) if part is None else part for part in given])

    def in_form(self, form: BodyForm, onto: np.ndarray | sparray) -> Placed:
        """The placed body in another form, such as a FullBody in place of a ReducedBody.

        form : the new form of the body, with r' coordinates
        onto : (r', r) matrix, dense or sparse, from the present coordinates to those of `form`
        """
        return replace(
            self,
            body=form,
            coordinates=onto @ self.coordinates,
            coordinate_rates=onto @ self.coordinate_rates,
        )

    def with_centre_velocity(self, velocity: ArrayLike) -> Placed:
        """The placed body with a given velocity v_c (3,) of its undeformed centre of mass c, global.

            v = v_c - A (w x c)

        v is the velocity of the frame origin, A the rotation matrix of the frame, and w its angular velocity,
        which does not change; zero in place of None.
        """
        turning = np.zeros(3) if self.angular_velocity is None else self.angular_velocity
        centre = space_vector(f"centre velocity of body '{self.body.name}'", velocity)
        origin = centre - self.rotation @ np.cross(turning, self.body.centre_of_mass)
        return replace(self, velocity=origin, angular_velocity=turning)

    def moved_to(self, position: np.ndarray, rotation: np.ndarray) -> Placed:
        """The body in another initial pose; its pose at assembly does not change.

        rotation : (3, 3); its rounding errors after many rotations are removed
        """
        left, _, right = np.linalg.svd(rotation)
        return replace(self, position=position, rotation=left @ right, assembled=self.assembly)

    def positions(self, nodes: ArrayLike | slice = slice(None)) -> np.ndarray:
        """Global positions `R + A (x + u)` (k, 3) of some or all nodes, with the initial deformation."""
        own = nodes if isinstance(nodes, slice) else np.asarray(nodes)
        local = self.body.nodes[own] + self.body.expand(self.coordinates, own)
        return self.position + local @ self.rotation.T


Load = ForceElement | NodalLoad | BaseAcceleration
"""Anything that acts on the bodies besides joints and gravity."""


@dataclass(frozen=True, eq=False, repr=False)
class System(Summarized):
    """Bodies, joints, loads and gravity; checked at construction.

    bodies : Placed, one per body, with different names; a body without `Placed` is at the origin, not rotated
    joints : Joint, with different names
    loads : ForceElement | NodalLoad | BaseAcceleration
    gravity : (3,) acceleration, global components, such as (0, 0, -9.81); default zero
    controllers : Controller | SampledController, with different names
    ties : Tie, of explicit parts
    contacts : Contact | SurfaceContact, of explicit parts
    supports : Support, of explicit parts
    Raises ModelError for a machine without bodies; a name used twice; a joint or load on a body or interface
    that does not exist; a law whose values have the wrong shape; a controller that reads a joint that does
    not exist.
    """

    bodies: Sequence[Placed | Any]
    joints: Sequence[Joint] = ()
    loads: Sequence[Load] = ()
    gravity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    controllers: Sequence[Controller | SampledController] = ()
    ties: Sequence[Tie] = ()
    contacts: Sequence[Contact | SurfaceContact] = ()
    supports: Sequence[Support] = ()

    def __post_init__(self) -> None:
        for item in ("bodies", "joints", "loads", "controllers", *_OF_PARTS):
            check_sequence(f"System, {item}", getattr(self, item), f"a list of {item}, also of a single one")
            object.__setattr__(self, item, tuple(getattr(self, item)))
        placed = (body if isinstance(body, Placed) else Placed(body) for body in self.bodies)
        object.__setattr__(self, "bodies", tuple(placed))
        for joint in self.joints:
            check_instance(
                "System, joints", joint, Joint, "joints such as Revolute(first=.., second=.., axis=..)"
            )
        for load in self.loads:
            expected = "loads such as DeadForce(at=.., force=..), or springs"
            check_instance("System, loads", load, (ForceElement, NodalLoad, BaseAcceleration), expected)
        object.__setattr__(self, "gravity", space_vector("gravity", self.gravity))
        if not self.bodies:
            raise ModelError("a system needs at least one body")
        names = [placed.body.name for placed in self.bodies]
        for kind, seen in (("body", names), ("joint", [joint.name for joint in self.joints])):
            for name in seen:
                if seen.count(name) > 1:
                    raise ModelError(
                        f"{kind} name '{name}' is used {seen.count(name)} times: names must differ"
                    )
        if GROUND.body in names:
            raise ModelError("no body may be named 'ground', the fixed frame of joints: rename it")
        for joint in self.joints:
            self._check_end(f"joint '{joint.name}'", joint.first)
            self._check_end(f"joint '{joint.name}'", joint.second)
            if joint.law is not None:
                check_law_shape(f"joint '{joint.name}'", joint.law, ())
        for load in self.loads:
            self._check_load(load)
        self._check_controllers()
        self._check_parts()

    def summary(self) -> Summary:
        """Bodies with their types, joints with their ends, loads, controllers and gravity."""
        sizes = (f"{item} {len(getattr(self, item))}" for item in ("bodies", "joints", "loads"))
        rows = [
            (f"body {placed.body.name}", f"{placed.body.kind}, {placed.body.n_coordinates} coordinates")
            for placed in self.bodies
        ]
        rows += [
            (f"joint {joint.name}", f"{type(joint).__name__}: {joint.first} - {joint.second}")
            for joint in self.joints
        ]
        named = {"loads": [load.label for load in self.loads]}
        named["controllers"] = [each.name for each in self.controllers]
        named |= {item: [each.nodes for each in getattr(self, item)] for item in _OF_PARTS}
        rest = [(item, listed(names)) for item, names in named.items() if names]
        rest += [("gravity", place_text(self.gravity))] if self.gravity.any() else []
        # The rows of bodies and joints are truncated, so that the rows of loads are shown.
        most = N_LINES - 2 - len(rest)
        if len(rows) > most:
            rows = [*rows[:most], ("...", f"{len(rows) - most} bodies and joints more")]
        return Summary(f"System: {', '.join(sizes)}", rows + rest)

    def _check_parts(self) -> None:
        """Raise ModelError unless ties, contacts and supports act on node sets of explicit parts."""
        for item, (kinds, expected) in _OF_PARTS.items():
            for each in getattr(self, item):
                check_instance(f"System, {item}", each, kinds, expected)
                what = f"{item[:-1]} of '{each.nodes}'"
                for end in (each.nodes, *((each.surface,) if isinstance(each, SurfaceContact) else ())):
                    self._check_end(what, end)
                    if (body := self.placed(end.body, what).body).kind not in _EXPLICIT:
                        raise ModelError(
                            f"{what}: it acts on explicit parts, but body '{body.name}' is "
                            f"{body.kind}: make the body a modal_subdomain or an explicit_subdomain, or "
                            f"leave out the {item[:-1]}"
                        )
                if isinstance(each, Tie):
                    self.body_index(each.on, what)

        free = [contact.obstacle for contact in self.rigid_contacts if np.isfinite(contact.obstacle.mass)]
        for number, obstacle in enumerate(free):
            if any(obstacle is other for other in free[:number]):
                raise ModelError(
                    f"a free {type(obstacle).__name__} is the obstacle of two contacts, which would move it "
                    "independently: use one contact with all nodes, or one obstacle for each contact"
                )

    @property
    def acting(self) -> tuple[Load, ...]:
        """All loads, then the force elements that controllers drive."""
        driven = (element for each in self.controllers for element in each.drives.values())
        return (*self.loads, *driven)

    def check_has_frames(self) -> None:
        """Raise ModelError for explicit finite elements, which only explicit runs support."""
        for body in (placed.body for placed in self.bodies):
            if not body.has_frame:
                raise ModelError(
                    f"body '{body.name}' has explicit finite elements, which only `simulate` supports; for "
                    "statics, modes, batches and error estimates reduce the body, or use a FullBody"
                )

    def _check_controllers(self) -> None:
        names = [controller.name for controller in self.controllers]
        joints = [joint.name for joint in self.joints]
        for controller in self.controllers:
            expected = "Controller(reads=.., drives=.., outputs=..) or SampledController(..)"
            kinds = (Controller, SampledController)
            check_instance("System, controllers", controller, kinds, expected)
            if names.count(controller.name) > 1:
                raise ModelError(
                    f"controller name '{controller.name}' is used more than once: names must differ"
                )
            what = f"controller '{controller.name}'"
            for reading in controller.reads.values():
                if isinstance(reading, EndReading):
                    self._check_end(what, reading.at)
                elif reading.joint not in joints:
                    near = did_you_mean(reading.joint, joints)
                    raise ModelError(f"{what}: there is no joint '{reading.joint}'{near}")
            for key, element in controller.drives.items():
                self._check_load(element)
                if any(element is load for load in self.loads):
                    raise ModelError(
                        f"{what} drives {element.label} ('{key}'), which is also among the loads: the "
                        "element would act twice; leave it out of loads (in a case file, remove its table "
                        "and create it in the controller's function)"
                    )
        drivers = [(own, element) for own in self.controllers for element in own.drives.values()]
        for number, (own, element) in enumerate(drivers):
            if any(element is other for _, other in drivers[:number]):
                raise ModelError(
                    f"controller '{own.name}' drives {element.label}, which another output drives already: "
                    "the element would act twice; give each output a separate element"
                )

    def _check_moves_something(self, element: ForceElement) -> None:
        """Raise ModelError for a servo or motor whose motion a joint between the same two ends prevents."""
        if not isinstance(element, AxialElement) or not element.blocked_by:
            return
        for joint in self.joints:
            if {joint.first, joint.second} != {element.first, element.second}:
                continue
            held = np.array(
                [any(f"{words} {axis}" in joint.rows for words in element.blocked_by) for axis in "xyz"]
            )
            held[2] &= joint.law is None
            free = joint.initial_axes[:, ~held]
            if np.linalg.norm(free.T @ element.initial_axes[:, 2]) < _ACROSS:
                ways = " or ".join(str(np.round(axis, 4).tolist()) for axis in free.T)
                remedy = (
                    f"give it an axis along {ways}, which the joint leaves free, or" if ways else "give it"
                )
                raise ModelError(
                    f"{element.label}: it has no effect, because joint '{joint.name}' fixes its ends along "
                    f"the axis {tuple(element.axis)}: {remedy} ends that can move relative to each other"
                )

    def _check_load(self, load: Load) -> None:
        if isinstance(load, NodalLoad):
            self._check_nodal_load(load)
        elif isinstance(load, BaseAcceleration):
            check_law_shape(load.label, load.law, (3,))
        else:
            self._check_end(load.label, load.first)
            self._check_end(load.label, load.second)
            self._check_moves_something(load)
            if isinstance(load, JointFriction) and load.joint not in self.joints:
                raise ModelError(f"{load.label}: this joint is not among the machine's joints")
            if load.law is not None:
                check_law_shape(load.label, load.law, load.value_shape)

    def _check_end(self, what: str, end: At) -> None:
        if end == GROUND:
            return
        known = [interface.name for interface in self.placed(end.body, what).body.interfaces]
        if end.interface not in known:
            raise ModelError(
                f"{what}: body '{end.body}' has no interface '{end.interface}'"
                + did_you_mean(end.interface, known)
            )

    def _check_nodal_load(self, load: NodalLoad) -> None:
        body, nodes = self.placed(load.body, load.label).body, load.nodes
        if not nodes.size:
            self._check_end(load.label, At(load.body, str(getattr(load, "at", ""))))
        elif body.n_coordinates == 0:
            raise ModelError(f"{load.label}: a rigid body has no nodes; name one of its interfaces")
        elif nodes.min() < 0 or nodes.max() >= len(body.nodes):
            raise ModelError(
                f"{load.label}: node indices run from {nodes.min()} to {nodes.max()}, "
                f"but the body has nodes 0 to {len(body.nodes) - 1}"
            )
        check_law_shape(load.label, load.law, *load.value_shapes)
        full = body if isinstance(body, FullBody) else getattr(body, "full", None)
        if isinstance(full, FullBody):
            full.body.warn_of_massless(load.label, nodes)

    def initial_point(self, end: At) -> np.ndarray:
        """Global position (3,) of an interface at assembly, where the bodies are undeformed."""
        placed = self.placed(end.body)
        position, rotation = placed.assembly
        return position + rotation @ placed.body.interface(end.interface).position

    @property
    def n_constraints(self) -> int:
        """Number of constraint equations of all joints, including redundant ones."""
        return sum(joint.n_constraints for joint in self.joints)

    @property
    def constraint_slices(self) -> dict[str, slice]:
        """By joint name, the slice of its equations in the vector of all constraint equations."""
        ends = np.cumsum([0, *(joint.n_constraints for joint in self.joints)])
        spans = zip(self.joints, pairwise(ends), strict=True)
        return {joint.name: slice(int(begin), int(end)) for joint, (begin, end) in spans}

    def placed(self, name: str, what: str = "lookup") -> Placed:
        """The placed body with a name; ModelError, beginning with `what`, if there is none."""
        return self.bodies[self.body_index(name, what)]

    @property
    def rigid_contacts(self) -> tuple[Contact, ...]:
        """Contacts with rigid obstacles, in the order of the results."""
        return tuple(contact for contact in self.contacts if isinstance(contact, Contact))

    @property
    def surface_contacts(self) -> tuple[SurfaceContact, ...]:
        """Contacts between parts."""
        return tuple(contact for contact in self.contacts if isinstance(contact, SurfaceContact))

    def node_numbers(self, end: At) -> np.ndarray:
        """Numbers of the nodes (n,) of a node set, within its explicit part."""
        part: Any = self.placed(end.body).body
        return part.interface(end.interface).nodes

    def mesh_of(self, part: str) -> Mesh:
        """Mesh of the elements of an explicit part."""
        body: Any = self.placed(part).body
        return body.mesh

    def bodies_of(self, form: type[_Form]) -> dict[str, _Form]:
        """The bodies of one type, such as FullBody, by name, in the order of `bodies`."""
        named = ((placed.body.name, placed.body) for placed in self.bodies)
        return {name: body for name, body in named if isinstance(body, form)}

    def body_index(self, name: str, what: str = "lookup") -> int:
        """Index in `bodies` of the body with a name; ModelError, beginning with `what`, if there is none."""
        names = [placed.body.name for placed in self.bodies]
        if name not in names:
            raise ModelError(f"{what}: there is no body '{name}'" + did_you_mean(name, names))
        return names.index(name)
