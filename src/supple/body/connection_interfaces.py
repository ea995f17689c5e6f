"""Interfaces from the connections of a mesh file: RBE2 becomes rigid, RBE3 averaging."""

from __future__ import annotations

from collections.abc import Container, Sequence

from supple.body.interface import AveragingInterface, RigidInterface
from supple.errors import ModelError
from supple.importers import Connection

__all__ = ["check_rigid_connections", "connection_interface", "connection_named"]


def connection_interface(
    connection: Connection, name: str | None = None
) -> RigidInterface | AveragingInterface:
    """The interface defined by a connection; `name` replaces the name of the connection."""
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
