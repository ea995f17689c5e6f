"""Loads on the nodes of a body, one kind per module."""

from supple.machine.nodal_loads.dead_force import (
    DeadForce,
)

__all__ = [
    "DeadForce",
]
