"""Machines linearised about an equilibrium: modes, state space, frequency response, Campbell diagram."""

from supple.linearization.campbell import CampbellDiagram, campbell_diagram, modal_assurance
from supple.linearization.frequency_response import (
    FrequencyResponse,
    RandomResponse,
    frequency_response,
    random_response,
)
from supple.linearization.linear_machine import LinearMachine
from supple.linearization.linearize import linearize
from supple.linearization.machine_modes import MachineModes, machine_modes
from supple.linearization.mode_motion import mode_motion
from supple.linearization.ports import Port, RotationPort, TranslationPort
from supple.linearization.sparse_machine import SparseMachine
from supple.linearization.state_space import Acceleration, StateSpace, Velocity, state_space

__all__ = [
    "Acceleration",
    "CampbellDiagram",
    "FrequencyResponse",
    "LinearMachine",
    "MachineModes",
    "Port",
    "RandomResponse",
    "RotationPort",
    "SparseMachine",
    "StateSpace",
    "TranslationPort",
    "Velocity",
    "campbell_diagram",
    "frequency_response",
    "linearize",
    "machine_modes",
    "modal_assurance",
    "mode_motion",
    "random_response",
    "state_space",
]
