"""The line index agrees with the positions of keys in every construct of TOML that a case file may use."""

from __future__ import annotations

import tomllib

import pytest

from supple.importers.toml.line_index import index_lines

TEXT = '''\
# a comment with = and [brackets]
title = "spin # not a comment"
gravity = [
  0.0,  # x
  0.0,
  -9.81,
]
units.length = "m"
"quoted key" = 1
note = """
several = lines
[not.a.table]
"""
path = \'C:\\data\'

[[body]]
name = "blade"
frame = { kind = "mean-axis", odd = [ { a = 1 }, { a = 2 } ] }

[body.shell]   # belongs to the first body
thickness = 0.02

[[body.interface]]
name = "root"

  [[body.interface]]
  name = "tip"

[[body]]
name = "hub"
[[body.interface]]
name = "shaft"

[simulation]
adaptive.first = 1e-6
'''

EXPECTED = {
    ("title",): 2,
    ("gravity",): 3,
    ("gravity", 0): 4,
    ("gravity", 2): 6,
    ("units",): 8,
    ("units", "length"): 8,
    ("quoted key",): 9,
    ("note",): 10,
    ("path",): 14,
    ("body",): 16,
    ("body", 0): 16,
    ("body", 0, "name"): 17,
    ("body", 0, "frame", "kind"): 18,
    ("body", 0, "frame", "odd", 1, "a"): 18,
    ("body", 0, "shell"): 20,
    ("body", 0, "shell", "thickness"): 21,
    ("body", 0, "interface", 0): 23,
    ("body", 0, "interface", 1, "name"): 27,
    ("body", 1): 29,
    ("body", 1, "interface", 0, "name"): 32,
    ("simulation",): 34,
    ("simulation", "adaptive", "first"): 35,
}


@pytest.mark.parametrize(("path", "line"), EXPECTED.items())
def test_line_of_each_construct(path, line):
    assert index_lines(TEXT).line_of(path) == line


def leaves(value, path=()):
    """Every path of the parsed text."""
    yield path
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, (*path, key))
    elif isinstance(value, list):
        for position, item in enumerate(value):
            yield from leaves(item, (*path, position))


def test_index_has_exactly_the_paths_that_the_toml_reader_sees():
    assert set(index_lines(TEXT).lines) | {()} == set(leaves(tomllib.loads(TEXT)))


def test_windows_line_ends_count_once():
    assert index_lines(TEXT.replace("\n", "\r\n")).lines == index_lines(TEXT).lines


@pytest.mark.parametrize(
    "text",
    [
        "a = [[1, 2], [3]]",
        'a = ["]", "}", "#"]',
        "a = { b = '}', c = {} }",
        "a = []",
        "a = 1979-05-27T07:32:00Z",
    ],
)
def test_values_that_hold_brackets_and_signs_do_not_lose_the_next_key(text):
    assert index_lines(f"{text}\nnext = 1\n").line_of(("next",)) == 2


def test_a_missing_key_points_to_the_table_that_should_hold_it():
    index = index_lines(TEXT)
    assert index.line_of(("body", 0, "shell", "density")) == 20
    assert index.line_of(("output",)) == 1


def test_an_invalid_text_is_refused():
    with pytest.raises(ValueError, match="line 2: expected '='"):
        index_lines("a = 1\nb 2\n")
