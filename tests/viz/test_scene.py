"""Scenes of several bodies, and responses beside their errors."""

import numpy as np
import pytest
from PIL import Image

from supple.errors import ModelError
from supple.mesh import CellType, Skin, block, skin_of
from supple.viz import (
    Actor,
    Response,
    Series,
    animate,
    plot_response_errors,
    scene_of,
)

T = np.linspace(0.0, 1.0, 50)


@pytest.fixture
def actors():
    mesh = block(1.0, 0.3, 0.3, 2, 1, 1, CellType.TETRA4)
    still = np.broadcast_to(mesh.nodes, (2, *mesh.nodes.shape))
    beside = still + np.array([0.0, 0.0, 1.0])
    values = np.arange(still[..., 0].size, dtype=float).reshape(still.shape[:2])
    return [Actor(skin_of(mesh), still), Actor(skin_of(mesh), beside, values)]


def test_scene_keeps_every_triangle_where_it_was(actors):
    scene = scene_of(actors)
    for shift, actor in zip((0, actors[0].positions.shape[1]), actors, strict=True):
        own = actor.positions[0][actor.skin.triangles]
        place = np.flatnonzero((scene.skin.triangles >= shift).all(axis=1))
        assert scene.positions[0][shift + actor.skin.triangles].tolist() == own.tolist()
        assert len(place) >= len(own)
    np.testing.assert_array_equal(np.isnan(scene.values).all(axis=0), [True] * 12 + [False] * 12)


def test_animations_show_bodies_without_values_in_the_plain_colour(actors, tmp_path):
    scene = scene_of(actors)
    path = animate(tmp_path / "two.gif", T[:2], scene.positions, scene.skin, values=scene.values)
    with Image.open(path) as animation:
        assert animation.n_frames == 2
        animation.seek(1)
        pixels = np.asarray(animation.convert("RGB")).reshape(-1, 3).astype(int)
    seen = pixels[(pixels < 250).any(axis=1)]
    # The plain colour is a greyish blue; viridis has no blue above both red and green but not far above.
    plain = (seen[:, 2] > seen[:, 1]) & (seen[:, 1] > seen[:, 0]) & (seen[:, 2] - seen[:, 0] < 60)
    assert plain.sum() > 500
    assert (seen[:, 1] > seen[:, 2] + 30).sum() > 100  # green to yellow, from viridis


def test_scenes_need_bodies_at_the_same_times(actors):
    with pytest.raises(
        ModelError, match="a scene needs bodies at the same times; the numbers of times are \\[\\]"
    ):
        scene_of([])
    shorter = Actor(actors[0].skin, actors[0].positions[:1])
    with pytest.raises(ModelError, match=r"times are \[1, 2\]"):
        scene_of([shorter, actors[1]])


def test_errors_stand_beside_responses(ink, tmp_path):
    truth = Series("full", T, np.sin(9 * T))
    models = [Series("a", T, truth.values + 1e-3 * T), Series("b", T, truth.values + 1e-6 * T)]
    path = plot_response_errors(tmp_path / "r.png", [Response("u (m)", truth, models)] * 2, until=0.5)
    assert ink(path) > 0.01


def test_responses_need_models_at_the_references_times(tmp_path):
    truth = Series("full", T, np.sin(9 * T))
    with pytest.raises(ModelError, match="give at least one response, each of at least one model"):
        plot_response_errors(tmp_path / "r.png", [Response("u", truth, [])])
    late = Series("late", T + 1.0, truth.values)
    with pytest.raises(ModelError, match="series 'late' is not at the times of the reference"):
        plot_response_errors(tmp_path / "r.png", [Response("u", truth, [late])])
    of_late = Response("v", late, [Series("a", T, truth.values)])
    with pytest.raises(ModelError, match="series 'a' is not at the times of the reference"):
        plot_response_errors(tmp_path / "r.png", [Response("u", truth, [truth]), of_late])


def test_skins_of_plain_triangles_join_too():
    skin = Skin.of_triangles(np.array([[0, 1, 2]]))
    corner = np.zeros((1, 3, 3))
    assert scene_of([Actor(skin, corner)] * 2).skin.triangles.tolist() == [[0, 1, 2], [3, 4, 5]]
