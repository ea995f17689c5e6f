"""A fork after a simulation: the child says what is wrong instead of waiting for ever."""

from __future__ import annotations

import subprocess
import sys

import pytest

SCRIPT = """
import multiprocessing, sys
import numpy as np
import supple as sp

ball = sp.RigidBody("ball", 1.0, [0, 0, 0], np.eye(3))
system, run = sp.System([ball], gravity=(0, 0, -9.81)), sp.Run(0.1, 0.05)

def height(_):
    try:
        return f"{sp.simulate(system, run).bodies['ball'].position[-1, 2]:.4f}"
    except sp.errors.SuppleError as error:
        return f"{type(error).__name__}: {error}"

if __name__ == "__main__":
    if sys.argv[1] == "after":
        height(0)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        print(pool.map(height, [0])[0])
"""


def printed(tmp_path, when):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    command = [sys.executable, "-W", "ignore", str(script), when]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    return done.stdout.strip()


@pytest.mark.slow
def test_a_child_forked_after_a_run_refuses(tmp_path):
    assert printed(tmp_path, "after").startswith("ForkedProcessError: this process was forked")


@pytest.mark.slow
def test_a_child_forked_before_it_computes(tmp_path):
    assert printed(tmp_path, "before") == "-0.0491"
