"""A group of cases as machines, each built in milliseconds from shared bodies."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from supple.body import BodyForm, Damping, FullBody
from supple.cases.bodies import Body
from supple.cases.case import Case
from supple.cases.case_inputs import digests_of_files
from supple.cases.condense import with_sufficient_modes
from supple.cases.notify import silent
from supple.cases.result_tables import recorded_quantities
from supple.cases.static_case import starting_system
from supple.error import SelfCorrection
from supple.errors import CaseError, ConvergenceError, LockingWarning, ResultFileError
from supple.importers.toml import KeyPath
from supple.integrate import Run, Solution
from supple.machine import Controller, System
from supple.quantities import Quantity
from supple.reduction import ReducedBody, ReductionBasis, project
from supple.reduction.projection import counted_damping
from supple.simulation import simulate_batch
from supple.storage.run_inputs import changes
from supple.sweeps.body_numbers import PLACING
from supple.sweeps.group_bodies import GroupBodies, bodies_of_group
from supple.sweeps.plan import SweepPlan

__all__ = ["SweptCase", "SweptGroup", "TrainingRuns", "swept_group"]


@dataclass(frozen=True, eq=False)
class SweptCase:
    """A case of a sweep, ready for simulation.

    case : case with its own values and the bodies of the group
    system : machine at the start of its run
    """

    case: Case
    system: System

    @property
    def run(self) -> Run:
        """The run of the case."""
        return self.case.run

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """All recorded quantities: sensors, joint forces, tracked points, energies."""
        return recorded_quantities(self.case, self.system)


@dataclass(frozen=True, eq=False)
class TrainingRuns:
    """Numbers, machines and solutions of the cases that ran to their end."""

    numbers: Sequence[int]
    cases: Sequence[SweptCase]
    solutions: Sequence[Solution]


@dataclass(frozen=True, eq=False)
class SweptGroup:
    """Cases that differ only in numbers of their runs.

    like : the representative case, with the reduced bodies
    fresh : the representative case, with bodies built from its tables
    """

    plan: SweepPlan
    like: Case
    bodies: GroupBodies
    fresh: Case
    _damped: dict[tuple[str, str], ReducedBody] = field(default_factory=dict)

    def case(self, number: int) -> SweptCase:
        """A case of the group, by its number.

        Raises CaseError for values that are invalid in the case file; ResultFileError for an input file that
        was changed since the sweep was planned; errors of building and starting it.
        """
        values = self.plan.values(number)
        _check_files(self.plan, set(self.plan.family.files(values)) - self._files)
        return self.with_values(values)

    def with_values(self, values: Mapping[KeyPath, Any]) -> SweptCase:
        """A case with any numbers of its run, by keys in the case file; errors as for `case`."""
        case = self.plan.family.variant(values, self.like, self._made)
        made = dict(self._made)
        for table in case.parts.body:
            if table.name in self.bodies.reduced:
                # One object for all cases with equal damping, so that shared data are computed once.
                key = table.name, repr(table.damping)
                if key not in self._damped:
                    self._damped[key] = self.bodies.damped(table.name, table)
                made[table.name] = self._damped[key]
            elif table.name in self._rigid and _content(table) == self._rigid[table.name][0]:
                # The same object, so that cases with equal starts are started together (`batch_start`).
                made[table.name] = self._rigid[table.name][1]
        case = self.like.varied(case.tables, made)
        return SweptCase(case, self._started(case))

    @property
    def targets(self) -> dict[str, SelfCorrection]:
        """Accuracies of the bodies with self-correction."""
        return {name: start.target for name, start in self.fresh.starts.items()}

    @property
    def requests_errors(self) -> bool:
        """Whether the case file requests basis errors."""
        return bool(self.fresh.starts) or self.like.study.basis

    def fulls(self, case: Case) -> dict[str, FullBody]:
        """The full bodies of a case from which its bodies are reduced."""
        found = {}
        for name, damping in self.dampings(case).items():
            body = self.bodies.reduced[name]
            found[name] = FullBody(self.fresh.flexible[name], body.frame, counted_damping(damping, body.r))
        return found

    def dampings(self, case: Case) -> dict[str, Damping | None]:
        """Damping of the reduced bodies in a case."""
        tables = {table.name: table for table in case.parts.body}
        return {name: self.bodies.damping(name, tables[name]) for name in self.bodies.reduced}

    def projected(self, name: str, basis: ReductionBasis) -> ReducedBody:
        """A self-correcting body of the representative case on another basis, which may lock."""
        full = self.fulls(self.like)[name]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LockingWarning)
            quartic = self.fresh.starts[name].quartic
            return project(full.body, basis, damping=full.damping, quartic=quartic)

    def in_full(self, case: Case, fulls: Mapping[str, FullBody]) -> System:
        """The machine of a case at the start of its run, with full bodies in place of some reduced bodies."""
        return self._started(case.varied(case.tables, {**self._made, **case.made, **fulls}))

    def training_runs(self, numbers: Sequence[int]) -> TrainingRuns:
        """Simulate cases of the group in one batch; cases that fail are left out.

        The failure is recorded later, when the sweep runs the case. Raises CaseError if no machine can be
        built; errors of `simulate_batch`.
        """
        known, made = list[int](), list[SweptCase]()
        for number in numbers:
            with suppress(CaseError, ConvergenceError):
                made.append(self.case(number))
                known.append(number)
        if not made:
            raise CaseError("no machine of the group can be built: check the values of the table")
        found = simulate_batch([own.system for own in made], made[0].run, progress=silent)
        ran = [place for place in range(len(made)) if place not in found.failures]
        return TrainingRuns(
            [known[place] for place in ran],
            [made[place] for place in ran],
            [found.solutions[place] for place in ran],
        )

    def with_bodies(self, reduced: Mapping[str, ReducedBody]) -> SweptGroup:
        """The group with other reduced bodies."""
        bodies = replace(self.bodies, reduced={**self.bodies.reduced, **reduced})
        return SweptGroup(self.plan, self.like.varied(self.like.tables, bodies.reduced), bodies, self.fresh)

    def _started(self, case: Case) -> System:
        return starting_system(case, allow_code=self.plan.allow_code)

    @cached_property
    def _files(self) -> frozenset[str]:
        """Names of the files of the representative case."""
        return frozenset(self.like.files)

    @cached_property
    def _rigid(self) -> Mapping[str, tuple[str, BodyForm]]:
        """Rigid bodies of the representative case, with their contents as text."""
        tables = {table.name: table for table in self.like.parts.body}
        forms = [placed.body for placed in self.like.system.bodies if placed.body.kind == "rigid"]
        return {form.name: (_content(tables[form.name]), form) for form in forms}

    @cached_property
    def _made(self) -> Mapping[str, BodyForm]:
        """All bodies except rigid bodies, whose numbers may differ between cases."""
        case = self.like
        placed = case.system.bodies
        # Mesh data for the points and sensors of one case serve all cases (`Case.varied`).
        recorded_quantities(case, case.system)
        condensed = {body.name: body.condense for body in case.tables.body if body.condense is not None}
        if condensed:
            placed = with_sufficient_modes(self._started(case), case.run, condensed, silent).bodies
        return {each.body.name: each.body for each in placed if each.body.kind != "rigid"}


def _content(table: Body) -> str:
    """The table of a body without its placement, as text."""
    return table.model_dump_json(exclude=set(PLACING))


@lru_cache(maxsize=2)
def swept_group(folder: Path, plan: SweepPlan, number: int) -> SweptGroup:
    """A group of a sweep; its bodies are reduced now if they are not stored yet.

    Raises
    ------
    ResultFileError     an input file that was changed since the sweep was planned
    CaseError           controllers that may not run, or whose functions are created for every case
    SuppleError         errors of its bodies and reductions
    """
    fresh = _representative(plan, number)
    bodies = bodies_of_group(fresh, folder)
    like = fresh.varied(fresh.tables, bodies.reduced)
    _check_functions(like, allow_code=plan.allow_code)
    return SweptGroup(plan, like, bodies, fresh)


def _representative(plan: SweepPlan, number: int) -> Case:
    """The first case of a group with values that a case file can have; the CaseError of the first if none."""
    first: CaseError | None = None
    for case in plan.representatives(number).tolist():
        values = plan.values(case)
        _check_files(plan, plan.family.files(values))
        try:
            return plan.family.variant(values)
        except CaseError as error:
            first = first or error
    assert first is not None
    raise first


def _check_files(plan: SweepPlan, names: Iterable[str]) -> None:
    """ResultFileError for an input file that was changed since the sweep was planned."""
    files = digests_of_files(names, plan.case_file.parent)
    if changed := changes({name: plan.inputs[name] for name in files.keys() & plan.inputs.keys()}, files):
        raise ResultFileError(
            f"the sweep of {plan.case_file} was planned with other files ({changed}): restore them, or run "
            "the sweep again with --force"
        )


def _check_functions(case: Case, *, allow_code: bool) -> None:
    """CaseError for controllers whose functions are created anew for every case."""
    first, second = (
        [
            (own.outputs, own.rates)
            for own in case.controlled(case.system, allow_code=allow_code).controllers
            if isinstance(own, Controller)
        ]
        for _ in range(2)
    )
    if first != second:
        raise CaseError(
            f'{case.path}: control = "{case.tables.control}" creates new functions at every call, so '
            "that each case would be compiled separately: define `outputs` and `rates` at the top level of "
            "the file, not within another function"
        )
