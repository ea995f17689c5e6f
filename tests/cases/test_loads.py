"""`[[load]]` on faces and of the base: what Python builds, and how a body moves under them."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

from supple import machine as m
from supple.cases import read_case
from supple.cli.main import app
from supple.errors import CaseError
from supple.simulation import simulate

PRESSURE = 7850.0 * 0.01
"""Of a strip 1 cm thick: it falls with 1 m/s2."""
LOADS = f"""
[[load]]
kind = "pressure"
at = "strip.ALL"
pressure = {PRESSURE}

[[load]]
kind = "base-acceleration"
vector = [0, 0, 1]
law = {{ kind = "constant", value = FACTOR }}
"""


@pytest.fixture
def path(case_folder):
    mesh = case_folder / "strip.inp"
    mesh.write_text(mesh.read_text() + "*NSET, NSET=ALL, GENERATE\n1, 27, 1\n")
    path = case_folder / "strip.toml"
    text = (
        path.read_text().replace("gravity = [0, 0, -9.81]\n", "").replace("duration = 0.4", "duration = 0.02")
    )
    path.write_text(text[: text.index("[[joint]]")] + LOADS + text[text.index("[simulation]") :])
    return path


def rewritten(path, old, new):
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    return path


def test_they_are_those_of_python(path):
    case = read_case(rewritten(path, "FACTOR", "-1.0"))
    pressure, base = case.system.loads
    assert (type(pressure), type(base)) == (m.FollowerPressure, m.BaseAcceleration)
    corners = case.meshes["strip"].nodes[pressure.faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    np.testing.assert_allclose(areas.sum(axis=0), [0, 0, 0.1], atol=1e-12)
    assert float(pressure.law(0.3)) == PRESSURE
    np.testing.assert_array_equal(base.law(0.3), [0.0, 0.0, -1.0])


@pytest.mark.parametrize("seen", [0.0, -1.0])
def test_a_free_strip_falls_under_its_pressure_and_rests_on_a_base_that_falls_along(path, seen):
    case = read_case(rewritten(path, "FACTOR", str(seen)))
    place = simulate(case.system, case.run).bodies["strip"].position
    fallen = -0.5 * 0.02**2 if seen == 0.0 else 0.0
    assert place[-1] - place[0] == pytest.approx([0.0, 0.0, fallen], abs=1e-4 * 0.02**2)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'at = "strip.ALL"',
            'at = "strip.root"',
            r"load\[1\].at: 'root' is an interface, but a pressure acts on the faces",
        ),
        ('at = "strip.ALL"', 'at = "strip.AL"', "no node set named 'AL', did you mean 'ALL'"),
        (
            "vector = [0, 0, 1]",
            "",
            r"load\[2\].vector: this key is missing; add it \(an acceleration, global axes\)",
        ),
        (
            'at = "strip.ALL"',
            'at = "strip.ROOT"',
            "needs an outer face of a solid or shell with all corners in the set",
        ),
    ],
)
def test_a_mistake_is_named(path, old, new, message):
    rewritten(path, old, new)
    with pytest.raises(Exception, match=message) as seen:
        _ = read_case(rewritten(path, "FACTOR", "1.0")).system
    assert isinstance(seen.value, CaseError) or "a pressure on 'strip.ROOT'" in str(seen.value)


def test_info_names_them_and_a_deck_holds_them(path, tmp_path):
    """Each pushes down with the mass of the strip times 1 m/s2."""
    clamp = '[[joint]]\nkind = "fixed"\nfirst = "ground"\nsecond = "strip.root"\n[simulation]'
    rewritten(rewritten(path, "FACTOR", "1.0"), "[simulation]", clamp)
    shown = CliRunner().invoke(app, ["info", str(path)]).output
    assert "pressure at strip.ALL" in shown
    assert "base-acceleration" in shown
    result = CliRunner().invoke(app, ["export", str(path), "-o", str(tmp_path / "deck.inp"), "--abaqus"])
    assert result.exit_code == 0, result.output
    assert f"{-2 * 7850.0 * 0.01 * 0.1:.6g}" in result.output
