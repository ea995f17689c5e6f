"""A disk that fills up within a sweep: what is written stands, the rest follows once there is room."""

from __future__ import annotations

import os
import shutil
import subprocess

import numpy as np
import pytest
from fixtures.swept_pendulum import TABLE
from sweeps.test_sweep import Here

from supple.errors import ResultFileError
from supple.sweeps import Given, make_plan, plan_sweep, read_sweep, run_sweep, sweep_status
from supple.sweeps.sweep_file import SweepOutput

ROOM_LEFT = 2**13


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 4 MiB of its own."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = shutil.which("mount")
    made = mount and subprocess.run(
        [mount, "-t", "tmpfs", "-o", "size=4m", "tmpfs", place], capture_output=True, check=False
    )
    if not made or made.returncode:
        pytest.skip("no file system can be mounted here")
    yield place
    subprocess.run(["umount", place], check=True)


class FillsUp(Here):
    """The disk is full once a share is done."""

    def __init__(self, place):
        super().__init__()
        self._place = place

    def submit(self, task, *arguments):
        done = super().submit(task, *arguments)
        if self.tasks == 1:
            free = os.statvfs(self._place)
            (self._place / "ballast").write_bytes(bytes(free.f_bavail * free.f_frsize - ROOM_LEFT))
        return done


def test_a_full_disk_costs_nothing_that_was_done(pendulum, small_disk, tmp_path):
    # Motions are kept: a part is larger than the room that is left.
    plan = make_plan(pendulum, TABLE, SweepOutput.model_validate({"keep": "all", "cases_per_share": 2}))
    whole, folder = tmp_path / "whole", small_disk / "out"
    for place in (whole, folder):
        plan_sweep(plan, place)
    run_sweep(whole, Given(Here()))
    with pytest.raises(ResultFileError, match=r"cannot write .*the disk is full: free some space"):
        run_sweep(folder, Given(FillsUp(small_disk)))
    status = sweep_status(folder)
    assert (status.missing, status.begun, status.n_ran) == ((1, 2), (), 2)
    (small_disk / "ballast").unlink()
    again = Here()
    assert run_sweep(folder, Given(again)).n_ran == 6
    assert again.tasks == 2
    assert np.array_equal(read_sweep(folder).statistics.values, read_sweep(whole).statistics.values)
    assert not list((folder / "parts").glob(".*")), "no half of a file is left"
