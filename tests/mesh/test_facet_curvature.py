"""Curvature of surfaces at the triangles of their meshes; folds and flat walls have none."""

import numpy as np
import pytest

from supple.mesh.facet_curvature import facet_curvature


def grid(n, m, place):
    """Triangles of n x m cells over parameters 0 to 1."""
    numbers = np.arange((n + 1) * (m + 1)).reshape(n + 1, m + 1)
    s, t = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, m + 1), indexing="ij")
    a, b, c, d = numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]
    cells = np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=2)
    return np.column_stack(place(s.ravel(), t.ravel())), cells.reshape(-1, 3)


def cap(radius, width):
    """Part of a sphere about the z axis."""
    return lambda s, t: (
        x := width * (s - 0.5),
        y := width * (t - 0.5),
        np.sqrt(radius**2 - x**2 - y**2),
    )


def folded(angle, height=0.3):
    """Two planes that meet at an angle, along t = 1/2."""
    half = np.radians(angle) / 2
    return lambda s, t: (s, height * (t - 0.5) * np.cos(half), -height * abs(t - 0.5) * np.sin(half))


def tangents(nodes, triangles):
    corners = nodes[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.eye(3) - normal[:, :, None] * normal[:, None], normal


def test_a_sphere_has_minus_one_over_its_radius_in_every_direction_also_at_the_rim():
    errors = []
    for n in (4, 8):
        nodes, triangles = grid(n, n, cap(2.0, 1.0))
        plane, _ = tangents(nodes, triangles)
        errors.append(np.abs(facet_curvature(nodes, triangles) + plane / 2.0).max() * 2.0)
    assert errors[0] < 0.1
    assert np.log2(errors[0] / errors[1]) > 0.9


def test_a_shallow_quadratic_surface_has_its_own():
    K = np.array([[0.7, -0.4], [-0.4, -1.1]])
    nodes, triangles = grid(5, 4, lambda s, t: (1.3 * s + 0.2 * t, t - 0.1 * s, 0 * s))
    nodes[:, 2] = 0.5e-4 * np.einsum("ni,ij,nj->n", nodes[:, :2], K, nodes[:, :2])
    found = facet_curvature(nodes, triangles)
    np.testing.assert_allclose(found[:, :2, :2], np.broadcast_to(1e-4 * K, (40, 2, 2)), rtol=0, atol=1e-10)


def test_a_triangle_that_turns_the_other_way_has_the_other_sign():
    nodes, triangles = grid(6, 6, cap(2.0, 1.0))
    expected = facet_curvature(nodes, triangles)
    which = np.random.default_rng(3).random(len(triangles)) < 0.5
    found = facet_curvature(nodes, np.where(which[:, None], triangles[:, ::-1], triangles))
    np.testing.assert_allclose(found, np.where(which, -1, 1)[:, None, None] * expected, atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 8.0, 20.0, 40.0, 90.0, 175.0])
@pytest.mark.parametrize("cells", [2, 4, 6])
def test_two_planes_have_none_however_they_are_cut(angle, cells):
    assert not facet_curvature(*grid(5, cells, folded(angle))).any()


@pytest.mark.parametrize("cells", [1, 2])
def test_a_sheet_with_trapezoid_waves_has_none(cells):
    """Folds of 20 degrees, up and down; with one cell on each flat its crests alone would fit an arc."""
    angles = np.repeat(np.radians([0, 20, 0, -20, 0, 20, 0, -20, 0]), cells)
    y, z = (np.concatenate([[0], np.cumsum(f(angles) / cells)]) for f in (np.cos, np.sin))
    at = np.linspace(0, 1, len(y))
    sheet = grid(6, len(angles), lambda s, t: (6 * s, np.interp(t, at, y), np.interp(t, at, z)))
    assert not facet_curvature(*sheet).any()


def test_a_wall_on_a_curved_skin_changes_nothing():
    """Three triangles at an edge: the two of the skin continue each other."""
    nodes, triangles = grid(6, 6, cap(2.0, 1.0))
    expected = facet_curvature(nodes, triangles)
    foot = np.arange(21, 28)
    top = len(nodes) + np.arange(7)
    web = np.concatenate([
        np.stack([foot[:-1], foot[1:], top[1:]], axis=1), np.stack([foot[:-1], top[1:], top[:-1]], axis=1)
    ])  # fmt: skip
    both = np.vstack([nodes, nodes[foot] + [0, 0, 0.2]])
    found = facet_curvature(both, np.concatenate([triangles, web]))
    np.testing.assert_allclose(found[: len(triangles)], expected, atol=1e-12)
    assert not found[len(triangles) :].any()
