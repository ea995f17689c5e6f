"""Labelled matrices: one triangle stands for both; maps and entries that break the rules are rejected."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array

from supple.errors import ImportFormatError
from supple.importers.matrices.labelled_matrix import (
    LabelledMatrix,
    from_labelled_entries,
    printed_resolution,
)

LABELS = np.array([[7, 1], [7, 2], [3, 6]])
SYMMETRIC = np.array([[4.0, -1.0, 0.5], [-1.0, 3.0, 0.0], [0.5, 0.0, 2.0]])


def entries(matrix, chosen):
    row, column = np.nonzero(matrix * chosen)
    return LABELS[row], LABELS[column], matrix[row, column]


@pytest.mark.parametrize(
    "chosen",
    [np.triu(np.ones((3, 3))), np.tril(np.ones((3, 3))), np.ones((3, 3)), [[1, 0, 1], [1, 1, 0], [0, 0, 1]]],
    ids=["upper", "lower", "both", "one way each"],
)
def test_one_way_stands_for_both(chosen):
    made = from_labelled_entries("file", *entries(SYMMETRIC, np.array(chosen)), 1e-15)
    np.testing.assert_array_equal(made.freedoms, [[3, 6], [7, 1], [7, 2]])
    np.testing.assert_array_equal(made.matrix.toarray(), SYMMETRIC[np.ix_([2, 0, 1], [2, 0, 1])])


@pytest.mark.parametrize(
    ("matrix", "labels", "message"),
    [
        (
            np.eye(2),
            LABELS,
            r"file: the matrix has shape \(2, 2\), but its map names 3 freedoms; export both",
        ),
        (np.eye(3), [[7, 1], [7, -1], [3, 6]], "component -1 of node 7; only 1 to 6 are motions of a node"),
        (np.eye(3), [[7, 1], [3, 6], [7, 1]], "node 7 ux occurs twice in the map"),
        (np.diag([1, np.nan, 1]), LABELS, "an entry in the row of node 7 uy is not finite; export it again"),
        (
            SYMMETRIC + 0.1 * np.eye(3)[[2, 2, 0]].T * [1, 0, 0],
            LABELS,
            r"not symmetric: .* of node (7 ux with node 3 rz|3 rz with node 7 ux) differ by 2\.5e-02",
        ),
    ],
)
def test_maps_and_entries_that_break_the_rules(matrix, labels, message):
    with pytest.raises(ImportFormatError, match=message):
        LabelledMatrix("file", csc_array(matrix), np.array(labels))


def test_an_entry_given_twice():
    rows, columns, values = entries(SYMMETRIC, np.ones((3, 3)))
    with pytest.raises(
        ImportFormatError, match="the entry of node 7 ux with node 7 ux is given twice; give it once"
    ):
        from_labelled_entries(
            "file",
            np.vstack([rows, rows[:1]]),
            np.vstack([columns, columns[:1]]),
            np.append(values, 1.0),
            1e-15,
        )


@pytest.mark.parametrize(
    ("word", "error"), [("-1.234567890E+05", 5e-10), ("1.5D0", 0.05), (".25+3", 0.05), ("1" * 20, 2**-52)]
)
def test_digits_tell_the_resolution(word, error):
    assert printed_resolution(word) == pytest.approx(error)
