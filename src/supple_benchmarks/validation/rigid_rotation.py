"""Rigid bodies that rotate freely in space or about one fixed point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.special import ellipj, ellipk

from supple.body import RigidBody
from supple.integrate import FixedStep, FloatingMotion, Run
from supple.machine import GROUND, At, Ball, Placed, System
from supple.simulation import simulate
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, largest_difference

__all__ = ["CASES"]

Array = NDArray[np.float64]


def intermediate_axis() -> Sequence[Comparison]:
    """A free body rotating about its intermediate axis turns over periodically (Dzhanibekov's wing nut).

    With I1 < I2 < I3, energy E and angular momentum M, M^2 > 2 E I2, the angular velocities are proportional
    to Jacobi's cn, sn and dn of n t + K, n^2 = (I3 - I2)(M^2 - 2 E I1) / (I1 I2 I3), with the complete
    elliptic integral K.
    """
    I1, I2, I3 = 1.0, 2.0, 2.5
    start = np.array([0.0, 4.0, 0.1])
    E2, M2 = I2 * start[1] ** 2 + I3 * start[2] ** 2, (I2 * start[1]) ** 2 + (I3 * start[2]) ** 2
    rate = np.sqrt((I3 - I2) * (M2 - E2 * I1) / (I1 * I2 * I3))
    modulus = (I2 - I1) * (E2 * I3 - M2) / ((I3 - I2) * (M2 - E2 * I1))

    body = RigidBody("nut", 1.0, np.zeros(3), np.diag([I1, I2, I3]))
    run = Run(8.0, 0.02, step=FixedStep(0.002))
    solution = simulate(System([Placed(body, angular_velocity=start)]), run)
    spin = solution.motion("nut", FloatingMotion).angular_velocity
    sn, cn, dn, _ = ellipj(rate * solution.times + ellipk(modulus), modulus)
    largest = (
        np.sqrt((E2 * I3 - M2) / (I1 * (I3 - I1))),
        np.sqrt((E2 * I3 - M2) / (I2 * (I3 - I2))),
        np.sqrt((M2 - E2 * I1) / (I3 * (I3 - I1))),
    )
    exact = np.column_stack([cn, sn, dn]) * largest
    first_turn = CubicSpline(solution.times, spin[:, 1]).roots(extrapolate=False)[0]
    source = "L. D. Landau, E. M. Lifshitz, Mechanics, section 37: Jacobi's elliptic functions"
    return (
        Comparison("time of the first reversal, s", first_turn, ellipk(modulus) / rate, source, 1e-4),
        largest_difference("angular velocity over 8 s, rad/s", spin, exact, source, 1e-3),
    )


def heavy_top() -> Sequence[Comparison]:
    """A fast top on a ball joint under gravity, a test problem of Lie group integrators.

    J w' + w x J w = m X x R^T g,     R' = R w~

    J : inertia about the fixed point;  X : centre of mass from this point, in body axes
    """
    mass, arm, g = 15.0, np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -9.81])
    about_centre = np.diag([0.234375, 0.46875, 0.234375])
    start = np.array([0.0, 150.0, -4.61538])
    about_point = about_centre + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))

    def rates(_: float, y: Array) -> list[float]:
        R, w = y[:9].reshape(3, 3), y[9:]
        moment = mass * np.cross(arm, R.T @ g)
        skew = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        turning = np.linalg.solve(about_point, moment - np.cross(w, about_point @ w))
        return [*np.ravel(R @ skew), *turning]

    body = RigidBody("top", mass, arm, about_centre, {"foot": np.zeros(3)})
    joint = Ball(name="foot", first=GROUND, second=At("top", "foot"))
    solution = simulate(
        System([Placed(body, angular_velocity=start)], [joint], gravity=g),
        Run(0.5, 0.01, step=FixedStep(1e-4)),
    )
    y0 = np.concatenate([np.eye(3).ravel(), start])
    exact = solve_ivp(rates, (0, 0.5), y0, t_eval=solution.times, method="DOP853", rtol=1e-11, atol=1e-11).y
    source = (
        "O. Bruls, A. Cardona, M. Arnold, Mech. Mach. Theory 48 (2012) 121-137; Euler's equations, by DOP853"
    )
    centre = solution.motion("top", FloatingMotion).rotation @ arm
    return (
        largest_difference(
            "centre of mass over 0.5 s, m", centre, exact[:9].reshape(3, 3, -1)[:, 1].T, source, 1e-3
        ),
    )


CASES = (
    ValidationCase("body rotating about its intermediate axis (Dzhanibekov)", intermediate_axis),
    ValidationCase("heavy top", heavy_top, quick=False),
)
