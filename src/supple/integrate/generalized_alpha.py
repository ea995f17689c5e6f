"""The Newmark family of time integrators, for equations of second order with rotations and constraints.

A step of size `h` leads from index 0 to index 1:

    q_1 = q_0 o exp( h v_0 + h^2 [ (1/2 - beta) a_0 + beta a_1 ] )
    v_1 = v_0 + h [ (1 - gamma) a_0 + gamma a_1 ]
    (1 - alpha_m) a_1 + alpha_m a_0 = (1 - alpha_f) vdot_1 + alpha_f vdot_0

`q` is the configuration, `v` the velocity, `vdot` the acceleration, and `a` an auxiliary acceleration;
`q_0 o exp(..)` adds translations and multiplies rotations. The equations of motion hold at the end of the
step. The family is of second order if `gamma = 1/2 - alpha_m + alpha_f`.

Sources: Chung & Hulbert (1993); Arnold & Bruels (2007) for rotations and Lagrange multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from supple.arguments import check_fields

__all__ = [
    "Coefficients",
    "GeneralizedAlpha",
    "HilberHughesTaylor",
    "Newmark",
    "StepFactors",
    "StepRule",
    "TimeIntegrator",
    "damps_joint_forces",
]


class Coefficients(NamedTuple):
    """The four coefficients of an integrator of the Newmark family."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float


class TimeIntegrator(Protocol):
    """An integrator of the Newmark family, defined by its four coefficients."""

    @property
    def coefficients(self) -> Coefficients:
        """`alpha_m`, `alpha_f`, `beta` and `gamma`."""
        ...


def damps_joint_forces(method: TimeIntegrator) -> bool:
    """Whether oscillations of the multipliers decay.

    They do for `gamma > 1/2`: the spectral radius at infinite frequency is then below 1.
    """
    return method.coefficients.gamma > 0.5 + 1e-12


def _second_order(alpha_m: float, alpha_f: float) -> Coefficients:
    gamma = 0.5 - alpha_m + alpha_f
    return Coefficients(alpha_m, alpha_f, beta=0.25 * (gamma + 0.5) ** 2, gamma=gamma)


@dataclass(frozen=True)
class GeneralizedAlpha:
    """Generalized-alpha: second order, with numerical damping of high frequencies.

    rho_inf : spectral radius at infinite frequency, in [0, 1]. 1: no numerical damping. 0: vibrations with
        periods much shorter than the step vanish within one step. For values near 1, spurious oscillations of
        joint forces decay slowly
    """

    rho_inf: float = 0.8

    def __post_init__(self) -> None:
        check_fields(self)
        if not 0.0 <= self.rho_inf <= 1.0:
            raise ValueError(f"rho_inf must lie in [0, 1], got {self.rho_inf}: 0.8 suits most machines")

    @property
    def coefficients(self) -> Coefficients:
        """`alpha_m = (2 rho - 1)/(rho + 1)`, `alpha_f = rho/(rho + 1)` (Chung & Hulbert 1993, (25))."""
        rho = self.rho_inf
        return _second_order((2 * rho - 1) / (rho + 1), rho / (rho + 1))


@dataclass(frozen=True)
class Newmark:
    """Newmark's trapezoidal rule (`beta = 1/4`, `gamma = 1/2`), without numerical damping."""

    @property
    def coefficients(self) -> Coefficients:
        """`alpha_m = alpha_f = 0`."""
        return _second_order(0.0, 0.0)


@dataclass(frozen=True)
class HilberHughesTaylor:
    """HHT-alpha: `alpha` in [0, 1/3] damps high frequencies; 0 is the trapezoidal rule."""

    alpha: float = 0.05

    def __post_init__(self) -> None:
        check_fields(self)
        if not 0.0 <= self.alpha <= 1 / 3:
            raise ValueError(f"the HHT parameter must lie in [0, 1/3], got {self.alpha}: try 0.05")

    @property
    def coefficients(self) -> Coefficients:
        """`alpha_m = 0`, `alpha_f = alpha`."""
        return _second_order(0.0, self.alpha)


class StepFactors(NamedTuple):
    """Derivatives of position and velocity with respect to the new acceleration `vdot_1`, for the tangent.

    They are `beta h^2 kappa` and `gamma h kappa`; `kappa = (1 - alpha_f)/(1 - alpha_m)` is the derivative of
    the auxiliary acceleration `a_1`. Arnold & Bruels denote them `1/beta'` and `gamma'/beta'`.
    """

    by_position: Any
    """`beta h^2 kappa`, of the configuration increment."""
    by_velocity: Any
    """`gamma h kappa`, of the new velocity."""


class StepRule(NamedTuple):
    """The equations of one step of size `h`, for NumPy and JAX arrays."""

    coefficients: Coefficients
    h: Any

    @property
    def factors(self) -> StepFactors:
        """Derivatives of position and velocity with respect to the new acceleration, for the tangent."""
        alpha_m, alpha_f, beta, gamma = self.coefficients
        kappa = (1 - alpha_f) / (1 - alpha_m)
        return StepFactors(beta * self.h**2 * kappa, gamma * self.h * kappa)

    def auxiliary(self, vdot_1: Any, vdot_0: Any, a_0: Any) -> Any:
        """The new auxiliary acceleration `a_1`."""
        alpha_m, alpha_f, _, _ = self.coefficients
        return ((1 - alpha_f) * vdot_1 + alpha_f * vdot_0 - alpha_m * a_0) / (1 - alpha_m)

    def increment(self, v_0: Any, a_0: Any, a_1: Any) -> Any:
        """The configuration increment, the argument of `exp`."""
        beta = self.coefficients.beta
        return self.h * v_0 + self.h**2 * ((0.5 - beta) * a_0 + beta * a_1)

    def new_velocity(self, v_0: Any, a_0: Any, a_1: Any) -> Any:
        """The new velocity."""
        gamma = self.coefficients.gamma
        return v_0 + self.h * ((1 - gamma) * a_0 + gamma * a_1)

    def position_error(self, a_0: Any, a_1: Any) -> Any:
        """Leading local error of a position, `h^2 (beta - 1/6) (a_1 - a_0)` (Zienkiewicz & Xie 1991)."""
        return self.h**2 * (self.coefficients.beta - 1 / 6) * (a_1 - a_0)
