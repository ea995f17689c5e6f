"""Machine elements against closed forms: friction, stops, servos, gears, screws, controllers.

All elements are in one machine, which is compiled and run once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import brentq

from supple.body import RigidBody
from supple.integrate import FixedStep, Run
from supple.machine import (
    GROUND,
    AngleServo,
    At,
    Controller,
    Cylindrical,
    Gear,
    JointReading,
    Penalty,
    Placed,
    Prismatic,
    Revolute,
    RevoluteFriction,
    Screw,
    SlideFriction,
    SlideStop,
    System,
    TorqueBetween,
)
from supple.quantities import JointMotionSensor
from supple.simulation import simulate
from supple_benchmarks.table import Row
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, largest_difference

__all__ = ["CASES"]

Array = NDArray[np.float64]

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
GRAVITY = 9.81
MASS, INERTIA = 2.0, 0.5
"""Mass of every body, kg, and its moment of inertia about every axis, kg m2"""

SPEED, GRIP = 2.0, 0.3
"""Initial speed of the sledge, m/s, and its coefficient of friction"""
BRAKE = 1.5
"""Friction moment that stops a disc with an initial angular velocity of 2 rad/s, N m"""
APPROACH, GAP, STIFFNESS, DISSIPATION = 1.0, 0.1, 8e3, 0.3
SERVO, SERVO_DAMPING, TARGET = 200.0, 4.0, 0.4
TORQUE, TEETH, PITCH = 3.0, (20, 50), 0.5
PROPORTIONAL, INTEGRAL, WANTED = 6.0, 30.0, 10.0


def _body(name: str) -> RigidBody:
    return RigidBody(name, MASS, np.zeros(3), INERTIA * np.eye(3), {"eye": np.zeros(3)})


@cache
def _workshop() -> dict[str, Array]:
    """Angle, rate, slide and its speed (t, 4) of each joint over one second; key "times": (t,)."""
    along = np.array(X)
    placed: Row = {
        "sledge": {"velocity": SPEED * along},
        "buffer": {"velocity": APPROACH * along},
        "soft buffer": {"velocity": APPROACH * along},
        "disc": {"angular_velocity": np.array([0, 0, 2.0])},
        "arm": {},
        "pinion": {"position": np.zeros(3)},
        "wheel": {"position": np.array([0.7, 0, 0])},
        "nut": {},
        "motor": {},
    }
    bodies = [Placed(_body(name), **start) for name, start in placed.items()]
    slides = [
        Prismatic(name=name, first=GROUND, second=At(name, "eye"), axis=X)
        for name in ("sledge", "buffer", "soft buffer")
    ]
    hinges = [
        Revolute(name=name, first=GROUND, second=At(name, "eye"), axis=Z)
        for name in ("disc", "arm", "pinion", "wheel", "motor")
    ]
    joints = (*slides, *hinges, Cylindrical(name="nut", first=GROUND, second=At("nut", "eye"), axis=Z))
    stop, soft = (
        Penalty(stiffness=STIFFNESS),
        Penalty(stiffness=STIFFNESS, exponent=1.5, dissipation=DISSIPATION),
    )
    loads = (
        SlideFriction(joint=slides[0], coefficient=GRIP, width=1e-3),
        SlideStop(first=GROUND, second=At("buffer", "eye"), axis=X, upper=GAP, penalty=stop),
        SlideStop(first=GROUND, second=At("soft buffer", "eye"), axis=X, upper=GAP, penalty=soft),
        RevoluteFriction(first=GROUND, second=At("disc", "eye"), axis=Z, moment=BRAKE, width=1e-3),
        AngleServo(
            first=GROUND,
            second=At("arm", "eye"),
            axis=Z,
            angle=TARGET,
            stiffness=SERVO,
            damping=SERVO_DAMPING,
        ),
        TorqueBetween(first=GROUND, second=At("pinion", "eye"), axis=Z, torque=TORQUE),
        Gear(
            first=At("pinion", "eye"),
            second=At("wheel", "eye"),
            axis=Z,
            teeth=TEETH,
            stiffness=1e5,
            damping=2e3,
        ),
        TorqueBetween(first=GROUND, second=At("nut", "eye"), axis=Z, torque=TORQUE),
        Screw(first=GROUND, second=At("nut", "eye"), axis=Z, pitch=PITCH, stiffness=1e6, damping=2e3),
    )
    controller = Controller(
        reads={"shaft": JointReading("motor")},
        drives={"motor": TorqueBetween(first=GROUND, second=At("motor", "eye"), axis=Z)},
        outputs=lambda _, read, states: {
            "motor": PROPORTIONAL * (WANTED - read["shaft"].rate) + INTEGRAL * states[0]
        },
        rates=lambda _, read, states: WANTED - read["shaft"].rate + 0 * states,
        initial=(0.0,),
    )
    system = System(bodies, joints, loads, gravity=np.array([0, 0, -GRAVITY]), controllers=(controller,))
    solution = simulate(system, Run(1.0, 0.005, step=FixedStep(1e-3)))
    read = {
        joint.name: JointMotionSensor(joint.name, joint.name).values(system, solution) for joint in joints
    }
    return {**read, "times": solution.times}


def sliding_friction() -> Sequence[Comparison]:
    """A sledge slides until friction stops it."""
    slide = _workshop()["sledge"][-1, 2]
    return (
        Comparison("stopping distance, m", slide, SPEED**2 / (2 * GRIP * GRAVITY), "v^2 / (2 mu g)", 1e-3),
    )


def brake() -> Sequence[Comparison]:
    """A disc is stopped by a constant friction moment."""
    angle = _workshop()["disc"][-1, 0]
    return (Comparison("stopping angle, rad", angle, 2.0**2 * INERTIA / (2 * BRAKE), "w^2 J / (2 M)", 1e-3),)


def stop() -> Sequence[Comparison]:
    """A mass hits an elastic stop; an equal mass hits a stop with Hunt-Crossley dissipation."""
    v, a = APPROACH, DISSIPATION
    hard, soft = _workshop()["buffer"], _workshop()["soft buffer"]
    back = brentq(lambda w: v / a - np.log(1 + a * v) / a**2 + w / a + np.log(1 - a * w) / a**2, 0.5 * v, v)
    half = np.pi * np.sqrt(MASS / STIFFNESS)
    away = float(hard[-1, 2])
    return (
        Comparison(
            "position after one second, m",
            away,
            GAP - (1 - GAP / v - half) * v,
            "half a period of vibration at the stop",
            1e-3,
            scale=1.0,
        ),
        Comparison(
            "speed after the dissipating stop, m/s",
            -soft[-1, 3],
            float(back),
            "K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440-445: work of the force",
            2e-3,
        ),
    )


def servo() -> Sequence[Comparison]:
    """A servo moves an arm from rest at 0 to a constant target angle: damped vibration about the target."""
    read = _workshop()
    w, decay = np.sqrt(SERVO / INERTIA), SERVO_DAMPING / (2 * INERTIA)
    fast, t = np.sqrt(w**2 - decay**2), read["times"]
    exact = TARGET * (1 - np.exp(-decay * t) * (np.cos(fast * t) + decay / fast * np.sin(fast * t)))
    return (
        largest_difference("angle over one second, rad", read["arm"][:, 0], exact, "damped vibration", 2e-3),
    )


def gear() -> Sequence[Comparison]:
    """A pinion with 20 teeth, under a torque, drives a wheel with 50 teeth."""
    read = _workshop()
    ratio = TEETH[0] / TEETH[1]
    rate = TORQUE / (INERTIA * (1 + ratio**2))
    return (
        Comparison(
            "speed of the pinion after a second, rad/s",
            read["pinion"][-1, 1],
            rate,
            "M / (J_1 + J_2 (z_1 / z_2)^2)",
            1e-3,
        ),
        Comparison("speed of the wheel, rad/s", read["wheel"][-1, 1], -ratio * rate, "- z_1 / z_2", 1e-3),
    )


def screw() -> Sequence[Comparison]:
    """A torque on a nut that rises on its thread against its weight."""
    read = _workshop()["nut"][-1]
    lead = PITCH / (2 * np.pi)
    rate = (TORQUE - lead * MASS * GRAVITY) / (INERTIA + lead**2 * MASS)
    return (
        Comparison(
            "angular velocity after a second, rad/s",
            read[1],
            rate,
            "(M - p m g / 2 pi) / (J + m (p / 2 pi)^2)",
            1e-3,
        ),
        Comparison("height after a second, m", read[2], lead * rate / 2, "p / (2 pi) times the angle", 2e-3),
    )


def speed_control() -> Sequence[Comparison]:
    """A motor with a proportional and integral controller of its speed."""
    read = _workshop()
    matrix = np.array([[-PROPORTIONAL / INERTIA, INTEGRAL / INERTIA], [-1.0, 0.0]])
    start = np.array([-WANTED, 0.0])
    # State: rate - target, and the integral of (target - rate). There is no input.
    exact = WANTED + np.array([(expm(matrix * t) @ start)[0] for t in read["times"]])
    return (
        largest_difference(
            "speed over one second, rad/s",
            read["motor"][:, 1],
            exact,
            "matrix exponential of the closed loop",
            2e-3,
        ),
    )


CASES = (
    ValidationCase("sledge stopped by friction", sliding_friction, quick=False),
    ValidationCase("disc stopped by a brake", brake, quick=False),
    ValidationCase("elastic and dissipating stops", stop, quick=False),
    ValidationCase("servo", servo, quick=False),
    ValidationCase("pair of gears", gear, quick=False),
    ValidationCase("screw that lifts", screw, quick=False),
    ValidationCase("speed control", speed_control, quick=False),
)
