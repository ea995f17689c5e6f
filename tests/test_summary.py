"""What `print` and a notebook show of meshes, bodies, machines, runs and results."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fixtures.bar_of_every_form import bar_as, elastic, model
from fixtures.made_up_solutions import make_solution

from supple.integrate import ErrorPart, ErrorStatement, FixedStep, Run
from supple.linearization import campbell_diagram, linearize, machine_modes
from supple.machine import GROUND, At, Placed, Revolute, Spin, SpringDamper, System
from supple.mesh import strip
from supple.quantities.reading import Channel, QuantityKind, Reading, Readings
from supple.simulation import equilibrium
from supple.summary import N_LINES, WIDTH, Summary


def chain(n):
    bodies = [Placed(bar_as("rigid", f"bar {i}"), position=(i, 0, 0)) for i in range(n)]
    firsts = [GROUND, *(At(f"bar {i}", "tip") for i in range(n))]
    hinges = [Revolute(first=firsts[i], second=At(f"bar {i}", "root"), axis=(0, 1, 0)) for i in range(n)]
    spring = SpringDamper(first=At("bar 0", "tip"), second=GROUND, stiffness=1.0, anchor=(1, 0, 1))
    return System(bodies, hinges, [spring], gravity=(0, 0, -9.81))


STATEMENT = ErrorStatement(
    "the tip", 0.1, basis=ErrorPart(1e-3, "by projection", "take more modes"), allowed=0.01
)
SPINS = [Spin(rate, (0, 0, 1)) for rate in (1.0, 2.0)]


def turning():
    """A bar on a flap hinge, which a spin about z holds out."""
    hinge = Revolute(first=GROUND, second=At("bar", "root"), axis=(0, 1, 0))
    return System([bar_as("rigid", "bar")], [hinge])


def reading():
    """Of a tip, at 2000 times."""
    channels = tuple(Channel(axis, QuantityKind.LENGTH, "global") for axis in "xyz")
    return Reading("tip", channels, np.arange(2000.0), np.linspace(0.0, 3.0, 6000).reshape(2000, 3))


SOLUTION = make_solution(n_times=2000)
EVERY = {
    "mesh": lambda: model().mesh,
    "flexible body": elastic,
    **{form: lambda form=form: bar_as(form) for form in ("rigid", "reduced", "full", "intrinsic", "modal")},
    "finite elements": lambda: bar_as("finite elements"),
    "placed": lambda: Placed(bar_as("rigid")),
    "system": lambda: chain(2),
    "run": lambda: Run(1.0, 0.1, step=FixedStep(0.01)),
    "solution": lambda: SOLUTION,
    "motion": lambda: SOLUTION.bodies["hub"],
    "error": lambda: STATEMENT,
    "equilibrium": lambda: equilibrium(chain(1)),
    "linear machine": lambda: linearize(turning(), spin=SPINS[0]),
    "modes": lambda: machine_modes(linearize(turning(), spin=SPINS[0])),
    "Campbell diagram": lambda: campbell_diagram(turning(), SPINS),
    "readings": lambda: Readings(40 * (reading(),)),
    "reading": reading,
}


@pytest.mark.parametrize("what", EVERY)
def test_everything_prints_in_ten_lines(what):
    printed = str(EVERY[what]())
    assert len(printed.splitlines()) <= N_LINES
    assert max(map(len, printed.splitlines())) <= 4 * WIDTH
    assert len(repr(EVERY[what]())) <= 4 * WIDTH


def test_a_mesh_shows_its_nodes_cells_extent_and_sets():
    mesh = strip(1.0, 0.1, 8, 2)
    rows = dict(mesh.summary().rows)
    assert rows["nodes"] == "27"
    assert rows["x"] == "0 to 1"
    assert rows["node set root"].startswith("3 nodes, centroid (0, ")
    assert repr(mesh).startswith("<Mesh of 27 nodes, ")


def test_of_a_long_chain_the_loads_are_shown_and_the_rest_is_counted():
    shown = str(chain(20))
    assert len(shown.splitlines()) == N_LINES
    assert "spring" in shown.lower()
    assert "34 bodies and joints more" in shown


def test_rows_that_do_not_fit_are_counted():
    lines = str(Summary("title", [(f"row {i}", "x") for i in range(30)])).splitlines()
    assert lines[0] == "title"
    assert lines[-1].split() == ["...", "22", "rows", "more"]
    assert len(lines) == N_LINES


def test_a_statement_of_error_shows_its_sum_its_parts_and_its_remedy():
    shown = str(STATEMENT)
    assert shown.startswith("Error of the tip: at least 0.001")
    assert "by projection" in shown
    assert "take more modes" in shown
    assert "step, newton, model" in shown


def test_readings_show_the_range_of_every_channel():
    rows = dict(Readings((reading(),)).summary().rows)
    assert rows["tip.z"] == "0.001 to 3, length"


def test_what_rounding_leaves_of_a_centroid_is_nothing():
    """Also where every coordinate of it is zero."""
    mesh = strip(1.0, 0.1, 8, 2)
    off = replace(mesh, nodes=mesh.nodes + np.array([0, 0, 1e-18]))
    assert dict(off.summary().rows)["node set root"] == "3 nodes, centroid (0, 0, 0)"


def test_a_motion_shows_shapes_and_sizes():
    hub = SOLUTION.bodies["hub"]
    assert f"2000 x 3, at most {np.abs(hub.position).max():.4g}" in str(hub)


def test_a_notebook_shows_a_table_and_no_markup_of_names():
    shown = Summary("a <b>", [("body <i>", "1 & 2")])._repr_html_()
    assert "a &lt;b&gt;" in shown
    assert '<th style="text-align:left">body &lt;i&gt;</th>' in shown
    assert "1 &amp; 2" in shown
    assert SOLUTION._repr_html_().count("<tr>") == 4
