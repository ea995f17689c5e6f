"""Real kills: of a worker, of the command, of whatever meets a case; nothing is lost or done again."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest
from fixtures.swept_pendulum import CASE

from supple.other_processes import python_environment
from supple.sweeps import read_sweep, run_sweep, sweep_status
from supple.sweeps.executors import LocalProcesses
from supple.sweeps.part_file import CaseStatus, part_path

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="signals"),
]

DEADLY = textwrap.dedent(
    """
    import importlib.util, os, pathlib, signal, sys

    class Finder:
        def find_spec(self, name, path=None, target=None):
            if name != "supple.sweeps.swept_group":
                return None
            sys.meta_path.remove(self)
            spec = importlib.util.find_spec(name)
            execute = spec.loader.exec_module

            def exec_module(module):
                execute(module)
                build = module.SweptGroup.case

                def case(group, number):
                    once = pathlib.Path(os.environ["DEADLY_ONCE"])
                    if str(number) in os.environ["DEADLY"].split(",") and not once.exists():
                        if once.name != "never":
                            once.touch()
                        os.kill(os.getpid(), signal.SIGKILL)
                    return build(group, number)

                module.SweptGroup.case = case

            spec.loader.exec_module = exec_module
            return spec

    sys.meta_path.insert(0, Finder())
    """
)
"""Of every process: some cases end it as they are built, always or once."""


@pytest.fixture
def sweep_file(tmp_path):
    """A sweep of eight cases, two a share."""
    (tmp_path / "pendulum.toml").write_text(CASE)
    (tmp_path / "cases.toml").write_text(
        'case = "pendulum.toml"\n[vary]\n"gravity[2]" = { from = -9.0, to = -2.0, number = 8 }\n'
        "[output]\ncases_per_share = 2\n"
    )
    (tmp_path / "hook").mkdir()
    (tmp_path / "hook" / "sitecustomize.py").write_text(DEADLY)
    return tmp_path / "cases.toml"


def started(sweep_file, *, deadly="", once="never"):
    """The command, running."""
    folder = sweep_file.parent
    environment = python_environment(DEADLY=deadly, DEADLY_ONCE=str(folder / once))
    environment["PYTHONPATH"] = os.pathsep.join([str(folder / "hook"), environment["PYTHONPATH"]])
    script = "from supple.cli.main import main\nif __name__ == '__main__':\n    main()\n"
    (folder / "command.py").write_text(script)
    command = [sys.executable, str(folder / "command.py"), "sweep", str(sweep_file)]
    return subprocess.Popen(
        [*command, "-o", str(folder / "out"), "--workers", "1"],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def finished(process, code):
    output, _ = process.communicate(timeout=600)
    assert process.returncode == code, output
    return output


def test_a_case_that_kills_every_process_is_found_and_recorded(sweep_file):
    output = finished(started(sweep_file, deadly="3"), 3)
    assert "7 ran, 0 failed, 1 killed their process, 0 to do" in output
    status = sweep_status(sweep_file.parent / "out")
    (found,) = status.failed
    assert (found.case, found.status) == (3, CaseStatus.KILLED)
    assert "signal 9 (SIGKILL)" in found.cause
    assert np.isfinite(read_sweep(sweep_file.parent / "out").statistics.values[[0, 1, 2, 4, 5, 6, 7]]).all()
    assert not list((sweep_file.parent / "out" / "attempts").iterdir())


def test_a_worker_that_is_killed_once_costs_nothing(sweep_file):
    assert "8 ran" in finished(started(sweep_file, deadly="2", once="flag"), 0)
    assert sweep_status(sweep_file.parent / "out").n_ran == 8


def test_the_command_is_killed_and_goes_on(sweep_file):
    folder = sweep_file.parent / "out"
    process = started(sweep_file)
    waited = time.monotonic() + 600
    while not part_path(folder, 0).exists():
        assert time.monotonic() < waited
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    done = {path: path.stat().st_mtime_ns for path in (folder / "parts").glob("0*.h5")}
    finished(started(sweep_file), 0)
    assert {path: path.stat().st_mtime_ns for path in done} == done, "what was done stands"
    assert sweep_status(folder).n_ran == 8


def test_workers_end_with_the_command(sweep_file):
    """Killed alone, the command leaves no process behind that goes on working."""
    process = started(sweep_file, deadly="7", once="flag")
    folder = sweep_file.parent / "out"
    waited = time.monotonic() + 600
    while not (marks := list((folder / "attempts").glob("*.json"))):
        assert time.monotonic() < waited
        time.sleep(0.02)
    worker = int(marks[0].stem.split("-")[-2])
    json.loads(marks[0].read_text() or "{}")
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    while is_alive(worker):
        assert time.monotonic() < waited
        time.sleep(0.05)
    # What it had not done, the next one does.
    assert run_sweep(folder, LocalProcesses(1)).n_ran == 8


def is_alive(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    status = Path(f"/proc/{number}/status")
    return not status.exists() or "zombie" not in status.read_text()
