"""The reduced bodies and the certificate of a sweep, computed once for all folders with the same cases."""

from __future__ import annotations

import shutil
from pathlib import Path
from time import perf_counter

from supple.sweeps import LocalProcesses, SweepPlan, plan_sweep, read_plan
from supple.sweeps.certified_group import certified_group

__all__ = ["make_certificate", "plan_with_certificate"]

_KEPT = ("bodies", "certificates")


def make_certificate(plan: SweepPlan, folder: Path) -> float:
    """Reduce and certify the bodies of a sweep of one group in a separate process; returns the seconds."""
    shutil.rmtree(folder, ignore_errors=True)
    plan_sweep(plan, folder)
    began = perf_counter()
    with LocalProcesses(1).opened() as executor:
        executor.submit(_certify, str(folder)).result()
    return perf_counter() - began


def _certify(folder: str) -> None:
    where = Path(folder).resolve()
    certified_group(where, read_plan(where), 0)


def plan_with_certificate(plan: SweepPlan, folder: Path, certified: Path) -> None:
    """Plan a sweep in an empty folder, with the results of `make_certificate` in another folder."""
    plan_sweep(plan, folder)
    for name in _KEPT:
        shutil.copytree(certified / name, folder / name)
