"""Time integrators: they know equations, not bodies."""

from supple.integrate.generalized_alpha import (
    Coefficients,
    GeneralizedAlpha,
    HilberHughesTaylor,
    Newmark,
    StepRule,
    TimeIntegrator,
)
from supple.integrate.run_options import Run, Validity
from supple.integrate.solution import FloatingMotion, Solution, Statistics, concatenate
from supple.integrate.step_control import AdaptiveStep, FixedStep, StepControl, Tolerances

__all__ = [
    "AdaptiveStep",
    "Coefficients",
    "FixedStep",
    "FloatingMotion",
    "GeneralizedAlpha",
    "HilberHughesTaylor",
    "Newmark",
    "Run",
    "Solution",
    "Statistics",
    "StepControl",
    "StepRule",
    "TimeIntegrator",
    "Tolerances",
    "Validity",
    "concatenate",
]
