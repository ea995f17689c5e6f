"""Tables of time and value that a case names: what is wrong with them is a mistake of the case."""

from __future__ import annotations

import pytest

from supple.cases import read_case
from supple.errors import CaseError

CASE = """\
title = "a bar on a motor"
[[body]]
name = "bar"
rigid = { mass = 1.0, inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }
interface = [{ name = "pin", position = [0, 0, 0] }]
[[joint]]
kind = "prescribed-rotation"
first = "ground"
second = "bar.pin"
axis = [0, 0, 1]
law = { kind = "table", file = "angle.csv" }
[[load]]
kind = "torque"
at = "bar.pin"
vector = [0, 0, 1]
law = { kind = "table", file = "torque.csv" }
[simulation]
duration = 1.0
output_step = 0.1
step = 0.1
"""
GOOD = "0,0\n0.5,0.5\n1,1\n"


def read(folder, angle=GOOD, torque=GOOD):
    (folder / "angle.csv").write_text(angle)
    (folder / "torque.csv").write_text(torque)
    (folder / "case.toml").write_text(CASE)
    return read_case(folder / "case.toml")


def test_tables_that_last_as_long_as_the_run_are_good(tmp_path):
    assert read(tmp_path).system.joints[0].law.end == 1.0
    read(tmp_path, angle="-1,0\n0.5,0.5\n2,1\n", torque="-1,0\n7,1\n")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("0,0\n0.9,1\n", r"the table ends at t = 0\.9, before the run ends \(t = 1\); extend the table or"),
        ("0.1,0\n1,1\n", r"the table begins at t = 0\.1, after the run begins \(t = 0\); extend"),
        ("0,0\n0,1\n", r"\.csv: times must increase"),
        ("0,0\nx,1\n", r"\.csv, line 2: 'x,1'; write rows of two numbers"),
        ("0,0\n", r"\.csv has 1 rows of 2 numbers"),
    ],
)
@pytest.mark.parametrize(("which", "line", "place"), [("angle", 11, "joint"), ("torque", 16, "load")])
def test_what_is_wrong_with_a_table_has_its_line(tmp_path, which, line, place, content, message):
    with pytest.raises(
        CaseError, match=rf"one mistake:\n  line {line}, {place}\[1\]\.law\.file: .*{message}"
    ):
        read(tmp_path, **{which: content})


def test_a_motion_that_jumps_has_its_line_and_a_load_may(tmp_path):
    jump = "0,0\n0.1,0\n0.2,0\n0.3,0\n0.301,1\n0.4,1\n0.5,1\n1,1\n"
    read(tmp_path, torque=jump)
    with pytest.raises(CaseError, match=r"line 11, joint\[1\]\.law\.file: .*a motion must be smooth"):
        read(tmp_path, angle=jump)


def test_mistakes_of_both_tables_come_at_once(tmp_path):
    with pytest.raises(CaseError, match="2 mistakes"):
        read(tmp_path, angle="0,0\n0.9,1\n", torque="0,0\n0.8,1\n")
