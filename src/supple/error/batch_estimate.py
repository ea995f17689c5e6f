"""Errors caused by the bases in many runs of one machine; their error equations are solved together.

The runs share their bodies and bases. They therefore share the expensive parts: one error space, built from
corrections at sample times of all runs, and the matrices of the deformed bodies. Each run has its own
residual and its own march; the compiled program is mapped over the runs. A run whose error is not small is
assessed again separately.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from supple.blas_threads import one_blas_thread
from supple.body.full_body import FullBody
from supple.error.basis_error import ENRICH, FIRST_ORDER, BasisError
from supple.error.basis_part import in_full, stated_of
from supple.error.check_run import check_run
from supple.error.converged_error import converged, deformed_rows, is_small
from supple.error.equation import (
    AssessedBody,
    ErrorEquation,
    error_space,
    modes_in_frame,
    run_columns,
    second_corrections,
)
from supple.error.equation.error_batch import first_together
from supple.error.equation.linearised_march import ErrorState
from supple.error.error_estimate import (
    ErrorEstimator,
    body_error,
    check_linearised,
    is_smooth,
    modal_damping,
    reduced_form,
    unknown_error,
)
from supple.error.error_study import ErrorStudy, statements
from supple.error.residual_correction import active_constraints, system_corrections
from supple.error.sample_times import stratified_samples
from supple.error.stopping import locking_loss
from supple.errors import ModelError
from supple.integrate import ErrorPart, FloatingMotion, Run, Solution
from supple.machine import System
from supple.methods.floating.compiled.every_step import every_step
from supple.quantities.quantity_of_interest import WholeBody
from supple.reduction import ReducedBody, ReductionBasis
from supple.simulation.stored_basis import stored_bases

__all__ = ["estimate_batch_errors", "state_batch_errors"]

LOOKED, FRESH = 34, 16
"""Numbers of sample times of all runs together: for the error space, and to measure the part outside it."""


@one_blas_thread()
def state_batch_errors(
    cases: Sequence[System], run: Run, solutions: Sequence[Solution], fulls: Mapping[str, FullBody]
) -> tuple[Solution, ...]:
    """The solutions of a batch with their reduction errors and the floor of the integration error.

    Parameters as for `estimate_batch_errors`. Errors of the time step and of the model need single runs
    (`state_errors`).
    """
    bases = stored_bases(cases[0], fulls)
    quantities = [WholeBody(name) for name in bases]
    study = ErrorStudy(basis=False, integration=False, model=False)
    stated = []
    for system, solution, own in zip(
        cases, solutions, estimate_batch_errors(cases, run, solutions, fulls), strict=True
    ):
        bodies = own.bodies.values()
        if solution.stopped is not None:
            parts = {}
        # The first condition holds for a body that locks.
        elif any(each.is_doubtful(np.inf) or not each.is_converged for each in bodies):
            asked = stated_of(system, bases, quantities)
            parts, _ = check_run(system, run, solution, fulls, bases, asked)
        else:
            parts = {
                name: ErrorPart(each.estimate, "the error equation", ENRICH)
                for name, each in own.bodies.items()
            }
        stated.append(
            solution.with_errors(
                statements(system, run, solution, study, fulls, bases, parts, quantities=quantities)
            )
        )
    return tuple(stated)


def estimate_batch_errors(
    cases: Sequence[System], run: Run, solutions: Sequence[Solution], fulls: Mapping[str, FullBody]
) -> tuple[BasisError, ...]:
    """Errors caused by the bases of reduced bodies in each run of a batch, as `estimate_error` for one run.

    About sixty factorisations serve all runs. Runs with equal numbers of steps are marched together, up to 64
    in one compiled call.

    Parameters
    ----------
    cases, run, solutions : as simulated, all with the same bodies
    fulls : the bodies to assess, with all their coordinates, by name

    Returns
    -------
    BasisError      of every run; infinite where the run stopped early or the equation has no finite solution

    Raises
    ------
    ModelError      bodies that differ between cases or from the full ones given; no body to assess; a machine
                    with controllers or intrinsic bodies
    """
    check_linearised(cases[0])
    bases = stored_bases(cases[0], fulls)
    if not bases:
        raise ModelError("batch estimate: give the bodies to estimate in full; none of them is in the cases")
    for system in cases[1:]:
        for one, other in zip(cases[0].bodies, system.bodies, strict=True):
            if one.body is not other.body:
                raise ModelError(
                    f"batch estimate: body '{one.body.name}' is not the same object in all cases: build the "
                    "body once and place it in every case"
                )
    whole = [number for number, solution in enumerate(solutions) if solution.stopped is None]
    found = {
        number: BasisError(dict.fromkeys(bases, unknown_error(solution)))
        for number, solution in enumerate(solutions)
        if number not in whole
    }
    if whole:
        own = _Batch([cases[i] for i in whole], run, [solutions[i] for i in whole], fulls, bases)
        found |= dict(zip(whole, own.errors(), strict=True))
    return tuple(found[number] for number in range(len(solutions)))


class _Batch:
    """Runs of a batch that reached their last output time."""

    def __init__(
        self,
        cases: Sequence[System],
        run: Run,
        solutions: Sequence[Solution],
        fulls: Mapping[str, FullBody],
        bases: Mapping[str, ReductionBasis],
    ) -> None:
        self.cases, self.run, self.solutions, self.bases = cases, run, solutions, bases
        self.fulls = {name: fulls[name] for name in bases}
        self.steps = [
            every_step(system, run, solution) for system, solution in zip(cases, solutions, strict=True)
        ]
        self.estimators = [ErrorEstimator(in_full(system, fulls, bases), run) for system in cases]

    def errors(self) -> list[BasisError]:
        """Reduction errors of every run."""
        looked, fresh = self._corrections(LOOKED, 0), self._corrections(FRESH, 1)
        bodies = {name: self._assessed(name, looked[name]) for name in self.bases}
        equations = [self._equation(number, bodies) for number in range(len(self.cases))]
        # In one compiled march all runs have the same number of steps.
        found = {}
        for n_steps in {len(each.solution.times) for each in self.steps}:
            rows = [i for i, each in enumerate(self.steps) if len(each.solution.times) == n_steps]
            found |= dict(zip(rows, first_together([equations[i] for i in rows]), strict=True))
        return [
            self._error(number, equations[number], found[number], fresh) for number in range(len(self.cases))
        ]

    def _corrections(self, number: int, seed: int) -> dict[str, np.ndarray]:
        """Motion outside the bases at up to `number` sample times of all runs together, (n, m) by body."""
        n_cases, lengths = len(self.cases), [len(each.solution.times) for each in self.steps]
        # The sample times are distributed over the runs; with many runs some have none.
        chosen = (np.arange(number) * n_cases) // number if n_cases > 1 else np.zeros(number, dtype=int)
        fields: dict[str, list[np.ndarray]] = {name: [] for name in self.bases}
        for case in np.unique(chosen):
            share = int(np.sum(chosen == case))
            missed = system_corrections(
                self.cases[case],
                tuple(self.fulls.values()),
                self.bases,
                self.steps[case].solution,
                stratified_samples(lengths[case], min(share, lengths[case] - 1), seed=seed + 2 * int(case)),
            )
            for name, own in missed.items():
                fields[name].append(own.deformation)
        return {name: np.hstack(each) for name, each in fields.items()}

    def _body(self, name: str) -> ReducedBody:
        """The reduced body, which is the same in all runs."""
        return reduced_form(self.cases[0], name)

    def _assessed(self, name: str, corrections: np.ndarray) -> AssessedBody:
        """The assessed body, with its motion in all runs one after the other."""
        full, body = self.fulls[name], self._body(name)
        motions = [each.solution.bodies[name] for each in self.steps]
        together = FloatingMotion(
            **{
                item: np.concatenate([motion.arrays()[item] for motion in motions])
                for item in motions[0].arrays()
            }
        )
        motion = run_columns(full.body, body, self.bases[name], together)
        rows = deformed_rows(len(motion.coordinates))[1:]
        deformed = motion.vectors @ motion.coordinates[rows].T
        space = error_space(modes_in_frame(full.body, full.frame), motion.vectors, corrections, deformed)
        return AssessedBody(full, motion, space, full.damping or modal_damping(body))

    def _equation(self, number: int, bodies: Mapping[str, AssessedBody]) -> ErrorEquation:
        ends = np.cumsum([0, *(len(each.solution.times) for each in self.steps)])
        rows = slice(int(ends[number]), int(ends[number + 1]))
        steps, estimator = self.steps[number].solution, self.estimators[number]
        return ErrorEquation(
            self.cases[number],
            {name: each.along(each.motion.at(rows)) for name, each in bodies.items()},
            self.run.second_order_method.coefficients,
            steps,
            active_constraints(self.cases[number], self.solutions[number]),
            estimator.start_errors(steps, self.bases),
        )

    def _error(
        self, number: int, equation: ErrorEquation, found: ErrorState, fresh: Mapping[str, np.ndarray]
    ) -> BasisError:
        histories = equation.histories(found)
        if all(np.isfinite(history.rms).all() for history in histories.values()):
            second = second_corrections(equation, histories)
            simulated = {name: reduced_form(self.cases[number], name) for name in histories}
            small = is_small(histories, second, simulated)
            if small and not is_smooth(self.cases[number]):
                _, histories, second = converged(equation, found, histories, smooth=False)
                small = max(second.values()) <= FIRST_ORDER
            if small:
                outputs = self.steps[number].outputs
                return BasisError(
                    {
                        name: body_error(
                            history,
                            second[name],
                            outputs,
                            fresh[name],
                            locking_loss=locking_loss(self._body(name)),
                        )
                        for name, history in histories.items()
                    }
                )
        return self.estimators[number].assess(self.cases[number], self.bases, self.solutions[number]).error
