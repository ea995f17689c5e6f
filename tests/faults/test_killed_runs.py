"""Runs that are killed at random moments: nothing is lost or mixed, and resumed they end in the same bits."""

from __future__ import annotations

import random
import signal
import time

import pytest
from fixtures.runs_on_disk import RUNS, STARTS, bits, pendulum, started, turned_strip

from supple.error import correct_recorded
from supple.errors import ResultFileError
from supple.simulation import simulate
from supple.storage import read_header, read_solution

PLAIN = """
import sys
from fixtures.runs_on_disk import RUNS, pendulum
from supple.simulation import simulate
simulate(pendulum(), RUNS[sys.argv[2]], file=sys.argv[1], progress=print)
"""

CORRECTING = """
import sys
from fixtures.runs_on_disk import RUNS, STARTS, turned_strip
from supple.error import correct_recorded
correct_recorded(turned_strip(), RUNS["self-correcting"], STARTS, sys.argv[1], case="strip", progress=print)
"""


def kill_after(process, lines, pause):
    """Kill a program without warning, so many seconds after so many lines; the lines that it did print."""
    with process:
        seen = [process.stdout.readline() for _ in range(lines)]
        time.sleep(pause)
        process.send_signal(signal.SIGKILL)
        seen += process.stdout.readlines()
        error = process.stderr.read()
    assert all(seen), error
    return seen


@pytest.fixture(scope="module")
def uninterrupted():
    return {kind: bits(simulate(pendulum(), RUNS[kind])) for kind in ("fixed", "adaptive")}


def check_plain(path, kind, seed, whole):
    draw = random.Random(seed)
    reported = kill_after(started(PLAIN, path, kind), draw.randrange(1, 7), draw.uniform(0.0, 0.01))
    kept = read_solution(path)
    # Every leg that was reported is there, in the bits of the uninterrupted run.
    assert len(kept.times) >= round(float(reported[-1]) * len(RUNS[kind].times))
    for name, content in bits(kept).items():
        assert whole[name].startswith(content)
    assert bits(simulate(pendulum(), RUNS[kind], file=path)) == whole
    assert bits(read_solution(path)) == whole
    assert read_header(path).complete


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["fixed", "adaptive"])
def test_a_killed_run_is_continued_to_the_same_bits(tmp_path, kind, uninterrupted):
    check_plain(tmp_path / "run.h5", kind, 1, uninterrupted[kind])


@pytest.mark.slow
@pytest.mark.soak
@pytest.mark.parametrize("seed", range(2, 22))
@pytest.mark.parametrize("kind", ["fixed", "adaptive"])
def test_a_killed_run_is_continued_to_the_same_bits_at_many_moments(tmp_path, kind, seed, uninterrupted):
    check_plain(tmp_path / "run.h5", kind, seed, uninterrupted[kind])


@pytest.fixture(scope="module")
def corrected(tmp_path_factory):
    """Bits of an uninterrupted self-correction, and how often it reports."""
    reports = []
    path = tmp_path_factory.mktemp("whole") / "run.h5"
    found = correct_recorded(
        turned_strip(),
        RUNS["self-correcting"],
        STARTS,
        path,
        case="strip",
        progress=lambda *report: reports.append(report),
    )
    return bits(found.solution), len(reports)


def check_correcting(path, seed, whole, n_reports):
    draw = random.Random(seed)
    kill_after(started(CORRECTING, path), draw.randrange(1, n_reports), draw.uniform(0.0, 0.01))
    system, run = turned_strip(), RUNS["self-correcting"]
    with pytest.raises(ResultFileError, match=r"holds the rounds of an interrupted run|a finished run"):
        correct_recorded(system, run, STARTS, path, case="strip")
    if path.exists():  # killed behind its last line
        assert bits(read_solution(path)) == whole
        return
    again = correct_recorded(system, run, STARTS, path, case="strip", resume=True)
    assert bits(again.solution) == whole
    assert bits(read_solution(path)) == whole


@pytest.mark.slow
def test_a_killed_self_correction_goes_on_to_the_same_bits(tmp_path, corrected):
    check_correcting(tmp_path / "run.h5", 5, *corrected)


@pytest.mark.slow
@pytest.mark.soak
@pytest.mark.parametrize("seed", range(10, 30))
def test_a_killed_self_correction_goes_on_to_the_same_bits_at_many_moments(tmp_path, seed, corrected):
    check_correcting(tmp_path / "run.h5", seed, *corrected)
