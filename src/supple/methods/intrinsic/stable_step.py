"""Length of steps: the stability limit of explicit rules, and the default step from the periods of modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.errors import ModelError
from supple.integrate import FixedStep, GeneralizedAlpha, ResidualRungeKutta4, Run
from supple.machine import System
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.line_march import LineRule
from supple.methods.intrinsic.line_model import LineModel
from supple.methods.intrinsic.machine_of_lines import MachineOfLines

__all__ = ["with_chosen_step"]

ROUNDING = 1e-9
"""Growth of a mode per step up to which it is round-off, not instability."""
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
    return float(min(accurate, OF_STABLE * largest_stable_step(*_linear_modes(body.model, n))))


def check_stable(machine: MachineOfLines, rule: LineRule, step: float) -> None:
    """Raise ModelError if a mode grows under an explicit rule, or if the rule keeps no elastic mode."""
    if isinstance(rule, GeneralizedAlpha):
        return
    for placed, model in zip(machine.system.bodies, machine.lines.lines, strict=True):
        n = rule.n_kept if isinstance(rule, ResidualRungeKutta4) else model.velocities.shape[1]
        if isinstance(rule, ResidualRungeKutta4) and n <= model.n_rigid:
            raise ModelError(
                f"body '{placed.body.name}': {n} modes kept, {model.n_rigid} of them rigid: keep elastic "
                "modes too"
            )
        modes = _linear_modes(model, n)
        if _growth(linear_eigenvalues(*modes), step) <= 1 + ROUNDING:
            continue
        omega, longest = modes[0], largest_stable_step(*modes)
        raise ModelError(
            f"body '{placed.body.name}': a step of {step:.4g} is unstable with a highest frequency of "
            f"{omega.max():.4g} rad/s (step times frequency {step * omega.max():.3g}; at most 2.83, less "
            f"with damping): use steps of at most {longest:.3g}, fewer modes, ResidualRungeKutta4(n_kept) "
            "or GeneralizedAlpha, which is stable at any step"
        )


def largest_stable_step(omega: np.ndarray, decay: np.ndarray, retardation: np.ndarray) -> float:
    """The longest step for which no linear mode grows: 2 sqrt 2 / w undamped, infinite without modes."""
    if not omega.size or not omega.max() > 0:
        return np.inf
    eigenvalues = linear_eigenvalues(omega, decay, retardation)
    low, high = 0.0, 3.0 / float(omega.max())
    for _ in range(60):
        middle = 0.5 * (low + high)
        stable = _growth(eigenvalues, middle) <= 1 + ROUNDING
        low, high = (middle, high) if stable else (low, middle)
    return low


def linear_eigenvalues(omega: np.ndarray, decay: np.ndarray, retardation: np.ndarray) -> np.ndarray:
    """Eigenvalues s (2 e,) of the linear modes, s^2 + (d + w beta w) s + w^2 = 0.

    decay, retardation : (e,) or (e, e)    d and beta
    """
    if decay.ndim == retardation.ndim == 1:
        half = 0.5 * (decay + retardation * omega**2)
        root = np.sqrt((half**2 - omega**2).astype(complex))
        return np.concatenate([-half + root, -half - root])
    whole, late = (each if each.ndim == 2 else np.diag(each) for each in (decay, retardation))
    damping = whole + omega[:, None] * late * omega
    elastic = np.diag(omega)
    return np.linalg.eigvals(np.block([[-damping, elastic], [-elastic, np.zeros_like(elastic)]]))


def _linear_modes(model: LineModel, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies, decay and retardation times of the elastic modes among the n lowest modes."""
    k = model.n_rigid
    e = max(n - k, 0)
    decay = np.asarray(model.decay)[(slice(k, k + e),) * model.decay.ndim]
    retardation = np.asarray(model.retardation)[(slice(e),) * model.retardation.ndim]
    return np.asarray(model.omega)[:e], decay, retardation


def _growth(eigenvalues: np.ndarray, h: float) -> float:
    """Largest factor by which a Runge-Kutta step multiplies a linear mode, at most 1 for a stable step.

    |1 + z + z^2/2 + z^3/6 + z^4/24|, z = h s. Without damping the factor exceeds 1 where w h > 2 sqrt 2.
    """
    z = h * eigenvalues
    return float(np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24).max(initial=0.0))
