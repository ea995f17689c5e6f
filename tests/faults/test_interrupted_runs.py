"""Runs stopped by Ctrl-C or by the system: they say what is kept, and exit as shells expect."""

from __future__ import annotations

import re
import signal
import time

import pytest
from fixtures.bar_case import bar_case
from fixtures.runs_on_disk import started
from fixtures.strip_case import CASE as STRIP

from supple.errors import ResultFileError
from supple.simulation.interruption import Terminated, raising_terminated
from supple.storage import read_header

COMMAND = "from supple.cli.main import main; main()"

SCRIPT = """
import sys
from supple.integrate import FixedStep, Run
from fixtures.runs_on_disk import pendulum
from supple.simulation import simulate
simulate(pendulum(), Run(100.0, 0.1, step=FixedStep(1e-4)), file=sys.argv[1])
"""

LONG = bar_case(100.0, 0.1, 1e-4)


def stopped(process, path, number, outputs=2):
    """Exit code and error output of a program that gets a signal once so many output times are on disk."""
    with process:
        try:
            while process.poll() is None and _outputs_in(path) < outputs:
                time.sleep(0.02)
            process.send_signal(number)
            printed = process.communicate(timeout=120)
        finally:
            process.kill()
    return process.returncode, re.sub(r"\s+", " ", "".join(printed))


def _outputs_in(path):
    try:
        return read_header(path).n_times
    except ResultFileError:
        return 0


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_command_says_what_it_keeps_and_can_be_resumed(tmp_path, number, code):
    (tmp_path / "bar.toml").write_text(LONG)
    path = tmp_path / "out" / "bar.h5"
    process = started(COMMAND, "run", tmp_path / "bar.toml", "-o", path.parent)
    found, printed = stopped(process, path, number)
    assert found == code, printed
    header = read_header(path)
    assert not header.complete
    last = 0.1 * (header.n_times - 1)
    assert f"stopped: the run up to t = {last:g} is stored in {path}; the same call continues it" in printed
    assert "with --resume" in printed
    assert "Traceback" not in printed
    assert [each.name for each in path.parent.iterdir()] == ["bar.h5"]


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, -signal.SIGINT), (signal.SIGTERM, 143)])
def test_a_script_says_what_it_keeps(tmp_path, number, code):
    path = tmp_path / "run.h5"
    found, printed = stopped(started(SCRIPT, path), path, number)
    assert found == code, printed
    assert f"the run up to t = {0.1 * (read_header(path).n_times - 1):g} is stored in {path}" in printed


@pytest.mark.slow
def test_a_self_correction_says_what_it_keeps(tmp_path):
    from fixtures.abaqus_text import abaqus_text

    from supple.mesh import strip

    (tmp_path / "strip.inp").write_text(abaqus_text(strip(1.0, 0.1, 8, 2)))
    (tmp_path / "strip.toml").write_text(re.sub(r"reduction = .*\n", "", STRIP).replace("0.4", "4.0"))
    path = tmp_path / "out" / "self_correction" / "round-0.h5"
    process = started(COMMAND, "run", tmp_path / "strip.toml", "-o", tmp_path / "out")
    found, printed = stopped(process, path, signal.SIGTERM)
    assert found == 143, printed
    assert f"is stored in {path}" in printed
    assert "with --resume" in printed


@pytest.mark.parametrize(
    ("number", "expected"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)]
)
def test_a_signal_that_arrives_while_an_object_is_cleared_away_is_not_lost(number, expected):
    """Python prints what is raised there and goes on; the run would never hear of it."""

    class Cleared:
        def __del__(self):
            signal.raise_signal(number)

    def swallowed():
        Cleared()
        for _ in range(300):
            time.sleep(0.01)

    # A shell that starts programs in the background has them ignore SIGINT.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(expected), raising_terminated():
            swallowed()
    finally:
        signal.signal(signal.SIGINT, before)
