"""Explicit integration of pendulums and of an oscillator; first frequency of a modal part on a joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from supple.body import RigidBody, RigidInterface, flexible_body
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, FloatingMotion, Run
from supple.linearization import linearize, machine_modes
from supple.machine import Fixed, Placed, Revolute, SpringDamper, System
from supple.mesh import CellType, block
from supple.methods.explicit import Explicit, modal_subdomain
from supple.reduction import CraigBampton
from supple.simulation import simulate
from supple_benchmarks.lines import BENDING_ROOTS
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, largest_difference

__all__ = ["CASES"]

FloatArray = NDArray[np.float64]

G = 9.81
ACROSS = (0.0, 1.0, 0.0)


def _rod(name: str, mass: float = 2.0, length: float = 1.0) -> RigidBody:
    inertia = mass * length**2 / 12
    ends = {"a": np.zeros(3), "b": np.array([length, 0.0, 0.0])}
    centre = np.array([length / 2, 0.0, 0.0])
    return RigidBody(name, mass, centre, np.diag([1e-3, inertia, inertia]), ends)


def _angles(solution, name: str) -> FloatArray:
    """Angle (t,) of the x axis of a body below the horizontal, rad, without jumps of 2 pi."""
    x = solution.bodies[name].rotation[:, :, 0]
    return np.unwrap(np.arctan2(-x[:, 2], x[:, 0]))


def _pendulum() -> Sequence[Comparison]:
    """A rod released from the horizontal is vertical after K(1 / sqrt 2) sqrt(2 L / (3 g)).

    K : complete elliptic integral of the first kind, as a function of the modulus
    """
    quarter = float(ellipk(0.5) * np.sqrt(2 / 3 / G))
    system = System(
        [_rod("rod")],
        joints=[Revolute(name="pin", first="ground", second="rod.a", axis=ACROSS)],
        gravity=np.array([0.0, 0.0, -G]),
    )
    solution = simulate(system, Run(quarter, quarter / 10, FixedStep(quarter / 400), Explicit()))
    source = "closed form: Landau and Lifshitz, Mechanics, 3rd ed., section 11"
    force = float(np.linalg.norm(solution.joint_forces["pin"][-1, :3]))
    return (
        Comparison(
            "angle after a quarter swing, rad", float(_angles(solution, "rod")[-1]), np.pi / 2, source, 2e-5
        ),
        Comparison("force of the hinge at this angle, N", force, 2.5 * 2.0 * G, "closed form, 5/2 m g", 1e-4),
    )


def _double_pendulum() -> Sequence[Comparison]:
    """Two rods released from the horizontal; reference: their equations, integrated to 1e-12 by scipy."""
    system = System(
        [_rod("one"), Placed(_rod("two"), position=np.array([1.0, 0.0, 0.0]))],
        joints=[
            Revolute(name="pin", first="ground", second="one.a", axis=ACROSS),
            Revolute(name="knee", first="one.b", second="two.a", axis=ACROSS),
        ],
        gravity=np.array([0.0, 0.0, -G]),
    )
    run = Run(1.0, 0.05, FixedStep(5e-4), Explicit())
    solution = simulate(system, run)

    def rates(_t: float, state: FloatArray) -> FloatArray:
        a, b, da, db = state
        mass = np.array([[4 / 3, np.cos(a - b) / 2], [np.cos(a - b) / 2, 1 / 3]])
        turning = np.sin(a - b) / 2 * np.array([-(db**2), da**2])
        return np.array([da, db, *np.linalg.solve(mass, turning + G * np.array([1.5, 0.5]) * np.cos([a, b]))])

    exact = solve_ivp(rates, (0, 1), np.zeros(4), "DOP853", run.times, rtol=1e-12, atol=1e-12).y
    source = "Lagrange's equations of two rods, DOP853 of scipy to 1e-12"
    return tuple(
        largest_difference(f"angle of rod {name}, rad", _angles(solution, name), own, source, 1e-4)
        for name, own in zip(("one", "two"), exact, strict=False)
    )


def _oscillator() -> Sequence[Comparison]:
    """A mass on a spring and a damper, released with the spring stretched.

    The damper force is that of the velocity half a step earlier.
    """
    mass, k, c, z0 = 2.0, 800.0, 4.0, 0.1
    ball = RigidBody("ball", mass, np.zeros(3), 0.01 * np.eye(3), {"eye": np.zeros(3)})
    spring = SpringDamper(
        first="ground", second="ball.eye", anchor=(0, 0, 1.0), stiffness=k, damping=c, rest_length=1.0
    )
    system = System([Placed(ball, position=np.array([0.0, 0.0, -z0]))], loads=[spring])
    run = Run(1.0, 0.02, FixedStep(1e-4), Explicit())
    a = c / mass / 2
    w = np.sqrt(k / mass - a**2)
    exact = -z0 * np.exp(-a * run.times) * (np.cos(w * run.times) + a / w * np.sin(w * run.times))
    found = simulate(system, run).motion("ball", FloatingMotion).position[:, 2]
    return (largest_difference("height of the mass, m", found, exact, "closed form", 1e-3),)


def _clamped_bar() -> Sequence[Comparison]:
    """First bending frequency of a modal part clamped by a fixed joint; length / thickness is 20."""
    E, rho, length, side = 2e11, 7850.0, 1.0, 0.05
    model = solid_model(block(length, side, side, 10, 1, 1, CellType.TETRA10), Isotropic(E, 0.0, rho))
    ends = [RigidInterface("root", "root"), RigidInterface("tip", "tip")]
    part = modal_subdomain(flexible_body("bar", model, ends), CraigBampton(4))
    system = System([part], joints=[Fixed(name="clamp", first="ground", second="bar.root")])
    found = machine_modes(linearize(system)).frequencies[0]
    exact = BENDING_ROOTS[0] ** 2 * np.sqrt(E * side**2 / 12 / rho) / length**2
    return (
        Comparison(
            "first frequency, rad/s", float(found), float(exact), "closed form, Euler and Bernoulli", 0.01
        ),
    )


CASES: tuple[ValidationCase, ...] = (
    ValidationCase("explicit pendulum on a hinge", _pendulum),
    ValidationCase("explicit double pendulum", _double_pendulum),
    ValidationCase("explicit mass on a spring and damper", _oscillator),
    ValidationCase("modal part clamped by a joint", _clamped_bar),
)
