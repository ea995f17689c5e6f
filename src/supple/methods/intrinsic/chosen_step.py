"""The step of a run that names none, from the periods of the modes that are kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.integrate import FixedStep, GeneralizedAlpha, ResidualRungeKutta4, Run
from supple.machine import System
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.stable_step import largest_stable_step

__all__ = ["with_chosen_step"]

STEPS_A_PERIOD = 20
"""The rule of second order then turns a mode by 0.8 % of a period too little in each of its periods."""
MOST_RESOLVED = 16
"""Modes of a body, the lowest, whose periods bind an implicit step; the others follow, damped by the rule."""
OF_STABLE = 0.9


def with_chosen_step(system: System, run: Run) -> Run:
    """The run with a fixed step, where it names none and the machine has intrinsic bodies.

    An implicit step is a twentieth of the shortest period of the modes kept, of the lowest sixteen at most
    and without those of second order; an explicit one is stable besides. It divides the output step.
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
    k, model = body.modes.n_rigid, body.model
    n = body.modes.n_modes
    if isinstance(run.method, ResidualRungeKutta4):
        n = min(n, run.method.n_kept)
    omega = np.asarray(model.omega)[: n - k]
    decay, retardation = np.asarray(model.decay)[k:n], np.asarray(model.retardation)[: n - k]
    return float(min(accurate, OF_STABLE * largest_stable_step(omega, decay, retardation)))
