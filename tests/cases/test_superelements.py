"""Superelements of a Nastran deck in a case file: one body, one of them, or bodies tied to each other."""

from __future__ import annotations

import numpy as np
import pytest

from supple.cases import read_case
from supple.simulation import equilibrium

# A cantilever of ten beams, grid 6 common to both halves, whose ids overlap.
HALVES = [
    "\n".join(
        [
            *(f"GRID,{i + 1},,{(5 * half + i) / 10},0.,0." for i in range(6)),
            *(f"CBAR,{i + 1},7,{i + 1},{i + 2},0.,0.,1." for i in range(5)),
            "PBAR,7,5,4.-4,1.3-8,1.3-8,2.-8",
            "MAT1,5,2.1+11,,.3,7850.",
            "",
        ]
    )
    for half in (0, 1)
]
CASE = """\
title = "two superelements"
gravity = [0.0, 0.0, -9.81]
[[body]]
name = "beam"
mesh = "beam.bdf"
nastran = {}
frame = { kind = "mean-axis" }
reduction = { basis = "craig-bampton", modes = 4 }
damping = { kind = "rayleigh", alpha = 0.0, beta = 1e-4 }
interface = [{ name = "root", node_indices = [1] }]
[[joint]]
kind = "fixed"
first = "ground"
second = "beam.root"
[simulation]
duration = 0.01
output_step = 1e-3
step = 1e-3
"""


@pytest.fixture
def case(tmp_path):
    """Reads the case with other words for `nastran = {}`."""
    (tmp_path / "beam.bdf").write_text(
        f"BEGIN BULK\nBEGIN SUPER=1\n{HALVES[0]}BEGIN SUPER=2\n{HALVES[1]}ENDDATA\n"
    )

    def read(words):
        path = tmp_path / "case.toml"
        path.write_text(CASE.replace("nastran = {}", words))
        return read_case(path)

    return read


def test_without_a_part_all_of_them_are_one_body(case):
    (body,) = case("nastran = {}").flexible.values()
    assert len(body.nodes) == 11
    (one,) = case('nastran = { part = "super_2" }').flexible.values()
    np.testing.assert_allclose(one.nodes[:, 0], np.linspace(0.5, 1.0, 6))


@pytest.mark.filterwarnings("ignore::supple.errors.SuppleWarning")
@pytest.mark.parametrize(("tie", "joint"), [("", "cut-1"), (', tie = "nodes"', "node-6")])
def test_each_is_a_body_tied_at_the_common_grids(case, tie, joint):
    whole = case("nastran = {}").flexible["beam"]
    read = case(f'nastran = {{}}\nsplit = {{ cell_sets = ["super_1", "super_2"]{tie} }}')
    first, second = read.flexible.values()
    assert [each.name for each in (first, second)] == ["beam-1", "beam-2"]
    assert [len(each.nodes) for each in (first, second)] == [6, 6]
    assert [each.name for each in read.system.joints] == ["fixed ground - beam.root", f"beam {joint}"]
    mass = sum(np.trace(b.rigid_modes[:, :3].T @ b.mass @ b.rigid_modes[:, :3]) / 3 for b in (first, second))
    R = whole.rigid_modes[:, :3]
    assert mass == pytest.approx(np.trace(R.T @ whole.mass @ R) / 3, rel=1e-12)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.SuppleWarning")
def test_the_joined_bodies_sag_as_the_whole(case):
    """Both have the static answer to gravity; small deflections, so that frames make no difference."""
    split = 'nastran = {}\nsplit = { cell_sets = ["super_1", "super_2"], tie = "nodes" }'

    def sag(read):
        return equilibrium(read.system).system.bodies[-1].positions()[-1, 2]

    whole = sag(case("nastran = {}"))
    assert whole == pytest.approx(-4e-4 * 7850 * 9.81 / (8 * 2.1e11 * 1.3e-8), rel=5e-3)
    assert sag(case(split)) == pytest.approx(whole, rel=1e-3)
