"""State of a compiled run between two steps, and its numerical settings."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from supple.arrays import AnyArray
from supple.equations.configuration import Configuration, ControlState
from supple.integrate import Coefficients
from supple.methods.floating.compiled.contraction import Contraction
from supple.methods.floating.compiled.frozen_tangent import FrozenInverse

# NumPy arrays: a program accepts them as they are; JAX would compile a program for each.
_COUNT, _FALSE, _NONE, _UNKNOWN = np.zeros((), int), np.zeros((), bool), np.zeros(()), np.zeros(4)


class Controls(NamedTuple):
    """Numerical settings of a run as plain floats, so that a change needs no new compilation."""

    coefficients: Coefficients
    first: AnyArray
    largest: AnyArray
    smallest: AnyArray
    error_tolerance: AnyArray
    residual_tolerance: AnyArray
    max_iterations: AnyArray


class State(NamedTuple):
    """All numbers needed to continue a run from an instant."""

    time: AnyArray
    step: AnyArray
    """Size of the next trial step."""
    configuration: Configuration
    velocity: AnyArray
    acceleration: AnyArray
    auxiliary: AnyArray
    """Auxiliary acceleration of the Newmark family."""
    multipliers: AnyArray
    contraction: Contraction
    steps: AnyArray = _COUNT
    iterations: AnyArray = _COUNT
    rejected_steps: AnyArray = _COUNT
    failed: AnyArray = _FALSE
    """True when the smallest step did not converge; the state is that before this step."""
    relative_residual: AnyArray = _UNKNOWN
    """Relative residual at the last evaluation, by kind: force, moment, deformation, constraint."""
    largest_error: AnyArray = _NONE
    """Largest local error of the accepted steps."""
    largest_turn: AnyArray = _NONE
    """Largest rotation of a body within an accepted step, rad."""
    control: ControlState | None = None
    """None where there are no controllers"""
    kept: FrozenInverse | None = None
    """None where every iterate has its own tangent"""
