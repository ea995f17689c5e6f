"""Interfaces from the connections of a mesh file: RBE2 becomes rigid, RBE3 averaging."""

from __future__ import annotations

from collections.abc import Sequence

from supple.body.interface import AveragingInterface, RigidInterface
from supple.errors import ModelError
from supple.importers import Connection


def connection_interface(
    connection: Connection, name: str | None = None
) -> RigidInterface | AveragingInterface:
    """The interface that a connection describes, under its own name or another."""
    name = connection.name if name is None else name
    if connection.weights is None:
        return RigidInterface(name, connection.nodes, connection.position)
    return AveragingInterface(name, connection.nodes, connection.position, connection.weights)


def connection_named(name: str, connections: Sequence[Connection]) -> Connection:
    """The connection of that name; ModelError lists those there are."""
    for connection in connections:
        if connection.name == name:
            return connection
    known = ", ".join(f"'{connection.name}'" for connection in connections) or "none"
    raise ModelError(
        f"no connection '{name}' (RBE2, or RBE3 on nodes that all carry stiffness) in the mesh file; it has "
        f"{known}"
    )
