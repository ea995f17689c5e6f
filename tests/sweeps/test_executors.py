"""The same digits wherever a sweep runs: processes, job arrays, a Dask cluster, MPI."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from threading import Thread

import numpy as np
import pytest
from fixtures.swept_pendulum import TABLE

from supple.other_processes import python_environment
from supple.sweeps import (
    Cluster,
    LocalProcesses,
    make_plan,
    plan_sweep,
    read_sweep,
    run_part_of_sweep,
    run_sweep,
    sweep_status,
)
from supple.sweeps.sweep_file import SweepOutput

pytestmark = pytest.mark.slow


@pytest.fixture
def plan(pendulum):
    """Six cases in three shares."""
    return make_plan(pendulum, TABLE, SweepOutput.model_validate({"cases_per_share": 2}))


@pytest.fixture
def here(plan, tmp_path):
    """What they come to in this process."""
    plan_sweep(plan, tmp_path / "here")
    run_part_of_sweep(tmp_path / "here", 2, 2)
    assert sweep_status(tmp_path / "here").missing == (0, 2), "each job has its own shares"
    run_part_of_sweep(tmp_path / "here", 1, 2)
    assert sweep_status(tmp_path / "here").exit_code == 0
    return read_sweep(tmp_path / "here").statistics.values


def test_processes_find_the_same_digits(plan, here, tmp_path):
    plan_sweep(plan, tmp_path / "out")
    fractions = []
    assert run_sweep(tmp_path / "out", LocalProcesses(2), fractions.append).n_ran == 6
    assert np.array_equal(read_sweep(tmp_path / "out").statistics.values, here)
    assert fractions[0] == 0.0
    assert fractions[-1] == 1.0


def test_a_dask_cluster_finds_the_same_digits(plan, here, tmp_path):
    distributed = pytest.importorskip("distributed")
    plan_sweep(plan, tmp_path / "out")
    with distributed.LocalCluster(1, threads_per_worker=1, dashboard_address=None) as cluster:
        assert run_sweep(tmp_path / "out", Cluster(cluster.scheduler_address)).n_ran == 6
    assert np.array_equal(read_sweep(tmp_path / "out").statistics.values, here)


def test_a_dask_worker_that_is_killed_costs_nothing(plan, here, tmp_path):
    """Its mark names it; Dask starts another one, which does its share."""
    distributed = pytest.importorskip("distributed")
    folder = tmp_path / "out"
    plan_sweep(plan, folder)
    killed = []

    def kill_first_worker():
        until = time.monotonic() + 600
        while time.monotonic() < until and not killed:
            for mark in (folder / "attempts").glob("*.json"):
                killed.append(int(mark.stem.split("-")[-2]))
                os.kill(killed[0], signal.SIGKILL)
                break
            time.sleep(0.01)

    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster:
        Thread(target=kill_first_worker, daemon=True).start()
        assert run_sweep(folder, Cluster(cluster.scheduler_address)).n_ran == 6
    assert killed
    assert np.array_equal(read_sweep(folder).statistics.values, here)


def test_processes_of_mpi_find_the_same_digits(pendulum, plan, here, tmp_path):
    """The command by `mpiexec`, with two workers."""
    mpiexec = shutil.which("mpiexec")
    if mpiexec is None or find_spec("mpi4py") is None:
        pytest.skip("mpiexec or mpi4py is not installed")
    columns = TABLE.columns
    rows = [",".join(columns), *(",".join(map(str, TABLE.row(i).values())) for i in range(len(TABLE)))]
    (tmp_path / "cases.csv").write_text("\n".join(rows) + "\n")
    file = tmp_path / "cases.toml"
    file.write_text(f'case = "{pendulum.name}"\ntable = "cases.csv"\n[output]\ncases_per_share = 2\n')
    command = [mpiexec, "--oversubscribe", "-n", "3", sys.executable, "-m", "mpi4py.futures", "-m", "supple"]
    done = subprocess.run(
        [*command, "sweep", file, "-o", tmp_path / "out", "--mpi"],
        env=python_environment(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1"),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert np.array_equal(read_sweep(tmp_path / "out").statistics.values, here)
