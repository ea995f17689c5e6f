"""Room for more columns: spaces of nearby sizes have arrays of one size, and so one program."""

import pytest

from supple.error.equation.error_model import BRIEF, padded_size


@pytest.mark.parametrize(
    ("size", "brief", "long"),
    [(1, 32, 32), (32, 32, 32), (33, 64, 64), (64, 64, 64), (65, 128, 96), (120, 128, 128), (129, 160, 160)],
)
def test_columns_of_a_brief_run_are_doubled_up_to_128(size, brief, long):
    assert padded_size(size, BRIEF) == brief
    assert padded_size(size, BRIEF + 1) == long
