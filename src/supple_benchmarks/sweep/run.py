"""The measurements of the benchmark of sweeps, one after the other."""

from __future__ import annotations

import resource
import shutil
from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from supple.other_processes import available_cores
from supple.quantities import read_sensors
from supple.simulation import simulate
from supple.sweeps import (
    Cluster,
    Executors,
    LocalProcesses,
    SweepColumns,
    make_plan,
    plan_sweep,
    read_sweep,
    run_sweep,
    swept_case,
)
from supple.sweeps.channel_statistics import STATISTICS, channel_statistics
from supple.sweeps.plan import MARCHED_AT_ONCE, SweepPlan
from supple.sweeps.sweep_file import SweepOutput
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.progress import Announce
from supple_benchmarks.sweep.gradient import gradient_error
from supple_benchmarks.sweep.kills import killed_sweep
from supple_benchmarks.sweep.swept_arm import arm_case, arm_table

__all__ = ["run_benchmark"]

KILLED_CASES = 48
_EXPONENT = 4.0
_OUTPUT = {"keep": [0], "fatigue": {"exponents": [_EXPONENT]}}


def run_benchmark(quick: bool, folder: Path, announce: Announce) -> Iterator[dict[str, Any]]:
    """The report, ready for JSON, after every measurement; its keys are a contract."""
    n, duration = (128, 0.5) if quick else (1880, 10.0)
    case = arm_case(folder, duration)
    plan = make_plan(case, arm_table(n), SweepOutput.model_validate(_OUTPUT))
    cores = available_cores()
    report: dict[str, Any] = {
        "quick": quick,
        "machine": describe_computer(),
        "cases": n,
        "simulated": duration,
    }

    def timed(name: str, executors: Executors, what: SweepPlan = plan) -> float:
        own = folder / name
        shutil.rmtree(own, ignore_errors=True)
        plan_sweep(what, own)
        began = perf_counter()
        run_sweep(own, executors, announce(name))
        return perf_counter() - began

    few = make_plan(case, arm_table(MARCHED_AT_ONCE), SweepOutput.model_validate(_OUTPUT))
    timed("programs compiled", LocalProcesses(1), few)
    alone = timed("one process", LocalProcesses(1))
    together = timed("all cores", LocalProcesses(cores))
    report |= {"cores": cores, "seconds": together, "seconds_one_process": alone}
    report["per_core_efficiency"] = {"cores": alone / (cores * together)}
    report["memory_mib"] = _peak_memory()
    yield report
    if find_spec("distributed"):
        from distributed import LocalCluster

        with LocalCluster(cores, threads_per_worker=1, dashboard_address=None) as cluster:
            report["seconds_dask"] = timed("Dask", Cluster(cluster.scheduler_address))
        report["per_core_efficiency"]["dask"] = alone / (cores * report["seconds_dask"])
        yield report
    report |= _against_single_runs(folder / "all cores", n)
    yield report
    report |= _reading(folder / "all cores")
    yield report
    report |= _del_error(folder / "all cores")
    report["gradient_error"] = gradient_error(folder / "all cores", n // 2)
    yield report
    report["kills"] = killed_sweep(case, arm_table(KILLED_CASES), folder / "killed")
    yield report


def _against_single_runs(folder: Path, n: int) -> dict[str, float]:
    """Largest distance of the statistics of three cases from those of their runs alone, over the largest.

    Beside it the distance of these runs from themselves with a gravity of one unit in the last place more,
    which is what round-off alone makes of them.
    """
    found, round_off, seconds = [], [], []
    statistics = read_sweep(folder).statistics.sel(statistic=list(STATISTICS))
    for number in (0, n // 2, n - 1):
        own = swept_case(folder, number)
        nearby = replace(own.system, gravity=np.nextafter(own.system.gravity, np.inf))
        solutions = [simulate(system, own.run) for system in (own.system, nearby)]
        seconds.append(solutions[0].statistics.seconds)
        columns = [read_sensors(own.quantities, own.system, each).columns() for each in solutions]
        alone, other = (channel_statistics(each.times, each.values).T for each in columns)
        largest = np.abs(alone).max()
        found.append(np.abs(statistics[number].values - alone).max() / largest)
        round_off.append(np.abs(other - alone).max() / largest)
    return {
        "equal_to_single": float(max(found)),
        "round_off": float(max(round_off)),
        "case_seconds_single": float(np.mean(seconds)),
    }


def _reading(folder: Path) -> dict[str, float]:
    began = perf_counter()
    data = read_sweep(folder)
    opened = perf_counter()
    _ = data.statistics.sel(channel="tip.z", statistic="maximum").values
    return {"seconds_to_open": opened - began, "seconds_to_read_a_column": perf_counter() - opened}


def _del_error(folder: Path) -> dict[str, float]:
    """Largest distance of the equivalent loads of the kept case from those by the package `rainflow`.

    L = (sum n_i S_i^m / N)^(1/m),   in parts of each; nothing where the package is not installed
    """
    if not find_spec("rainflow"):
        return {}
    from rainflow import extract_cycles

    columns = SweepColumns(folder)
    motion = columns.motion(0)
    reference = motion["times"][-1] - motion["times"][0]

    def load(history: np.ndarray) -> float:
        cycles = np.array([(each[0], each[2]) for each in extract_cycles(history)]).reshape(-1, 2)
        return float((cycles[:, 1] @ cycles[:, 0] ** _EXPONENT / reference) ** (1 / _EXPONENT))

    expected = np.array([load(history) for history in motion["channels"].T])
    place = next(i for i, name in enumerate(columns.statistics) if name.startswith("damage-equivalent"))
    found = columns.statistic(place)[0]
    moves = expected > 0
    return {"del_error": float(np.max(np.abs(found - expected)[moves] / expected[moves]))}


def _peak_memory() -> dict[str, float]:
    """Of this process and of the largest of its workers, MiB (Linux counts KiB)."""
    own, workers = (
        resource.getrusage(who).ru_maxrss / 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return {"command": own, "worker": workers}
