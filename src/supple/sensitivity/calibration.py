"""Result of a fit to measurements: parameter values, uncertainty, and undetermined directions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.integrate import Solution
from supple.summary import Summarized, Summary

__all__ = ["Calibration", "Uncertainty", "uncertainty"]


_UNDETERMINED = 1e-7
"""Singular values of the scaled Jacobian up to this fraction of the largest count as zero."""
_INVOLVED = 1e-3
"""Component of an undetermined direction above which a parameter is part of it."""


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Uncertainty of fitted parameters, in linear approximation about the fit.

    covariance : (p, p); parameters that the data do not determine have variance inf and covariances nan
    undetermined : combinations of parameter changes that do not change the residuals; each contains, by name,
        the changes of its parameters relative to their sizes
    """

    covariance: FloatArray
    undetermined: tuple[Mapping[str, float], ...]

    @property
    def deviations(self) -> FloatArray:
        """Standard deviations (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> FloatArray:
        """Correlation matrix (p, p); nan for parameters that the data do not determine."""
        with np.errstate(invalid="ignore"):
            return self.covariance / np.outer(self.deviations, self.deviations)


def without_undetermined(jacobian: FloatArray) -> FloatArray:
    """A scaled Jacobian (n, p) with zero in place of singular values of directions that are undetermined."""
    left, singular, right = np.linalg.svd(jacobian, full_matrices=False)
    return (left * np.where(_determined(singular), singular, 0.0)) @ right


def _determined(singular: FloatArray) -> NDArray[np.bool_]:
    return singular > _UNDETERMINED * np.max(singular, initial=0.0)


def uncertainty(jacobian: FloatArray, sizes: Mapping[str, float], variance: float) -> Uncertainty:
    """Uncertainty with the covariance `s^2 (J^T J)^-1`; J (n, p) is the Jacobian of the weighted residuals.

    sizes : sizes of the parameters by name, which scale the Jacobian
    variance : s^2, 1 if the deviations are known
    Source: [BatesWatts1988], section 2.1.
    """
    scale = np.array(list(sizes.values()))
    _, singular, right = np.linalg.svd(jacobian * scale, full_matrices=False)
    determined = _determined(singular)
    inverse = np.where(determined, 1 / np.where(determined, singular, 1.0), 0.0)
    half = (right.T * inverse) * scale[:, None]
    covariance = variance * half @ half.T
    undetermined = right[~determined]
    involved = np.any(abs(undetermined) > _INVOLVED, axis=0)
    covariance[involved] = covariance[:, involved] = np.nan
    covariance[involved, involved] = np.inf
    return Uncertainty(
        covariance,
        tuple(
            {name: float(own) for name, own in zip(sizes, row, strict=True) if abs(own) > _INVOLVED}
            for row in undetermined
        ),
    )


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Summarized):
    """Parameters of a machine fitted to measurements.

    parameters : fitted values by name
    residuals : for each measurement, in the given order: computed minus measured values (k,), in the units of
        the measurement
    misfit : weighted sum of squares of the residuals, divided by their number minus the number of parameters
        (at least 1): near 1 if the deviations are known, otherwise an estimate of the squared deviation
    jacobian : (n, p) of the weighted residuals
    solution : the run of the fitted machine
    runs : number of runs, with and without derivatives
    at_bounds : names of parameters at a bound, for which the standard deviations are not valid
    """

    parameters: Mapping[str, float]
    uncertainty: Uncertainty
    residuals: tuple[FloatArray, ...]
    misfit: float
    jacobian: FloatArray
    solution: Solution
    runs: int
    at_bounds: tuple[str, ...]

    def summary(self) -> Summary:
        """Each parameter with its standard deviation."""
        rows = [
            (name, f"{value:.6g} +- {own:.2g}" + (", at a bound" if name in self.at_bounds else ""))
            for (name, value), own in zip(self.parameters.items(), self.uncertainty.deviations, strict=True)
        ]
        rows += [
            ("not determined", " with ".join(f"{100 * part:+.3g} % {name}" for name, part in each.items()))
            for each in self.uncertainty.undetermined
        ]
        return Summary(f"Calibration of {len(self.parameters)} parameters, misfit {self.misfit:.3g}", rows)
