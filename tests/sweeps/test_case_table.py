"""Tables of cases: combinations, samples, and the files that describe them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from supple.errors import CaseError, ImportFormatError
from supple.sweeps import (
    CaseTable,
    LatinHypercube,
    Normal,
    Sobol,
    Uniform,
    Weibull,
    crossed,
    full_factorial,
    read_sweep_file,
    sampled,
)


def test_every_combination_comes_once_and_the_last_path_varies_fastest():
    table = full_factorial({"a": [1, 2], "b": [10, 20, 30]})
    assert table.columns == {"a": (1, 1, 1, 2, 2, 2), "b": (10, 20, 30, 10, 20, 30)}


def test_tables_are_crossed_row_by_row():
    rows = CaseTable({"wind": [8.0, 12.0], "hours": [1, 2]})
    table = crossed(rows, full_factorial({"seed": [1, 2, 3]}))
    assert table.columns["wind"] == (8.0, 8.0, 8.0, 12.0, 12.0, 12.0)
    assert table.columns["hours"] == (1, 1, 1, 2, 2, 2)
    assert table.row(4) == {"wind": 12.0, "hours": 2, "seed": 2}
    with pytest.raises(CaseError, match="wind is varied twice"):
        crossed(rows, full_factorial({"wind": [1.0]}))


def test_columns_of_different_lengths_are_refused():
    with pytest.raises(CaseError, match=r"a 2, b 3"):
        CaseTable({"a": [1, 2], "b": [1, 2, 3]})


def test_columns_may_be_arrays_and_have_the_values_of_a_case_file():
    table = CaseTable(
        {
            "modes": np.arange(4, 6),
            "gravity": np.array([[0.0, 0.0, -9.81], [0.0, 0.0, 1.0]]),
            "law": [{"kind": "ramp", "value": np.float32(2)}, {"kind": np.str_("sine")}],
        }
    )
    assert table.columns == {
        "modes": (4, 5),
        "gravity": ([0.0, 0.0, -9.81], [0.0, 0.0, 1.0]),
        "law": ({"kind": "ramp", "value": 2.0}, {"kind": "sine"}),
    }
    assert {type(value) for value in table.columns["modes"]} == {int}


@pytest.mark.parametrize("column", [1.0, "revolute", {"a": 1}, iter([1.0])])
def test_a_column_that_is_no_list_is_refused(column):
    with pytest.raises(CaseError, match="a: give a list with one value per case, not"):
        CaseTable({"a": column})


def test_a_value_that_no_case_file_has_is_refused():
    with pytest.raises(
        CaseError, match=r"a: a case file has numbers, texts, lists and tables, not \(1\+2j\)"
    ):
        CaseTable({"a": [1 + 2j]})


@pytest.mark.parametrize(
    ("text", "columns"),
    [
        ("a,b\n1,2.5\n2,3\n", {"a": (1, 2), "b": (2.5, 3.0)}),
        ("a,b\ntrue,x\nfalse,7\n", {"a": (True, False), "b": ("x", "7")}),
        ("a,b\nx,1\n,2\n", {"a": ("x", ""), "b": (1, 2)}),
    ],
)
def test_a_csv_table_has_numbers_truth_values_or_texts(tmp_path, text, columns):
    (tmp_path / "t.csv").write_text(text)
    (tmp_path / "case.toml").write_text("")
    (tmp_path / "s.toml").write_text('case = "case.toml"\ntable = "t.csv"\n')
    assert read_sweep_file(tmp_path / "s.toml").table.columns == columns


@pytest.mark.parametrize(
    ("entry", "message"),
    [("", "a is empty; every case needs a value"), ("nan", "a is 'nan'; write a finite")],
)
def test_an_entry_without_value_in_a_column_of_numbers_is_named_with_its_line(tmp_path, entry, message):
    """It made a column of texts of all numbers, so that every case failed."""
    (tmp_path / "t.csv").write_text(f"a,b\n1,2\n{entry},3\n")
    (tmp_path / "case.toml").write_text("")
    (tmp_path / "s.toml").write_text('case = "case.toml"\ntable = "t.csv"\n')
    with pytest.raises(ImportFormatError, match=rf"t\.csv, line 3: {message}"):
        read_sweep_file(tmp_path / "s.toml")


def test_a_latin_hypercube_has_one_point_in_each_slice():
    table = sampled({"x": Uniform(2.0, 4.0), "y": Uniform(-1.0, 0.0)}, LatinHypercube(50, seed=3))
    for column, low, width in (("x", 2.0, 2.0), ("y", -1.0, 1.0)):
        slices = np.floor((np.array(table.columns[column]) - low) / width * 50)
        assert sorted(slices) == list(range(50))


def test_a_sobol_sequence_integrates_better_than_its_number_of_random_points():
    table = sampled({"x": Uniform(0.0, 1.0), "y": Uniform(0.0, 1.0)}, Sobol(256))
    x, y = (np.array(table.columns[name]) for name in "xy")
    # Random points miss the mean of x y, 1/4, by 0.22 / sqrt(256) = 0.014.
    assert np.mean(x * y) == pytest.approx(0.25, abs=1e-3)
    with pytest.raises(CaseError, match="number = 64 or 128, not 100"):
        sampled({"x": Uniform(0.0, 1.0)}, Sobol(100))


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: Normal(1.0, 0.0), "the deviation positive, got 1.0 and 0.0"),
        (lambda: Uniform(0.0, float("inf")), "low and high must be finite"),
        (lambda: LatinHypercube(0), "LatinHypercube: number must be at least 1"),
        (lambda: Sobol(0), "Sobol: number must be at least 1"),
    ],
)
def test_distributions_and_samplings_without_meaning(made, message):
    with pytest.raises(CaseError, match=message):
        made()


def test_a_whole_number_of_points_may_be_written_as_a_float():
    assert LatinHypercube(8.0).points(2).shape == Sobol(8.0).points(2).shape == (8, 2)


@pytest.mark.parametrize(
    ("distribution", "mean", "deviation"),
    [
        (Normal(3.0, 0.5), 3.0, 0.5),
        (Weibull(2.0, 2.0), 2.0 * math.gamma(1.5), 2.0 * math.sqrt(1.0 - math.gamma(1.5) ** 2)),
    ],
)
def test_samples_have_the_moments_of_their_distribution(distribution, mean, deviation):
    values = np.array(sampled({"v": distribution}, LatinHypercube(4096)).columns["v"])
    assert values.mean() == pytest.approx(mean, rel=1e-3)
    assert values.std() == pytest.approx(deviation, rel=5e-3)


@pytest.fixture
def file(tmp_path):
    """Writes the file of a sweep."""
    (tmp_path / "rod.toml").touch()

    def written(text):
        path = tmp_path / "cases.toml"
        path.write_text(f'case = "rod.toml"\n{text}')
        return path

    return written


def test_a_file_combines_a_csv_table_samples_and_values(file, tmp_path):
    (tmp_path / "cases.csv").write_text("# wind\nload[0].law.file,gravity[2]\na.csv,-9.81\nb.csv,-9.8\n")
    path = file(
        'table = "cases.csv"\n'
        '[sample]\nmethod = "sobol"\nnumber = 4\nseed = 1\n[sample.of]\n"body.rod.solid.density" = '
        "{ mean = 7850.0, deviation = 10.0 }\n"
        '[vary]\n"body.rod.reduction.modes" = { from = 4, to = 8, step = 2 }\n'
        '"joint.shaft.law.speed" = { from = 1.0, to = 2.0, number = 3 }\n'
        '"load[1].law.file" = { pattern = "seed-{:02}.csv", from = 9, to = 10 }\n'
    )
    read = read_sweep_file(path)
    assert len(read.table) == 2 * 4 * 3 * 3 * 2
    assert read.table.row(0)["load[0].law.file"] == "a.csv"
    assert read.table.row(len(read.table) - 1) == {
        "load[0].law.file": "b.csv",
        "gravity[2]": -9.8,
        "body.rod.solid.density": read.table.columns["body.rod.solid.density"][-1],
        "body.rod.reduction.modes": 8,
        "joint.shaft.law.speed": 2.0,
        "load[1].law.file": "seed-10.csv",
    }
    assert isinstance(read.table.columns["body.rod.reduction.modes"][0], int)
    assert read.case == tmp_path / "rod.toml"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"nothing is varied"),
        ('[vary]\n"a.b" = []', r"line 3, vary\.a\.b: the list is empty"),
        ('[vary]\n"a.b" = [1.0, "x"]', r"give values of one kind, not numbers and words"),
        ('[vary]\n"a.b" = 3.0', r"give a list of values"),
        ('[vary]\n"a.b" = { from = 1.0, to = 2.0 }', r"give either number or step"),
        ('[vary]\n"a.b" = { from = 1.0, to = 2.0, numbr = 3 }', r"unknown key, did you mean 'number'"),
        ('[vary]\n"a.b" = { from = 2.0, to = 1.0, step = 0.1 }', r"is less than from = 2.0"),
        ('[vary]\n"a.b" = { pattern = "seed.csv", from = 1, to = 2 }', r"no \{\} for the number"),
        (
            '[sample]\nmethod = "halton"\nnumber = 4\n[sample.of]\n"a" = {from = 1.0, to = 2.0}',
            "choose one of",
        ),
        ('[sample]\nmethod = "sobol"\nnumber = 4\n[sample.of]\n"a" = [1.0]', r"give a range"),
        ('table = "none.csv"', r"there is no file"),
    ],
)
def test_mistakes_of_a_file_are_named_with_their_remedy(file, text, message):
    with pytest.raises(CaseError, match=message):
        read_sweep_file(file(text))
