"""Static equations of a machine, at rest or in steady rotation, by the method for its bodies."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from supple.equations.static_search import Equations
from supple.equations.steady_motion import SteadyRotation
from supple.machine import AngleServo, Controller, SlideServo, System
from supple.methods.explicit.check_machine import check_spin_stiffness
from supple.methods.floating import compiled_statics, full_statics
from supple.methods.intrinsic.line_in_frame import lines_in_frames
from supple.methods.intrinsic.line_statics import line_statics


def equations_of(
    system: System, turning: SteadyRotation | None, time: float, known: tuple[int, ...] | None = None
) -> Equations:
    """Equations of a machine for statics and modes; without `known`, its joints are closed first.

    turning : steady rotation, with one angular velocity per body; None at rest
    time : time at which laws of time are evaluated
    known : numbers of the independent joint equations, if the bodies are placed with closed joints
    Raises ModelError for a rotation with modal parts that have a centrifugal stiffness, and for joints that
    the start of a run rejects.
    """
    if turning is not None and np.any(turning.angular_velocities):
        check_spin_stiffness(system)
    system = with_held_servos(system, turning, time)
    kinds = {placed.body.kind for placed in system.bodies}
    if "full" in kinds or ("intrinsic" in kinds and system.controllers):
        return full_statics(lines_in_frames(system), turning, time, known)
    method = line_statics if "intrinsic" in kinds else compiled_statics
    return method(system, turning, time, known)


def with_held_servos(system: System, turning: SteadyRotation | None, time: float) -> System:
    """The machine with the set-points of its servos held at their values at a time, with zero rate.

    An angle servo between bodies of different spin keeps its law: the angle changes in the steady rotation. A
    slide does not change.
    """
    still = SteadyRotation(np.zeros((len(system.bodies), 3)), np.zeros(3))
    spins = (turning or still).by_body([placed.body.name for placed in system.bodies])

    def held(load: Any) -> Any:
        if not isinstance(load, AngleServo | SlideServo):
            return load
        turn_alike = np.array_equal(spins[load.first.body], spins[load.second.body])
        return load.held(time) if turn_alike or isinstance(load, SlideServo) else load

    controllers = tuple(
        replace(own, drives={name: held(each) for name, each in own.drives.items()})
        if isinstance(own, Controller)
        else own
        for own in system.controllers
    )
    return replace(system, loads=tuple(map(held, system.loads)), controllers=controllers)
