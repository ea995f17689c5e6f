"""Contours show bands, their bar and the place of the largest value, and refuse what is not a field."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from PIL import Image

from supple.errors import ModelError
from supple.mesh import CellType, block, skin_of, strip
from supple.units import SI
from supple.viz import Camera, NodalField, animate, plot_contour, stress_field
from supple.viz.shaded_surface import is_seen, page_around

FROM_ABOVE = Camera.looking(along=[0.0, 0.0, -1.0], up=[0.0, 1.0, 0.0])


@pytest.fixture
def plate():
    return strip(10.0, 5.0, 20, 10)


def colours(path):
    """Saturated colours of a picture and how many pixels each has, most first."""
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("RGB")).reshape(-1, 3)
    pixels = pixels[np.ptp(pixels.astype(int), axis=1) > 60]
    found, count = np.unique(pixels, axis=0, return_counts=True)
    return found[np.argsort(-count)], np.sort(count)[::-1]


def test_stress_is_read_in_megapascals():
    field = stress_field(np.array([1.0e6, 2.5e8]), SI)
    np.testing.assert_allclose(field.values, [1.0, 250.0])
    assert "MPa" in field.label


@pytest.mark.slow
def test_a_field_is_drawn_in_at_most_so_many_bands(tmp_path, plate):
    field = NodalField("x (m)", plate.nodes[:, 0])
    few = colours(plot_contour(tmp_path / "5.png", plate.nodes, skin_of(plate), field, n_bands=5))[1]
    many = colours(plot_contour(tmp_path / "20.png", plate.nodes, skin_of(plate), field, n_bands=20))[1]
    # Each band is one colour on a flat body in one light, but for mesh lines and the edges of bands.
    assert 0.5 * few[:5].sum() > few[5:].max() * 5
    assert (few > 0.05 * few[0]).sum() < (many > 0.05 * many[0]).sum()


def test_a_part_without_values_is_plain_and_not_in_the_highest_colour(tmp_path, plate):
    """The half without values shows none of the saturated colours of the bands."""
    x = plate.nodes[:, 0]
    field = NodalField("f", np.where(x < 5.0, x, np.nan))
    path = plot_contour(tmp_path / "half.png", plate.nodes, skin_of(plate), field, camera=FROM_ABOVE)
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("RGB"), dtype=int)
    body = pixels[: len(pixels) // 2]
    saturated = np.ptp(body, axis=2) > 60
    left, right = np.array_split(saturated, 2, axis=1)
    assert left.mean() > 0.2
    assert right.mean() < 0.02


@pytest.mark.slow
def test_the_largest_value_is_marked_where_it_is(tmp_path, plate):
    """The dark ring and text lie in the half of the picture where the peak is."""
    dark = []
    for x in (0.0, 10.0):
        field = NodalField("f", -np.abs(plate.nodes[:, 0] - x) - np.abs(plate.nodes[:, 1]))
        path = plot_contour(tmp_path / f"{x}.png", plate.nodes, skin_of(plate), field, camera=FROM_ABOVE)
        with Image.open(path) as picture:
            pixels = np.asarray(picture.convert("RGB"), dtype=int)
        body = pixels[: int(0.5 * len(pixels))]
        # Ink is dark and grey; the darkest colour of the map is violet.
        ink = (body.max(axis=2) < 80) & (np.ptp(body, axis=2) < 12)
        dark.append([half.sum() for half in np.array_split(ink, 2, axis=1)])
    assert dark[0][0] > dark[1][0]
    assert dark[1][1] > dark[0][1]


@pytest.mark.slow
def test_values_inside_a_solid_are_not_its_largest(tmp_path):
    mesh = block(1.0, 1.0, 1.0, 2, 2, 2, CellType.HEXA8)
    inside = np.ones(mesh.n_nodes)
    (middle,) = np.flatnonzero((np.abs(mesh.nodes - mesh.nodes.mean(axis=0)) < 1e-9).all(axis=1))
    with_peak = inside.copy()
    with_peak[middle] = 100.0
    one = plot_contour(tmp_path / "1.png", mesh.nodes, skin_of(mesh), NodalField("f", inside))
    two = plot_contour(tmp_path / "2.png", mesh.nodes, skin_of(mesh), NodalField("f", with_peak))
    assert one.read_bytes() == two.read_bytes()


@pytest.mark.slow
def test_a_mark_on_the_far_side_says_so(tmp_path, monkeypatch):
    mesh = block(2.0, 1.0, 0.5, 4, 2, 2, CellType.HEXA8)
    camera = Camera.three_quarter(mesh.nodes)
    near = camera.project(mesh.nodes)[1]
    words, annotate = {}, Axes.annotate

    def noted(axes, text, *args, **kwargs):
        if text.startswith("largest"):
            words[node] = text
        return annotate(axes, text, *args, **kwargs)

    monkeypatch.setattr(Axes, "annotate", noted)
    for node in (int(near.argmax()), int(near.argmin())):
        field = NodalField("f", -np.linalg.norm(mesh.nodes - mesh.nodes[node], axis=1))
        plot_contour(tmp_path / f"{node}.png", mesh.nodes, skin_of(mesh), field)
    assert not words[int(near.argmax())].endswith("on the far side")
    assert words[int(near.argmin())].endswith(f"node {near.argmin()} on the far side")


def test_what_is_seen_of_a_block():
    mesh = block(2.0, 1.0, 0.5, 4, 2, 2, CellType.HEXA8)
    skin = skin_of(mesh)
    page = page_around(FROM_ABOVE.project(mesh.nodes)[0], 200)
    x, y, z = mesh.nodes.T
    for node in np.flatnonzero((z == z.max()) | (z == z.min())):
        on_rim = x[node] in (0.0, 2.0) or abs(y[node] - y.mean()) > 0.49
        if z[node] == z.max() or not on_rim:
            seen = is_seen(mesh.nodes, skin, FROM_ABOVE, page, int(node))
            assert seen == (z[node] == z.max())


def test_bad_contours(tmp_path, plate):
    with pytest.raises(ModelError, match="contour of 'f': 1 bands; give at least 2"):
        plot_contour(
            tmp_path / "a.png", plate.nodes, skin_of(plate), NodalField("f", plate.nodes[:, 0]), n_bands=1
        )
    with pytest.raises(ModelError, match="field 'f' of shape"):
        plot_contour(tmp_path / "a.png", plate.nodes, skin_of(plate), NodalField("f", np.ones(3)))


def test_an_animation_carries_the_bar_of_its_colours(tmp_path, plate):
    times, positions = np.arange(2.0), np.repeat(plate.nodes[None], 2, axis=0)
    values = np.linspace(0.0, 250.0, 2 * plate.n_nodes).reshape(2, -1)
    strips = []
    for label in ("", "von Mises stress (MPa)"):
        path = tmp_path / f"{len(label)}.gif"
        animate(path, times, positions, skin_of(plate), values=values, values_label=label, n_columns=200)
        with Image.open(path) as animation:
            assert animation.size[0] == 200
            strips.append(np.asarray(animation.convert("HSV"))[-72:].reshape(-1, 3))
    plain, bar = strips
    assert not (plain[:, 1] > 100).any()
    # The bar runs through the colour map, from violet over green to yellow.
    assert np.ptp(bar[bar[:, 1] > 100, 0].astype(int)) > 100
    with pytest.raises(ModelError, match=r"cannot draw a colour bar of 'stress \(MPa\)': give the values"):
        animate(tmp_path / "a.gif", times, positions, skin_of(plate), values_label="stress (MPa)")
