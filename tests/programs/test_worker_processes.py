"""Other cores do what one would have done, in whatever order; what they leave undone is done all the same."""

import os
import signal
import subprocess
import threading

import jax
import numpy as np
import pytest

from supple.algebra.rotation import rotation_exp
from supple.programs import worker_processes
from supple.programs.program_cache import CachedProgram
from supple.programs.worker_processes import on_all_cores


@pytest.fixture
def program(kept):
    return CachedProgram(rotation_exp)


@pytest.fixture
def started(monkeypatch):
    """Two cores, for which any work is worth it; the processes that were started."""
    seen = []
    popen = subprocess.Popen

    def noted(*words, **options):
        seen.append(popen(*words, **options))
        return seen[-1]

    monkeypatch.setattr(worker_processes.subprocess, "Popen", noted)
    monkeypatch.setattr(worker_processes, "available_cores", lambda: 2)
    monkeypatch.setattr(worker_processes, "_WORTH", 1e-9)
    return seen


def vector(number):
    return np.array([0.1 * number, 0.2, -0.3])


def tasks_of(n, began, started=()):
    """Tasks that note who began them; after the first one, this process waits until one started has one."""
    other = threading.Event()

    def task(number):
        began.append((number, threading.current_thread()))
        if threading.current_thread() is not threading.main_thread():
            other.set()
        elif started and len(began) > 1:
            assert other.wait(60)
        return (vector(number),)

    return [lambda number=number: task(number) for number in range(n)]


def assert_right(finished, n):
    assert sorted(each.number for each in finished) == list(range(n))
    for each in finished:
        np.testing.assert_array_equal(each.result, jax.jit(rotation_exp)(vector(each.number)))


@pytest.mark.slow
def test_another_process_takes_its_share(program, started):
    began = []
    assert_right(list(on_all_cores(program, tasks_of(30, began, started))), 30)
    assert len(started) == 1
    assert started[0].poll() is not None
    assert len({thread for _, thread in began}) == 2


@pytest.mark.slow
def test_what_a_killed_process_leaves_is_done_here(program, started):
    began = []
    finished = []
    for each in on_all_cores(program, tasks_of(40, began, started)):
        finished.append(each)
        if any(thread is not threading.main_thread() for _, thread in began) and started[0].poll() is None:
            os.kill(started[0].pid, signal.SIGKILL)
    assert_right(finished, 40)
    assert started[0].returncode == -signal.SIGKILL


@pytest.mark.slow
def test_who_asks_no_more_ends_them(program, started):
    turns = on_all_cores(program, tasks_of(30, [], started))
    next(turns), next(turns)
    turns.close()
    assert [process.poll() is not None for process in started] == [True]


def test_an_error_of_a_task_is_told(program, started):
    def wrong():
        raise ValueError("no such table")

    with pytest.raises(ValueError, match="no such table"):
        list(on_all_cores(program, [*tasks_of(2, []), wrong]))
    assert all(process.poll() is not None for process in started)


def test_short_work_is_done_here(program, started, monkeypatch):
    monkeypatch.setattr(worker_processes, "_WORTH", 3.0)
    assert_right(list(on_all_cores(program, tasks_of(3, []))), 3)
    assert not started


def test_programs_that_are_not_kept_run_here(program, started):
    jax.config.update("jax_enable_compilation_cache", False)
    assert_right(list(on_all_cores(program, tasks_of(3, []))), 3)
    assert not started


def test_no_task_is_no_work(program):
    assert list(on_all_cores(program, [])) == []


def test_where_no_process_can_be_started_one_does_all(program, started, monkeypatch):
    def refused(*words, **options):
        raise OSError("no more processes")

    monkeypatch.setattr(worker_processes.subprocess, "Popen", refused)
    assert_right(list(on_all_cores(program, tasks_of(3, []))), 3)
