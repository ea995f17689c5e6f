"""A machine: bodies placed in space, joints between them, loads on them, gravity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches

import numpy as np
from scipy.spatial.transform import Rotation

from supple.body import RigidBody
from supple.body.full_body import FullBody
from supple.errors import ModelError
from supple.machine.forces.force_element import ForceElement
from supple.machine.joints.joint import GROUND, At, Joint
from supple.machine.laws.time_law import check_law_shape
from supple.machine.nodal_loads.dead_force import DeadForce
from supple.reduction import ReducedBody

__all__ = ["Body", "Placed", "System"]

Body = RigidBody | ReducedBody | FullBody


def _vector(name: str, value: object) -> np.ndarray:
    array = np.array(value, dtype=float)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ModelError(f"{name} must be three finite numbers, got {value}")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class Placed:
    """A body with the initial position and velocity of its floating frame.

    position : (3,)           frame origin, global
    rotation : (3,) or (3, 3) rotation vector (rad) or matrix, body to global
    velocity : (3,)           of the frame origin, global
    angular_velocity : (3,)   body components, rad/s
    coordinates, coordinate_rates : (r,) deformation at the start; zero unless given
    Raises ModelError for a vector of the wrong size, or a matrix that is not a rotation.
    """

    body: Body
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rotation: np.ndarray = field(default_factory=lambda: np.zeros(3))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    coordinates: np.ndarray = field(default_factory=lambda: np.zeros(0))
    coordinate_rates: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        name = self.body.name
        for item in ("position", "velocity", "angular_velocity"):
            object.__setattr__(self, item, _vector(f"{item} of body '{name}'", getattr(self, item)))
        rotation = np.array(self.rotation, dtype=float)
        if rotation.shape == (3,):
            _vector(f"rotation of body '{name}'", rotation)
            rotation = Rotation.from_rotvec(rotation).as_matrix()
        if rotation.shape != (3, 3) or not np.allclose(rotation.T @ rotation, np.eye(3), atol=1e-9):
            raise ModelError(
                f"rotation of body '{name}' must be a rotation vector (3,) or an orthonormal matrix (3, 3)"
            )
        if np.linalg.det(rotation) < 0:
            raise ModelError(f"rotation of body '{name}' mirrors the body (determinant -1): swap two columns")
        rotation.setflags(write=False)
        object.__setattr__(self, "rotation", rotation)
        r = n_coordinates(self.body)
        for item in ("coordinates", "coordinate_rates"):
            value = np.array(getattr(self, item), dtype=float)
            array = value if value.size else np.zeros(r)
            if array.shape != (r,) or not np.isfinite(array).all():
                raise ModelError(
                    f"{item} of body '{name}' must be {r} finite numbers, got shape {array.shape}"
                )
            array.setflags(write=False)
            object.__setattr__(self, item, array)


def n_coordinates(body: Body) -> int:
    """Number of deformation coordinates of a body."""
    return 0 if isinstance(body, RigidBody) else body.r


def interface_names(body: Body) -> tuple[str, ...]:
    """Names of a body's interfaces."""
    if isinstance(body, RigidBody):
        return tuple(body.interfaces)
    return tuple(interface.name for interface in body.interfaces)


def _did_you_mean(name: str, known: Sequence[str]) -> str:
    close = get_close_matches(name, known, n=1)
    return f"; did you mean '{close[0]}'?" if close else f"; there are: {', '.join(known) or 'none'}"


@dataclass(frozen=True, eq=False)
class System:
    """Bodies, joints, loads and gravity; checked when built.

    bodies : Placed, one per body, names unique
    joints : Joint, names unique
    loads : DeadForce | ForceElement
    gravity : (3,) global, e.g. (0, 0, -9.81)
    Raises ModelError: no body, a name used twice, a joint or load on a body or interface that is not there, a
        quantity over time of the wrong shape.
    """

    bodies: tuple[Placed, ...]
    joints: tuple[Joint, ...] = ()
    loads: tuple[DeadForce | ForceElement, ...] = ()
    gravity: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        for item in ("bodies", "joints", "loads"):
            object.__setattr__(self, item, tuple(getattr(self, item)))
        object.__setattr__(self, "gravity", _vector("gravity", self.gravity))
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
            raise ModelError("no body may be named 'ground': joints use that name for what does not move")
        for joint in self.joints:
            self._check_end(f"joint '{joint.name}'", joint.first)
            self._check_end(f"joint '{joint.name}'", joint.second)
            if joint.law is not None:
                check_law_shape(f"joint '{joint.name}'", joint.law, ())
        for load in self.loads:
            if isinstance(load, DeadForce):
                self._check_dead_force(load)
            else:
                self._check_end(load.label, load.first)
                self._check_end(load.label, load.second)
                if load.law is not None:
                    check_law_shape(load.label, load.law, load.value_shape)

    def _check_end(self, what: str, end: At) -> None:
        if end == GROUND:
            return
        self.body_index(end.body, what)
        known = interface_names(self.bodies[self.body_index(end.body)].body)
        if end.interface not in known:
            raise ModelError(
                f"{what}: body '{end.body}' has no interface '{end.interface}'"
                + _did_you_mean(end.interface, known)
            )

    def _check_dead_force(self, load: DeadForce) -> None:
        body = self.bodies[self.body_index(load.body, load.label)].body
        if isinstance(load.at, str):
            self._check_end(load.label, At(load.body, load.at))
            check_law_shape(load.label, load.law, (3,))
            return
        if isinstance(body, RigidBody):
            raise ModelError(f"{load.label}: a rigid body has no nodes; name one of its interfaces")
        nodes = np.asarray(load.at)
        if nodes.ndim != 1 or nodes.size == 0:
            raise ModelError(f"{load.label}: node indices must be a list of at least one node")
        if nodes.min() < 0 or nodes.max() >= len(body.nodes):
            raise ModelError(
                f"{load.label}: node indices run from {nodes.min()} to {nodes.max()}, "
                f"but the body has nodes 0 to {len(body.nodes) - 1}"
            )
        check_law_shape(load.label, load.law, (3,), (nodes.size, 3))

    def body_index(self, name: str, what: str = "lookup") -> int:
        """Position of the body of that name among `bodies`."""
        names = [placed.body.name for placed in self.bodies]
        if name not in names:
            raise ModelError(f"{what}: there is no body '{name}'" + _did_you_mean(name, names))
        return names.index(name)
