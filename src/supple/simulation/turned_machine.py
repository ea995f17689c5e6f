"""A machine in steady rotation at a later angle, and its linear equations there."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from supple.equations.static_search import Equations, StaticState, carried_state
from supple.equations.steady_motion import LinearEquations
from supple.errors import ModelError, ValidityWarning
from supple.machine import (
    GROUND,
    AngleServo,
    At,
    Bushing,
    ConstantRate,
    ForceElement,
    Joint,
    PrescribedRotation,
    Spin,
    System,
)
from supple.machine.laws.with_rate import WithRate
from supple.machine.system import Load
from supple.methods.floating.full.linear_equations import SparseEquations
from supple.simulation.equations_of import equations_of
from supple.simulation.resting_state import RestingState, at_rest, placed_at_rest

CONSTANT = 1e-6
"""Relative variation of the equations over the rotation above which they are not constant."""
LITTLE_UNBALANCE = 1e-5
"""Eccentricity of the mass, relative to the size of the machine, up to which a rotor is linearised as if it
were balanced: a mesh that is not symmetric about the axis is slightly unbalanced."""
LATER, LEAST_VARYING, ROUND_OFF_UNBALANCE = 0.7, 1e-3, 1e-7
"""Angle, rad, at which an equilibrium is compared with that found, unlikely as an angle of symmetry; relative
unbalance there above which the equilibrium is that of one angle; eccentricity of the mass, relative to the
size of the machine, that has this unbalance or less."""
SAME_RATE = 1e-9
"""Ratio of a drive's rate to the spin rate up to which the drive counts as fixed."""


class TurnedEquations(NamedTuple):
    """Linear equations at an angle, and the largest relative unbalance of forces there.

    An unbalance above `CONSTANT` is that of a machine without equilibrium at this angle.
    """

    equations: LinearEquations | SparseEquations
    unbalanced: float


def turning_bodies(found: RestingState, spin: Spin) -> np.ndarray:
    """Mask (nb,): True for bodies that rotate."""
    return found.turning.angular_velocities @ spin.axis != 0


def refuse_other_speeds(found: RestingState, time: float, spin: Spin) -> None:
    """Raise ModelError for a drive with a nonzero rate between bodies that both rotate, or both stand."""
    turning = turning_bodies(found, spin)
    for joint in found.system.joints:
        if not isinstance(joint, PrescribedRotation) or _spans_speeds(joint, found, turning):
            continue
        rate = float(WithRate(joint.law)(time)[1])
        if abs(rate) > SAME_RATE * abs(spin.rate):
            raise ModelError(
                f"joint '{joint.name}' rotates at {rate:g} rad per unit of time between bodies that rotate "
                f"alike, beside a spin of {spin.rate:g}: machines of two speeds are not linearised. Fix the "
                "joint, angle=0.0, or give the spin its rate, if the bodies on one side of the joint rotate "
                "at this rate"
            )


def refuse_turning_bushings(found: RestingState, spin: Spin) -> None:
    """Raise ModelError for a bushing that resists tilt between a rotating and a standing body.

    Its rotation vector grows with the angle of rotation, and its stiffness against tilt with it.
    """
    turning = turning_bodies(found, spin)
    for load in found.system.loads:
        if not isinstance(load, Bushing) or not _spans_speeds(load, found, turning):
            continue
        axis = load.initial_axes.T @ spin.axis
        across = np.eye(3) - np.outer(axis, axis)
        damping = np.asarray(load.damping)[3:, 3:]
        left = abs(across @ damping @ across).max()
        if np.any(np.asarray(load.stiffness)[3:, 3:]) or left > SAME_RATE * abs(damping).max():
            raise ModelError(
                f"{load.label}: it resists the rotation between a rotating and a standing body, and its "
                "stiffness against tilt changes with the angle of rotation. Give it no rotational stiffness "
                "and no damping of tilt; for a bearing that resists tilt, connect the bushing to a "
                "body of the bearing that stands, and this body to the rotor by a Revolute joint"
            )


def _spans_speeds(part: Joint | ForceElement, found: RestingState, turning: np.ndarray) -> bool:
    """Whether one end of a joint or force element is on a rotating body, and the other one is not."""
    return _turns(part.first, found, turning) != _turns(part.second, found, turning)


def _turns(end: At, found: RestingState, turning: np.ndarray) -> bool:
    return end != GROUND and bool(turning[found.system.body_index(end.body)])


def equations_turned_on(found: RestingState, time: float, spin: Spin, angle: float) -> TurnedEquations:
    """The equations of the machine rotated by an angle (rad) about the axis, with its loads unchanged."""
    later, state, unbalanced = _carried_on(found, time, spin, angle, LITTLE_UNBALANCE / CONSTANT)
    return TurnedEquations(later.linear_equations(state, time), unbalanced)


def warn_of_varying_loads(found: RestingState, time: float, spin: Spin | None) -> None:
    """ValidityWarning of a machine in steady rotation that is not in equilibrium at a later angle."""
    if spin is None or not spin.rate:
        return
    *_, unbalanced = _carried_on(found, time, spin, LATER, ROUND_OFF_UNBALANCE / LEAST_VARYING)
    if unbalanced > LEAST_VARYING:
        warnings.warn(
            f"the equilibrium in steady rotation is that of one angle: rotated by {LATER:g} rad, "
            f"{unbalanced:.2g} of the forces are not in balance (gravity or loads normal to the axis, or an "
            "unbalanced rotor on supports that differ between directions). Loads that are fixed in space act "
            "here as if they rotated with the machine, and deflect a rotor otherwise. For the deflection by "
            "weight of a rotor set the rate to zero; otherwise simulate the rotation",
            ValidityWarning,
            stacklevel=4,
        )


def _carried_on(
    found: RestingState, time: float, spin: Spin, angle: float, least_size: float
) -> tuple[Equations, StaticState, float]:
    """The machine rotated by an angle, its state, and the largest relative unbalance of forces.

    least_size : least size of the forces, relative to the inertia forces of all mass at a radius of the size
    """
    system = _turned_on(found, time, spin, angle)
    system = replace(system, bodies=tuple(map(at_rest, system.bodies)))
    later = equations_of(system, found.turning, time, found.equations.model.active)
    mass = sum(placed.body.mass for placed in system.bodies)
    turning = mass * (spin.rate * float(found.equations.model.length)) ** 2
    return later, *carried_state(later, time, least_size * turning)


def _turned_on(found: RestingState, time: float, spin: Spin, angle: float) -> System:
    """The machine with its rotating bodies rotated by an angle.

    Driven joints have the corresponding angles, and servos the set-points of their laws at this angle.
    """
    turn = Rotation.from_rotvec(angle * spin.axis).as_matrix()
    turning = turning_bodies(found, spin)
    system = placed_at_rest(found)
    bodies = [
        replace(
            placed,
            position=spin.point + turn @ (placed.position - spin.point),
            rotation=turn @ placed.rotation,
        )
        if moves
        else placed
        for placed, moves in zip(system.bodies, turning, strict=True)
    ]

    def driven_on(joint: Joint) -> Joint:
        if not isinstance(joint, PrescribedRotation):
            return joint
        first, second = (_turns(end, found, turning) for end in (joint.first, joint.second))
        sense = np.sign(np.dot(joint.axis, spin.axis)) * (float(second) - float(first))
        return replace(joint, angle=float(joint.law(time)) + sense * angle)

    def followed_on(load: Load) -> Load:
        if not isinstance(load, AngleServo) or not _spans_speeds(load, found, turning):
            return load
        value, rate = map(float, load.law(time))
        now = value + rate * angle / spin.rate
        return replace(load, angle=ConstantRate(rate, now - rate * time))

    return replace(
        system,
        bodies=tuple(bodies),
        joints=tuple(map(driven_on, system.joints)),
        loads=tuple(map(followed_on, system.loads)),
    )
