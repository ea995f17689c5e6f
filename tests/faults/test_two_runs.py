"""Two runs that want one file or one folder: one of them is refused, and nothing is mixed or lost."""

from __future__ import annotations

import errno
import signal

import pytest
from fixtures.bar_case import bar_case
from fixtures.runs_on_disk import RUNS, bits, pendulum, started

from supple.cases import read_case, run_case
from supple.error import CorrectionFolder
from supple.errors import ResultFileError, UnlockedWarning
from supple.simulation import simulate
from supple.storage import ResultFile, exclusive_lock, read_header, read_solution, write_solution
from supple.storage.exclusive_lock import ExclusiveLock

RUN = RUNS["fixed"]

# Waits in the middle of its run for a line; then says where its bar is at the end.
WAITING = """
import sys
from fixtures.runs_on_disk import RUNS, pendulum
from supple.simulation import simulate
waited = []
def wait(share):
    if share > 0.4 and not waited:
        print("half", flush=True)
        waited.append(sys.stdin.readline())
motion = simulate(pendulum(), RUNS["fixed"], file=sys.argv[1], progress=wait)
print(motion.bodies["bar"].rotation[-1, 0, 0].hex(), flush=True)
"""


@pytest.mark.slow
def test_the_second_run_is_refused_and_the_first_reports_its_own_motion(tmp_path):
    path, other = tmp_path / "run.h5", pendulum(mass=2.0)
    with started(WAITING, path) as first:
        assert first.stdout.readline() == "half\n", first.stderr.read()
        assert not read_header(path).complete  # anybody may read
        busy = rf"another run is writing it \(process {first.pid} on "
        with pytest.raises(ResultFileError, match=busy):
            simulate(other, RUN, file=path, overwrite=True)
        with pytest.raises(ResultFileError, match=busy):
            simulate(pendulum(), RUN, file=path)
        with pytest.raises(ResultFileError, match=busy):
            write_solution(path, simulate(other, RUN), case="other")
        printed, error = first.communicate("go on\n")
    expected = simulate(pendulum(), RUN)
    assert printed.strip() == expected.bodies["bar"].rotation[-1, 0, 0].hex(), error
    assert bits(read_solution(path)) == bits(expected)
    assert [each.name for each in tmp_path.iterdir()] == ["run.h5"]


@pytest.mark.slow
def test_a_lock_ends_with_the_process_that_holds_it(tmp_path):
    path = tmp_path / "run.h5"
    with started(WAITING, path) as first:
        assert first.stdout.readline() == "half\n", first.stderr.read()
        first.send_signal(signal.SIGKILL)
    assert (tmp_path / ".run.h5.lock").exists()
    assert bits(simulate(pendulum(), RUN, file=path)) == bits(simulate(pendulum(), RUN))
    assert not (tmp_path / ".run.h5.lock").exists()


def test_a_file_that_is_taken_away_is_noticed(tmp_path, make):
    path = tmp_path / "run.h5"
    with ResultFile.create(path, case="a") as file:
        file.append(make(0.0))
        write_solution(tmp_path / "other.h5", make(5.0), case="b").replace(path)
        with pytest.raises(ResultFileError, match="was removed or replaced during the run"):
            file.append(make(1.0))
        assert file.solution().times[0] == 0.0
    assert read_header(path).case == "b"


@pytest.fixture
def case(tmp_path):
    (tmp_path / "bar.toml").write_text(CASE)
    return read_case(tmp_path / "bar.toml")


CASE = bar_case(0.2, 0.05, 0.05)


def test_a_folder_takes_one_run_of_a_case_at_a_time(tmp_path, case):
    out = tmp_path / "out"
    out.mkdir()
    with ExclusiveLock(out), pytest.raises(ResultFileError, match="another run is writing it"):
        run_case(case, out)
    run_case(case, out)
    assert {each.name for each in out.iterdir()} == {"bar.h5", "bar.json"}


def test_a_finished_run_of_a_case_is_not_overwritten_unless_forced(tmp_path, case):
    out = tmp_path / "out"
    run_case(case, out)
    before = (out / "bar.h5").read_bytes()
    remedies = r"contains the finished run bar\.h5; --resume continues an interrupted run, --force replaces"
    with pytest.raises(ResultFileError, match=remedies):
        run_case(case, out)
    assert (out / "bar.h5").read_bytes() == before
    run_case(case, out, force=True)
    assert (out / "bar.h5").read_bytes() != before  # other seconds
    with pytest.raises(ResultFileError, match="its run is complete; --force runs it again"):
        run_case(case, out, resume=True)
    with pytest.raises(ResultFileError, match="there is no such file; run it without --resume"):
        run_case(case, tmp_path / "empty", resume=True)


def test_a_run_of_a_case_that_was_cut_off_is_not_overwritten_unless_forced(tmp_path, case):
    out = tmp_path / "out"
    out.mkdir()
    with ResultFile.create(out / "bar.h5", case=case.text, inputs=case.inputs) as file:
        file.append(simulate(case.system, case.run).at(slice(2)))
    with pytest.raises(ResultFileError, match=r"contains the interrupted run bar\.h5; --resume continues"):
        run_case(case, out)
    whole = run_case(case, out, resume=True).solution
    assert bits(whole).keys() == bits(simulate(case.system, case.run)).keys()
    assert read_header(out / "bar.h5").complete


def test_what_is_no_result_is_not_overwritten_either(tmp_path, case):
    (tmp_path / "bar.h5").write_text("the thesis")
    with pytest.raises(ResultFileError, match=r"a result that cannot be read .*not an HDF5 file"):
        run_case(case, tmp_path)
    with pytest.raises(ResultFileError, match="give overwrite=True to replace it"):
        ResultFile.create(tmp_path / "bar.h5", case="a")
    assert (tmp_path / "bar.h5").read_text() == "the thesis"


@pytest.mark.slow
def test_a_finished_run_of_a_file_is_replaced_where_that_is_said(tmp_path):
    path, other = tmp_path / "run.h5", pendulum(mass=2.0)
    simulate(pendulum(), RUN, file=path)
    with pytest.raises(ResultFileError, match=r"another run than .* set overwrite=True"):
        simulate(other, RUN, file=path)
    simulate(other, RUN, file=path, overwrite=True)
    assert bits(simulate(other, RUN, file=path)) == bits(simulate(other, RUN))


def test_rounds_that_are_being_written_are_not_removed(tmp_path):
    (tmp_path / "round-0.h5").touch()
    with (
        ExclusiveLock(tmp_path / "round-0.h5"),
        pytest.raises(ResultFileError, match=r"round-0\.h5: another run is writing it"),
    ):
        CorrectionFolder.create(tmp_path, case="a")
    assert (tmp_path / "round-0.h5").exists()


def test_a_file_system_without_locks_earns_a_warning(tmp_path, make, monkeypatch):
    def no_locks(_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(exclusive_lock, "_lock", no_locks)
    with pytest.warns(UnlockedWarning, match=r"run\.h5 has no locks: make sure"):
        write_solution(tmp_path / "run.h5", make(), case="a")
    assert read_header(tmp_path / "run.h5").complete


def test_a_run_that_was_stopped_has_no_report_of_the_one_before(tmp_path, case):
    def stop(*_):
        raise KeyboardInterrupt

    run_case(case, tmp_path / "out")
    assert (tmp_path / "out" / "bar.json").exists()
    with pytest.raises(KeyboardInterrupt):
        run_case(case, tmp_path / "out", force=True, progress=stop)
    assert not (tmp_path / "out" / "bar.json").exists()
