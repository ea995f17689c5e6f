"""Self-correction at rest: find an equilibrium or modes, and enrich the bases by motion outside the bases.

No time integration is needed. One factorisation gives the equilibrium in all coordinates from the reduced
equilibrium, and the enriched basis contains this equilibrium. One or two rounds therefore suffice.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from supple.body import FullBody
from supple.equations import StaticSearch
from supple.error.correction_rounds import (
    ReductionStart,
    SelfCorrection,
    SelfCorrectionError,
    warn_of_fixed_sizes,
)
from supple.error.start_deformation import with_reduced
from supple.errors import BasisWarning, LockingWarning, ModelError, ValidityWarning
from supple.machine import Spin, System
from supple.quantities.quantity_of_interest import quantity_distance
from supple.reduction import ReducedBody, ReductionBasis, enrich, project, reduction_basis
from supple.simulation import Equilibrium, equilibrium
from supple.simulation.equilibrium import warn_of_rest_limits
from supple.simulation.resting_state import resting_state
from supple.simulation.turned_machine import warn_of_varying_loads

__all__ = [
    "MotionOutsideBasis",
    "StaticallyCorrected",
    "correct_at_rest",
    "correct_statically",
    "missed_at_rest",
]


class MotionOutsideBasis(NamedTuple):
    """Motion outside the basis of one body.

    error, allowed : in the unit of the quantity of interest
    fields : (n, m)     displacements in the body's coordinates that enrich the basis
    """

    error: float
    allowed: float
    fields: np.ndarray

    @property
    def is_met(self) -> bool:
        """Whether the error is known and at most the allowed error."""
        return self.error <= self.allowed


Look = Callable[[System, Mapping[str, FullBody]], Mapping[str, MotionOutsideBasis]]
"""Solves a reduced machine; returns the motion outside its bases, by name of the body."""


@dataclass(frozen=True, eq=False)
class StaticallyCorrected:
    """A machine whose bases meet their target errors at rest.

    system : System         with its bodies reduced, in their given placements
    bases : ReductionBasis  by name
    missed : by name, the motion outside the basis in each round
    """

    system: System
    bases: Mapping[str, ReductionBasis]
    missed: Mapping[str, tuple[MotionOutsideBasis, ...]]


def correct_at_rest(
    system: System,
    target: SelfCorrection | ReductionStart | Mapping[str, ReductionStart],
    *,
    time: float = 0.0,
    spin: Spin | None = None,
    search: StaticSearch | None = None,
) -> tuple[Equilibrium, StaticallyCorrected]:
    """Equilibrium of a system, and its bodies, reduced together until their errors at rest are allowed.

    system : System     contains each body to reduce as a FullBody, with its frame and damping
    target : the target error of every full body (SelfCorrection), or also its start basis (ReductionStart);
        or a ReductionStart for each named body, with all other bodies unchanged
    time, spin, search : as for `equilibrium`

    Raises
    ------
    SelfCorrectionError     the error is not met with the allowed rounds or coordinates
    ModelError              nothing to reduce, a body that is not full; errors of `equilibrium` and `reduce`
    ConvergenceError        no equilibrium
    """
    start = ReductionStart(target) if isinstance(target, SelfCorrection) else target
    starts = start if isinstance(start, Mapping) else dict.fromkeys(system.bodies_of(FullBody), start)
    found: list[Equilibrium] = []

    def look(reduced: System, fulls: Mapping[str, FullBody]) -> Mapping[str, MotionOutsideBasis]:
        found.append(equilibrium(reduced, time=time, spin=spin, search=search, fulls=fulls))
        return missed_at_rest(found[-1], starts)

    corrected = correct_statically(system, starts, look)
    warn_of_rest_limits(found[-1].system, found[-1].solution, starts)
    if spin is not None:
        warn_of_varying_loads(
            resting_state(found[-1].system, time=time, spin=spin, search=search), time, spin
        )
    return found[-1], corrected


def missed_at_rest(found: Equilibrium, starts: Mapping[str, ReductionStart]) -> dict[str, MotionOutsideBasis]:
    """Motion outside the bases in an equilibrium, and the errors of the quantities of interest, by body."""
    missed = {}
    for name, start in starts.items():
        quantity = start.target.quantity(name)
        error = np.inf
        if found.full is not None:
            error = quantity_distance(quantity, found.system, found.solution, *found.full)
        size = quantity.size(found.system, found.solution)
        fields = found.errors[name].deformation[:, None]
        missed[name] = MotionOutsideBasis(error, start.target.allowed(size), fields)
    return missed


def correct_statically(
    system: System, starts: Mapping[str, ReductionStart], look: Look
) -> StaticallyCorrected:
    """Repeat `look` and enrichment until every body meets its target; raises as `correct_at_rest`."""
    fulls = system.bodies_of(FullBody)
    if not starts or not starts.keys() <= fulls.keys():
        other = next((name for name in starts if name not in fulls), None)
        raise ModelError(
            "self-correction at rest: name at least one body of the system to reduce"
            if other is None
            else f"self-correction at rest: body '{other}' must be in the system as a FullBody"
        )
    warn_of_fixed_sizes(system, starts)
    fulls = {name: fulls[name] for name in starts}
    bases = {
        name: reduction_basis(full.body, full.frame, starts[name].basis, derivatives=starts[name].derivatives)
        for name, full in fulls.items()
    }
    rounds: dict[str, list[MotionOutsideBasis]] = {name: [] for name in starts}
    while True:
        reduced = _reduced(system, fulls, starts, bases)
        with warnings.catch_warnings():
            # The rounds report the error.
            warnings.simplefilter("ignore", BasisWarning)
            warnings.simplefilter("ignore", ValidityWarning)
            missed = look(reduced, fulls)
        for name, each in missed.items():
            rounds[name].append(each)
        unmet = [name for name, each in missed.items() if not each.is_met]
        if not unmet:
            return StaticallyCorrected(reduced, bases, {name: tuple(each) for name, each in rounds.items()})
        for name in unmet:
            fields = missed[name].fields
            more = int(np.linalg.matrix_rank(fields)) if fields.any() else 0
            _check_prospects(name, starts[name].target, rounds[name], bases[name].r + more)
            bases[name] = enrich(fulls[name].body, bases[name], fields, more).basis


def _check_prospects(name: str, target: SelfCorrection, rounds: list[MotionOutsideBasis], size: int) -> None:
    """Raise SelfCorrectionError where the rounds or the allowed coordinates are used up."""
    if not np.isfinite(rounds[-1].error):
        reason = "no equilibrium was found with all its coordinates, so that its error is unknown"
    elif size > target.largest_size:
        reason = f"the next basis would have {size} coordinates, more than {target.largest_size} allowed"
    elif len(rounds) > target.max_rounds:
        reason = f"all rounds are used up (max_rounds = {target.max_rounds})"
    else:
        return
    errors = ", ".join(f"{each.error:.2g}" for each in rounds)
    raise SelfCorrectionError(
        f"self-correction of body '{name}' at rest did not reach the error {target.wanted}: {reason}. "
        f"Errors, round by round: {errors}. Start with more modes or derivatives, or allow more coordinates",
        (),
    )


def _reduced(
    system: System,
    fulls: Mapping[str, FullBody],
    starts: Mapping[str, ReductionStart],
    bases: Mapping[str, ReductionBasis],
) -> System:
    """The machine with reduced bodies; their initial deformation is projected on the bases."""
    with warnings.catch_warnings():
        # Locking is caused by motion outside the basis, which the rounds find and report.
        warnings.simplefilter("ignore", LockingWarning)
        bodies: dict[str, ReducedBody] = {
            name: project(full.body, bases[name], damping=full.damping, quartic=starts[name].quartic)
            for name, full in fulls.items()
        }

    return with_reduced(system, bodies, bases)
