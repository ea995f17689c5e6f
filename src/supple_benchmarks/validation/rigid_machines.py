"""Mechanisms of rigid bodies: closed forms and the published reference solutions of benchmark libraries."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import ellipj, ellipk

from supple.body import RigidBody
from supple.integrate import FixedStep, Run
from supple.machine import GROUND, At, Placed, Revolute, System
from supple.simulation import simulate
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES"]


def pendulum() -> Sequence[Comparison]:
    """A physical pendulum let go at 120 degrees: sin(angle / 2) = k sn(K - w t)."""
    mass, arm, inertia, g, swing = 2.0, 0.8, 0.15, 9.81, 2 * np.pi / 3
    rate = np.sqrt(mass * g * arm / (inertia + mass * arm**2))
    k = np.sin(swing / 2)
    period = 4 * ellipk(k**2) / rate
    bob = RigidBody("bob", mass, np.array([0, 0, -arm]), inertia * np.eye(3), {"hinge": np.zeros(3)})
    hinge = Revolute(name="hinge", first=GROUND, second=At("bob", "hinge"), axis=(1, 0, 0))
    system = System([Placed(bob, rotation=np.array([swing, 0, 0]))], [hinge], gravity=np.array([0, 0, -g]))
    run = Run(period, period / 60, step=FixedStep(period / 3000))
    solution = simulate(system, run)
    rotation = solution.bodies["bob"].rotation
    angle = np.arctan2(rotation[:, 2, 1], rotation[:, 1, 1])
    exact = 2 * np.arcsin(k * ellipj(ellipk(k**2) - rate * solution.times, k**2)[0])
    source = "elliptic integral of the first kind: Abramowitz and Stegun, chapters 16 and 17"
    carried = -solution.multipliers["hinge"][:, :3]
    lowest = int(np.argmin(np.abs(exact[:31])))
    return (
        Comparison(
            "angle over a period, largest difference, rad",
            float(np.abs(angle - exact).max()),
            0.0,
            source,
            1e-5,
            scale=swing,
        ),
        Comparison(
            "force of the hinge at the lowest point, N",
            float(np.linalg.norm(carried[lowest])),
            mass * g * (1 + 2 * (1 - np.cos(swing)) * mass * arm**2 / (inertia + mass * arm**2)),
            "energy and centripetal acceleration",
            1e-5,
        ),
    )


CASES = (ValidationCase("pendulum let go at 120 degrees", pendulum),)
