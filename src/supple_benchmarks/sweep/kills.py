"""Kills of a running sweep: of a worker, of the command, and a truncated part; number of repeated cases."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

import numpy as np

from supple.other_processes import python_command, python_environment
from supple.storage.sealed_hdf5 import is_whole
from supple.sweeps import CaseTable, make_plan, read_sweep, read_sweep_file, sweep_status
from supple.sweeps.part_file import part_path
from supple.sweeps.plan import read_plan
from supple_benchmarks.sweep.certificate_once import plan_with_certificate

__all__ = ["killed_sweep"]

CASES_PER_SHARE = 16
_MOST_SECONDS = 600.0
"""s, longest time to wait for the command to begin or to finish its next share."""

_Found = TypeVar("_Found")
Stamp = tuple[int, int]
"""Inode number and modification time, which change when a file is replaced."""


def killed_sweep(case: Path, table: CaseTable, folder: Path, certified: Path) -> dict[str, int | list[str]]:
    """Run a sweep by its command, kill it in three ways, and count the repeated cases.

    The worker is killed during its first share, and the command continues. The command is killed with all its
    processes after two shares, one of which is then truncated. The same command computes the missing cases.

    certified : folder with the bodies and the certificate of the same cases

    Returns
    -------
    lost : cases without results, or with results that differ from those before the kill
    twice : cases that were simulated again although their part was complete
    """
    shutil.rmtree(folder, ignore_errors=True)
    file, results = _sweep_file(case, table, folder), folder / "results"
    given = read_sweep_file(file)
    plan_with_certificate(make_plan(given.case, given.table, given.output), results, certified)
    command = _started(file, results)
    try:
        worker = _awaited(command, lambda: _worker_of(results))
        os.kill(worker, signal.SIGKILL)
        _awaited(command, lambda: part_path(results, 1).exists())
    finally:
        os.killpg(command.pid, signal.SIGKILL)
        command.wait()
    cut = part_path(results, 0)
    first = read_sweep(results).statistics.values
    with cut.open("r+b") as part:
        part.truncate(cut.stat().st_size // 2)
    before = _stamps(results)
    rest = _started(file, results)
    if code := rest.wait(timeout=_MOST_SECONDS):
        raise RuntimeError(f"the command ended with code {code}")
    plan, after = read_plan(results), _stamps(results)
    found = read_sweep(results).statistics.values
    known = np.isfinite(first)
    lost = plan.n_cases - sweep_status(results).n_ran
    lost += int((known & (first != found)).any(axis=(1, 2)).sum())
    again = [share for share, stamp in before.items() if after.get(share) != stamp]
    return {
        "of": ["worker", "command", "part"],
        "cases": plan.n_cases,
        "lost": lost,
        "twice": sum(len(plan.cases_of(share)) for share in again),
    }


def _sweep_file(case: Path, table: CaseTable, folder: Path) -> Path:
    """The sweep file of a table, in the same folder."""
    folder.mkdir(parents=True)
    rows = [",".join(table.columns), *(_line(table.row(number).values()) for number in range(len(table)))]
    (folder / "cases.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    path = folder / "cases.toml"
    path.write_text(
        f'case = "{case.resolve()}"\ntable = "cases.csv"\n[output]\ncases_per_share = {CASES_PER_SHARE}\n',
        encoding="utf-8",
    )
    return path


def _line(values: Iterable[object]) -> str:
    return ",".join(map(repr, values))


def _started(file: Path, results: Path) -> subprocess.Popen[bytes]:
    """The command, with its processes in one process group."""
    words = ("-m", "supple", "sweep", str(file), "-o", str(results), "--workers", "1")
    return subprocess.Popen(
        python_command(*words),
        env=python_environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def _worker_of(results: Path) -> int | None:
    """Id of the process that computes a share, from the file that marks its attempt; None without a file."""
    marks = sorted((results / "attempts").glob("*.json"))
    return int(marks[0].stem.split("-")[-2]) if marks else None


def _awaited(command: subprocess.Popen[bytes], found: Callable[[], _Found | None]) -> _Found:
    """The first true result of `found`, called again and again while the command runs; else RuntimeError."""
    until = time.monotonic() + _MOST_SECONDS
    while not (own := found()):
        if command.poll() is not None or time.monotonic() > until:
            raise RuntimeError("the sweep ended before it could be killed: give more cases")
        time.sleep(0.01)
    return own


def _stamps(results: Path) -> dict[int, Stamp]:
    """Time stamps of the complete parts, by share."""
    plan = read_plan(results)
    paths = {share: part_path(results, share) for share in range(plan.n_shares)}
    whole = {share: path.stat() for share, path in paths.items() if is_whole(path)}
    return {share: (stat.st_ino, stat.st_mtime_ns) for share, stat in whole.items()}
