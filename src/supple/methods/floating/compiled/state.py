"""State of a compiled run between two steps, and its numerical settings."""

from __future__ import annotations

from typing import Any, NamedTuple

from supple.equations.configuration import AnyArray, Configuration, ControlState
from supple.integrate import Coefficients
from supple.methods.floating.compiled.contraction import Contraction
from supple.methods.floating.compiled.frozen_tangent import FrozenInverse

__all__ = ["Controls", "State"]


class Controls(NamedTuple):
    """Numerical settings of a run as plain floats, so that a change needs no new compilation."""

    coefficients: Coefficients
    first: Any
    largest: Any
    smallest: Any
    error_tolerance: Any
    residual_tolerance: Any
    max_iterations: Any


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
    steps: AnyArray
    iterations: AnyArray
    rejected_steps: AnyArray
    failed: AnyArray
    """True when the smallest step did not converge; the state is that before this step."""
    relative_residual: AnyArray
    """Relative residual at the last evaluation, by kind: force, moment, deformation, constraint."""
    contraction: Contraction
    largest_error: AnyArray
    """Largest local error of the accepted steps."""
    largest_turn: AnyArray
    """Largest rotation of a body within an accepted step, rad."""
    control: ControlState | None = None
    """None where there are no controllers"""
    kept: FrozenInverse | None = None
    """None where every iterate has its own tangent"""
