"""Assembly of machines: bodies are moved until all joints are closed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from supple.arguments import checked_arguments
from supple.body import FullBody
from supple.equations.build_model import build_model
from supple.equations.compiled_machine import CompiledMachine
from supple.equations.consistent_start import angle_behind, placed_configuration
from supple.equations.joint_closure import joints_assembled
from supple.equations.start_change import PositionCorrection
from supple.machine import Joint, PrescribedRotation, System
from supple.methods.floating.full.full_system import FullSystem
from supple.methods.intrinsic import IntrinsicBody
from supple.methods.intrinsic.line_in_frame import lines_in_frames

__all__ = ["AssembledMachine", "assemble"]

_TURN = 0.8
"""Largest change of a prescribed angle, rad, for which the joints are closed at once."""


@dataclass(frozen=True, eq=False)
class AssembledMachine:
    """A machine with closed joints.

    system : System
    moved : tuple of PositionCorrection   displacement (unit of length) and rotation (rad) of each body
    """

    system: System
    moved: tuple[PositionCorrection, ...]


@checked_arguments
def assemble(system: System, *, time: float = 0.0) -> AssembledMachine:
    """The machine with its bodies moved rigidly until every joint is closed: `g(q, t) = 0`.

    Each iteration is the smallest motion in the mass norm: light bodies near open joints move most, and the
    assembly nearest to the given placement is found. Points and axes of joints on the bodies are unchanged.
    Velocities are unchanged; the start of a run corrects them.

    Parameters
    ----------
    time : time at which the joints' laws are evaluated

    Raises
    ------
    ConvergenceError    joints that cannot be closed; the message states the worst joint and its residual
    Source: [Nikravesh1988] section 3.2 (Newton's method on the constraint equations).
    """
    found = placed_configuration(system)
    for machine in (*_driven_part_of_the_way(system, time), system):
        found = joints_assembled(_equations(machine), time, found)
    bodies, moved = [], []
    for placed, position, rotation in zip(system.bodies, found.origins, found.rotations, strict=True):
        bodies.append(placed.moved_to(position, rotation))
        moved.append(PositionCorrection.of(placed, position, bodies[-1].rotation))
    return AssembledMachine(replace(system, bodies=tuple(bodies)), tuple(moved))


def _equations(system: System) -> FullSystem | CompiledMachine:
    sparse = system.bodies_of(FullBody) or system.bodies_of(IntrinsicBody)
    return FullSystem(lines_in_frames(system)) if sparse else CompiledMachine(system, build_model(system))


def _driven_part_of_the_way(system: System, time: float) -> Iterator[System]:
    """The machine with its prescribed rotations nearer to their angles, each time by at most `_TURN`.

    A joint measures the sine of its deviation: beyond a right angle the iteration would end half a revolution
    away from the angle.
    """
    behind = {
        joint.name: angle_behind(system, joint, time)
        for joint in system.joints
        if isinstance(joint, PrescribedRotation)
    }
    largest = max(map(abs, behind.values()), default=0.0)
    number = int(np.ceil(largest / _TURN)) if np.isfinite(largest) else 0  # the joints name the law

    def nearer(joint: Joint, left: float) -> Joint:
        if not isinstance(joint, PrescribedRotation):
            return joint
        return replace(joint, angle=float(joint.law(time)) + left * behind[joint.name])

    for k in range(1, number):
        yield replace(system, joints=tuple(nearer(joint, 1 - k / number) for joint in system.joints))
