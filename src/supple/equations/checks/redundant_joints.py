"""Check that constraint equations left out as redundant still hold while the machine moves."""

from __future__ import annotations

import numpy as np

from supple.equations.build_model import row_scales
from supple.equations.checks.joint_residuals import joint_residuals
from supple.errors import AccuracyError
from supple.integrate import Solution
from supple.machine import System

__all__ = ["check_redundant_joints"]

OPEN = 1e-4
"""Residual of an omitted equation, relative to the system's size or in rad, above which the equation counts
as violated; the residuals of redundant equations are far smaller."""


def check_redundant_joints(system: System, leg: Solution) -> None:
    """Raise AccuracyError for a joint that is violated because its equations were left out.

    Such an equation depends on others at the start of the run, but not at a later time.

    leg : a part of the run
    """
    n_equations = system.n_constraints
    kept = leg.engine_state.get("active")
    if kept is None or len(kept) == n_equations:
        return
    residuals = np.abs(joint_residuals(system, leg)) / row_scales(system)
    residuals[:, kept.astype(int)] = 0.0
    row, worst = np.unravel_index(np.argmax(residuals), residuals.shape)
    if residuals[row, worst] > OPEN:
        labels = [f"'{joint.name}' ({what})" for joint in system.joints for what in joint.rows]
        raise AccuracyError(
            f"{labels[worst]} was left out at the start as redundant, and is off by "
            f"{residuals[row, worst]:.3g} of the machine's size, or rad, at t = {leg.times[row]:.6g}: the "
            "machine has left the position in which its joints are redundant. Start beside that position"
        )
