"""Time integrators and the march through time: they know equations, not bodies."""

from supple.integrate.engine import Engine, Leg, Progress, Recorder
from supple.integrate.error_statement import PARTS, ErrorPart, ErrorStatement
from supple.integrate.explicit_rule import ExplicitRule
from supple.integrate.first_order import FirstOrderRule, ResidualRungeKutta4, RungeKutta4
from supple.integrate.generalized_alpha import (
    Coefficients,
    GeneralizedAlpha,
    HilberHughesTaylor,
    Newmark,
    StepFactors,
    StepRule,
    TimeIntegrator,
    damps_joint_forces,
)
from supple.integrate.kinematic import Kinematic
from supple.integrate.motion import FloatingMotion, Motion, StackedMotion, motion_from_arrays, register_motion
from supple.integrate.run import leg_size, run
from supple.integrate.run_options import MOST_OUTPUT_TIMES, Run, Validity
from supple.integrate.solution import (
    JOINT_AXES,
    JOINT_COMPONENTS,
    Solution,
    Statistics,
    concatenate,
)
from supple.integrate.step_control import AdaptiveStep, FixedStep, StepControl, Tolerances

__all__ = [
    "JOINT_AXES",
    "JOINT_COMPONENTS",
    "MOST_OUTPUT_TIMES",
    "PARTS",
    "AdaptiveStep",
    "Coefficients",
    "Engine",
    "ErrorPart",
    "ErrorStatement",
    "ExplicitRule",
    "FirstOrderRule",
    "FixedStep",
    "FloatingMotion",
    "GeneralizedAlpha",
    "HilberHughesTaylor",
    "Kinematic",
    "Leg",
    "Motion",
    "Newmark",
    "Progress",
    "Recorder",
    "ResidualRungeKutta4",
    "Run",
    "RungeKutta4",
    "Solution",
    "StackedMotion",
    "Statistics",
    "StepControl",
    "StepFactors",
    "StepRule",
    "TimeIntegrator",
    "Tolerances",
    "Validity",
    "concatenate",
    "damps_joint_forces",
    "leg_size",
    "motion_from_arrays",
    "register_motion",
    "run",
]
