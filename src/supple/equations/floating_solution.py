"""Conversion between the states of floating-frame methods and solutions."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from supple.arrays import AnyArray
from supple.equations.configuration import Configuration, SystemMotion
from supple.equations.joint_wrench import joint_wrenches
from supple.errors import ModelError
from supple.integrate import (
    FloatingMotion,
    FramedMotion,
    Motion,
    Run,
    Solution,
    Statistics,
    damps_joint_forces,
)
from supple.machine import System


def floating_solution(
    system: System,
    slices: tuple[slice, ...],
    active: tuple[int, ...],
    motion: SystemMotion,
    statistics: Statistics,
    engine_state: Mapping[str, np.ndarray] = MappingProxyType({}),
    seen: StationMotions | None = None,
    series: Mapping[str, np.ndarray] = MappingProxyType({}),
) -> Solution:
    """Stacked states (leading axis: time) as a solution, with the forces of the joints.

    slices : positions of the velocities of each body
    active : constraint equations in use, in the order of the multipliers
    engine_state : further numbers for an exact resume
    seen : motions of bodies represented by stations; None without such bodies
    series : as in `Solution`
    """
    bodies: dict[str, Motion] = dict(
        body_motions(system, slices, motion.configuration, motion.velocity, motion.acceleration)
    )
    bodies |= {} if seen is None else seen.bodies
    ends, of_ends = (system, bodies) if seen is None else (seen.system, bodies | dict(seen.stations))
    multipliers = joint_multipliers(system, active, motion.multipliers)
    return Solution(
        times=motion.time,
        bodies=bodies,
        joint_forces=joint_wrenches(ends, motion.time, of_ends, multipliers),
        multipliers=multipliers,
        statistics=statistics,
        engine_state=engine_state,
        series=series,
    )


def body_motions(
    system: System,
    slices: tuple[slice, ...],
    configuration: Configuration,
    velocity: np.ndarray,
    acceleration: np.ndarray,
) -> dict[str, FloatingMotion]:
    """Split stacked states (leading axis: time) by body.

    slices : positions of the velocities of each body
    """
    motions = {}
    first = 0
    for index, (placed, part) in enumerate(zip(system.bodies, slices, strict=True)):
        own, rate = velocity[..., part], acceleration[..., part]
        after = first + part.stop - part.start - 6
        motions[placed.body.name] = FloatingMotion(
            position=configuration.origins[..., index, :],
            rotation=configuration.rotations[..., index, :, :],
            coordinates=configuration.coordinates[..., first:after],
            velocity=own[..., :3],
            angular_velocity=own[..., 3:6],
            coordinate_rates=own[..., 6:],
            acceleration=rate[..., :3],
            angular_acceleration=rate[..., 3:6],
            coordinate_accelerations=rate[..., 6:],
        )
        first = after
    return motions


def joint_multipliers(
    system: System, active: tuple[int, ...], multipliers: np.ndarray
) -> dict[str, np.ndarray]:
    """Multipliers by joint; zero for the equations that were left out as redundant."""
    every = np.zeros((*multipliers.shape[:-1], system.n_constraints))
    every[..., list(active)] = multipliers
    return {name: every[..., rows] for name, rows in system.constraint_slices.items()}


class StationMotions(NamedTuple):
    """Motions of bodies with stations, and of the stations, by name; in `system`, stations are bodies."""

    system: System
    bodies: Mapping[str, Motion]
    stations: Mapping[str, FloatingMotion]


def last_instant(system: System, done: Solution) -> SystemMotion:
    """The last state of a recorded part, with multipliers of all equations.

    Raises ModelError when its bodies or joints are not those of the system.
    """
    known, names = done.engine_state, [placed.body.name for placed in system.bodies]
    if set(names) != set(done.bodies) or {joint.name for joint in system.joints} != set(done.multipliers):
        raise ModelError("the recorded part has other bodies or joints than this system: start a new run")

    last = {name: done.motion(name, FramedMotion) for name in names}

    def joined(*items: str) -> np.ndarray:
        return np.concatenate([getattr(last[name], item)[-1] for name in names for item in items])

    return SystemMotion(
        time=float(done.times[-1]),
        configuration=Configuration(
            origins=np.array([last[name].position[-1] for name in names]),
            rotations=np.array([last[name].rotation[-1] for name in names]),
            coordinates=joined("coordinates"),
        ),
        velocity=known["velocity"]
        if "velocity" in known
        else joined("velocity", "angular_velocity", "coordinate_rates"),
        acceleration=known["acceleration"]
        if "acceleration" in known
        else joined("acceleration", "angular_acceleration", "coordinate_accelerations"),
        multipliers=np.concatenate(
            [np.zeros(0)] + [done.multipliers[joint.name][-1] for joint in system.joints]
        ),
    )


def failure_message(system: System, run: Run, time: AnyArray, relative_residual: AnyArray) -> str:
    """Message with the time and the likely cause of a failed run.

    relative_residual : (4,)    of forces, moments, deformation and constraints
    """
    relative_residual = np.asarray(relative_residual)
    kinds = ("forces", "moments", "deformation", "constraints")
    worst = int(np.argmax(np.where(np.isfinite(relative_residual), relative_residual, np.inf)))
    if not np.isfinite(relative_residual).all():
        return (
            f"no convergence at t = {time:.6g} with the smallest step allowed: the {kinds[worst]} are not "
            "numbers. A user-defined controller, law or load that returns nan or infinity is the usual "
            "cause; the results until then are stored"
        )
    likely = (
        "The likely cause is the method: with rho_inf = 1, as with the trapezoidal rule, nothing damps the "
        "oscillations of joint forces, which grow; take GeneralizedAlpha(0.8), rho_inf = 0.8 in a case "
        "file. Otherwise: a singular"
        if system.joints and not damps_joint_forces(run.second_order_method)
        else "A singular"
    )
    return (
        f"no convergence at t = {time:.6g} with the smallest step allowed: relative residual "
        f"{relative_residual[worst]:.2g} in the {kinds[worst]}. {likely} position (all links of a "
        "mechanism in line), a motion prescribed with a jump, loads far beyond the body's stiffness, or a "
        "basis without the nonlinear terms it needs are the usual causes; the results until then are stored"
    )
