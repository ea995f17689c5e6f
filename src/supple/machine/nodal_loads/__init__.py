"""Loads on the nodes of a body, one kind per module."""

from supple.machine.nodal_loads.base_acceleration import *
from supple.machine.nodal_loads.dead_force import *
from supple.machine.nodal_loads.follower_pressure import *
from supple.machine.nodal_loads.nodal_load import *
