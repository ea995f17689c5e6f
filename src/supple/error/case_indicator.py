"""Indicator of the reduction error in many runs of one machine, from the error equation in few columns.

The estimate for a single run has about a hundred columns, from factorisations for this run alone. Here about
thirty columns serve all runs of a group: the columns of their bases, the motion outside the bases found by
estimates of representative runs, and the lowest modes. The elasticity in these columns is one polynomial
(`ElasticPolynomial`). Each run therefore needs one additional linear march only, mapped over the cases in one
compiled program.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from supple.arrays import FloatArray
from supple.blas_threads import one_blas_thread
from supple.body import Damping, FullBody
from supple.body.damping import damping_matrix
from supple.error.equation import (
    AssessedBody,
    ErrorEquation,
    ErrorHistory,
    ErrorSpace,
    MotionColumns,
    RunColumns,
    modes_in_frame,
    motion_columns,
    small_space,
)
from supple.error.equation.elastic_polynomial import ElasticPolynomial, works_on_themselves
from supple.error.equation.error_batch import first_together
from supple.error.equation.error_model import body_of_columns, padded_size
from supple.error.error_estimate import DIVERGED, modal_damping, reduced_form
from supple.error.residual_correction import active_constraints
from supple.integrate import FloatingMotion, Run, Solution
from supple.machine import System
from supple.methods.floating.compiled.every_step import every_step
from supple.quantities.quantity_of_interest import largest_displacement
from supple.reduction import ReducedBody, ReductionBasis
from supple.reduction.tensors import strain_products

__all__ = ["ErrorIndicator", "IndicatorBody", "case_indicators", "indicator_body", "size_of_motion"]


MORE = 12
"""Smallest number of error columns besides those of the motion; at most half of them are for the given
fields. In two runs of a blade, the ratio of estimate to indicator was 1.8 and 1.4 with 11 such columns, and
1.2 and 1.1 with 19."""
SLOWNESS = 1e2
"""Length of a first step that brings all bodies to equilibrium, times their lowest frequency in rad/s."""
AT_ONCE = 16
"""Number of runs marched together; 5000 steps in 14 coordinates need 0.2 GB."""
MOST_INSTANTS = 1250
"""Largest number of steps of the error's march in a run. Full estimates use all steps; the ratio of estimate
to indicator (effectivity) corrects the difference."""
MANY_STEPS = np.inf
"""Number of steps assumed for `padded_size`, for little padding: each column costs time in every run of a
sweep, and all runs share one program."""
PROVEN = 1e-2
"""Allowed error of tangents along a run, as in `ErrorEquation`. The indicators of 16 runs of a blade differ
by less than 0.5 % from those with a limit thirty times as small, and 15 matrices suffice instead of 32."""
FEWEST_SAMPLES = 8
"""`fewest_samples` of `ErrorEquation`: little padding, as thousands of runs share a compiled program."""
LOOKED = 200
"""Number of times at which the size of a motion is evaluated."""


class ErrorIndicator(NamedTuple):
    """Indicator of a body in a run: largest RMS error of its nodes, and its largest displacement.

    error : infinite where the run stopped early, or where the error exceeds ten times the displacement
    """

    error: float
    size: float


@dataclass(frozen=True, eq=False)
class IndicatorBody:
    """A body that many runs share, with the columns of their motion and of their error.

    full : the full body as in any of the runs, except for its damping
    columns : columns of the motion
    space : columns of the error, which contain those of the motion
    """

    full: FullBody
    columns: MotionColumns
    space: ErrorSpace
    _damped: dict[str, AssessedBody] = field(default_factory=dict)

    def along(self, motion: FloatingMotion, damping: Damping | None, reduced: ReducedBody) -> AssessedBody:
        """The body in one run, with the damping of that run."""
        run = self.columns.along(motion)
        key = repr(damping)
        if key not in self._damped:
            self._damped[key] = self._with_damping(run, damping, reduced)
        return self._damped[key].along(run)

    def _with_damping(self, run: RunColumns, damping: Damping | None, reduced: ReducedBody) -> AssessedBody:
        own = damping or modal_damping(reduced)
        full = replace(self.full, damping=damping)
        made = AssessedBody(full, run, self.space, own, self._polynomial)
        k, undamped = self.space.size, self._undamped
        matrix = damping_matrix(own, full.body, self.space.vectors, undamped.stiffness[:k, :k])
        padded = np.pad(matrix, (0, undamped.r - k))
        # The inertia and the Gram matrix of the nodes do not depend on the damping.
        object.__setattr__(made, "columns", replace(undamped, damping=padded))
        for other in list(self._damped.values())[:1]:
            object.__setattr__(made, "squares", other.squares)
        return made

    @cached_property
    def _undamped(self) -> ReducedBody:
        return body_of_columns(self.full.body, self.full.frame, self.space.vectors, None, MANY_STEPS)

    @cached_property
    def _polynomial(self) -> ElasticPolynomial | None:
        body = self.full.body
        if body.is_linear:
            return None
        works = works_on_themselves(strain_products(body, self.space.vectors))
        return ElasticPolynomial(works, self.space.n_motion)


def indicator_body(
    full: FullBody, reduced: ReducedBody, basis: ReductionBasis, coordinates: FloatArray, fields: FloatArray
) -> IndicatorBody:
    """The columns of a body that many runs share.

    coordinates : (t, r)    of some of the runs, to sample the motion z that condensed tensors add
    fields : (n, m)         motion outside the basis, found by estimates of some of the runs
    """
    columns = motion_columns(full.body, reduced, basis, coordinates)
    moving = columns.vectors.shape[1]
    number = padded_size(moving + MORE, MANY_STEPS) - moving
    space = small_space(modes_in_frame(full.body, full.frame, number), columns.vectors, fields, number)
    return IndicatorBody(full, columns, space)


@one_blas_thread()
def case_indicators(
    cases: Sequence[System],
    run: Run,
    solutions: Sequence[Solution],
    bodies: Mapping[str, IndicatorBody],
    dampings: Sequence[Mapping[str, Damping | None]],
    *,
    at_rest: bool,
) -> list[dict[str, ErrorIndicator]]:
    """Indicators of the reduction error of each run, by body, to first order and in few columns.

    Parameters
    ----------
    cases, run, solutions : as simulated
    bodies : bodies whose bases are assessed, by name
    dampings : damping of these bodies in each case
    at_rest : whether the runs start at rest, in equilibrium

    The machine must have no intrinsic bodies or controllers (`check_linearised`).
    """
    found = [
        {
            name: ErrorIndicator(
                np.inf, size_of_motion(reduced_form(system, name), solution.motion(name, FloatingMotion))
            )
            for name in bodies
        }
        for system, solution in zip(cases, solutions, strict=True)
    ]
    if not bodies:
        return found
    whole = [number for number, solution in enumerate(solutions) if solution.stopped is None]
    for start in range(0, len(whole), AT_ONCE):
        rows = whole[start : start + AT_ONCE]
        steps = [_seen_instants(cases[i], run, solutions[i]) for i in rows]
        active = active_constraints(cases[rows[0]], solutions[rows[0]])
        equations = [
            ErrorEquation(
                cases[i],
                {
                    name: body.along(
                        each.motion(name, FloatingMotion), dampings[i][name], reduced_form(cases[i], name)
                    )
                    for name, body in bodies.items()
                },
                run.second_order_method.coefficients,
                each,
                active,
                {},
                proven=PROVEN,
                fewest_samples=FEWEST_SAMPLES,
            )
            for i, each in zip(rows, steps, strict=True)
        ]
        rest = _long(cases[rows[0]], bodies) if at_rest else 0.0
        # In one compiled march all runs have the same number of steps.
        lengths = [len(each.times) for each in steps]
        for length in sorted(set(lengths)):
            own = [place for place, each in enumerate(lengths) if each == length]
            at_once = 1 << (len(own) - 1).bit_length()  # powers of two: few sizes to compile
            states = first_together([equations[place] for place in own], rest=rest, at_once=at_once)
            for place, state in zip(own, states, strict=True):
                histories = equations[place].histories(state)
                for name, history in histories.items():
                    case = found[rows[place]]
                    case[name] = _bounded(history, case[name].size)
    return found


def size_of_motion(body: ReducedBody, motion: FloatingMotion) -> float:
    """Largest displacement of a node along a run, relative to the first interface."""
    stride = max(1, len(motion.coordinates) // LOOKED)
    return largest_displacement(body, motion.coordinates[::stride])


def _seen_instants(system: System, run: Run, solution: Solution) -> Solution:
    """The run at the steps of its error: every step, or at most `MOST_INSTANTS` times of a long run."""
    seen = solution if len(solution.times) > MOST_INSTANTS else every_step(system, run, solution).solution
    return seen.at(slice(None, None, -(-(len(seen.times) - 1) // MOST_INSTANTS)))


def _bounded(history: ErrorHistory, size: float) -> ErrorIndicator:
    largest = float(history.rms.max())
    return ErrorIndicator(largest if largest <= DIVERGED * size else np.inf, size)


def _long(system: System, bodies: Mapping[str, IndicatorBody]) -> float:
    """A time much longer than the vibration periods of all bodies."""
    return SLOWNESS / min(reduced_form(system, name).lowest_frequency() for name in bodies)
