"""Every picture is drawn, shows something, and refuses what it cannot show."""

import subprocess
import sys
import time
from dataclasses import replace
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from supple.errors import ModelError, ResultFileError
from supple.mesh import CellType, Skin, block, cylinder_shell, skin_of, strip
from supple.results import MotionError
from supple.viz import (
    PUBLISHED,
    REFERENCE,
    Camera,
    NodalField,
    Panel,
    Series,
    Traces,
    animate,
    displacement_magnitude,
    mode_titles,
    plot_error_over_parameter,
    plot_mesh,
    plot_mode_shapes,
    plot_rms_error,
    plot_time_history,
)
from supple.viz.shaded_surface import page_around, render

T = np.linspace(0.0, 10.0, 201)


@pytest.fixture
def beam():
    return strip(10.0, 0.5, 20, 2)


def bent(mesh, amount):
    return np.stack(
        [0 * mesh.nodes[:, 0], 0 * mesh.nodes[:, 0], amount * (mesh.nodes[:, 0] / 10.0) ** 2], axis=1
    )


# --- curves


def test_time_history(tmp_path, ink):
    ours, theirs = Series("ours", T, np.sin(T)), Series("theirs", T, np.sin(T) + 0.1, REFERENCE)
    peaks = Series("published", np.array([1.57]), np.array([1.0]), PUBLISHED)
    path = plot_time_history(
        tmp_path / "tip.png", [Panel("u (m)", [ours, theirs]), Panel("v (m)", [ours, peaks])]
    )
    assert path == tmp_path / "tip.png"
    assert 0.01 < ink(path) < 0.5


@pytest.mark.parametrize("suffix", [pytest.param("pdf", marks=pytest.mark.slow), "svg"])
def test_the_suffix_chooses_the_format_and_the_same_data_gives_the_same_file(tmp_path, suffix):
    panels = [Panel("u (m)", [Series("ours", T, np.sin(T))])]
    one = plot_time_history(tmp_path / f"one.{suffix}", panels)
    two = plot_time_history(tmp_path / f"two.{suffix}", panels)
    assert one.read_bytes() == two.read_bytes()


def test_drawing_leaves_the_settings_of_matplotlib_alone(tmp_path):
    # Reading the backend would choose one.
    def settings():
        return {name: mpl.rcParams[name] for name in mpl.rcParams if name != "backend"}

    before = settings()
    plot_time_history(tmp_path / "tip.png", [Panel("u (m)", [Series("ours", T, np.sin(T))])])
    assert settings() == before


@pytest.mark.slow
def test_drawing_needs_neither_pyplot_nor_a_window(tmp_path):
    script = "import sys, numpy as np; from supple.viz import *; t = np.arange(3.0)\n"
    script += f"plot_time_history({str(tmp_path / 'a.png')!r}, [Panel('u', [Series('a', t, t)])])\n"
    script += "sys.exit('matplotlib.pyplot' in sys.modules)"
    subprocess.run([sys.executable, "-c", script], check=True)


def test_bad_curves(tmp_path):
    with pytest.raises(ModelError, match=r"series 'a': times of shape \(201,\) and values of shape \(3,\)"):
        Series("a", T, np.zeros(3))
    with pytest.raises(ModelError, match="series 'a': no value is finite"):
        Series("a", T, np.full(201, np.nan))
    with pytest.raises(ModelError, match="at least one panel"):
        plot_time_history(tmp_path / "a.png", [])
    with pytest.raises(ModelError, match="each panel at least one series"):
        plot_time_history(tmp_path / "a.png", [Panel("u", [])])


def test_bad_paths(tmp_path):
    panels = [Panel("u (m)", [Series("ours", T, np.sin(T))])]
    with pytest.raises(ModelError, match=r"no picture format '\.bmpp'; use one of .*png"):
        plot_time_history(tmp_path / "a.bmpp", panels)
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultFileError, match="cannot write"):
        plot_time_history(tmp_path / "file" / "a.png", panels)


# --- errors


def motion_error(scale):
    return MotionError(T, scale * T * np.abs(np.sin(T) + 1.1), 0.01)


def test_rms_error(tmp_path, ink):
    errors = {"nodal-fixed": motion_error(1e-4), "mean-axis": motion_error(1e-5)}
    path = plot_rms_error(tmp_path / "rms.png", errors, published={"nodal-fixed": 1.5e-4, "limit": 1e-2})
    assert 0.01 < ink(path) < 0.5


def test_error_over_parameter(tmp_path, ink):
    errors = {"a": np.array([1e-3, 2e-3, 5e-3]), "b": np.array([1e-4, np.nan, 1e-3])}
    path = plot_error_over_parameter(
        tmp_path / "re.png", np.array([6.0, 8.0, 10.0]), errors, parameter_label="speed (rad/s)"
    )
    assert 0.01 < ink(path) < 0.5


def test_bad_errors(tmp_path):
    exact = replace(motion_error(1.0), rms=np.zeros(201))
    with pytest.raises(ModelError, match="error 'a' is nowhere positive"):
        plot_rms_error(tmp_path / "a.png", {"a": exact})
    with pytest.raises(ModelError, match="at least one error over time"):
        plot_rms_error(tmp_path / "a.png", {})
    with pytest.raises(ModelError, match="at least one error"):
        plot_error_over_parameter(tmp_path / "a.png", T, {}, parameter_label="t")
    with pytest.raises(ModelError, match="error 'a': 2 values for 201 t"):
        plot_error_over_parameter(tmp_path / "a.png", T, {"a": np.ones(2)}, parameter_label="t")


# --- surfaces


@pytest.mark.slow
@pytest.mark.parametrize("cell_type", [CellType.TETRA10, CellType.HEXA8])
def test_mesh_of_a_solid(tmp_path, ink, cell_type):
    mesh = block(2.0, 1.0, 0.5, 4, 2, 2, cell_type)
    assert 0.2 < ink(plot_mesh(tmp_path / "mesh.png", mesh.nodes, skin_of(mesh), title="block")) < 0.9


def test_deformed_shell_over_its_outline(tmp_path, ink, beam):
    u = bent(beam, 2.0)
    path = plot_mesh(
        tmp_path / "bent.png",
        beam.nodes + u,
        skin_of(beam),
        colour_by=displacement_magnitude(u),
        undeformed=beam.nodes,
        camera=Camera.looking(along=[0.2, 1.0, -0.3], up=[0.0, 0.0, 1.0]),
    )
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("HSV")).reshape(-1, 3)
    hues = pixels[pixels[:, 1] > 100, 0]
    # The colour map runs from violet over green to yellow.
    assert np.ptp(hues) > 100


def test_a_square_looks_square():
    mesh = strip(1.0, 1.0, 2, 2)
    camera = Camera.looking(along=[0.0, 0.0, -1.0], up=[0.0, 1.0, 0.0])
    page = page_around(camera.project(mesh.nodes)[0], 100)
    covered = render(mesh.nodes, skin_of(mesh), camera, page)[..., 3] > 0.5
    assert covered.any(axis=0).sum() == covered.any(axis=1).sum()
    assert covered.sum() == covered.any(axis=0).sum() ** 2


def test_faces_turned_to_the_light_are_brighter():
    mesh = block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8)
    camera = Camera.looking(along=[-1.0, 1.0, -1.0], up=[0.0, 0.0, 1.0])
    page = page_around(camera.project(mesh.nodes)[0], 60)
    picture = render(mesh.nodes, skin_of(mesh), camera, page)
    top, left, right = picture[50, 30, :3].sum(), picture[20, 15, :3].sum(), picture[20, 45, :3].sum()
    assert top > left > right


@pytest.mark.slow
def test_a_large_mesh_takes_about_a_second(tmp_path):
    mesh = cylinder_shell(2.0, 60.0, 120, 36)
    assert len(skin_of(mesh).triangles) > 8394
    start = time.process_time()
    plot_mesh(
        tmp_path / "large.png", mesh.nodes, skin_of(mesh), colour_by=NodalField("z (m)", mesh.nodes[:, 2])
    )
    assert time.process_time() - start < 5.0


def test_bad_surfaces(tmp_path, beam):
    path, seen = tmp_path / "a.png", skin_of(beam)
    with pytest.raises(ModelError, match=r"positions of shape \(63, 2\): give \(N, 3\)"):
        plot_mesh(path, beam.nodes[:, :2], seen)
    with pytest.raises(ModelError, match="skin of nodes 0 to 62: there are 62 positions"):
        plot_mesh(path, beam.nodes[:-1], seen)
    lost = beam.nodes.copy()
    lost[7, 1] = np.nan
    with pytest.raises(ModelError, match="node 7 is not at a finite position"):
        plot_mesh(path, beam.nodes, seen, undeformed=lost)
    with pytest.raises(
        ModelError, match=r"field 'T' of shape \(3,\): give a finite value at each of 63 nodes"
    ):
        plot_mesh(path, beam.nodes, seen, colour_by=NodalField("T", np.zeros(3)))


# --- modes


def test_mode_shapes(tmp_path, ink, beam):
    x = beam.nodes[:, 0] / 10.0
    modes = np.stack([np.stack([0 * x, 0 * x, np.sin(k * np.pi * x)], axis=1) for k in (1, 2, 3)])
    path = plot_mode_shapes(
        tmp_path / "modes.png", beam.nodes, skin_of(beam), modes, mode_titles(np.array([1.0, 4.0, 9.0]))
    )
    assert 0.02 < ink(path) < 0.5


@pytest.mark.slow
def test_mode_shapes_do_not_depend_on_the_scale_of_the_modes(tmp_path, beam):
    modes = bent(beam, 1.0)[None]
    one = plot_mode_shapes(tmp_path / "1.png", beam.nodes, skin_of(beam), modes, ["one"])
    two = plot_mode_shapes(tmp_path / "2.png", beam.nodes, skin_of(beam), 1e4 * modes, ["one"])
    with Image.open(one) as first, Image.open(two) as second:
        np.testing.assert_allclose(np.asarray(first, int), np.asarray(second, int), atol=2)


def test_bad_modes(tmp_path, beam):
    path, seen, modes = tmp_path / "a.png", skin_of(beam), np.ones((2, 63, 3))
    with pytest.raises(ModelError, match=r"modes of shape \(2, 63, 3\) with 3 titles"):
        plot_mode_shapes(path, beam.nodes, seen, modes, ["one"] * 3)
    with pytest.raises(ModelError, match="mode 2 has no finite displacement"):
        plot_mode_shapes(path, beam.nodes, seen, modes * np.array([1.0, 0.0])[:, None, None], ["one"] * 2)
    with pytest.raises(ModelError, match="n_columns is 0"):
        plot_mode_shapes(path, beam.nodes, seen, modes, ["one"] * 2, n_columns=0)


# --- animations


def turning(mesh, n_frames=6):
    angle = np.linspace(0.0, 1.0, n_frames)
    c, s = np.cos(angle), np.sin(angle)
    R = np.moveaxis(np.array([[c, -s, 0 * c], [s, c, 0 * c], [0 * c, 0 * c, 0 * c + 1]]), -1, 0)
    return angle, np.einsum("tij,nj->tni", R, mesh.nodes)


def test_animation_has_a_frame_for_each_time_and_moves(tmp_path, beam):
    times, positions = turning(beam)
    shares = []
    path = animate(
        tmp_path / "film.gif",
        times,
        positions,
        skin_of(beam),
        values=np.linalg.norm(positions - positions[0], axis=2),
        traces=Traces(times, positions[:, beam.nodes_of("tip_centre")[:1]]),
        n_columns=200,
        frames_per_second=25.0,
        progress=shares.append,
    )
    np.testing.assert_allclose(shares, np.arange(1, 7) / 6)
    with Image.open(path) as animation:
        assert animation.n_frames == 6
        assert animation.info["duration"] == 40
        frames = []
        for i in range(6):
            animation.seek(i)
            frames.append(np.asarray(animation.convert("RGB"), dtype=int))
    assert all((frame[5, 5] == 255).all() for frame in frames)
    assert all(np.abs(later - earlier).max() > 50 for earlier, later in pairwise(frames))


def test_a_path_goes_through_places_between_the_frames(tmp_path, beam):
    """A full turn in three frames is a circle: its points are as far from the middle."""
    angle = np.linspace(0.0, 2 * np.pi, 200)
    circle = 10 * np.ptp(beam.nodes) * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    film = animate(
        tmp_path / "turn.gif",
        np.arange(3.0),
        np.repeat(beam.nodes[None], 3, axis=0),
        skin_of(beam),
        camera=Camera.looking(along=(0.0, 0.0, -1.0), up=(0.0, 1.0, 0.0)),
        traces=Traces(np.linspace(0.0, 2.0, 200), circle[:, None]),
    )
    with Image.open(film) as turn:
        on_path = []
        for number in range(3):
            turn.seek(number)
            red, _, blue = np.moveaxis(np.asarray(turn.convert("RGB"), dtype=float), -1, 0)
            on_path.append(np.argwhere(red - blue > 100))
    middle = 0.5 * (on_path[2].min(axis=0) + on_path[2].max(axis=0))
    radius = np.linalg.norm(on_path[2] - middle, axis=1)
    assert radius == pytest.approx(radius.mean(), rel=0.02)
    assert len(on_path[0]) == 0
    assert len(on_path[1]) == pytest.approx(0.5 * len(on_path[2]), rel=0.05)


def test_a_body_at_rest_still_gives_every_frame(tmp_path, beam):
    still = np.repeat(beam.nodes[None], 3, axis=0)
    path = animate(tmp_path / "still.gif", np.arange(3.0), still, skin_of(beam), n_columns=120)
    with Image.open(path) as animation:
        assert animation.n_frames == 3


def test_bad_animations(tmp_path, beam):
    (times, positions), seen, path = turning(beam), skin_of(beam), tmp_path / "a.gif"
    with pytest.raises(ModelError, match=r"end the path in \.gif or \.mp4"):
        animate(tmp_path / "a.avi", times, positions, seen)
    with pytest.raises(ModelError, match=r"positions of shape \(6, 63, 3\) at 5 times"):
        animate(path, times[:-1], positions, seen)
    with pytest.raises(ModelError, match="skin of nodes"):
        animate(path, times, positions[:, :-1], seen)
    with pytest.raises(ModelError, match=r"values of shape \(6, 2\): give finite values of shape \(6, 63\)"):
        animate(path, times, positions, seen, values=np.zeros((6, 2)))
    with pytest.raises(ModelError, match=r"points of shape \(6, 63, 3\) at 5 times"):
        animate(path, times, positions, seen, traces=Traces(times[:-1], positions))
    with pytest.raises(ModelError, match="times that do not ascend"):
        animate(path, times, positions, seen, traces=Traces(times[::-1], positions))
    with pytest.raises(ModelError, match=r"at 60\.0 frames per second"):
        animate(path, times, positions, seen, frames_per_second=60.0)
    assert not list(tmp_path.iterdir())


def test_plain_triangles_have_a_skin(tmp_path, ink, beam):
    plain = Skin.of_triangles(beam.cells[CellType.TRIANGLE3])
    assert ink(plot_mesh(tmp_path / "a.png", beam.nodes, plain)) > 0.02
