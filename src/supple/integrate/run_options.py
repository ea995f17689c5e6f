"""Settings of a run: time span, output times, steps, tolerances and limits of validity."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite

import numpy as np

from supple.arguments import check_fields
from supple.integrate.generalized_alpha import GeneralizedAlpha, TimeIntegrator
from supple.integrate.other_methods import ExplicitRule, FirstOrderRule, Kinematic
from supple.integrate.step_control import FixedStep, StepControl, Tolerances, check_positive
from supple.summary import Summarized, Summary

__all__ = ["MOST_OUTPUT_TIMES", "Run", "Validity"]

MOST_OUTPUT_TIMES = 10_000_000
"""Largest number of output times of a run, because of memory; `Run` raises ValueError for more."""


@dataclass(frozen=True)
class Validity:
    """Checks of a run: limits of its kinematics, initial state and steps.

    strict : True: a check that fails raises ValidityError; False: it warns
    spin_ratio : largest angular velocity of a body that lacks centrifugal stiffness, as a ratio to a
        reference. For a linear body, the reference is its lowest angular frequency. For a reduced body whose
        condensed motion has no inertia, it is the angular velocity at which the missing centrifugal stiffness
        equals the elastic stiffness. At a ratio of 0.3, the missing stiffness is about 10 % of the elastic
        stiffness
    """

    strict: bool = False
    spin_ratio: float = 0.3

    def __post_init__(self) -> None:
        check_fields(self)
        if not (np.isfinite(self.spin_ratio) and self.spin_ratio > 0):
            raise ValueError(f"spin_ratio must be positive, got {self.spin_ratio}")


@dataclass(frozen=True, repr=False)
class Run(Summarized):
    """Time span, output times and time integration of a simulation.

    duration : float        time span of the run, in the unit of time; a multiple of `output_step`
    output_step : float     time between output times
    step : FixedStep | AdaptiveStep     default: a fixed step equal to the output step; in a machine with
        intrinsic bodies a step from the periods of their modes; with explicit parts the stable step
    method : GeneralizedAlpha (rho_inf = 0.8) | Newmark | HilberHughesTaylor. A machine of only intrinsic
        bodies also allows RungeKutta4 | ResidualRungeKutta4. For explicit parts, the method is
        supple.methods.explicit.Explicit, also by default. Kinematic is for zero degrees of freedom
    tolerances : Tolerances     of Newton's iteration
    validity : Validity     limits of validity; if one is exceeded, the run warns, or fails if `strict`
    start : float           time of the initial state
    Raises ValueError for a duration or output step that is not positive and finite, a start that is not
        finite, a duration that is no multiple of the output step, or more than `MOST_OUTPUT_TIMES` output
        times.
    """

    duration: float
    output_step: float
    step: StepControl | None = None
    method: TimeIntegrator | FirstOrderRule | Kinematic | ExplicitRule = field(
        default_factory=GeneralizedAlpha
    )
    tolerances: Tolerances = field(default_factory=Tolerances)
    validity: Validity = field(default_factory=Validity)
    start: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self)
        check_positive(duration=self.duration, output_step=self.output_step)
        if not isfinite(self.start):
            raise ValueError(f"start must be a finite number, got {self.start}")
        ratio = self.duration / self.output_step
        if ratio > MOST_OUTPUT_TIMES:
            raise ValueError(
                f"a duration of {self.duration:g} with an output step of {self.output_step:g} has "
                f"{ratio:.3g} output times; at most {MOST_OUTPUT_TIMES} are stored: give a longer output "
                "step (the time step need not change)"
            )
        n = round(ratio)
        if n < 1 or abs(n * self.output_step - self.duration) > 1e-6 * self.output_step:
            raise ValueError(
                f"the duration ({self.duration}) is not a multiple of the output step ({self.output_step}): "
                f"try an output step of {self.duration / max(n, 1):.6g}"
            )

    def summary(self) -> Summary:
        """Time span, steps and method."""
        span = f"{self.start:g} to {self.start + self.duration:g}"
        rows = [
            ("times", f"{span}, {self.times.size} output times, every {self.output_step:g}"),
            ("step", "default of the machine" if self.step is None else str(self.step)),
            ("method", str(self.method)),
            ("tolerances", str(self.tolerances)),
            ("validity", str(self.validity)),
        ]
        return Summary(f"Run from {span}", rows)

    @property
    def times(self) -> np.ndarray:
        """`start, start + output_step, .. , start + duration`, (t,)."""
        n = round(self.duration / self.output_step)
        return self.start + np.arange(n + 1) * (self.duration / n)

    @property
    def step_control(self) -> StepControl:
        """Control of the step size; by default a fixed step equal to the output step."""
        return self.step or FixedStep(self.output_step)

    @property
    def n_steps(self) -> float:
        """Duration divided by the first step: the number of steps if all have this size."""
        return self.duration / float(self.step_control.first)

    @property
    def second_order_method(self) -> TimeIntegrator:
        """The method, if it is an implicit one of second order; ValueError for any other method."""
        floating = "GeneralizedAlpha(rho_inf), Newmark() or HilberHughesTaylor(alpha)"
        if isinstance(self.method, Kinematic):
            raise ValueError(
                f"a kinematic run has no time integration, which is necessary here: give the run {floating}"
            )
        if isinstance(self.method, ExplicitRule | FirstOrderRule):
            explicit = "modal and finite-element parts of an explicit run"
            supported = explicit if isinstance(self.method, ExplicitRule) else "machines of intrinsic bodies"
            raise ValueError(
                f"{type(self.method).__name__} supports {supported} only; for bodies in floating frames use "
                f"{floating}"
            )
        return self.method
