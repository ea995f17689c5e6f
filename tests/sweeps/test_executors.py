"""The same digits wherever a sweep runs: processes, job arrays, a Dask cluster."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.swept_pendulum import TABLE

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
