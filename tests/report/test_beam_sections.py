"""Beams in the page are prisms of their sections, which turn with their nodes and show their stress."""

import numpy as np
import pytest
from fixtures.moving_machines import beam_frame
from fixtures.report_page import ReadPage

from supple.quantities import deflections, von_mises_by_end
from supple.report import write_report
from supple.results import body_surface


@pytest.fixture(scope="module")
def frame():
    """(system, solution, model)."""
    return beam_frame()


@pytest.fixture(scope="module")
def page(frame, tmp_path_factory):
    system, solution, model = frame
    path = tmp_path_factory.mktemp("page") / "run.html"
    return ReadPage(write_report(path, system, solution, {"frame": model}, elements={"frame": model}))


def test_skins_are_where_pictures_have_them(page, frame):
    """All points of the surface, nodes first, at all instants; no triangle is on a node itself."""
    system, solution, model = frame
    body, motion = system.placed("frame").body, solution.bodies["frame"]
    exact = body_surface(model).positions(body, motion)
    largest = np.linalg.norm(deflections(body, motion), axis=2).max()
    assert largest > 0.05
    assert np.abs(page.positions("frame") - exact).max() < 1e-4 * largest + 2e-5  # single precision at 300 m
    data = page.body("frame")
    assert page.array(data["triangles"]).min() == model.mesh.n_nodes
    assert page.array(data["carriers"]).tolist() == body_surface(model).nodes.tolist()
    assert (page.array(data["ids"]) == model.mesh.node_ids[body_surface(model).nodes]).all()


def test_stress_is_that_of_each_end_and_missing_where_it_is_not_known(page, frame):
    system, solution, model = frame
    body, motion = system.placed("frame").body, solution.bodies["frame"]
    surface = body_surface(model)
    exact = surface.at_points(von_mises_by_end(body, model, motion.coordinates))
    unknown = page.array(page.body("frame")["unknown"]).astype(bool)
    assert np.array_equal(unknown, np.isnan(exact).all(axis=0))
    assert 0 < unknown.sum() < len(unknown)
    found = page.field(page.body("frame")["fields"]["von Mises stress"])[..., 0]
    scale = page.head["scene"]["scales"]["von Mises stress"]
    assert np.nanmax(np.abs(found - exact)) * scale["factor"] <= scale["error"]
    assert not found[:, unknown].any()


def test_without_sections_they_are_lines(tmp_path, frame):
    system, solution, model = frame
    page = ReadPage(write_report(tmp_path / "run.html", system, solution, {"frame": model.mesh}))
    data = page.body("frame")
    assert data["triangles"]["shape"] == [3, 0]
    assert page.array(data["edges"]).T.tolist() == model.mesh.cells[next(iter(model.mesh.cells))].tolist()
    assert data["carriers"] is None
