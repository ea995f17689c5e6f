"""Check whether a constraint equation is redundant everywhere, or only in the initial configuration.

In a singular position, constraint equations of a mechanism depend on each other; in other positions they do
not. Examples are a flat parallelogram, a folded slider-crank, and a taut chain between two pins. If such an
equation is left out of the run, its joint opens as soon as the mechanism moves. The test moves the mechanism
a little along the motions that the remaining equations allow, and solves these equations again; a truly
redundant equation is then still satisfied.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy.linalg

from supple.equations.configuration import Configuration
from supple.errors import ConvergenceError, ModelError

__all__ = ["check_redundant_nearby", "neighbours"]

MOVED_BY = 1e-3
"""Size of the motion, relative to the system's size or in rad; a residual quadratic in the motion is then
1e-6."""
OPENED_BY = 1e-8
"""Largest residual of a truly redundant equation, relative to the system's size or in rad."""
DIRECTIONS = 3
"""Number of random combinations of the free motions, because a single motion may not open the joint."""


def neighbours(length: float, parts: Sequence[slice], jacobian: np.ndarray) -> np.ndarray:
    """Small motions of the bodies' frames (k, nb, 6) that the joints allow to first order.

    length : size of the system
    parts : positions of the velocities of each body in the columns of the jacobian, its frame's six first
    jacobian : (m, n)   of the remaining constraint equations
    """
    scale = np.tile(np.concatenate([np.full(3, length), np.ones(3)]), len(parts))
    columns = [jacobian[:, part.start : part.start + 6] for part in parts]
    free = scipy.linalg.null_space(np.hstack(columns) * scale, rcond=1e-9)
    if not free.shape[1]:
        return np.zeros((0, len(parts), 6))
    random = np.random.default_rng(0).standard_normal((DIRECTIONS, free.shape[1]))
    moves = random @ free.T
    moves *= MOVED_BY / np.abs(moves).max(axis=1, keepdims=True)
    return (moves * scale).reshape(DIRECTIONS, len(parts), 6)


def check_redundant_nearby(
    labels: Sequence[str],
    left_out: Sequence[int],
    nearby: Sequence[np.ndarray],
    closed: Callable[[np.ndarray], Configuration],
    relative_residual: Callable[[Configuration], np.ndarray],
) -> None:
    """Raise ModelError when an omitted equation is violated in a neighbouring configuration.

    labels : labels of all equations
    left_out : numbers of the equations that depend on others in the initial configuration
    nearby : motions of the frames
    closed : function for the configuration after such a motion that satisfies the remaining equations
    relative_residual : function for the residuals of all equations, positions relative to the system's size
    """
    for motion in nearby:
        try:
            opened = np.abs(relative_residual(closed(motion)))[list(left_out)]
        except ConvergenceError:
            continue  # the remaining equations do not allow this configuration
        worst = int(np.argmax(opened))
        if opened[worst] > OPENED_BY:
            names = ", ".join(labels[index] for index in left_out)
            raise ModelError(
                f"the mechanism starts in a dead point: {names} depend(s) on the other joints in the initial "
                f"configuration, but not beside it, where {labels[left_out[worst]]} would open by "
                f"{opened[worst]:.2g} of the machine's size, or rad. The motion out of a dead point is "
                "undetermined: place the bodies beside it, with all joints closed; it is enough to give a "
                "driving joint an initial angle that is not at the dead point"
            )
