"""Derivatives of run results with respect to parameters of the machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter
from types import MappingProxyType

import jax
import numpy as np

from supple.algebra.jax_settings import before_compiled_code
from supple.arguments import check_number, checked_arguments
from supple.arrays import FloatArray
from supple.equations.checks.output_rate import report_output_rate
from supple.equations.checks.step_resolution import report_step_length
from supple.equations.checks.validity import watch
from supple.equations.floating_solution import failure_message
from supple.errors import ArgumentError, ConvergenceError, ModelError, did_you_mean
from supple.integrate import Run, Solution
from supple.methods.floating.compiled.engine import as_solution, controls, march_statistics
from supple.methods.floating.compiled.sensitivity_march import march_with_changes
from supple.methods.floating.compiled.sensitivity_step import StateChange
from supple.methods.floating.compiled.state import State
from supple.progress import with_progress_bar
from supple.sensitivity.derivative_reader import DerivativeReader, read
from supple.sensitivity.observable import Observables
from supple.sensitivity.parameter_changes import Build, ParameterChanges, parameter_changes
from supple.simulation.watched_run import check_laws_cover, warn_of_unseen_laws
from supple.summary import Summarized, Summary, listed

__all__ = ["Sensitivities", "sensitivities"]


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities(Summarized):
    """Results of a run, and their derivatives with respect to parameters of the machine.

    parameters : values by name
    solution : the run itself
    values : values by observable, each in its own shape
    derivatives : by observable, then by parameter, of the same shape as the values
    """

    parameters: Mapping[str, float]
    solution: Solution
    values: Mapping[str, FloatArray]
    derivatives: Mapping[str, Mapping[str, FloatArray]]

    def summary(self) -> Summary:
        """By observable: its largest relative change per relative change of each parameter."""
        rows = []
        for name, values in self.values.items():
            largest = np.max(np.abs(values), initial=0.0) or 1.0
            parts = (
                f"{parameter} {abs(self.parameters[parameter]) * np.max(np.abs(own)) / largest:.3g}"
                for parameter, own in self.derivatives[name].items()
            )
            rows.append((name, "relative change by " + listed(parts)))
        return Summary(f"Sensitivities of {len(self.values)} to {len(self.parameters)} parameters", rows)


@checked_arguments
@with_progress_bar("derivatives of a run")
def sensitivities(
    build: Build,
    parameters: Mapping[str, float],
    run: Run,
    observables: Observables,
    *,
    sizes: Mapping[str, float] = MappingProxyType({}),
) -> Sensitivities:
    """Derivatives of sensors and statistics of a run with respect to parameters of its machine.

    The time-discrete motion is differentiated: the number of steps is constant, and the step lengths change
    with the times of kinks in laws. For any motion, the relative error of the derivatives is about 1e-9 plus
    the tolerance of the run. The derivatives include the effects of parameters on initial values, and on an
    equilibrium or an assembly within `build`. Forward mode: the cost grows with the number of parameters, not
    of observables.

    Parameters
    ----------
    build : callable        returns the System for a mapping of values by name; it is called once, and four
        times per parameter, with changes of 0.3 and 0.6 % of the parameter's size to either side
    parameters : values by name
    run : Run               as for `simulate`, with fixed or adaptive steps
    observables : sensors, `Statistic` of them, or any object with a name and `values(system, solution)`;
        if some refer to parts of the System, such as a `SpringForceSensor`: a function of the System that
        returns all observables
    sizes : magnitude of a large change of each parameter, by name; by default the magnitude of its value, so
        that a parameter with value 0 needs a size

    Returns
    -------
    Sensitivities

    Raises
    ------
    ModelError          full, intrinsic or explicit bodies, a sampled controller, a kinematic run; a parameter
                        that changes more than numbers, or with a jump or a kink; an observable that is not
                        smooth
    ArgumentError       a parameter that is not finite, or is 0 without a size
    ConvergenceError    a step, or a derivative, that does not converge
    """
    before_compiled_code()
    machine = parameter_changes(build, parameters, sizes_of(parameters, sizes), run)
    check_laws_cover(machine.system, run.times[0], run.times[-1])
    warn_of_unseen_laws(machine.system, run)
    states, changes, solution = _marched(machine, run)
    limits = watch(machine.system, run.validity)
    limits.report(limits.observe({}, solution))
    report_step_length(solution.statistics, run)
    report_output_rate(machine.system, run, solution)
    reader = DerivativeReader(machine, states, changes, observables)
    values = read(observables, machine.system, solution)
    by_parameter = {name: reader.derivatives(name, number, values) for number, name in enumerate(parameters)}
    derivatives = {each: {name: own[each] for name, own in by_parameter.items()} for each in values}
    return Sensitivities(dict(parameters), solution, values, derivatives)


def sizes_of(parameters: Mapping[str, float], sizes: Mapping[str, float]) -> dict[str, float]:
    """The size of each parameter, by name: the magnitude of a large change.

    Raises ModelError without parameters or for an unknown name, ArgumentError for a value that is not finite
    or a size that is not finite and positive.
    """
    if not parameters:
        raise ModelError("give at least one parameter, with its value")
    for name in sizes:
        if name not in parameters:
            raise ModelError(f"sizes: '{name}' is not a parameter{did_you_mean(name, parameters)}")
    found = {}
    for name, value in parameters.items():
        check_number(f"parameter '{name}'", value)
        found[name] = float(sizes.get(name, abs(value)))
        if not (np.isfinite(value) and np.isfinite(found[name]) and found[name] > 0):
            raise ArgumentError(
                f"parameter '{name}' is {value:g}: give a finite value, and for a value of 0 a "
                f"large change, sizes={{'{name}': ..}}"
            )
    return found


def _marched(machine: ParameterChanges, run: Run) -> tuple[State, StateChange, Solution]:
    """States and derivatives at the output times, and the solution; ConvergenceError if a step fails."""
    began = perf_counter()
    found = march_with_changes(
        machine.model, controls(run), machine.state, machine.stops, machine.changes, run.n_steps
    )
    last = found.last
    if last.failed:
        raise ConvergenceError(failure_message(machine.system, run, last.time, last.relative_residual))
    states, changes = jax.tree.map(
        lambda first, rows: np.concatenate([np.asarray(first)[None], rows[machine.outputs]]),
        (machine.state._replace(kept=None), machine.changes.start),
        (found.states, found.changes),
    )
    _check_converged(states, changes)
    statistics = march_statistics(last, perf_counter() - began)
    return states, changes, as_solution(machine.system, machine.model, states, statistics)


def _check_converged(states: State, changes: StateChange) -> None:
    finite = [np.isfinite(leaf).reshape(len(leaf), -1).all(axis=1) for leaf in jax.tree.leaves(changes)]
    solved = np.all(finite, axis=0)
    if not solved.all():
        raise ConvergenceError(
            f"the derivatives do not converge at t = {states.time[np.argmin(solved)]:.6g}: there are none "
            "where joints are singular or the derivative of a law is infinite; shorten the run or the steps"
        )
