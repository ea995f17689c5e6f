"""A million explicit steps, killed and gone on with again, end in the bits of a run that was left alone."""

from __future__ import annotations

import random
import signal
from typing import Any

import numpy as np
import pytest
from fixtures.runs_on_disk import bits, started

from supple.storage import read_header, read_solution

STEPS = 1_000_000
MARCH = """
from fixtures.explicit_bars import explicit_bar
from supple.integrate import FixedStep, Run
from supple.machine import Placed, System
from supple.mesh import CellType
from supple.simulation import simulate


def marched(path, progress=None):
    '''One cell that turns and breathes.'''
    cell = Placed(explicit_bar(CellType.HEXA8, counts=(1, 1, 1)), angular_velocity=(0.02, 0.01, 0.05))
    run = Run(10_000.0, 100.0, FixedStep(0.01))
    return simulate(System([cell]), run, file=path, progress=progress)
"""
KILLED = MARCH + "import sys; marched(sys.argv[1], print)"


@pytest.mark.slow
@pytest.mark.soak
def test_a_million_steps_are_killed_and_resumed_to_the_same_bits(tmp_path):
    names: dict[str, Any] = {}
    exec(MARCH, names)
    whole = names["marched"](tmp_path / "whole.h5")
    path, draw = tmp_path / "killed.h5", random.Random(7)
    for _ in range(3):
        process = started(KILLED, path)
        with process:
            seen = [process.stdout.readline() for _ in range(draw.randrange(2, 12))]
            process.send_signal(signal.SIGKILL)
            error = process.stderr.read()
        assert all(seen), error
    assert not read_header(path).complete
    resumed = names["marched"](path)
    assert whole.statistics.steps == STEPS
    assert bits(resumed) == bits(whole) == bits(read_solution(path))
    e = whole.series["energies"]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert np.abs(total / total[0] - 1).max() < 1e-6
