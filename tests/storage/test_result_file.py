"""Result files: bit-equal round trips, killed and continued runs, and every message."""

import errno
import os
import resource
import shutil
import signal
import subprocess
import sys
import textwrap
from dataclasses import fields, replace
from functools import partial
from pathlib import Path

import h5py
import numpy as np
import pytest

from supple.errors import ResultFileError
from supple.integrate.motion import FloatingMotion
from supple.integrate.solution import Statistics, concatenate
from supple.storage.result_file import ResultFile, write_solution
from supple.storage.result_reader import read_header, read_last_instant, read_solution

CASE = "title = 'two bodies'\nspeed = 6.0\n"


def assert_bit_equal(left, right):
    assert left.times.tobytes() == right.times.tobytes()
    assert left.bodies.keys() == right.bodies.keys()
    for name in left.bodies:
        for field in fields(FloatingMotion):
            one, other = getattr(left.bodies[name], field.name), getattr(right.bodies[name], field.name)
            assert one.shape == other.shape
            assert one.tobytes() == other.tobytes()
    assert left.joint_forces.keys() == right.joint_forces.keys()
    for name in left.joint_forces:
        assert left.joint_forces[name].shape == right.joint_forces[name].shape
        assert left.joint_forces[name].tobytes() == right.joint_forces[name].tobytes()
    assert left.statistics == right.statistics


def test_single_shot_round_trip_is_bit_equal(tmp_path, solution):
    odd = replace(solution, joint_forces={**solution.joint_forces, "odd": np.full((7, 2), -0.0)})
    odd.joint_forces["odd"][0] = np.nan, 5e-324
    path = write_solution(tmp_path / "run.h5", odd, case=CASE, metadata={"version": "0.1", "seed": 3})
    assert_bit_equal(read_solution(path), odd)
    header = read_header(path)
    assert header.case == CASE
    assert header.metadata == {"version": "0.1", "seed": 3}
    assert header.complete
    assert header.n_times == 7


def test_chunks_join_to_the_whole_run(tmp_path, make):
    chunks = [make(0.0, 7, 1), make(1.0, 1, 2), make(2.0, 300, 3)]
    with ResultFile.create(tmp_path / "run.h5", case=CASE) as file:
        for chunk in chunks:
            file.append(chunk)
        assert file.last_time == chunks[-1].times[-1]
        file.finish()
    assert_bit_equal(read_solution(tmp_path / "run.h5"), concatenate(chunks))
    assert read_header(tmp_path / "run.h5").complete


@pytest.mark.slow
def test_a_running_file_can_be_read_by_others(tmp_path, make):
    path = tmp_path / "run.h5"
    with ResultFile.create(path, case=CASE) as file:
        file.append(make(0.0))
        file.append(make(1.0))
        reader = "import sys; from supple.storage import read_header, read_solution as read\n"
        reader += "h = read_header(sys.argv[1]); print(h.n_times, h.complete, read(sys.argv[1]).times[-1])"
        seen = subprocess.run(
            [sys.executable, "-c", reader, path], capture_output=True, text=True, check=True
        )
    assert seen.stdout.split() == ["14", "False", "1.6"]


def test_last_instant_is_the_last_row(tmp_path, make):
    path = write_solution(tmp_path / "run.h5", make(0.0, 9), case=CASE)
    last = read_last_instant(path)
    np.testing.assert_array_equal(last.times, make(0.0, 9).times[-1:])
    np.testing.assert_array_equal(last.bodies["hub"].rotation, make(0.0, 9).bodies["hub"].rotation[-1:])


KILLED_RUN = """
import sys
sys.path.insert(0, sys.argv[2])
from dataclasses import replace
import numpy as np
from fixtures.made_up_solutions import make_solution
from supple.storage.result_file import ResultFile
file = ResultFile.create(sys.argv[1], case={case!r})
for i in range(10**6):
    state = {{"own": np.full(int(sys.argv[3]), float(i))}} if sys.argv[3:] else {{}}
    file.append(replace(make_solution(float(i), 7, i), engine_state=state))
    print(i, flush=True)
"""


@pytest.fixture
def killed_run(tmp_path):
    """A file whose writer was killed without warning, and how many chunks it had reported written."""
    path = tmp_path / "killed.h5"
    script = textwrap.dedent(KILLED_RUN).format(case=CASE)
    here = str(Path(__file__).parents[1])
    with subprocess.Popen(
        [sys.executable, "-c", script, path, here], stdout=subprocess.PIPE, text=True
    ) as run:
        reported = 0
        while reported < 5:
            reported = int(run.stdout.readline()) + 1
        run.send_signal(signal.SIGKILL)
        reported += len(run.stdout.readlines())
    assert run.returncode == -signal.SIGKILL
    return path, reported


@pytest.mark.slow
def test_a_killed_run_keeps_every_chunk(killed_run, make):
    path, reported = killed_run
    header, kept = read_header(path), read_solution(path)
    assert not header.complete
    # The kill may fall between the writing of a chunk and its report.
    n_chunks = header.n_times // 7
    assert n_chunks in {reported, reported + 1}
    assert_bit_equal(kept, concatenate([make(float(i), 7, i) for i in range(n_chunks)]))


@pytest.mark.slow
def test_a_killed_run_can_be_continued(killed_run, make):
    path, _ = killed_run
    kept = read_solution(path)
    with ResultFile.resume(path, case=CASE) as file:
        assert file.last_time == kept.times[-1]
        more = make(1e6, 7, 1)
        file.append(more)
        file.finish()
    assert_bit_equal(read_solution(path), concatenate([kept, more]))


def test_a_run_cut_off_before_its_first_output_can_be_continued(tmp_path, make):
    path = tmp_path / "run.h5"
    ResultFile.create(path, case=CASE).close()
    with pytest.raises(ResultFileError, match="ended before the first"):
        read_solution(path)
    with ResultFile.resume(path, case=CASE) as file:
        file.append(make())
        file.finish()
    assert_bit_equal(read_solution(path), make())


def test_a_run_without_output_can_finish(tmp_path):
    with ResultFile.create(tmp_path / "run.h5", case=CASE) as file:
        file.finish()
    assert read_header(tmp_path / "run.h5").complete


def test_a_closed_file_keeps_its_run(tmp_path, make):
    path = tmp_path / "run.h5"
    with ResultFile.create(path, case=CASE) as file:
        file.append(make())
    for act in (file.finish, file.solution):
        with pytest.raises(ResultFileError, match=r"it is closed; continue it with ResultFile\.resume"):
            act()
    assert_bit_equal(read_solution(path), make())


def test_an_exception_leaves_an_incomplete_readable_file(tmp_path, make):
    def crash():
        with ResultFile.create(tmp_path / "run.h5", case=CASE) as file:
            file.append(make())
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        crash()
    assert not read_header(tmp_path / "run.h5").complete
    assert_bit_equal(read_solution(tmp_path / "run.h5"), make())


def test_only_the_same_unfinished_case_is_continued(tmp_path, make):
    path = tmp_path / "run.h5"
    with ResultFile.create(path, case=CASE) as file:
        file.append(make())
    with pytest.raises(
        ResultFileError, match=r"another case \(line 2: 'speed = 6.0' in the file, 'speed = 8.0' now\)"
    ):
        ResultFile.resume(path, case=CASE.replace("6.0", "8.0"))
    with pytest.raises(ResultFileError, match="they differ in line ends"):
        ResultFile.resume(path, case=CASE.replace("\n", "\r\n"))
    write_solution(path, make(), case=CASE)
    with pytest.raises(ResultFileError, match="its run is complete"):
        ResultFile.resume(path, case=CASE)


def test_chunks_must_follow_one_another(tmp_path, make):
    with ResultFile.create(tmp_path / "run.h5", case=CASE) as file:
        file.append(make(0.0))
        with pytest.raises(
            ResultFileError, match=r"times end at 0\.6 and the new ones \(0\.6 to 1\.2\) do not increase"
        ):
            file.append(make(0.6))
        with pytest.raises(ResultFileError, match=r"the new ones \(none\)"):
            file.append(make(2.0, 0))
        with pytest.raises(ResultFileError, match=r"joint_forces/free has row shape None, but \(0,\) in the"):
            file.append(replace(make(2.0), joint_forces={"ball": np.zeros((7, 3))}))
        with pytest.raises(ResultFileError, match="joint_forces/ball has 6 rows for 7 times"):
            file.append(replace(make(2.0), joint_forces={"ball": np.zeros((6, 3)), "free": np.zeros((7, 0))}))
        file.finish()
        with pytest.raises(ResultFileError, match="it is closed"):
            file.append(make(3.0))


def failing(number):
    def fail(*_, **__):
        raise OSError(number, os.strerror(number))

    return fail


def test_full_disk_keeps_the_run_and_names_the_remedy(tmp_path, make, monkeypatch):
    path = tmp_path / "run.h5"
    with ResultFile.create(path, case=CASE) as file:
        file.append(make(0.0))
        monkeypatch.setattr(os, "posix_fallocate", failing(errno.ENOSPC))
        with pytest.raises(
            ResultFileError, match=r"disk is full: free some space .*up to t = 0\.6 is stored"
        ):
            file.append(make(1.0))
    monkeypatch.undo()
    assert_bit_equal(read_solution(path), make(0.0))
    with ResultFile.resume(path, case=CASE) as again:
        again.append(make(1.0))
        again.finish()
    assert_bit_equal(read_solution(path), concatenate([make(0.0), make(1.0)]))


def test_where_space_cannot_be_reserved_it_is_compared(tmp_path, make, monkeypatch):
    monkeypatch.setattr(sys, "platform", "darwin")
    with ResultFile.create(tmp_path / "run.h5", case=CASE) as file:
        file.append(make(0.0))
        file.append(make(1.0))
        monkeypatch.setattr(shutil, "disk_usage", lambda _: shutil._ntuple_diskusage(10**6, 10**6 - 100, 100))
        with pytest.raises(ResultFileError, match="disk is full"):
            file.append(make(2.0))


def test_a_failure_inside_hdf5_is_named_and_the_chunk_can_be_written_again(tmp_path, make, monkeypatch):
    # HDF5 puts the number into its message; the half-written chunk does not count.
    text = (
        f"Can't write data (file write failed: errno = {errno.EDQUOT}, error message = 'Disk quota exceeded')"
    )

    def fail(*_):
        raise RuntimeError(text)

    with ResultFile.create(tmp_path / "run.h5", case=CASE) as file:
        file.append(make(0.0))
        with monkeypatch.context() as patch:
            patch.setattr(h5py.Dataset, "__setitem__", fail)
            with pytest.raises(ResultFileError, match="disk quota is used up"):
                file.append(make(1.0))
        file.append(make(1.0))
        file.finish()
    assert_bit_equal(read_solution(tmp_path / "run.h5"), concatenate([make(0.0), make(1.0)]))


def test_full_disk_leaves_the_old_file_of_a_single_shot(tmp_path, make, monkeypatch):
    path = write_solution(tmp_path / "run.h5", make(), case=CASE)
    monkeypatch.setattr(Path, "write_bytes", failing(errno.EDQUOT))
    with pytest.raises(ResultFileError, match="disk quota is used up"):
        write_solution(path, make(5.0), case=CASE)
    assert_bit_equal(read_solution(path), make())
    assert list(tmp_path.iterdir()) == [path]


def limit_file_size(limit):
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))


@pytest.mark.slow
@pytest.mark.parametrize(("n_state", "limit"), [(0, 2_000_000), (500_000, 20_000_000)])
def test_a_real_failing_write_keeps_what_was_written(tmp_path, n_state, limit):
    # The operating system itself refuses to let the file grow, in the middle of a run. An explicit run has a
    # large state.
    path = tmp_path / "run.h5"
    script = textwrap.dedent(KILLED_RUN).format(case=CASE)
    here = str(Path(__file__).parents[1])
    run = subprocess.run(
        [sys.executable, "-B", "-c", script, path, here, str(n_state)],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=partial(limit_file_size, limit),
    )
    assert "ResultFileError" in run.stderr
    assert "the file has reached the size limit" in run.stderr
    assert read_header(path).n_times == 7 * len(run.stdout.split())
    assert read_solution(path).times[-1] == pytest.approx(len(run.stdout.split()) - 1 + 0.6)


def test_missing_foreign_and_truncated_files(tmp_path, solution):
    with pytest.raises(ResultFileError, match="no such file; check the path"):
        read_solution(tmp_path / "none.h5")
    (tmp_path / "notes.txt").write_text("not a result")
    with pytest.raises(ResultFileError, match="not an HDF5 file"):
        read_solution(tmp_path / "notes.txt")
    with h5py.File(tmp_path / "foreign.h5", "w") as file:
        file["x"] = 1.0
    with pytest.raises(ResultFileError, match="not a result of supple"):
        read_solution(tmp_path / "foreign.h5")
    path = write_solution(tmp_path / "run.h5", solution, case=CASE)
    os.truncate(path, path.stat().st_size // 2)
    with pytest.raises(ResultFileError, match="truncated"):
        read_solution(path)


def test_another_version_is_refused(tmp_path, solution):
    path = write_solution(tmp_path / "run.h5", solution, case=CASE)
    with h5py.File(path, "r+") as file:
        file.attrs["version"] = 1
    with pytest.raises(ResultFileError, match="format version 1, and this version of supple reads 4"):
        read_solution(path)


@pytest.mark.parametrize("lost", ["commits", "times", "bodies/hub/rotation"])
def test_missing_parts_are_named(tmp_path, solution, lost):
    path = write_solution(tmp_path / "run.h5", solution, case=CASE)
    with h5py.File(path, "r+") as file:
        del file[lost]
    with pytest.raises(ResultFileError, match=f"is damaged .*{Path(lost).name}"):
        read_solution(path)


def test_unwritable_folder(tmp_path, solution):
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultFileError, match="cannot write"):
        write_solution(tmp_path / "file" / "run.h5", solution, case=CASE)


def test_statistics_add_up_over_a_continued_run(tmp_path, make):
    path = tmp_path / "run.h5"
    with ResultFile.create(path, case=CASE) as file:
        file.append(make(0.0))
        file.append(make(1.0))
    with ResultFile.resume(path, case=CASE) as file:
        file.append(make(2.0))
        file.finish()
    assert read_header(path).statistics == Statistics(21, 42, 3, 0.75, 1.5)


def test_a_copy_of_a_running_file_opens(tmp_path, make):
    with ResultFile.create(tmp_path / "run.h5", case=CASE) as file:
        file.append(make())
        shutil.copy(tmp_path / "run.h5", tmp_path / "copy.h5")
    assert_bit_equal(read_solution(tmp_path / "copy.h5"), make())
