"""Accelerations at one time with friction that depends on the joint forces."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from supple.errors import ConvergenceError

__all__ = ["converged_reactions"]

MOST, CONVERGED = 100, 1e-12
"""Iterations, and the relative change of the joint forces at which they stop."""

S = TypeVar("S", bound=tuple[Any, ...])


def converged_reactions(answered: Callable[[np.ndarray], S], found: S) -> S:
    """Accelerations, multipliers and any further quantities, by fixed-point iteration.

    answered : function that returns these quantities for friction at given multipliers (m,)
    found : these quantities without friction

    Raises ConvergenceError where friction and joint forces increase each other without limit.
    """
    for _ in range(MOST):
        before, found = found[1], answered(found[1])
        if not np.isfinite(found[1]).all():
            break
        # Largest entries instead of norms: squares of diverging values would overflow.
        if np.max(abs(found[1] - before)) <= CONVERGED * np.max(abs(found[1])):
            return found
    raise ConvergenceError(
        "friction and the forces in the joints do not converge: each raises the other, as "
        "in a slide that jams. Lower the coefficient of friction, or the radius of the pin"
    )
