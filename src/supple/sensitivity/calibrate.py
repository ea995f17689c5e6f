"""Fit of machine parameters to measured motion."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

import numpy as np
import scipy
from numpy.typing import NDArray

from supple.algebra.jax_settings import before_compiled_code
from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.errors import (
    ConvergenceError,
    IdentifiabilityWarning,
    ModelError,
    SuppleError,
    SuppleWarning,
    did_you_mean,
)
from supple.integrate import Run, Solution
from supple.machine import System
from supple.progress import with_progress_bar
from supple.sensitivity.calibration import Calibration, uncertainty, without_undetermined
from supple.sensitivity.derivative_reader import read
from supple.sensitivity.measurement import Measurement
from supple.sensitivity.observable import Observables
from supple.sensitivity.parameter_changes import Build
from supple.sensitivity.sensitivities import sensitivities, sizes_of
from supple.simulation.watched_run import watched_run

__all__ = ["calibrate"]


_MOST = 100
"""Largest number of residual evaluations of a fit; runs for Jacobians are not counted."""
_KEPT = 1e-7
"""Weight of the deviation from the initial values, relative to the largest singular value of the scaled
Jacobian."""
_NEAR = 1e-3
"""A fit is rejected if one more linearised step changes a parameter by more than this fraction of its size,
and reduces the sum of squares by more than this fraction."""


@checked_arguments
@with_progress_bar("fitting to measurements")
def calibrate(
    build: Build,
    parameters: Mapping[str, float],
    run: Run,
    observables: Observables,
    measurements: Sequence[Measurement],
    *,
    bounds: Mapping[str, tuple[float, float]] = MappingProxyType({}),
    sizes: Mapping[str, float] = MappingProxyType({}),
) -> Calibration:
    """Parameters of a machine fitted to measurements by least squares.

        minimise  sum_i ((computed_i(p) - measured_i) / deviation_i)^2

    by a trust-region method with exact Jacobians (`sensitivities`). The method finds a local minimum near the
    initial values. This minimum may be wrong if the first computed motion is out of phase with the measured
    motion by half a period or more. Parameters that the measurements do not determine keep their initial
    values.

    Parameters
    ----------
    build, run, observables, sizes : as for `sensitivities`
    parameters : initial values, by name
    measurements : measured values of channels of the observables
    bounds : lowest and highest value of parameters, by name; by default none

    Returns
    -------
    Calibration

    Raises
    ------
    ModelError          as for `sensitivities`; fewer measured values than parameters, a measurement without
                        deviation among several, an initial value outside its bounds
    ArgumentError       as for `sensitivities`
    ConvergenceError    a fit that does not converge, or a run with the initial values that does not converge

    Warns
    -----
    IdentifiabilityWarning      parameters that the measurements do not determine
    """
    before_compiled_code()
    start, scale = dict(parameters), sizes_of(parameters, sizes)
    fit = _Fit(build, run, observables, _checked(measurements, len(start)), scale, frozenset(sizes))
    unit = np.array(list(scale.values()))
    begin = np.array(list(start.values())) / unit
    low, high = (side / unit for side in _bounds(start, bounds))

    def jacobian(z: FloatArray) -> FloatArray:
        return without_undetermined(fit.jacobian(z * unit) * unit)

    # Small enough to affect only parameters that the data do not determine, which keep their initial values.
    weight = _KEPT * np.linalg.norm(jacobian(begin), 2)
    found = scipy.optimize.least_squares(
        lambda z: np.concatenate([fit.residuals(z * unit), weight * (z - begin)]),
        begin,
        jac=lambda z: np.vstack([jacobian(z), weight * np.eye(len(z))]),
        bounds=(low, high),
        max_nfev=_MOST,
    )
    held = np.isclose(found.x, low) | np.isclose(found.x, high)
    if not found.success or _could_improve(jacobian(found.x)[:, ~held], fit.residuals(found.x * unit)):
        raise ConvergenceError(
            f"the fit does not converge in {fit.runs} runs (sum of squares {2 * found.cost:.3g})"
            + (f"; some of them failed: {fit.broken}" if fit.broken else "")
            + ". Start nearer to the solution, give bounds, or remove parameters with equal effects"
        )
    return fit.result(found.x * unit, held)


def _could_improve(jacobian: FloatArray, residuals: FloatArray) -> bool:
    """Whether the step to the minimum of the linearised residuals, and its gain, both exceed `_NEAR`."""
    step = np.linalg.lstsq(jacobian, residuals)[0]
    gained = jacobian @ step
    return bool(np.max(np.abs(step), initial=0.0) > _NEAR and gained @ gained > _NEAR * residuals @ residuals)


def _checked(measurements: Sequence[Measurement], n_parameters: int) -> tuple[Measurement, ...]:
    number = sum(int(each.known.sum()) for each in measurements)
    if number < n_parameters:
        raise ModelError(f"{n_parameters} parameters need as many measured values, and there are {number}")
    without = [each.observable for each in measurements if each.deviation is None]
    if without and len(measurements) > 1:
        raise ModelError(
            f"measurements of {', '.join(without)} have no deviation, which is needed to weight several "
            "measurements: give each a deviation"
        )
    return tuple(measurements)


def _bounds(
    start: Mapping[str, float], bounds: Mapping[str, tuple[float, float]]
) -> tuple[FloatArray, FloatArray]:
    for name, (low, high) in bounds.items():
        if name not in start:
            raise ModelError(f"bounds: '{name}' is no parameter{did_you_mean(name, start)}")
        if not low < high or not low <= start[name] <= high:
            raise ModelError(
                f"bounds of '{name}': {low:g} to {high:g} do not contain the initial value, {start[name]:g}"
            )
    low, high = (
        np.array([bounds.get(name, (-np.inf, np.inf))[side] for name in start], dtype=float)
        for side in (0, 1)
    )
    return low, high


@dataclass
class _Fit:
    """Residuals divided by deviations, and their Jacobian, as functions of the parameters (p,)."""

    build: Build
    run: Run
    observables: Observables
    measurements: tuple[Measurement, ...]
    sizes: Mapping[str, float]
    given: frozenset[str]
    """Names of parameters with a given size; any other size is reduced to the current value if smaller"""
    runs: int = field(default=0)
    broken: str = ""
    """Cause of the last failed run"""
    _last: tuple[FloatArray, tuple[FloatArray, FloatArray, Solution]] | None = None

    def _named(self, values: FloatArray) -> dict[str, float]:
        return {name: float(value) for name, value in zip(self.sizes, values, strict=True)}

    @cached_property
    def _measured(self) -> FloatArray:
        """Measured values (n,), divided by the deviations."""
        return np.concatenate([own.weights * np.asarray(own.values)[own.known] for own in self.measurements])

    def _columns(self, system: System) -> list[int]:
        return [each.column(system, self.observables) for each in self.measurements]

    def _computed(
        self, solution: Solution, values: Mapping[str, FloatArray], columns: Sequence[int]
    ) -> FloatArray:
        """Values (n,) of observables, or their derivatives, at the measured times, over the deviations."""
        times, pairs = np.asarray(solution.times), zip(self.measurements, columns, strict=True)
        return np.concatenate(
            [own.weights * own.at_times(times, values[own.observable], column) for own, column in pairs]
        )

    def residuals(self, values: FloatArray) -> FloatArray:
        """Weighted residuals (n,); inf, to shrink the trust region, without a machine or run of the values.

        Example: a step of the search to a negative mass. The initial values have been used before.
        """
        # The first step is often as long as its parameter. At zero no change of its own size would be known.
        if any(not value and name not in self.given for name, value in self._named(values).items()):
            return np.full(len(self._measured), np.inf)
        self.runs += 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SuppleWarning)  # trial values only
            try:
                system = self.build(self._named(values))
                solution = watched_run(system, self.run)
            except SuppleError as error:
                self.broken = str(error)
                return np.full(len(self._measured), np.inf)
        columns = self._columns(system)
        return self._computed(solution, read(self.observables, system, solution), columns) - self._measured

    def jacobian(self, values: FloatArray) -> FloatArray:
        """Jacobian (n, p) of the weighted residuals."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SuppleWarning)
            return self._jacobian(values)[0]

    def _jacobian(self, values: FloatArray) -> tuple[FloatArray, FloatArray, Solution]:
        """Jacobian with the residuals (n,) and the run; the last result is cached."""
        if self._last is not None and np.array_equal(self._last[0], values):
            return self._last[1]
        self.runs += 1
        named = self._named(values)
        sizes = {
            name: size if name in self.given else min(size, abs(named[name]))
            for name, size in self.sizes.items()
        }
        found = sensitivities(self.build, named, self.run, self.observables, sizes=sizes)
        columns = self._columns(self.build(named))
        by_parameter = [
            self._computed(found.solution, {of: own[name] for of, own in found.derivatives.items()}, columns)
            for name in self.sizes
        ]
        residuals = self._computed(found.solution, found.values, columns) - self._measured
        self._last = values.copy(), (np.column_stack(by_parameter), residuals, found.solution)
        return self._last[1]

    def result(self, values: FloatArray, at_bounds: NDArray[np.bool_]) -> Calibration:
        """The result of the fit; warns IdentifiabilityWarning."""
        jacobian, residuals, solution = self._jacobian(values)
        degrees = max(len(residuals) - len(values), 1)
        misfit = float(residuals @ residuals) / degrees
        are_known = all(each.deviation is not None for each in self.measurements)
        sure = uncertainty(jacobian, self.sizes, 1.0 if are_known else misfit)
        if sure.undetermined:
            names = sorted({name for each in sure.undetermined for name in each})
            warnings.warn(
                f"the measurements do not determine {', '.join(names)}: {len(sure.undetermined)} of their "
                "combinations do not affect the measured values. Fix some parameters at known values, or "
                "measure what they affect",
                IdentifiabilityWarning,
                stacklevel=5,
            )
        parts = np.split(residuals, np.cumsum([each.known.sum() for each in self.measurements])[:-1])
        return Calibration(
            parameters=self._named(values),
            uncertainty=sure,
            residuals=tuple(part / each.weights for part, each in zip(parts, self.measurements, strict=True)),
            misfit=misfit,
            jacobian=jacobian,
            solution=solution,
            runs=self.runs,
            at_bounds=tuple(name for name, own in zip(self.sizes, at_bounds, strict=True) if own),
        )
