"""Accelerations at one instant under friction that depends on what the joints carry."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from supple.errors import ConvergenceError

__all__ = ["converged_reactions"]

MOST, CONVERGED = 100, 1e-12
"""Iterations, and the change of the joint forces at which they end, of the largest."""

S = TypeVar("S", bound=tuple[Any, ...])


def converged_reactions(answered: Callable[[np.ndarray], S], found: S) -> S:
    """Accelerations, multipliers, and whatever else belongs to them, by iteration.

    answered : these, with the forces that depend on given multipliers (m,)
    found : without such forces

    Raises ConvergenceError where friction raises the joints' forces that it comes from by more each time.
    """
    for _ in range(MOST):
        before, found = found[1], answered(found[1])
        if not np.isfinite(found[1]).all():
            break
        # Of what grows without bound the largest entry, whose square would overflow.
        if np.max(abs(found[1] - before)) <= CONVERGED * np.max(abs(found[1])):
            return found
    raise ConvergenceError(
        "friction and the forces in the joints do not converge: each raises the other, as "
        "in a slide that jams. Lower the coefficient of friction, or the radius of the pin"
    )
