"""Controllers: laws that depend on what they read of the machine, in every step or at sampling instants."""

from supple.machine.control.controller import Controller, SampledController
from supple.machine.control.readings import EndReading, JointReading

__all__ = ["Controller", "EndReading", "JointReading", "SampledController"]
