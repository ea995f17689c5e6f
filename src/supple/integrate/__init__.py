"""Time integrators: they know equations, not bodies."""

from supple.integrate.generalized_alpha import (
    Coefficients,
    GeneralizedAlpha,
    HilberHughesTaylor,
    Newmark,
    StepRule,
    TimeIntegrator,
)
from supple.integrate.solution import BodyMotion, Solution, Statistics, concatenate
from supple.integrate.step_control import AdaptiveStep, FixedStep, StepControl, Tolerances

__all__ = [
    "AdaptiveStep",
    "BodyMotion",
    "Coefficients",
    "FixedStep",
    "GeneralizedAlpha",
    "HilberHughesTaylor",
    "Newmark",
    "Solution",
    "Statistics",
    "StepControl",
    "StepRule",
    "TimeIntegrator",
    "Tolerances",
    "concatenate",
]
