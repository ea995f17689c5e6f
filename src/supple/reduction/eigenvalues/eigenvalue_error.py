"""Estimates of the eigenvalue errors of a Craig-Bampton body, from the residual of its truncated modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from supple.algebra import ReadOnlyArrays, read_only
from supple.reduction.components.fixed_interface_component import FixedInterfaceComponent
from supple.reduction.components.free_vibration import FreeVibrations

__all__ = [
    "EigenvalueErrorEstimator",
    "ErrorTerms",
    "FirstOrderEstimate",
    "Han2020Bound",
    "KnownEigenvalues",
    "SharperBound",
    "TwoTermEstimate",
    "error_terms",
]


@dataclass(frozen=True, eq=False)
class ErrorTerms(ReadOnlyArrays):
    """The terms of the estimators; n counts the elastic vibrations of the free reduced body.

    values : (N,)   chi-bar, eigenvalues of the reduced body, rad^2/s^2
    first  : (N,)   xi^T X xi,  xi the interface part of each vibration
    second : (N,)   xi^T X2 xi
    fixed  : (m,)   kappa, eigenvalues of all computed fixed-interface modes, rad^2/s^2
    next_fixed : kappa of the first truncated mode, rad^2/s^2; infinite when all computed modes are kept
    """

    values: np.ndarray
    first: np.ndarray
    second: np.ndarray
    fixed: np.ndarray
    next_fixed: float


def error_terms(component: FixedInterfaceComponent, vibrations: FreeVibrations) -> ErrorTerms:
    """The terms of each vibration of a body with fewer modes than the component.

    The residual flexibility is that of the modes not computed, by deflation, plus a a^T / kappa for each
    computed but truncated mode of participation a. These rank-one updates only add. The difference
    K^-1 - Phi Lambda^-1 Phi^T would cancel nearly all digits.
    """
    n_kept, xi = len(vibrations.modal), vibrations.interfaces
    kept = component.leading(n_kept)
    return ErrorTerms(
        values=vibrations.values,
        first=np.sum(xi * (kept.residual_flexibility @ xi), axis=0),
        second=np.sum(xi * (kept.residual_mass @ xi), axis=0),
        fixed=component.eigenvalues,
        next_fixed=float(component.eigenvalues[n_kept]) if n_kept < component.n_modes else np.inf,
    )


class EigenvalueErrorEstimator(Protocol):
    """An estimate of zeta_n = chi-bar_n / chi_n - 1, the relative error of a reduced eigenvalue.

    Upper and lower estimates are bounds to first order, for errors of a few per cent and less. No estimate
    detects a truncated mode without motion or force at the interfaces; a count of the eigenvalues does.
    """

    def errors(self, terms: ErrorTerms) -> np.ndarray:
        """Relative error of each vibration, (N,)."""
        ...


@dataclass(frozen=True)
class FirstOrderEstimate:
    """The first term alone, eta_n = chi-bar xi^T X xi: to first order a lower estimate. [Han2020] (45)"""

    def errors(self, terms: ErrorTerms) -> np.ndarray:
        """eta_n."""
        return terms.values * terms.first


@dataclass(frozen=True)
class Han2020Bound:
    """(chi-bar + chi-bar^2 / kappa_n) xi^T X xi, n the number of the elastic vibration. [Han2020] (42)

    If at least n modes are kept, every truncated mode is above the n-th fixed-interface mode, so its share is
    bounded. With many modes the bound is two or three times the true error, or tens of times this error where
    chi-bar_n is far above kappa_n. With fewer than n modes, possible with several interfaces, the estimate is
    no bound. If fewer than n modes are computed, the last of them replaces the n-th.
    """

    def errors(self, terms: ErrorTerms) -> np.ndarray:
        """Upper estimate."""
        n_th = np.minimum(np.arange(terms.values.size), max(terms.fixed.size - 1, 0))
        ratio = terms.values / np.append(terms.fixed, np.inf)[n_th]
        return terms.values * (1.0 + ratio) * terms.first


@dataclass(frozen=True)
class SharperBound:
    """(chi-bar + chi-bar^2 / kappa_(d+1)) xi^T X xi: the first truncated mode bounds all of them."""

    def errors(self, terms: ErrorTerms) -> np.ndarray:
        """Upper estimate."""
        return terms.values * (1.0 + terms.values / terms.next_fixed) * terms.first


@dataclass(frozen=True)
class TwoTermEstimate:
    """chi-bar xi^T X xi + chi-bar^2 xi^T X2 xi: the error itself to first order, neither upper nor lower."""

    def errors(self, terms: ErrorTerms) -> np.ndarray:
        """Estimate."""
        return terms.values * terms.first + terms.values**2 * terms.second


@dataclass(frozen=True, eq=False)
class KnownEigenvalues:
    """Errors without an estimate: chi-bar_n / chi_n - 1 with the full body's eigenvalues, or lower bounds.

    values : (N,)   chi, rad^2/s^2, of the free elastic body
    """

    values: np.ndarray

    def __post_init__(self):
        object.__setattr__(self, "values", read_only(self.values))

    def errors(self, terms: ErrorTerms) -> np.ndarray:
        """Exact errors, or their upper bounds."""
        return terms.values / self.values[: terms.values.size] - 1.0
