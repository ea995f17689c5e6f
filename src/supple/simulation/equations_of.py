"""The equations of a machine at rest: the form of its bodies chooses the method."""

from __future__ import annotations

import numpy as np

from supple.equations.static_search import Equations
from supple.equations.steady_motion import SteadyTurning
from supple.machine import System
from supple.methods.explicit.check_machine import check_spun
from supple.methods.floating import compiled_statics, full_statics
from supple.methods.intrinsic.line_statics import line_statics
from supple.simulation.seen_machine import seen_machine

__all__ = ["equations_of"]


def equations_of(
    system: System, turning: SteadyTurning | None, time: float, known: tuple[int, ...] | None = None
) -> Equations:
    """A machine as its bodies are placed, made ready for statics and modes.

    turning : of its bodies in their order; None at rest
    known : equations of joints that are independent, where that is known: the joints are closed then
    Raises ModelError for a spin of modal parts that stiffen by it, and whatever the start of a run would
    find wrong with the joints.
    """
    if turning is not None and np.any(turning.angular_velocities):
        check_spun(system)
    kinds = {placed.body.kind for placed in system.bodies}
    if "full" in kinds or ("intrinsic" in kinds and system.controllers):
        return full_statics(seen_machine(system), turning, time, known)
    method = line_statics if "intrinsic" in kinds else compiled_statics
    return method(system, turning, time, known)
