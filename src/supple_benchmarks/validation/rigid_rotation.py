"""Rigid bodies that turn in space without a bearing, or about one point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import ellipj, ellipk

from supple.body import RigidBody
from supple.integrate import FixedStep, Run
from supple.machine import Placed, System
from supple.simulation import simulate
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES"]


def intermediate_axis() -> Sequence[Comparison]:
    """A body spun about its intermediate axis turns over, again and again (Dzhanibekov's wing nut).

    With I1 < I2 < I3, energy E and angular momentum M, M^2 > 2 E I2, the angular velocities are Jacobi's cn,
    sn and dn of n t + K, n^2 = (I3 - I2)(M^2 - 2 E I1) / (I1 I2 I3).
    """
    I1, I2, I3 = 1.0, 2.0, 2.5
    start = np.array([0.0, 4.0, 0.1])
    E2, M2 = I2 * start[1] ** 2 + I3 * start[2] ** 2, (I2 * start[1]) ** 2 + (I3 * start[2]) ** 2
    rate = np.sqrt((I3 - I2) * (M2 - E2 * I1) / (I1 * I2 * I3))
    modulus = (I2 - I1) * (E2 * I3 - M2) / ((I3 - I2) * (M2 - E2 * I1))

    body = RigidBody("nut", 1.0, np.zeros(3), np.diag([I1, I2, I3]))
    run = Run(8.0, 0.02, step=FixedStep(0.002))
    solution = simulate(System([Placed(body, angular_velocity=start)]), run)
    spin = solution.bodies["nut"].angular_velocity
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
        Comparison("time of the first turn, s", first_turn, ellipk(modulus) / rate, source, 1e-4),
        Comparison(
            "angular velocity over 8 s, largest difference, rad/s",
            float(np.abs(spin - exact).max()),
            0.0,
            source,
            1e-3,
            scale=4.0,
        ),
    )


CASES = (ValidationCase("body turning about its intermediate axis", intermediate_axis),)
