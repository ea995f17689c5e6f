"""The measurements of the benchmark of sweeps, one after the other."""

from __future__ import annotations

import resource
import shutil
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter

import numpy as np

from supple.other_processes import available_cores
from supple.quantities import read_sensors
from supple.simulation import simulate
from supple.sweeps import (
    Cluster,
    Executors,
    LocalProcesses,
    SweepColumns,
    SweepStatus,
    make_plan,
    read_sweep,
    run_sweep,
    swept_case,
)
from supple.sweeps.channel_statistics import STATISTICS, channel_statistics
from supple.sweeps.sweep_file import SweepOutput
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.progress import Announce
from supple_benchmarks.sweep.certificate_once import make_certificate, plan_with_certificate
from supple_benchmarks.sweep.gradient import gradient_error
from supple_benchmarks.sweep.kills import killed_sweep
from supple_benchmarks.sweep.swept_arm import arm_case, arm_table
from supple_benchmarks.table import Row

__all__ = ["CONTRACT", "QUICK_CASES", "run_benchmark"]

CONTRACT = (
    "cases",
    "seconds",
    "case_seconds_single",
    "per_core_efficiency",
    "equal_to_single",
    "memory_mib",
    "kills",
    "gradient_error",
    "del_error",
    "largest_estimate",
    "allowed",
    "run_again",
)
"""Keys of the report; further measurements are in its details."""
QUICK_CASES = 64
_EXPONENT = 4.0
_OUTPUT = {"keep": [0], "fatigue": {"exponents": [_EXPONENT]}, "cases_per_share": 16}


def run_benchmark(quick: bool, folder: Path, announce: Announce) -> Iterator[tuple[Row, Row]]:
    """The report and its details, ready for JSON, after every measurement."""
    n, duration = (QUICK_CASES, 0.15) if quick else (1880, 9.999)
    case, table, cores = arm_case(folder, duration), arm_table(n), available_cores()
    plan = make_plan(case, table, SweepOutput.model_validate(_OUTPUT))
    report: Row = dict.fromkeys(CONTRACT)
    details: Row = {"quick": quick, "machine": describe_computer(), "simulated": duration}
    report["cases"] = n
    certified = folder / "certified"
    announce("certificate")
    details["seconds_certificate"] = make_certificate(plan, certified)
    yield report, details

    def timed(name: str, executors: Executors) -> tuple[float, SweepStatus]:
        own = folder / name
        shutil.rmtree(own, ignore_errors=True)
        plan_with_certificate(plan, own, certified)
        began = perf_counter()
        status = run_sweep(own, executors, announce(name))
        return perf_counter() - began, status

    alone, _ = timed("one process", LocalProcesses(1))
    together, status = timed("all cores", LocalProcesses(cores))
    report["seconds"] = details["seconds_certificate"] + together
    report["per_core_efficiency"] = {"cores": alone / (cores * together), "dask": None}
    report["memory_mib"] = _peak_memory()
    report |= _estimates(folder / "all cores", status)
    details |= {"cores": cores, "seconds_all_cores": together, "seconds_one_process": alone}
    yield report, details
    if find_spec("distributed"):
        import dask
        from distributed import LocalCluster

        # As docs/how-to/sweeps.md recommends; see there.
        with (
            dask.config.set({"distributed.worker.profile.enabled": False}),
            LocalCluster(cores, threads_per_worker=1, dashboard_address=None) as cluster,
        ):
            details["seconds_dask"], _ = timed("Dask", Cluster(cluster.scheduler_address))
        report["per_core_efficiency"]["dask"] = alone / (cores * details["seconds_dask"])
        yield report, details
    announce("single runs")
    distance, round_off, seconds = _against_single_runs(folder / "all cores", n)
    report |= {"equal_to_single": distance, "case_seconds_single": seconds}
    details["round_off"] = round_off
    yield report, details
    details |= _reading(folder / "all cores")
    report["del_error"] = _del_error(folder / "all cores")
    with ThreadPoolExecutor(1) as beside:  # neither part is timed
        kills = beside.submit(killed_sweep, case, table, folder / "killed", certified)
        announce("derivatives")
        report["gradient_error"] = gradient_error(folder / "all cores", n // 2)
        yield report, details
        announce("kills")
        report["kills"] = kills.result()
    yield report, details


def _estimates(folder: Path, status: SweepStatus) -> Row:
    """Largest estimated error and smallest allowed error of a case, m; number of repeated cases."""
    allowed = SweepColumns(folder).of_cases("allowed_error")
    return {
        "largest_estimate": status.errors.largest,
        "allowed": float(allowed.min()),
        "run_again": status.n_again,
    }


def _against_single_runs(folder: Path, n: int) -> tuple[float, float, float]:
    """Largest difference of the statistics of three cases from those of single runs, over the largest value.

    Also returned: the difference between single runs with gravity changed by one unit in the last place,
    which is the effect of round-off alone; and the mean time of a single run, s.
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
    return float(max(found)), float(max(round_off)), float(np.mean(seconds))


def _reading(folder: Path) -> dict[str, float]:
    began = perf_counter()
    data = read_sweep(folder)
    opened = perf_counter()
    _ = data.statistics.sel(channel="tip.z", statistic="maximum").values
    return {"seconds_to_open": opened - began, "seconds_to_read_a_column": perf_counter() - opened}


def _del_error(folder: Path) -> float | None:
    """Largest distance of the equivalent loads of the stored case from those by the package `rainflow`.

    L = (sum n_i S_i^m / N)^(1/m),   relative errors; None where the package is not installed
    """
    if not find_spec("rainflow"):
        return None
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
    return float(np.max(np.abs(found - expected)[moves] / expected[moves]))


def _peak_memory() -> dict[str, float]:
    """Peak memory of this process and of the largest of its workers, MiB (Linux counts KiB)."""
    own, workers = (
        resource.getrusage(who).ru_maxrss / 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return {"command": own, "worker": workers}
