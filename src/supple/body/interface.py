"""Interfaces: the points of a body for joints and loads, each with the six freedoms of a virtual node."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.spatial.transform import Rotation

from supple.arguments import check_numbers, check_text
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError, did_you_mean
from supple.importers import Connection

__all__ = [
    "AveragingInterface",
    "BodyInterface",
    "Interface",
    "PointInterface",
    "RigidInterface",
    "check_rigid_connections",
    "connection_interface",
    "connection_named",
    "place_in_frame",
]

SAME_MOTION = 1e-10
"""Largest difference of two motion matrices that count as equal, relative to the largest entry."""


@dataclass(frozen=True, eq=False)
class RigidInterface:
    """Nodes that move as one rigid body with a virtual node (RBE2): u_a = u_v + theta_v x (x_a - x_v).

    u_a is the displacement of node a at x_a; u_v, theta_v and x_v are displacement, rotation and position of
    the virtual node. Nodes with rotations have theta_a = theta_v. The freedoms of the nodes are eliminated.
    The strains of adjacent elements include theta_v to second order (`second_order_tie`). Exceptions are
    linear bodies, and shells with von Karman strain.

    nodes    : name of a node set, or node numbers
    position : (3,) m, of the virtual node; by default the mean position of the nodes
    """

    name: str
    nodes: str | ArrayLike
    position: ArrayLike | None = None

    def __post_init__(self) -> None:
        _check_interface(self, self.position)


@dataclass(frozen=True, eq=False)
class AveragingInterface:
    """A virtual node that follows the mean rigid motion of its nodes (RBE3), without added stiffness.

    The mean is a weighted least-squares fit; see `averaged_motion`.

    nodes    : name of a node set, or node numbers
    position : (3,) m, of the virtual node; by default the weighted mean position of the nodes
    weights  : (k,) positive, one per node; by default equal. For an uneven mesh give the areas of the nodes
    """

    name: str
    nodes: str | ArrayLike
    position: ArrayLike | None = None
    weights: ArrayLike | None = None

    def __post_init__(self) -> None:
        _check_interface(self, self.position, self.weights)


def _check_interface(given: RigidInterface | AveragingInterface, *numbers: ArrayLike | None) -> None:
    """Raise ArgumentError for an invalid name, or for text in place of numbers."""
    check_text(f"{type(given).__name__}, name", given.name)
    for values in (None if isinstance(given.nodes, str) else given.nodes, *numbers):
        if values is not None:
            check_numbers(f"{type(given).__name__} '{given.name}'", values)


@dataclass(frozen=True, eq=False)
class BodyInterface:
    """A virtual node of a body: its position, and its motion as a linear map of the body's coordinates.

    position : (3,) in the mesh axes
    motion   : csr (6, n); displacement and rotation of the virtual node are (u_v, theta_v) = motion @ q
    node_ids : (k,) numbers of the nodes of the interface
    cubic_turn : c; a joint at this interface has the rotation vector theta_v (1 + c theta_v.theta_v)
    tied_nodes : numbers of the nodes tied rigidly to the interface, to second order (`second_order_tie`)

    c depends on how theta_v changes if the section rotates by the angle phi. Rigid interface: the energy of
    the adjacent elements, whose strains are truncated to second order, is least for |theta_v| = tan(phi);
    hence c = -1/3. Averaging interface: |theta_v| = sin(phi); hence c = 1/6. In a linear body, and where
    theta_v is the rotation of the nodes themselves (one node, or collinear nodes), c = 0.
    """

    name: str
    position: NDArray[np.float64]
    motion: sparse.csr_array
    node_ids: NDArray[np.int64]
    cubic_turn: float = 0.0
    tied_nodes: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))


class UntiedInterface:
    """Base of interfaces without tied nodes."""

    cubic_turn: ClassVar[float] = 0.0
    """A joint at the interface has the rotation vector theta, without a cubic term."""

    @property
    def tied_nodes(self) -> NDArray[np.int64]:
        """Empty (0,)."""
        return np.empty(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class PointInterface(UntiedInterface):
    """A point of a rigid body, whose motion in the body's frame is zero.

    position : (3,) in the body's axes
    """

    name: str
    position: NDArray[np.float64]

    @property
    def motion(self) -> NDArray[np.float64]:
        """Empty (6, 0): a rigid body has no coordinates."""
        return np.zeros((6, 0))


class Interface(Protocol):
    """The properties of an interface for every form of body."""

    @property
    def name(self) -> str:
        """Name of the interface, unique in the body."""
        ...

    @property
    def position(self) -> np.ndarray:
        """Undeformed position (3,) in the body's frame, m."""
        ...

    @property
    def motion(self) -> np.ndarray | sparse.csr_array:
        """Displacement and rotation per unit coordinate of the body, (6, r), dense or sparse."""
        ...

    @property
    def cubic_turn(self) -> float:
        """Coefficient c in the rotation vector theta (1 + c theta.theta) of a joint at the interface."""
        ...

    @property
    def tied_nodes(self) -> np.ndarray:
        """Numbers of the nodes tied rigidly to the interface, to second order."""
        ...


def moves_rigidly_with(interface: BodyInterface, other: BodyInterface) -> bool:
    """Whether `interface` moves like a point rigidly attached to `other`."""
    carried = sparse.csr_array(nodal_rigid_modes((interface.position - other.position)[None], 6))
    difference = abs(interface.motion - carried @ other.motion)
    return bool(difference.max() <= SAME_MOTION * abs(interface.motion).max())


def place_in_frame(interface: Interface, coordinates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pose of an interface in its body's frame: position x + u (t, 3), rotation exp(phi) (t, 3, 3).

        phi = theta (1 + c theta.theta),      (u, theta) = motion q

    coordinates : (t, r) q of the body
    """
    moved = coordinates @ interface.motion.T
    theta = moved[:, 3:]
    phi = theta * (1 + interface.cubic_turn * np.sum(theta**2, axis=1, keepdims=True))
    return interface.position + moved[:, :3], Rotation.from_rotvec(phi).as_matrix()


_Interface = TypeVar("_Interface", bound=Interface)


def interface_named(body: str, name: str, interfaces: Sequence[_Interface]) -> _Interface:
    """The interface of that name; the ModelError for an unknown name lists the nearest name, or all.

    body : name of the body, for the message
    """
    for interface in interfaces:
        if interface.name == name:
            return interface
    known = [interface.name for interface in interfaces]
    raise ModelError(f"body '{body}' has no interface '{name}'{did_you_mean(name, known)}")


def connection_interface(
    connection: Connection, name: str | None = None
) -> RigidInterface | AveragingInterface:
    """The interface of a connection, rigid for RBE2, averaging for RBE3; `name` replaces its name."""
    name = connection.name if name is None else name
    if connection.weights is None:
        return RigidInterface(name, connection.nodes, connection.position)
    return AveragingInterface(name, connection.nodes, connection.position, connection.weights)


def connection_named(name: str, connections: Sequence[Connection]) -> Connection:
    """The connection of that name; the ModelError for an unknown name lists all names."""
    for connection in connections:
        if connection.name == name:
            return connection
    known = ", ".join(f"'{connection.name}'" for connection in connections) or "none"
    raise ModelError(
        f"no connection '{name}' (RBE2, or RBE3 on nodes that all carry stiffness) in the mesh file; it has "
        f"{known}"
    )


def check_rigid_connections(
    body: str, file: str, connections: Sequence[Connection], taken: Container[str | None]
) -> None:
    """Raise ModelError if an RBE2 is not an interface: without it the body is softer than in the file.

    body, file : names, for the message
    taken : names of the connections that rigid interfaces use, directly or by the node set of that name
    """
    left = [each.name for each in connections if each.weights is None and each.name not in taken]
    if left:
        raise ModelError(
            f"body '{body}': {', '.join(left)} of {file} ties nodes rigidly and is not among the interfaces; "
            f'add an interface with connection = "{left[0]}", or remove the RBE2 from the file'
        )
