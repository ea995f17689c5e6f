"""Damaged result files: nothing in them reads silently wrong, what is damaged is named, the rest is read."""

from __future__ import annotations

import random
import time

import h5py
import numpy as np
import pytest
from fixtures.made_up_solutions import make_solution
from fixtures.runs_on_disk import bits

from supple.errors import ResultFileError
from supple.storage import (
    DamagedResultError,
    ResultFile,
    read_header,
    read_last_instant,
    read_solution,
    read_sound_part,
)
from supple.storage.hdf5_superblock import lookup3

N_CHUNKS = 4


@pytest.fixture(scope="module", params=["complete", "cut off", "going on"])
def written(request, tmp_path_factory):
    """A result file and its bytes, from a run that ended, was interrupted, or still writes."""
    path = tmp_path_factory.mktemp("whole") / "run.h5"
    with ResultFile.create(path, case="x = 1\n", metadata={"title": "a"}, inputs={"x": "1"}) as file:
        for number in range(N_CHUNKS):
            file.append(make_solution(float(number), 7, number))
        going_on = path.read_bytes()
        if request.param == "complete":
            file.finish()
    if request.param == "going on":
        path.write_bytes(going_on)
    return path, path.read_bytes()


def mutated(data, draw):
    """The bytes with one bit, byte or short run of bytes changed, most of them where something is written."""
    found = bytearray(data)
    used = np.flatnonzero(np.frombuffer(data, np.uint8))
    place = int(draw.choice(used)) if draw.random() < 0.8 else draw.randrange(len(data))
    match draw.randrange(3):
        case 0:
            found[place] ^= 1 << draw.randrange(8)
        case 1:
            found[place] = draw.randrange(256)
        case _:
            length = draw.choice([2, 4, 8])
            found[place : place + length] = bytes(draw.choice([0, 255]) for _ in range(length))
    return bytes(found[: len(data)])


def check_nothing_wrong(path, content, whole):
    """Every reader gives what was written, or says that it cannot, soon."""
    path.write_bytes(content)
    header, solution = whole
    began = time.perf_counter()
    named = 0
    try:
        assert read_header(path) == header
    except ResultFileError as error:
        named += str(path) in str(error)
    try:
        found = read_solution(path)
        assert bits(found) == bits(solution)
        assert found.statistics == solution.statistics
        assert {key: value.tobytes() for key, value in found.engine_state.items()} == {}
    except ResultFileError as error:
        named += str(path) in str(error)
    try:
        last = read_last_instant(path)
        assert bits(last) == bits(solution.at(slice(-1, None)))
    except ResultFileError as error:
        named += str(path) in str(error)
    try:
        part = read_sound_part(path)
        rows = np.searchsorted(solution.times, part.times)
        assert bits(part) == bits(solution.at(rows))
        assert part.stopped is not None or len(rows) == len(solution.times)
    except ResultFileError as error:
        named += str(path) in str(error)
    assert time.perf_counter() - began < 60.0  # not the minutes for which HDF5 would wait
    return named


@pytest.fixture
def at_once(monkeypatch):
    """A reader that does not wait before it looks again whether a run goes on."""
    monkeypatch.setattr("supple.storage.result_reader._PAUSES", (0.0,))


def check_mutations(written, folder, seed, n):
    path, data = written
    whole = read_header(path), read_solution(path)
    draw = random.Random(seed)
    return sum(check_nothing_wrong(folder / "bad.h5", mutated(data, draw), whole) > 0 for _ in range(n))


@pytest.mark.slow
def test_no_single_mutation_reads_silently_wrong(tmp_path, written, at_once):
    assert check_mutations(written, tmp_path, 1, 40) > 20  # and the mutations do hit


@pytest.mark.slow
@pytest.mark.soak
@pytest.mark.parametrize("seed", range(2, 7))
def test_none_of_many_mutations_reads_silently_wrong(tmp_path, written, seed, at_once):
    assert check_mutations(written, tmp_path, seed, 400) > 200


def test_a_damaged_chunk_is_named_and_the_rest_is_read(tmp_path, written):
    path, data = written
    solution = read_solution(path)
    place = data.find(solution.bodies["hub"].position[7:14].tobytes())
    damaged = bytearray(data)
    damaged[place + 3] ^= 1
    (tmp_path / "bad.h5").write_bytes(damaged)
    with pytest.raises(DamagedResultError, match=r"chunk 2 of 4: its numbers.*: the rest can be read"):
        read_solution(tmp_path / "bad.h5")
    part = read_sound_part(tmp_path / "bad.h5")
    rows = np.r_[:7, 14:28]
    assert bits(part) == bits(solution.at(rows))
    assert "chunk 2 of 4" in part.stopped
    assert bits(read_last_instant(tmp_path / "bad.h5")) == bits(solution.at(slice(-1, None)))
    with pytest.raises(ResultFileError, match=r"chunk 2 of 4|its run is complete"):
        ResultFile.resume(tmp_path / "bad.h5", case="x = 1\n", inputs={"x": "1"})


def test_a_sound_file_is_its_own_sound_part(written):
    path, _ = written
    assert bits(read_sound_part(path)) == bits(read_solution(path))
    assert read_sound_part(path).stopped is None


@pytest.mark.parametrize("where", ["commits", "times", "bodies/hub/position", "seals/chunks"])
def test_more_output_times_than_a_file_can_hold_are_refused_before_memory_is_taken(tmp_path, where):
    """Two thousand million rows, claimed by a dataset and, where it counts, by the row of commits."""
    path = tmp_path / "run.h5"
    with ResultFile.create(path, case="a") as file:
        file.append(make_solution(0.0))
        file.finish()
    with h5py.File(path, "r+") as file:
        file[where].resize(2_000_000_000, axis=0)
        if where != "seals/chunks":
            file["commits"][0, 1] = 2e9
    with pytest.raises(DamagedResultError, match=r"bytes of the file|its entry in `commits`|rows instead of"):
        read_solution(path)


def test_huge_shapes_are_refused_with_the_limit(tmp_path):
    path = tmp_path / "run.h5"
    with ResultFile.create(path, case="a") as file:
        file.append(make_solution(0.0))
        file.finish()
    with h5py.File(path, "r+") as file:
        row = file["commits"][0].nbytes
        file["commits"].resize(2_000_000_000, axis=0)
    size = path.stat().st_size
    with pytest.raises(
        DamagedResultError,
        match=f"commits has {row * 2_000_000_000} bytes, more than the {size} bytes of the",
    ):
        read_header(path)
    with h5py.File(path, "r+") as file:
        del file["case"]
        file.create_dataset("case", shape=(), dtype="S2000000000")
    with pytest.raises(DamagedResultError, match="case has 2000000000 bytes, more than the"):
        read_header(path)


def test_a_file_that_says_it_is_longer_than_it_is(tmp_path):
    """The end of file in its first bytes, with a checksum that agrees: a copy that was cut, or a forgery."""
    path = tmp_path / "run.h5"
    ResultFile.create(path, case="a").close()
    data = bytearray(path.read_bytes())
    data[28:36] = (10 * len(data)).to_bytes(8, "little")
    data[44:48] = lookup3(bytes(data[:44])).to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(
        DamagedResultError, match=f"truncated: {len(data)} of {10 * len(data)} bytes are present"
    ):
        read_header(path)


def test_a_small_damaged_file_of_a_run_that_was_killed_is_refused_at_once(tmp_path):
    """HDF5 reads what is marked as being written again and again, with pauses that grow to a second."""
    path = tmp_path / "run.h5"
    with ResultFile.create(path, case="a") as file:
        file.append(make_solution(0.0, 1))
        data = bytearray(path.read_bytes())
    place = data.find(b"OHDR") + 9
    data[place] ^= 0x10
    path.write_bytes(data)
    began = time.perf_counter()
    with pytest.raises(DamagedResultError, match=r"run\.h5 is damaged"):
        read_header(path)
    assert time.perf_counter() - began < 60.0  # not the minutes of such pauses, beside whatever load


def test_the_checksum_of_the_first_bytes_is_jenkins_hash():
    """His own test values, with initial values 0 (burtleburtle.net/bob/c/lookup3.c, driver5)."""
    assert lookup3(b"") == 0xDEADBEEF
    assert lookup3(b"Four score and seven years ago") == 0x17770551


def test_a_folder_in_place_of_a_file_is_named(tmp_path):
    with pytest.raises(ResultFileError, match="no such file"):
        read_header(tmp_path)
