"""Derivatives of a compiled machine's numbers, initial state and stops with respect to parameters.

Stops are the times at which steps must end. All these quantities are smooth and cost little compared to a
run, so they are differentiated by central differences of fourth order. Most of the quantities are polynomials
of low order, for which the differences are exact up to rounding. The motion is differentiated exactly
(`methods/floating/compiled/sensitivity_step`).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import numpy as np

from supple.arguments import check_instance
from supple.equations.configuration import Configuration
from supple.equations.coordinate_scales import position_scale
from supple.equations.machine_model import Model
from supple.equations.stops import Stops, stepping_instants
from supple.errors import ModelError, SuppleWarning
from supple.integrate import Kinematic, Run
from supple.machine import SampledController, System
from supple.methods.floating.compiled.batch_start import batch_start, form_of
from supple.methods.floating.compiled.sensitivity_march import MarchChanges
from supple.methods.floating.compiled.sensitivity_step import Carried, StateChange, state_change
from supple.methods.floating.compiled.state import State
from supple.sensitivity.differences import OFFSETS, central_difference, looks_smooth

Build = Callable[[Mapping[str, float]], System]
"""Function that returns the machine for parameter values by name"""

StopsOfRun = tuple[np.ndarray, np.ndarray]
"""Stops, and indices of the output times among them"""

_STEP = 3e-3
"""Step, relative to a parameter's size, with truncation and rounding errors below 1e-11 of a derivative."""
_COMPILED = {"rigid", "reduced"}
"""Kinds of bodies in compiled runs."""


class Neighbours(NamedTuple):
    """Machines at neighbouring values of one parameter."""

    systems: tuple[System, ...]
    """Machines with the value changed by `OFFSETS` times the step"""
    step: float


@dataclass(frozen=True, eq=False)
class ParameterChanges:
    """A machine prepared for a run, and derivatives of its numbers by p parameters."""

    system: System
    model: Model
    state: State
    stops: np.ndarray
    outputs: np.ndarray
    """Indices of the output times among the stops; the initial time is not a stop"""
    changes: MarchChanges
    neighbours: tuple[Neighbours, ...]


class _Numbers(NamedTuple):
    """All inputs of a run that depend on parameters."""

    model: Model
    start: StateChange
    stops: np.ndarray


def parameter_changes(
    build: Build, parameters: Mapping[str, float], sizes: Mapping[str, float], run: Run
) -> ParameterChanges:
    """The machine for some parameter values, with derivatives of its numbers by each parameter.

    sizes : magnitude of a large change of each parameter, by name

    Raises ModelError for a machine without derivatives, or a parameter that changes more than numbers or
    changes numbers with a jump or a kink.
    """
    system = _built(build, parameters)
    _check_marches(system, run)
    batch_start([system], run)  # issues the warnings of the machine
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SuppleWarning)
        neighbours = tuple(_neighbours(build, parameters, name, _STEP * sizes[name]) for name in parameters)
        every = [system, *(each for own in neighbours for each in own.systems)]
        starts = batch_start(every, run)
    begin, times = float(run.times[0]), run.times[1:]
    stops = [Stops(run.times, stepping_instants([own], run)).on_the_way(begin, times) for own in every]
    numbers = [
        _Numbers(model, state_change(state), own[0])
        for model, state, own in zip(starts.models, starts.states, stops, strict=True)
    ]
    columns, magnitudes = [], _magnitudes(numbers[0], run)
    for place, (name, own) in enumerate(zip(parameters, neighbours, strict=True)):
        around = slice(1 + place * len(OFFSETS), 1 + (place + 1) * len(OFFSETS))
        _check_same_program(name, numbers[0], numbers[around])
        _check_same_stops(name, stops[0], stops[around])
        columns.append(_derivatives(name, numbers[0], numbers[around], own.step, magnitudes))
    return ParameterChanges(
        system,
        starts.models[0],
        starts.states[0],
        *stops[0],
        changes=_together(numbers[0], columns),
        neighbours=neighbours,
    )


def _built(build: Build, parameters: Mapping[str, float]) -> System:
    system = build(parameters)
    check_instance("the result of the function of the parameters", system, System, "a System")
    return system


def _neighbours(build: Build, parameters: Mapping[str, float], name: str, step: float) -> Neighbours:
    values = (parameters[name] + offset * step for offset in OFFSETS)
    return Neighbours(tuple(_built(build, {**parameters, name: value}) for value in values), step)


def _check_marches(system: System, run: Run) -> None:
    """ModelError for machines and runs without support for derivatives."""
    kinds = {placed.body.kind for placed in system.bodies}
    if kinds - _COMPILED:
        raise ModelError(
            f"runs with {', '.join(sorted(kinds - _COMPILED))} bodies have no derivatives: reduce them, or "
            "use differences of `simulate`"
        )
    if isinstance(run.method, Kinematic):
        raise ModelError("a kinematic run has no derivatives: integrate it, or use differences of `simulate`")
    _ = run.second_order_method
    for each in system.controllers:
        if isinstance(each, SampledController):
            raise ModelError(
                f"controller '{each.name}' is sampled, a Python function without derivatives: write it as a "
                "Controller"
            )


def _check_same_program(name: str, middle: _Numbers, around: Sequence[_Numbers]) -> None:
    if any(form_of(own[:2]) != form_of(middle[:2]) for own in around):
        raise ModelError(
            f"parameter '{name}' changes more than numbers of the machine: bodies, joints, kinds of loads, "
            "sizes of tables and bases, redundant joint equations and user-defined functions must not change"
        )


def _check_same_stops(name: str, middle: StopsOfRun, around: Sequence[StopsOfRun]) -> None:
    if any(len(own[0]) != len(middle[0]) or np.any(own[1] != middle[1]) for own in around):
        raise ModelError(
            f"parameter '{name}' moves an instant at which a law of time changes across an output time, or "
            "out of the run: use another output step, or another value"
        )


def _magnitudes(numbers: _Numbers, run: Run) -> list[float]:
    """Smallest reference value for errors, by leaf: rounding errors, and the tolerance of an equilibrium.

    Inf for accelerations and multipliers, which thus always count as smooth: they follow from the other
    quantities, and at rest they are rounding errors.
    """
    model, carried = numbers.model, numbers.start.carried
    length, scale = float(model.length), float(np.max(position_scale(model), initial=1.0))
    of_start = StateChange(
        Carried(
            time=0.0,
            configuration=Configuration(length, 1.0, scale),
            velocity=max(length, 1.0) / run.duration,
            acceleration=np.inf,
            auxiliary=np.inf,
            control=jax.tree.map(lambda _: 0.0, carried.control),
        ),
        multipliers=np.inf,
    )
    return [*(0.0 for _ in jax.tree.leaves(model)), *jax.tree.leaves((of_start, run.duration))]


def _derivatives(
    name: str, middle: _Numbers, around: Sequence[_Numbers], step: float, magnitudes: Sequence[float]
) -> list[np.ndarray | None]:
    """Derivatives by leaf; None for a constant leaf; ModelError for a leaf that is not smooth."""
    found: list[np.ndarray | None] = []
    leaves = jax.tree_util.tree_leaves_with_path(middle)
    rows = zip(leaves, magnitudes, *map(jax.tree.leaves, around), strict=True)
    for (path, leaf), magnitude, *others in rows:
        values = [np.asarray(own) for own in others]
        if all(np.array_equal(own, leaf) for own in values):
            found.append(None)
            continue
        is_real = np.issubdtype(values[0].dtype, np.floating)
        # A leaf contains the limits of several elements; an infinite limit remains infinite.
        unlimited = np.isinf(leaf) & np.all([own == leaf for own in values], axis=0)
        middle_value, *values = (np.where(unlimited, 0.0, own) for own in (leaf, *values))
        if not is_real or not looks_smooth(middle_value, values, magnitude):
            raise ModelError(
                f"the machine is not smooth in parameter '{name}': with changes of {step:.3g} there "
                f"is a jump or a kink in {jax.tree_util.keystr(path)}. Reduce bodies outside the function, "
                "so that their bases are constant, or give a smaller change in `sizes`"
            )
        found.append(central_difference(values, step))
    return found


def _together(middle: _Numbers, columns: Sequence[Sequence[np.ndarray | None]]) -> MarchChanges:
    """Derivatives by all parameters, leaf by leaf."""

    def stacked(leaf: Any, own: Sequence[np.ndarray | None]) -> np.ndarray:
        return np.stack([np.zeros(np.shape(leaf)) if each is None else each for each in own])

    by_leaf = list(zip(*columns, strict=True))
    leaves = jax.tree.leaves(middle.model)
    of_model = [
        None if all(each is None for each in own) else stacked(leaf, own)
        for leaf, own in zip(leaves, by_leaf, strict=False)
    ]
    others, structure = jax.tree.flatten((middle.start, middle.stops))
    of_others = map(stacked, others, by_leaf[len(leaves) :])
    return MarchChanges(of_model, *jax.tree.unflatten(structure, of_others))
