"""Check of the step against the stability limit of an explicit rule."""

from __future__ import annotations

import numpy as np

from supple.errors import ModelError
from supple.integrate import GeneralizedAlpha, ResidualRungeKutta4
from supple.methods.intrinsic.line_march import LineRule
from supple.methods.intrinsic.line_model import LineModel
from supple.methods.intrinsic.machine_of_lines import MachineOfLines
from supple.methods.intrinsic.runge_kutta import growth, linear_eigenvalues

__all__ = ["check_stable", "largest_stable_step", "linear_modes"]

ROUNDING = 1e-9
"""Growth of a mode per step up to which it is round-off, not instability."""


def linear_modes(model: LineModel, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies, decay and retardation times of the elastic modes among the n lowest modes."""
    k = model.n_rigid
    e = max(n - k, 0)
    decay = np.asarray(model.decay)[(slice(k, k + e),) * model.decay.ndim]
    retardation = np.asarray(model.retardation)[(slice(e),) * model.retardation.ndim]
    return np.asarray(model.omega)[:e], decay, retardation


def largest_stable_step(omega: np.ndarray, decay: np.ndarray, retardation: np.ndarray) -> float:
    """The longest step for which no linear mode grows: 2 sqrt 2 / w undamped, infinite without modes."""
    if not omega.size or not omega.max() > 0:
        return np.inf
    eigenvalues = linear_eigenvalues(omega, decay, retardation)
    low, high = 0.0, 3.0 / float(omega.max())
    for _ in range(60):
        middle = 0.5 * (low + high)
        stable = growth(eigenvalues, middle) <= 1 + ROUNDING
        low, high = (middle, high) if stable else (low, middle)
    return low


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
        modes = linear_modes(model, n)
        if growth(linear_eigenvalues(*modes), step) <= 1 + ROUNDING:
            continue
        omega, longest = modes[0], largest_stable_step(*modes)
        raise ModelError(
            f"body '{placed.body.name}': a step of {step:.4g} is unstable with a highest frequency of "
            f"{omega.max():.4g} rad/s (step times frequency {step * omega.max():.3g}; at most 2.83, less "
            f"with damping): use steps of at most {longest:.3g}, fewer modes, ResidualRungeKutta4(n_kept) "
            "or GeneralizedAlpha, which is stable at any step"
        )
