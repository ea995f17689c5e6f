"""Machines linearised about an equilibrium: modes, state space, frequency response, Campbell diagram."""

from supple.linearization.linear_machine import LinearMachine
from supple.linearization.linearize import linearize
from supple.linearization.machine_modes import MachineModes, machine_modes

__all__ = ["LinearMachine", "MachineModes", "linearize", "machine_modes"]
