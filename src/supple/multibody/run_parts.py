"""A run in parts: what is handed on as each completes, and where a later one takes over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from supple.errors import ModelError
from supple.integrate import FloatingMotion, Solution
from supple.machine.system import System
from supple.multibody.equations.balance import Configuration
from supple.multibody.equations.model import Model

__all__ = [
    "CHUNKS",
    "Checkpoint",
    "LastInstant",
    "Progress",
    "Recorder",
    "body_motions",
    "failure_message",
    "joint_forces",
    "last_instant",
]

Progress = Callable[[float], None]
"""Called with the completed fraction of a run, 0 to 1."""
Recorder = Callable[[Solution], None]
"""Called with each completed chunk of a run; the first holds the initial state."""

CHUNKS = 50
"""A run is handed on in so many parts."""


@dataclass(frozen=True)
class Checkpoint:
    """A finished part of a run, from whose last instant a new run goes on.

    Made by `Checkpoint(solution)` from what was recorded; the auxiliary acceleration of the integrator is
    taken equal to the true one, which keeps the order of accuracy.
    """

    solution: Solution


def body_motions(
    system: System,
    slices: tuple[slice, ...],
    configuration: Configuration,
    velocity: np.ndarray,
    acceleration: np.ndarray,
) -> dict[str, FloatingMotion]:
    """Split stacked states (leading axis: time) by body."""
    motions = {}
    for index, (placed, part) in enumerate(zip(system.bodies, slices, strict=True)):
        own, rate = velocity[..., part], acceleration[..., part]
        motions[placed.body.name] = FloatingMotion(
            position=configuration.origins[..., index, :],
            rotation=configuration.rotations[..., index, :, :],
            coordinates=configuration.coordinates[index],
            velocity=own[..., :3],
            angular_velocity=own[..., 3:6],
            coordinate_rates=own[..., 6:],
            acceleration=rate[..., :3],
            angular_acceleration=rate[..., 3:6],
            coordinate_accelerations=rate[..., 6:],
        )
    return motions


def joint_forces(system: System, model: Model, multipliers: np.ndarray) -> dict[str, np.ndarray]:
    """Multipliers by joint; zero for the equations that were left out as redundant."""
    every = np.zeros((*multipliers.shape[:-1], model.n_equations))
    every[..., list(model.active)] = multipliers
    forces, start = {}, 0
    for joint in system.joints:
        forces[joint.name] = every[..., start : start + joint.n_constraints]
        start += joint.n_constraints
    return forces


class LastInstant(NamedTuple):
    """The state of a system at the end of a recorded part."""

    time: float
    configuration: Configuration
    velocity: np.ndarray
    acceleration: np.ndarray
    multipliers: np.ndarray


def last_instant(system: System, model: Model, done: Solution) -> LastInstant:
    """Where a recorded part ends; ModelError when it has other bodies or joints than the system."""
    last = done.bodies
    names = [placed.body.name for placed in system.bodies]
    if set(names) != set(last) or {joint.name for joint in system.joints} != set(done.joint_forces):
        raise ModelError(
            "the recorded part has other bodies or joints than this system: it cannot be continued"
        )

    def joined(*items: str) -> np.ndarray:
        return np.concatenate([getattr(last[name], item)[-1] for name in names for item in items])

    every = np.concatenate([np.zeros(0)] + [done.joint_forces[joint.name][-1] for joint in system.joints])
    return LastInstant(
        time=float(done.times[-1]),
        configuration=Configuration(
            origins=np.array([last[name].position[-1] for name in names]),
            rotations=np.array([last[name].rotation[-1] for name in names]),
            coordinates=tuple(np.array(last[name].coordinates[-1]) for name in names),
        ),
        velocity=joined("velocity", "angular_velocity", "coordinate_rates"),
        acceleration=joined("acceleration", "angular_acceleration", "coordinate_accelerations"),
        multipliers=every[list(model.active)],
    )


def failure_message(time: float, relative_residual: np.ndarray) -> str:
    """Why and where a run stopped; `relative_residual` is that of the four kinds of equations."""
    kinds = ("forces", "moments", "deformation", "constraints")
    worst = int(np.argmax(np.where(np.isfinite(relative_residual), relative_residual, np.inf)))
    return (
        f"no convergence at t = {time:.6g} with the smallest step allowed: relative residual "
        f"{relative_residual[worst]:.2g} in the {kinds[worst]}. A singular position (a mechanism stretched "
        "out), a motion prescribed with a jump, loads far beyond the body's stiffness, or a basis without "
        "the nonlinear terms it needs are the usual causes; what was computed until then is kept"
    )
