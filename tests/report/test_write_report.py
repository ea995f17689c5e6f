"""What a page holds of a run: places of nodes and marks, curves, tables; and nothing that it would fetch."""

import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from fixtures.moving_machines import MESH, N_TIMES, eroding, two_bodies
from fixtures.report_page import ReadPage

import supple as sp
from supple.errors import ModelError
from supple.integrate import Solution, Statistics
from supple.machine import GROUND, At, DeadForce, FollowerPressure
from supple.mesh import CellType, Mesh
from supple.quantities import deflections, joint_loads, tracked_motion, von_mises_history
from supple.report import write_report
from supple.report.charts import Chart
from supple.report.packed_arrays import PackedArrays, unpacked
from supple.report.scene_data import chart_data
from supple.simulation.recorded_columns import measured_columns
from supple.units import SI


@pytest.fixture
def machine(clamped_blade):
    """A blade and a rigid hub: (system, solution)."""
    return two_bodies(clamped_blade)


@pytest.fixture
def page(tmp_path, machine, blade):
    system, solution = machine
    tip = tracked_motion(system.placed("blade").body, solution.bodies["blade"], "tip")
    path = write_report(
        tmp_path / "run.html",
        system,
        solution,
        {"blade": MESH},
        title="a <b>bold</b> & title",
        tracked={"blade.tip": tip},
        elements={"blade": blade.model},
        inputs={"run.toml": "name = '</script><script>alert(1)</script>'"},
        units=SI,
    )
    return ReadPage(path)


def test_nodes_are_where_node_positions_has_them(page, machine):
    system, solution = machine
    body, motion = system.placed("blade").body, solution.bodies["blade"]
    ids = page.array(page.body("blade")["ids"])
    nodes = np.searchsorted(MESH.node_ids, ids)
    exact = sp.node_positions(body, motion, nodes)
    largest = np.linalg.norm(deflections(body, motion), axis=2).max()
    # Single precision of a place in a motion of 3 m is what remains beside the displacement.
    assert np.abs(page.positions("blade") - exact).max() < 1e-4 * largest + 4e-7
    found = page.field(page.body("blade")["displacement"])
    assert np.abs(found - deflections(body, motion)[:, nodes]).max() < 5e-5 * largest
    assert page.head["scene"]["scales"]["deflection"]["high"] == pytest.approx(largest, rel=1e-3)


def test_motions_on_other_columns_are_refused(tmp_path, machine):
    """As after reading a result and reducing again, where a column may have the other sign."""
    system, solution = machine
    known = replace(solution, columns=measured_columns(system))
    write_report(tmp_path / "run.html", system, known, {"blade": MESH})
    blade = system.placed("blade")
    basis = blade.body.nodal_basis * np.where(np.arange(blade.body.r) == 1, -1.0, 1.0)
    other = replace(blade, body=replace(blade.body, nodal_basis=basis))
    bodies = [other if placed is blade else placed for placed in system.bodies]
    with pytest.raises(ModelError, match=r"body 'blade' has other columns.*read_reduced_body"):
        write_report(tmp_path / "other.html", replace(system, bodies=bodies), known, {"blade": MESH})


def test_stress_is_that_of_its_history(page, machine, blade):
    system, solution = machine
    body, coordinates = system.placed("blade").body, solution.bodies["blade"].coordinates
    exact = von_mises_history(body, blade.model, coordinates)
    found = page.field(page.body("blade")["fields"]["von Mises stress"])[..., 0]
    scale = page.head["scene"]["scales"]["von Mises stress"]
    assert scale["label"] == "von Mises stress (MPa)"
    assert scale["high"] == pytest.approx(1e-6 * exact.max(), rel=1e-2)
    assert 1e-6 * np.abs(found - exact).max() <= scale["error"]


def test_marks_move_with_their_bodies(page, machine):
    system, solution = machine
    scene = page.head["scene"]
    (hinge,), (spring,), (arrow,) = scene["joints"], scene["links"], scene["arrows"]
    hub, blade = (system.placed(name).body for name in ("hub", "blade"))
    rim = hub.interface_motion(solution.bodies["hub"], "rim").position
    tip = blade.interface_motion(solution.bodies["blade"], "tip").position
    assert page.place(hinge["second"]) == pytest.approx(rim, abs=1e-5)
    assert page.place(hinge["first"])[0] == pytest.approx(system.initial_point(At("hub", "rim")), abs=1e-5)
    assert page.place(spring["first"]) == pytest.approx(rim, abs=1e-5)
    assert page.place(spring["second"]) == pytest.approx(tip, abs=1e-5)
    assert page.place(arrow["place"]) == pytest.approx(tip, abs=1e-5)
    assert page.array(arrow["values"])[2] == pytest.approx(5 * solution.times, rel=1e-6)
    assert hinge["kind"] == "revolute"
    # What a rigid body carries is one instant long, however long the run.
    assert hinge["second"]["moved"]["shape"] == [3, 1]


def test_curves_of_joints_and_tracked_places(page, machine):
    charts = {chart["title"]: chart for chart in page.head["charts"]}
    assert list(charts) == ["blade.tip, deflection", "blade.tip, position", "hinge, force", "hinge, moment"]
    exact = joint_loads(*machine)["hinge"]["moment"].T
    assert page.array(charts["hinge, moment"]["curves"]) == pytest.approx(exact, rel=1e-6, abs=1e-6)
    assert page.array(charts["hinge, moment"]["abscissa"])[0] == 2.0
    assert charts["hinge, moment"]["label"] == "moment (N m)"


def test_times_of_curves_are_exact_long_after_zero():
    times, arrays = 1e5 + 0.01 * np.arange(3), PackedArrays()
    (chart,) = chart_data([Chart("x", "x (m)", times, {"x": np.zeros(3)})], arrays)
    np.testing.assert_array_equal(unpacked(arrays.text(), chart["abscissa"]), times)


def test_the_error_comes_first_and_no_text_is_markup(page):
    body = page.text[page.text.index("<article>") : page.text.index("</article>")]
    assert re.findall(r"<h2>(.*?)</h2>", body) == ["Error of the run", "Results", "Inputs and versions"]
    assert "<title>a &lt;b&gt;bold&lt;/b&gt; &amp; title</title>" in page.text
    assert "<script>alert" not in page.text
    assert page.text.count("<script") == 4


def test_a_page_asks_nothing_of_a_network(page):
    policy = re.search(r'Content-Security-Policy" content="(.*?)"', page.text)
    assert policy
    assert policy.group(1).startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe" not in policy.group(1)
    assert not re.search(r"""(?:src|href)\s*=\s*["']?https?:""", page.text)


def test_a_body_without_a_mesh_is_drawn_by_its_nodes(tmp_path, machine):
    system, solution = machine
    read = ReadPage(write_report(tmp_path / "run.html", system, solution))
    data = read.body("blade")
    assert data["triangles"]["shape"] == [3, 0]
    assert data["nodes"]["shape"] == [len(system.placed("blade").body.nodes), 3]


def test_faces_inside_appear_where_an_element_is_deleted(tmp_path):
    system, solution = eroding([[1, 1, 1, 1], [1, 0, 1, 1], [1, 0, 0, 1]])
    bar = system.placed("bar").body
    page = ReadPage(write_report(tmp_path / "run.html", system, solution, {"bar": bar.mesh}))
    assert np.abs(page.positions("bar") - solution.bodies["bar"].nodes).max() < 1e-5
    data = page.body("bar")
    born, dies = page.array(data["lifetimes"])
    seen = [int(((born <= row) & (row < dies)).sum()) for row in range(3)]
    # Squares of a bar of four, of one and two cubes, and of two cubes, two triangles each.
    assert seen == [2 * 18, 2 * (6 + 10), 2 * (6 + 6)]


def test_deflection_of_what_has_no_axes_is_from_those_that_fit_best(tmp_path):
    system, solution = eroding(np.ones((3, 4)))
    page = ReadPage(write_report(tmp_path / "run.html", system, solution))
    found = page.field(page.body("bar")["displacement"])
    assert np.abs(found[0]).max() < 1e-6
    # One of its nodes is pulled by 0.2; the rest turns and flies without a deflection to speak of.
    assert 0.1 < np.linalg.norm(found[1], axis=1).max() < 0.2
    _, rotation = page.poses("bar")
    assert np.linalg.det(rotation) == pytest.approx(np.ones(3))


def test_a_run_that_stopped_says_why(tmp_path, machine):
    system, solution = machine
    stopped = Solution(
        solution.times, solution.bodies, solution.joint_forces, Statistics(), stopped="it broke"
    )
    text = write_report(tmp_path / "run.html", system, stopped).read_text()
    assert "Stopped at 3: it broke" in text


def test_ground_is_no_body(page):
    assert GROUND.body not in [body["name"] for body in page.head["scene"]["bodies"]]


def test_a_pressure_is_its_sum_and_a_force_on_each_node_too(tmp_path, clamped_blade):
    """A flat patch of 0.1 by 1 m whose normal turns with the blade; five newtons on each of two nodes."""
    system, solution = two_bodies(clamped_blade)
    faces = MESH.cells[CellType.TRIANGLE3]
    loads = [
        FollowerPressure(body="blade", faces=faces, pressure=30.0),
        DeadForce(body="blade", at=[0, 1], force=(0.0, 5.0, 0.0)),
    ]
    still = replace(system, loads=loads)
    flat = {"blade": replace(solution.bodies["blade"], coordinates=0 * solution.bodies["blade"].coordinates)}
    run = replace(solution, bodies=solution.bodies | flat)
    page = ReadPage(write_report(tmp_path / "run.html", still, run, {"blade": MESH}))
    pressure, force = (page.array(arrow["values"]).T for arrow in page.head["scene"]["arrows"])
    normal = solution.bodies["blade"].rotation[:, :, 2]
    assert np.abs(pressure) == pytest.approx(np.abs(30.0 * 0.1 * normal), abs=1e-5)
    assert force == pytest.approx(np.tile([0.0, 10.0, 0.0], (N_TIMES, 1)))


def test_beams_are_lines_beside_the_skin(tmp_path, clamped_blade):
    """Beams from node to node of the strip: as many more edges, and no triangle."""
    system, solution = two_bodies(clamped_blade)
    beams = np.column_stack([np.arange(MESH.n_nodes - 1), np.arange(1, MESH.n_nodes)])

    def drawn(cells):
        mesh = Mesh(MESH.nodes, cells, node_ids=MESH.node_ids)
        page = ReadPage(write_report(tmp_path / "run.html", system, solution, {"blade": mesh}))
        return [page.body("blade")[what]["shape"][-1] for what in ("triangles", "edges")]

    n_triangles, n_edges = drawn(MESH.cells)
    assert drawn(MESH.cells | {CellType.LINE2: beams}) == [n_triangles, n_edges + len(beams)]
    assert drawn({CellType.LINE2: beams}) == [0, len(beams)]


def test_a_notebook_has_the_page_in_a_frame(tmp_path, machine):
    system, solution = machine
    shown = sp.player(system, solution, {"blade": MESH})
    assert repr(shown) == f"<Player of {N_TIMES} output times, for a notebook; write_report writes a file>"
    frame = re.fullmatch(r'<iframe srcdoc="([^"<]*)" style="[^"]*"></iframe>', shown._repr_html_())
    assert frame
    path = tmp_path / "frame.html"
    path.write_text(unescape(frame.group(1)), encoding="utf-8")
    page, file = (
        ReadPage(path),
        ReadPage(write_report(tmp_path / "run.html", system, solution, {"blade": MESH})),
    )
    assert np.array_equal(page.positions("blade"), file.positions("blade"))
