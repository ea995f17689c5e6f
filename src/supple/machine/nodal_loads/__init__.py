"""Loads on the nodes of a body, one kind per module."""

from supple.machine.nodal_loads.base_acceleration import BaseAcceleration
from supple.machine.nodal_loads.dead_force import DeadForce
from supple.machine.nodal_loads.follower_pressure import FollowerPressure
from supple.machine.nodal_loads.nodal_load import NodalLoad

__all__ = ["BaseAcceleration", "DeadForce", "FollowerPressure", "NodalLoad"]
