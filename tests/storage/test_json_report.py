"""Reports: plain values in, JSON out, whole or not at all."""

import json
from dataclasses import dataclass

import numpy as np
import pytest

from supple.errors import ResultFileError
from supple.storage.json_report import write_json


@dataclass(frozen=True)
class Row:
    frame: str
    error: float


def test_arrays_dataclasses_and_numbers_become_plain(tmp_path):
    data = {
        "rows": [Row("mean-axis", 1e-5)],
        6: np.float64(0.1),
        "n": np.int64(3),
        "grid": np.eye(2),
        "none": None,
        "flag": True,
    }
    path = write_json(tmp_path / "new" / "report.json", data)
    assert json.loads(path.read_text()) == {
        "rows": [{"frame": "mean-axis", "error": 1e-5}],
        "6": 0.1,
        "n": 3,
        "grid": [[1.0, 0.0], [0.0, 1.0]],
        "none": None,
        "flag": True,
    }


def test_numbers_that_are_not_finite_become_null(tmp_path):
    path = write_json(tmp_path / "report.json", [np.inf, np.array([1.0, np.nan])])
    assert json.loads(path.read_text()) == [None, [1.0, None]]


def test_other_objects_are_refused_and_the_old_report_stays(tmp_path):
    path = write_json(tmp_path / "report.json", {"a": 1})
    with pytest.raises(TypeError, match="cannot hold a set"):
        write_json(path, {"a": {1, 2}})
    assert json.loads(path.read_text()) == {"a": 1}
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_in_the_way_is_named(tmp_path):
    with pytest.raises(ResultFileError, match="this is a folder"):
        write_json(tmp_path, {"a": 1})
