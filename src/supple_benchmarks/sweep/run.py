"""The measurements of the benchmark of sweeps, one after the other."""

from __future__ import annotations

import resource
import shutil
from collections.abc import Iterator
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
    make_plan,
    plan_sweep,
    read_sweep,
    run_sweep,
    swept_case,
)
from supple.sweeps.channel_statistics import channel_statistics
from supple.sweeps.sweep_file import SweepOutput
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.progress import Announce
from supple_benchmarks.sweep.swept_arm import arm_case, arm_table

__all__ = ["run_benchmark"]


def run_benchmark(quick: bool, folder: Path, announce: Announce) -> Iterator[dict[str, Any]]:
    """The report, ready for JSON, after every measurement; its keys are a contract."""
    n, duration = (192, 1.0) if quick else (1880, 10.0)
    case = arm_case(folder, duration)
    plan = make_plan(case, arm_table(n), SweepOutput.model_validate({}))
    cores = available_cores()
    report: dict[str, Any] = {
        "quick": quick,
        "machine": describe_computer(),
        "cases": n,
        "simulated": duration,
    }

    def timed(name: str, executors: Executors) -> float:
        own = folder / name
        shutil.rmtree(own, ignore_errors=True)
        plan_sweep(plan, own)
        began = perf_counter()
        run_sweep(own, executors, announce(name))
        return perf_counter() - began

    timed("programs compiled", LocalProcesses(1))
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


def _against_single_runs(folder: Path, n: int) -> dict[str, float]:
    """Largest distance of the statistics of three cases from those of their runs alone, over the largest."""
    found, seconds = [], []
    statistics = read_sweep(folder).statistics
    for number in (0, n // 2, n - 1):
        own = swept_case(folder, number)
        solution = simulate(own.system, own.run)
        seconds.append(solution.statistics.seconds)
        columns = read_sensors(own.quantities, own.system, solution).columns()
        alone = channel_statistics(columns.times, columns.values).T
        found.append(np.abs(statistics[number].values - alone).max() / np.abs(alone).max())
    return {"equal_to_single": float(max(found)), "case_seconds_single": float(np.mean(seconds))}


def _reading(folder: Path) -> dict[str, float]:
    began = perf_counter()
    data = read_sweep(folder)
    opened = perf_counter()
    _ = data.statistics.sel(channel="tip.z", statistic="maximum").values
    return {"seconds_to_open": opened - began, "seconds_to_read_a_column": perf_counter() - opened}


def _peak_memory() -> dict[str, float]:
    """Of this process and of the largest of its workers, MiB (Linux counts KiB)."""
    own, workers = (
        resource.getrusage(who).ru_maxrss / 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return {"command": own, "worker": workers}
