"""Default step of a run, from the periods of the retained modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.integrate import FixedStep, GeneralizedAlpha, ResidualRungeKutta4, Run
from supple.machine import System
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.stable_step import largest_stable_step, linear_modes

__all__ = ["with_chosen_step"]

STEPS_A_PERIOD = 20
"""Steps per period; the second-order rule then has a phase lag of 0.8 % of a period in each period."""
MOST_RESOLVED = 16
"""Number of lowest modes of a body whose periods limit the default step; higher modes are not resolved."""
OF_STABLE = 0.9
"""Default explicit step relative to the largest stable step."""


def with_chosen_step(system: System, run: Run) -> Run:
    """The run, with a fixed default step if it has no step and the machine has intrinsic bodies.

    The default step is at most a twentieth of the shortest period of the lowest sixteen modes of each body,
    without second-order modes. An explicit step is also at most 0.9 times the largest stable step. The output
    step is a multiple of the default step.
    """
    bodies = list(system.bodies_of(IntrinsicBody).values())
    if run.step is not None or not bodies:
        return run
    longest = min(_longest(body, run) for body in bodies)
    step = float(run.times[1] - run.times[0])
    return replace(run, step=FixedStep(step / max(1, int(np.ceil(step / longest * (1 - 1e-9))))))


def _longest(body: IntrinsicBody, run: Run) -> float:
    resolved = body.modes.frequencies[:MOST_RESOLVED].max(initial=0.0)
    accurate = 2 * np.pi / resolved / STEPS_A_PERIOD if resolved > 0 else np.inf
    if isinstance(run.method, GeneralizedAlpha):
        return float(accurate)
    n = run.method.n_kept if isinstance(run.method, ResidualRungeKutta4) else body.modes.n_modes
    return float(min(accurate, OF_STABLE * largest_stable_step(*linear_modes(body.model, n))))
