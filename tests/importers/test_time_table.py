"""A table over time that cannot be used is rejected in words."""

from __future__ import annotations

import pytest

from supple.errors import ImportFormatError
from supple.importers.time_table import read_time_table


@pytest.mark.parametrize("heading", ["", "time,value\n", '# of the test\n"Time [s]", "Force [N]"\n'])
def test_a_heading_is_optional(tmp_path, heading):
    (tmp_path / "law.csv").write_text(heading + "0,1\n2,5\n")
    times, values = read_time_table(tmp_path / "law.csv")
    assert (times.tolist(), values.tolist()) == ([0, 2], [1, 5])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1\nx,2\n", "write rows of two numbers, time,value"),
        ("time,2\n0,1\n1,2\n", "line 1: 'time,2'; write rows of two numbers"),
        ("time,value\ntime,value\n0,1\n", "line 2: .*write rows of two numbers"),
        ("nan,nan\n1,2\n", "has NaN or infinite numbers"),
        ("0,1\n", "has 1 rows of 2 numbers; write two or more rows"),
        ("0,1,2\n1,2,3\n", "has 2 rows of 3 numbers; write two or more rows"),
        ("0,1\n1,nan\n", "has NaN or infinite numbers; remove these rows"),
        ("0,1\n2,1\n1,1\n", "times must increase, but row 3 has 1 after 2"),
    ],
)
def test_wrong_tables_are_named(tmp_path, text, message):
    (tmp_path / "law.csv").write_text(text)
    with pytest.raises(ImportFormatError, match=message):
        read_time_table(tmp_path / "law.csv")
