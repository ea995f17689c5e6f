"""Machines are seen from one side, deformed by the factor asked for, walls never before what they touch."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.explicit_bars import explicit_bar
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from supple.body import RigidBody
from supple.errors import ModelError
from supple.integrate import FloatingMotion, Solution, Statistics
from supple.machine import GROUND, At, Contact, Placed, Revolute, RigidPlane, System
from supple.mesh import CellType, cylinder, skin_of, strip
from supple.mesh.feature_edges import feature_edges, silhouette_edges
from supple.methods.explicit import NodalMotion
from supple.quantities import deflections, observer
from supple.results.body_surface import body_surface
from supple.results.camera import View
from supple.results.colouring import DEFLECTION
from supple.units import SI
from supple.viz import Camera, Film, RotorAngle, animate_run, run_animation, run_pictures
from supple.viz.glyphs import Glyphs, Mark, MarkStyle
from supple.viz.machine_camera import machine_camera
from supple.viz.machine_scene import machine_scene
from supple.viz.mesh_plot import draw_surface
from supple.viz.rest_and_mode_pictures import animate_mode, draw_mode, draw_rest
from supple.viz.style import textbook_style

FRONT = Camera.looking(along=(0.0, 1.0, 0.0), up=(0.0, 0.0, 1.0))
NOW = np.array([0, 1])


def turn_about_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.fixture
def bent(clamped_blade):
    """The blade turned by 0, 1 and 2 rad, away from the origin, and bent in its first mode."""
    still, turned = np.full((3, 3), 2.0), np.stack([turn_about_z(each) for each in range(3)])
    many = np.outer([0.5, 1.0, -1.0], 1e-3 * np.eye(clamped_blade.r)[0])
    motion = FloatingMotion(still, turned, many, 0 * still, 0 * still, many, 0 * still, 0 * still, many)
    solution = Solution(np.arange(3.0), {"blade": motion}, {}, Statistics())
    return System(bodies=(Placed(clamped_blade),)), solution, {"blade": strip(1.0, 0.1, 6, 2)}


def test_a_title_stays_on_the_page_above_a_legend_of_several_rows():
    """Seven kinds of marks need two rows of the legend, on a page for a flat machine."""
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.2]])
    marks = tuple(Mark(MarkStyle(f"kind of joint {i}", "o"), points[None]) for i in range(7))
    glyphs = Glyphs(np.empty((1, 0, 2, 3)), marks)
    with textbook_style():
        figure, axes, _ = draw_surface(
            np.empty((0, 3)),
            None,
            colour_by=None,
            undeformed=None,
            glyphs=glyphs,
            camera=FRONT,
            title="t = 0 s",
            units=SI,
        )
        FigureCanvasAgg(figure).draw()
        drawn = axes.title.get_window_extent()
    assert drawn.y1 <= figure.bbox.y1


# --- enlargement


def test_an_enlargement_multiplies_deflections_and_leaves_the_interface_where_it_is(bent):
    system, solution, meshes = bent
    body = system.bodies[0].body
    small, large = (
        machine_scene(*bent, NOW, FRONT, enlargement=factor, colouring=DEFLECTION) for factor in (1.0, 20.0)
    )
    seen_from = observer(body, solution.bodies["blade"].at(NOW))
    along = small.positions - seen_from.origin[:, None], large.positions - seen_from.origin[:, None]
    seen = [np.einsum("tij,tni->tnj", seen_from.axes, each) for each in along]
    rest = body.nodes - seen_from.rest
    expected = deflections(body, solution.bodies["blade"].at(NOW))
    assert np.abs(expected).max() > 1e-4
    np.testing.assert_allclose(seen[0] - rest, expected, atol=1e-12)
    np.testing.assert_allclose(seen[1] - rest, 20.0 * expected, atol=1e-11)
    root = meshes["blade"].nodes_of("root")
    np.testing.assert_allclose(large.positions[:, root], small.positions[:, root], atol=1e-9)
    # Colours are those of the deflection as it is.
    np.testing.assert_allclose(large.values, small.values)
    np.testing.assert_allclose(small.values, np.linalg.norm(expected, axis=2))


def test_outlines_are_of_the_undeformed_body_where_its_interface_is(bent):
    system, solution, meshes = bent
    scene = machine_scene(*bent, NOW, FRONT)
    seen_from = observer(system.bodies[0].body, solution.bodies["blade"].at(NOW[:1]))
    rest = meshes["blade"].nodes - seen_from.rest
    np.testing.assert_allclose(scene.undeformed, seen_from.origin[0] + rest @ seen_from.axes[0].T, atol=1e-12)


def hit(camera):
    bar = explicit_bar(CellType.HEXA8)
    nodes = np.broadcast_to(bar.nodes, (2, *bar.nodes.shape))
    still = np.zeros((2, 4))
    motion = NodalMotion(nodes, 0 * nodes, 0 * nodes, still, still + 1, still)
    wall = RigidPlane((4.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    system = System([bar], contacts=[Contact(At("bar", "tip"), wall)])
    series = {"obstacles": np.zeros((2, 1, 6))}
    solution = Solution(np.arange(2.0), {"bar": motion}, {}, Statistics(), series=series)
    return system, solution, {"bar": bar.mesh}, camera


def test_explicit_elements_are_not_enlarged():
    system, solution, meshes, camera = hit(FRONT)
    with pytest.raises(ModelError, match="draw it true to scale"):
        machine_scene(system, solution, meshes, NOW, camera, enlargement=2.0)


# --- walls


@pytest.mark.parametrize("sight", [0.5, 0.0, -0.5])
def test_a_wall_seen_from_behind_is_an_outline(sight):
    """It would stand before the nose that hits it."""
    camera = Camera.looking(along=(sight, 1.0, -0.2), up=(0.0, 0.0, 1.0))
    system, solution, meshes, _ = hit(camera)
    scene = machine_scene(system, solution, meshes, NOW, camera)
    bar = len(skin_of(meshes["bar"]).triangles)
    assert scene.skin is not None
    if sight > 0:  # along the way of the bar: the viewer is on the side of the bar
        assert len(scene.skin.triangles) == bar + 2
        assert scene.glyphs.is_empty
    else:
        assert len(scene.skin.triangles) == bar
        assert scene.glyphs.thin_lines is not None
        assert scene.glyphs.thin_lines.shape == (2, 4, 2, 3)
        np.testing.assert_allclose(scene.glyphs.thin_lines[..., 0], 4.0)


@pytest.mark.parametrize("normal", np.vstack([np.eye(3), -np.eye(3)]).tolist())
@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), (0.0, 0.0, -9.81), (0.0, 9.81, 0.0)])
def test_the_side_of_a_machine_has_gravity_down_and_walls_before_the_viewer(normal, gravity):
    system, solution, meshes, _ = hit(FRONT)
    wall = RigidPlane((4.0, 0.0, 0.0), tuple(normal))
    system = System(system.bodies, contacts=[Contact(At("bar", "tip"), wall)], gravity=np.array(gravity))
    camera = machine_camera(system, solution, meshes)
    if any(gravity):
        right, up = camera.project(np.array(gravity))[0]
        assert right == pytest.approx(0.0, abs=1e-12)
        assert up < 0
    assert camera.axes[2] @ np.array(normal) > 0.1


# --- one side


def test_a_body_is_seen_from_the_side_from_which_its_machine_is_seen(bent, monkeypatch, tmp_path):
    system, solution, meshes = bent
    placed = Placed(system.bodies[0].body, rotation=turn_about_z(0.7), position=[1.0, 2.0, 3.0])
    found = {}
    for name in ("draw_mesh", "draw_deformed", "draw_modes"):
        monkeypatch.setattr(
            run_pictures, name, lambda path, drawn, *_, name=name: found.update({name: drawn.view.camera})
        )
    camera = Camera.looking(along=(1.0, 2.0, -1.0), up=(0.0, 0.0, 1.0))
    run_pictures.draw_run(tmp_path, System((placed,)), solution, meshes, view=View(camera))
    nodes = meshes["blade"].nodes
    expected = camera.project(nodes @ turn_about_z(0.7).T)[0]
    assert len(found) == 3
    for each in found.values():
        np.testing.assert_allclose(each.project(nodes)[0], expected, atol=1e-12)


# --- outlines


def test_the_outline_of_a_round_body_has_its_silhouette():
    bar = cylinder(0.5, 4.0, 6, 1, 6, CellType.HEXA8)
    skin = skin_of(bar)
    edges = silhouette_edges(bar.nodes, skin.triangles, np.array([0.0, 0.0, 1.0]))
    lengthwise = np.ptp(bar.nodes[edges][..., 0], axis=1) > 1e-9
    sides = bar.nodes[edges[lengthwise]]
    # Lines of six cells along both sides, where the surface turns away.
    assert lengthwise.sum() == 12
    assert np.abs(sides[..., 1]).min() > 0.45
    plain = feature_edges(bar.nodes, skin.triangles)
    assert not (np.ptp(bar.nodes[plain][..., 0], axis=1) > 1e-9).any()
    turned = skin.triangles.copy()
    turned[::2] = turned[::2, ::-1]
    again = silhouette_edges(bar.nodes, turned, np.array([0.0, 0.0, 1.0]))
    assert {tuple(edge) for edge in again} == {tuple(edge) for edge in edges}


# --- films of machines


@pytest.fixture(scope="module")
def rotor():
    """A rotor that turns at 2 rad/s, outputs every 0.05 s."""
    times = np.linspace(0.0, 12.0, 241)
    body = RigidBody("hub", 1.0, np.zeros(3), np.eye(3), {"axle": np.zeros(3), "tip": np.array([1.0, 0, 0])})
    shaft = Revolute(name="shaft", first=GROUND, second=At("hub", "axle"), axis=(0.0, 0.0, 1.0))
    turned = np.stack([turn_about_z(2.0 * each) for each in times])
    still, spin = np.zeros((241, 3)), np.tile([0.0, 0.0, 2.0], (241, 1))
    none = np.zeros((241, 0))
    motion = FloatingMotion(still, turned, none, still, spin, none, still, still, none)
    solution = Solution(times, {"hub": motion}, {}, Statistics())
    return System((Placed(body),), (shaft,)), solution


def shown(monkeypatch):
    """What is passed on to be drawn as a film."""
    given = {}

    def take(path, times, positions, skin, **options):
        given.update(options, times=times, positions=positions)
        return path

    monkeypatch.setattr(run_animation, "animate", take)
    return given


def test_a_stroboscope_shows_a_rotor_at_its_angle(rotor, tmp_path, monkeypatch):
    given = shown(monkeypatch)
    animate_run(tmp_path / "a.gif", *rotor, {}, film=Film(at=RotorAngle("shaft", 0.5)))
    passed = (0.5 + 2 * np.pi * np.arange(4)) / 2.0
    np.testing.assert_allclose(given["times"], passed, atol=0.026)
    tips = given["glyphs"].lines[:, 1, 1]
    np.testing.assert_allclose(tips, np.tile([np.cos(0.5), np.sin(0.5), 0.0], (4, 1)), atol=0.051)
    assert given["caption"].startswith("shaft at 28.65° (within ")


def test_a_film_states_its_enlargement_and_shows_its_window(bent, tmp_path, monkeypatch):
    given = shown(monkeypatch)
    film, view = Film(10.0, speed=5.0, start=1.0), View(FRONT, 20.0)
    animate_run(tmp_path / "a.gif", *bent, film=film, view=view)
    assert given["caption"] == "deflection enlarged 20 times"
    assert given["times"].tolist() == [1.0, 2.0]
    assert given["shown"].tolist() == [0, 0, 1] or given["shown"].tolist() == [0, 1, 1]
    assert given["camera"] is FRONT


@pytest.mark.slow
def test_a_film_of_a_window_is_a_file_of_that_length(rotor, tmp_path):
    path = animate_run(tmp_path / "a.gif", *rotor, {}, film=Film(20.0, speed=1.0, end=0.5), units=SI)
    assert path is not None
    with Image.open(path) as film:
        assert film.n_frames == 11
        assert film.info["duration"] == 50


# --- rest and modes


def titles_of(monkeypatch):
    given = {}
    monkeypatch.setattr(run_pictures, "plot_mesh", lambda path, *_, **own: given.update(own) or path)
    return given


def test_a_rest_is_coloured_over_its_undeformed_shape_and_is_no_instant(bent, tmp_path, monkeypatch):
    system, solution, meshes = bent
    still = Solution(solution.times[:1], {"blade": solution.bodies["blade"].at([0])}, {}, Statistics())
    given = titles_of(monkeypatch)
    draw_rest(tmp_path / "a.png", system, still, meshes, units=SI)
    size = np.linalg.norm(deflections(system.bodies[0].body, still.bodies["blade"])[0], axis=1).max()
    assert given["title"].startswith("equilibrium, deflection enlarged ")
    assert "t =" not in given["title"]
    assert given["colour_by"].label == "deflection (m)"
    assert given["colour_by"].values.max() == pytest.approx(size)
    assert given["undeformed"] is not None


def test_a_mode_is_coloured_over_the_machine_at_rest_and_states_its_size(bent, tmp_path, monkeypatch):
    system, motion, meshes = bent
    body = system.bodies[0].body
    rest = Solution(np.zeros(1), {"blade": motion.bodies["blade"].at([1])}, {}, Statistics())
    given, film = titles_of(monkeypatch), shown(monkeypatch)
    draw_mode(tmp_path / "a.png", system, motion, rest, meshes, title="mode 1:  2 Hz", units=SI)
    nodes = body.positions(motion.bodies["blade"])
    ways = np.linalg.norm(nodes - nodes[1], axis=2)
    assert given["title"] == f"mode 1:  2 Hz, largest displacement drawn as {ways.max():.3g} m"
    np.testing.assert_allclose(given["colour_by"].values, ways[0] / ways.max(), atol=1e-12)
    np.testing.assert_allclose(given["undeformed"], nodes[1], atol=1e-12)
    animate_mode(tmp_path / "a.gif", system, motion, rest, meshes, title="mode 1:  2 Hz", units=SI)
    np.testing.assert_allclose(film["values"], ways / ways.max(), atol=1e-12)
    assert film["values_label"] == "displacement, share of the largest"
    assert film["caption"].startswith("mode 1:  2 Hz\nlargest displacement")


def test_a_machine_of_one_round_body_is_drawn(bent, tmp_path, ink):
    """The whole way to the file, with colour, outline and bar."""
    path = draw_rest(tmp_path / "a.png", *bent)
    assert path is not None
    assert ink(path) > 0.02
    assert body_surface(bent[2]["blade"]).skin is not None
