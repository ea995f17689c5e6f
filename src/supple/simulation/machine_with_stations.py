"""A machine with bodies of several forms, for the sparse engine."""

from __future__ import annotations

from supple.equations.station_body import MachineWithStations
from supple.machine import System
from supple.methods.floating.full.full_system import FullSystem
from supple.methods.intrinsic import IntrinsicBody
from supple.methods.intrinsic.line_in_frame import lines_in_frames

__all__ = ["full_system", "machine_with_stations"]


def machine_with_stations(system: System) -> MachineWithStations:
    """The machine with its intrinsic bodies in floating frames.

    Raises ModelError for intrinsic bodies whose modes have a fixed root.
    """
    return (
        lines_in_frames(system)
        if system.bodies_of(IntrinsicBody)
        else MachineWithStations(system, system, ())
    )


def full_system(system: System, active: tuple[int, ...] | None = None) -> FullSystem:
    """The equations of a machine; `active` are the independent constraint equations."""
    return FullSystem(machine_with_stations(system), active)
