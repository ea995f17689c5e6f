"""Groups of a sweep with certificates, computed once and stored; repeated runs may have enriched bases."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from supple.cases.case import Case
from supple.error.error_estimate import check_linearised
from supple.errors import (
    ResultFileError,
    SuppleError,
    SuppleWarning,
)
from supple.integrate import Kinematic
from supple.simulation import store_body
from supple.simulation.engines import is_explicit
from supple.simulation.stored_bodies import stored_path
from supple.storage import read_reduced_body
from supple.storage.exclusive_lock import ExclusiveLock
from supple.storage.file_errors import file_errors
from supple.storage.sealed_hdf5 import is_whole
from supple.sweeps.attempts import NOT_OF_A_CASE, Attempts
from supple.sweeps.certificate import Certificate, read_certificate, write_certificate
from supple.sweeps.greedy_basis import certify, training_cases
from supple.sweeps.leading_columns import with_principal_bases
from supple.sweeps.plan import SweepPlan, read_plan
from supple.sweeps.sweep_shares import largest_ratio, sweep_shares
from supple.sweeps.swept_group import SweptCase, SweptGroup, swept_group

__all__ = ["CertifiedGroup", "certified_group", "swept_case"]

_CERTIFICATE = "certificate.h5"
MANY = 256
"""Smallest number of cases of a group for which smaller bases are searched.

For a blade, the search saves time from 150 cases on.
"""


@dataclass(frozen=True, eq=False)
class CertifiedGroup:
    """A group with the bases of its runs, and the certificate of their errors."""

    group: SweptGroup
    certificate: Certificate


def certified_group(
    folder: Path, plan: SweepPlan, number: int, level: int = 0, case: int | None = None
) -> CertifiedGroup:
    """A group of a sweep with the bases and the certificate of its runs; raises as `swept_group` does.

    level : number of earlier runs of its cases; repeated runs may have enriched bases
    case : for level 1 or more, a case that runs at this level
    """
    is_alone = level and case is not None and sweep_shares(folder, plan).is_certified_alone(case, level)
    return _certified_group(folder, plan, number, level, case if is_alone else None)


@lru_cache(maxsize=4)
def _certified_group(
    folder: Path, plan: SweepPlan, number: int, level: int, alone: int | None
) -> CertifiedGroup:
    """As `certified_group`; alone : the only case of the certificate, None for the group."""
    group = swept_group(folder, plan, number)
    reason = _why_not(group)
    if reason:
        return CertifiedGroup(group, Certificate(reason=reason))
    if level:
        group = certified_group(folder, plan, number, level - 1, alone).group
    # The digest separates the certificates of a sweep from those of a former one that still runs.
    name = f"{number:05}-{level}{'' if alone is None else f'-{alone:06}'}"
    own = folder / "certificates" / plan.digest / name
    with file_errors("make the folder", own):
        own.mkdir(parents=True, exist_ok=True)
    if not is_whole(own / _CERTIFICATE):
        with ExclusiveLock(own, wait=True):
            if not is_whole(own / _CERTIFICATE):
                _certify(folder, group, number, level, own, alone)
    kept = {name: stored_path(own, name) for name in group.bodies.reduced}
    reduced = {name: read_reduced_body(path) for name, path in kept.items() if path.exists()}
    group = group.with_bodies(reduced) if reduced else group
    fulls = group.fulls(group.like)
    return CertifiedGroup(group, read_certificate(own / _CERTIFICATE, fulls, group.targets))


def swept_case(folder: Path | str, number: int, *, allow_code: bool = False) -> SweptCase:
    """A case of the sweep in a folder, as in its last run.

        swept = swept_case("results/sweep", 17)
        solution = simulate(swept.system, swept.run)

    allow_code : run the Python file of `control`, if the case names one
    Raises ResultFileError for an unknown case; SuppleError where the case cannot be built.
    """
    folder = Path(folder).resolve()
    plan = read_plan(folder, allow_code=allow_code)
    if not 0 <= number < plan.n_cases:
        raise ResultFileError(f"{folder} has no case {number}: its cases are 0 to {plan.n_cases - 1}")
    level = sweep_shares(folder, plan).level_of(number)
    return certified_group(folder, plan, int(plan.group[number]), level, number).group.case(number)


def _why_not(group: SweptGroup) -> str:
    """Why the errors of a group are not estimated; empty if they are."""
    case: Case = group.like
    elastic = [placed.body.name for placed in case.system.bodies if placed.body.n_coordinates]
    others = [name for name in elastic if name not in group.bodies.reduced]
    named = f"body '{others[0]}'" if others else ""
    reasons = {
        "errors of machines with a controller are estimated in single runs only": case.tables.control
        is not None,
        "a kinematic run is not integrated, and no body deforms": isinstance(case.run.method, Kinematic),
        "the error of explicit time integration is not estimated": is_explicit(case.system, case.run),
        "no body is elastic: there is no basis, and the integration of rigid machines is not assessed": (
            not elastic
        ),
        f"{named} is not reduced by the sweep from elements: only single runs have an estimate": bool(others),
        "the bases have a fixed size: set basis = true in [error] to estimate their errors": (
            not group.requests_errors
        ),
    }
    return next((reason for reason, holds in reasons.items() if holds), "")


def _certify(folder: Path, group: SweptGroup, number: int, level: int, own: Path, alone: int | None) -> None:
    """Compute and store the certificate of a group or of one case, and the bodies whose bases changed."""
    plan = group.plan
    attempts = Attempts(own, 0)
    if attempts.are_many:
        ended = Certificate(reason="the processes that simulated the representative cases were killed")
        write_certificate(own / _CERTIFICATE, ended)
        return
    cases, worst = np.flatnonzero(plan.group == number).tolist(), None
    if alone is not None:
        cases, worst = [alone], alone
    elif level:
        shares = sweep_shares(folder, plan)
        cases = shares.cases_of_level(level, number)
        worst = largest_ratio(folder, shares, cases, level - 1)
    try:
        attempts.begin(cases)
        check_linearised(group.like.system)
        with warnings.catch_warnings():  # the runs of the cases give the warnings
            warnings.simplefilter("ignore", SuppleWarning)
            training = training_cases(plan, cases)
            if worst is not None:
                training = sorted({*training, worst})
            fewer, runs = group, None
            if level == 0 and len(cases) >= MANY:
                fewer, runs = with_principal_bases(group, training)
            found, certificate = certify(fewer, training, worst, runs)
    except SuppleError as error:  # the cases run without an estimate
        if isinstance(error, NOT_OF_A_CASE):
            attempts.withdraw()
            raise
        found, certificate = group, Certificate(reason=str(error))
    except BaseException:
        attempts.withdraw()
        raise
    for name, body in found.bodies.reduced.items():
        if body is not group.bodies.reduced[name]:
            store_body(body, own)
    write_certificate(own / _CERTIFICATE, certificate)
    attempts.end()
