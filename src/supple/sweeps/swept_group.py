"""A group of cases as machines: made of the same bodies, in milliseconds each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path

from supple.body import BodyForm
from supple.cases.case import Case
from supple.cases.case_inputs import digests_of_files
from supple.cases.condense import with_modes_enough
from supple.cases.notify import silent
from supple.cases.result_tables import recorded_quantities
from supple.cases.static_case import starting_system
from supple.errors import ResultFileError
from supple.integrate import Run
from supple.machine import System
from supple.quantities import Quantity
from supple.reduction import ReducedBody
from supple.storage.run_inputs import changes
from supple.sweeps.group_bodies import GroupBodies, bodies_of_group
from supple.sweeps.plan import SweepPlan, read_plan

__all__ = ["SweptCase", "SweptGroup", "swept_case", "swept_group"]


@dataclass(frozen=True, eq=False)
class SweptCase:
    """A case of a sweep as it is simulated.

    case : with its own numbers, its bodies made
    system : as its run starts
    """

    case: Case
    system: System

    @property
    def run(self) -> Run:
        """Span of time and steps."""
        return self.case.run

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What is read off it: sensors, forces of joints, tracked places, energies."""
        return recorded_quantities(self.case, self.system)


@dataclass(frozen=True, eq=False)
class SweptGroup:
    """Cases that differ in numbers of their runs.

    like : the representative case, with its bodies made
    """

    plan: SweepPlan
    like: Case
    bodies: GroupBodies
    _damped: dict[tuple[str, str], ReducedBody] = field(default_factory=dict)

    def case(self, number: int) -> SweptCase:
        """A case of the group.

        Raises CaseError for values that the case file could not have; errors of building and starting it.
        """
        case = self.plan.family.variant(self.plan.values(number), self.like, self._made)
        made = dict(self._made)
        for table in case.parts.body:
            if table.name in self.bodies.reduced:
                # One object for all cases of the same damping: what cases share is found once.
                key = table.name, repr(table.damping)
                if key not in self._damped:
                    self._damped[key] = self.bodies.damped(table.name, table)
                made[table.name] = self._damped[key]
        case = self.like.varied(case.tables, made)
        return SweptCase(case, starting_system(case))

    @cached_property
    def _made(self) -> Mapping[str, BodyForm]:
        """All bodies but the rigid ones, whose numbers are the cases' own."""
        case = self.like
        placed = case.system.bodies
        # What is read of meshes for the places and sensors of one case serves all (`Case.varied`).
        recorded_quantities(case, case.system)
        condensed = {body.name: body.condense for body in case.tables.body if body.condense is not None}
        if condensed:
            placed = with_modes_enough(starting_system(case), case.run, condensed, silent).bodies
        return {each.body.name: each.body for each in placed if each.body.kind != "rigid"}


@lru_cache(maxsize=2)
def swept_group(folder: Path, plan: SweepPlan, number: int) -> SweptGroup:
    """A group of a sweep; its bodies reduced now where nobody has yet.

    Raises
    ------
    ResultFileError     a file that is not as it was when the sweep was planned
    SuppleError         whatever its bodies and reductions find wrong
    """
    values = plan.values(plan.representative(number))
    files = digests_of_files(plan.family.files(values), plan.case_file.parent)
    if changed := changes({name: plan.inputs.get(name, "") for name in files}, files):
        raise ResultFileError(
            f"{folder} was planned with other files ({changed}): put them back, or run the sweep again with "
            "--force"
        )
    fresh = plan.family.variant(values)
    bodies = bodies_of_group(fresh, folder)
    return SweptGroup(plan, fresh.varied(fresh.tables, bodies.reduced), bodies)


def swept_case(folder: Path | str, number: int) -> SweptCase:
    """A case of the sweep in a folder, as it was simulated there.

        swept = swept_case("results/sweep", 17)
        solution = simulate(swept.system, swept.run)

    Raises ResultFileError without such a case; SuppleError as for building it.
    """
    folder = Path(folder).resolve()
    plan = read_plan(folder)
    if not 0 <= number < plan.n_cases:
        raise ResultFileError(f"{folder} has no case {number}: its cases are 0 to {plan.n_cases - 1}")
    return swept_group(folder, plan, int(plan.group[number])).case(number)
