"""A run read in parts is the run, whatever the parts; damage in one is found before it is given out."""

import numpy as np
import pytest
from fixtures.made_up_solutions import make_solution
from fixtures.runs_on_disk import bits

from supple.errors import ResultFileError
from supple.integrate.solution import concatenate
from supple.storage import ResultFile, ResultParts, read_solution, result_reader
from supple.storage.result_content import ResultContent


@pytest.fixture
def path(tmp_path):
    """Seven and five times, of two chunks."""
    with ResultFile.create(tmp_path / "run.h5", case="made up") as file:
        file.append(make_solution())
        file.append(make_solution(start=1.0, n_times=5, seed=1))
        file.finish()
    return tmp_path / "run.h5"


@pytest.mark.parametrize("n_bytes", [1, 2500, 2**26])
def test_parts_are_the_run(path, n_bytes, monkeypatch):
    monkeypatch.setattr(result_reader, "_PART_BYTES", n_bytes)
    parts = ResultParts(path)
    assert len(list(parts)) == {1: 12, 2500: 3, 2**26: 1}[n_bytes]
    whole = read_solution(path)
    assert bits(concatenate(list(parts))) == bits(whole)
    np.testing.assert_array_equal(parts.times, whole.times)


@pytest.mark.parametrize("n_bytes", [1, 2500, 2**26])
def test_chosen_times_are_those_of_the_run(path, n_bytes, monkeypatch):
    monkeypatch.setattr(result_reader, "_PART_BYTES", n_bytes)
    rows = np.array([0, 6, 7, 11])
    parts = ResultParts(path, rows)
    assert bits(concatenate(list(parts))) == bits(read_solution(path).at(rows))
    with pytest.raises(ResultFileError, match="12 output times, numbered from 0; there is no number 12"):
        ResultParts(path, [12])
    for wrong in ([5, 2], [2, 2], rows > 3, 0.5 * rows):
        with pytest.raises(ResultFileError, match="each once and ascending"):
            ResultParts(path, wrong)


def test_a_damaged_chunk_is_found_before_it_is_given_out(path, monkeypatch):
    monkeypatch.setattr(result_reader, "_PART_BYTES", 1)
    parts = ResultParts(path)
    wrong = read_solution(path).bodies["hub"].position[-1].tobytes()
    content = path.read_bytes()
    assert content.count(wrong) == 1
    path.write_bytes(content.replace(wrong, wrong[::-1]))
    given = []
    with pytest.raises(ResultFileError, match="damaged"):
        given.extend(parts)  # HDF5's own sums may find it, or the seal
    assert len(given) <= 7


def test_a_part_that_the_run_is_writing_is_read_again(tmp_path, monkeypatch):
    arrays, failures = ResultContent._arrays, iter([OSError("half of a block is written")])

    def failing_once(content, begin, end):
        for error in failures:
            raise error
        return arrays(content, begin, end)

    with ResultFile.create(tmp_path / "run.h5", case="made up") as file:
        file.append(make_solution())
        monkeypatch.setattr(ResultContent, "_arrays", failing_once)
        assert bits(concatenate(list(ResultParts(file.path)))) == bits(make_solution())


def test_a_run_without_output_times_is_named(tmp_path):
    ResultFile.create(tmp_path / "run.h5", case="made up").close()
    with pytest.raises(ResultFileError, match="contains no output times"):
        ResultParts(tmp_path / "run.h5")
