"""Trees of stations: sums along them, and what is refused."""

import numpy as np
import pytest

from supple.errors import ModelError
from supple.methods.intrinsic import load_path_tree

POINTS = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0], [1, 2, 0], [3, 0, 0.0]])
PARENTS = [-1, 0, 1, 1, 3, 2]


def test_the_sums_of_a_station_are_those_of_all_that_hangs_on_it():
    values = np.arange(6.0)[:, None] + 1
    sums = load_path_tree(POINTS, PARENTS).outboard_sums(values)
    assert sums[:, 0] == pytest.approx([21, 20, 9, 9, 5, 6])


def test_ancestors_double_their_distance_until_all_have_reached_the_root():
    tree = load_path_tree(np.arange(6.0)[:, None] * [1, 0, 0])
    assert [list(level) for level in tree.ancestors] == [
        [0, 0, 1, 2, 3, 4],
        [0, 0, 0, 1, 2, 3],
        [0, 0, 0, 0, 0, 1],
    ]
    assert tree.is_chain
    assert not load_path_tree(POINTS, PARENTS).is_chain


@pytest.mark.parametrize(
    ("points", "parents", "message"),
    [
        (POINTS, [-1, 0, 1, 4, 3, 2], "loop through station 3"),
        (POINTS, [-1, 0, 1, -1, 3, 2], "station 3 .* which does not exist"),
        (POINTS, [-1, 0, 9, 1, 3, 2], "has parent 9, which does not exist"),
        (POINTS, [-1, 5, 1, 1, 3, 0], "station 1 .* comes after it"),
        (POINTS, [0, 0, 1, 1, 3, 2], "must be its root"),
        (POINTS, [-1, 0], "6 stations needs 6"),
        (POINTS[:, :2], None, "points \\(n, 3\\)"),
        (np.where(POINTS == POINTS[2], np.nan, POINTS), None, "station 0 .* is at .*nan.* finite numbers"),
        (POINTS[[0, 1, 1]], None, "between stations 1 and 2 has length 0"),
    ],
)
def test_what_is_no_tree_is_refused_by_the_number_of_the_station(points, parents, message):
    with pytest.raises(ModelError, match=message):
        load_path_tree(points, parents)
