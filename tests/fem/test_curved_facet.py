"""Facets of curved thin walls: bending without stretch, published displacements, the warning."""

import warnings

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from supple.fem import GREEN_LAGRANGE, HomogeneousSection, Isotropic, LaminateSection, shell_model
from supple.fem.kirchhoff_bending import MIDSIDES
from supple.fem.model import parts_of_model
from supple.fem.optimal_membrane import triangle_area
from supple.fem.shell_triangle import (
    drilling_rotations,
    element_axes,
    layer_strain,
    plane_coordinates,
    plane_tensor,
    resultant_strains,
    shell_triangle,
)
from supple.mesh import CellType, DividedMesh, Mesh
from supple.mesh.mesh_part import mesh_part


def bent_cylinder(x, y):
    """Height of a cylinder, and displacement and rotation of one way to bend it without stretch.

    z = x^2/2, w = x^2/2 + x y; u and v make u_(a,b) + 1/2 (z,a w,b + z,b w,a) zero.
    """
    u = np.stack([-(x**3) / 3 - x**2 * y / 2, -(x**3) / 6, x**2 / 2 + x * y], axis=-1)
    return x**2 / 2, u, np.stack([x, -(x + y), x**2 / 2], axis=-1), np.diag([1.0, 0.0])


def bent_saddle(x, y):
    """The same of z = x y and w = p x^2/2 + q y^2/2."""
    p, q = 0.8, -0.5
    u = [-p * x**2 * y / 2 - q * y**3 / 6, -q * x * y**2 / 2 - p * x**3 / 6, (p * x**2 + q * y**2) / 2]
    turn = [q * y, -p * x, (q * y**2 - p * x**2) / 2]
    return x * y, np.stack(u, axis=-1), np.stack(turn, axis=-1), np.array([[0.0, 1.0], [1.0, 0.0]])


@pytest.mark.parametrize("bent", [bent_cylinder, bent_saddle])
def test_bending_without_stretch_strains_no_middle_surface(bent, material, rng):
    """Of the strains of flat facets what is left falls with the square of the slope."""
    xy = rng.normal(size=(20, 3, 2))
    clockwise = triangle_area(xy) < 0
    xy[clockwise] = xy[clockwise, ::-1]
    z, u, turn, curvature = bent(xy[..., 0], xy[..., 1])
    wall = HomogeneousSection(material, 0.01)
    left = []
    for slope in (0.01, 0.005):
        corners = np.concatenate([xy, slope * z[..., None]], axis=2)
        q = np.concatenate([u * [slope, slope, 1], turn * [1, 1, slope]], axis=2).reshape(20, 18)
        K = np.zeros((20, 3, 3))
        K[:, :2, :2] = slope * curvature
        axes = element_axes(corners, wall)
        local, surface = plane_coordinates(corners, axes), plane_tensor(K, axes)
        block = shell_triangle(corners, np.zeros((20, 18), int), wall, GREEN_LAGRANGE)
        strains = np.einsum("esn,en->es", block.B[:, 0], q)
        found = []
        for given in (None, surface):
            membrane, _ = resultant_strains(local, MIDSIDES, wall, given)
            drilling = drilling_rotations(local, wall, given)
            found.append([np.einsum("eis,es->ei", each, strains) for each in (membrane, drilling)])
        middle = np.einsum("eis,es->ei", layer_strain(corners, axes, wall, [0.0], K)[:, 0], strains)
        np.testing.assert_allclose(middle, found[1][0], atol=1e-12)
        left.append([np.abs(curved).max() / np.abs(flat).max() for flat, curved in zip(*found, strict=True)])
    assert np.max(left[0]) < 0.02
    np.testing.assert_allclose(np.log2(np.array(left[0]) / left[1]), 2.0, atol=0.3)


def grid(n, m, place):
    """Quadrilaterals n x m over parameters 0 to 1, cut along one diagonal; numbers of nodes (n+1, m+1)."""
    numbers = np.arange((n + 1) * (m + 1)).reshape(n + 1, m + 1)
    s, t = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, m + 1), indexing="ij")
    a, b, c, d = numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]
    cells = np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=2).reshape(-1, 3)
    return Mesh(np.column_stack(place(s.ravel(), t.ravel())), {CellType.TRIANGLE3: cells}), numbers


def solved(K, free, load):
    u = np.zeros(load.size)
    rows = np.flatnonzero(free.ravel())
    u[rows] = spsolve(K[rows][:, rows].tocsc(), load.ravel()[rows])
    return u.reshape(load.shape)


def twisted(s, t):
    """A strip 12 x 1.1, twisted by a quarter of a turn."""
    across = 1.1 * (t - 0.5)
    return 12 * s, across * np.cos(np.pi / 2 * s), across * np.sin(np.pi / 2 * s)


def twisted_tip(n, thickness, component):
    """Displacement of the middle of the tip along a unit force there, 6n x n cells."""
    mesh, numbers = grid(6 * n, n, twisted)
    model = shell_model(mesh, HomogeneousSection(Isotropic(29e6, 0.22, 1.0), thickness))
    free = np.ones((mesh.n_nodes, 6), bool)
    free[numbers[0]] = False
    load = np.zeros((mesh.n_nodes, 6))
    weights = np.ones(n + 1)
    weights[[0, -1]] = 0.5
    load[numbers[-1], component] = weights / n
    return solved(model.stiffness, free, load)[numbers[-1, n // 2], component]


@pytest.mark.parametrize(
    ("thickness", "component", "published"),
    [(0.32, 1, 1.754e-3), (0.32, 2, 5.424e-3), (0.0032, 1, 1294.0), (0.0032, 2, 5256.0)],
)
def test_a_twisted_beam_does_not_lock(thickness, component, published):
    """MacNeal and Harder 1985; the thin one: Belytschko, Wong and Stolarski 1989. 12 x 2 cells."""
    assert twisted_tip(2, thickness, component) == pytest.approx(published, rel=0.02)


def hemisphere(s, t):
    """A quarter, radius 10, from 18 degrees off the pole to the equator."""
    polar, around = np.radians(18 + 72 * s), np.pi / 2 * t
    return 10 * np.sin(polar) * np.cos(around), 10 * np.sin(polar) * np.sin(around), 10 * np.cos(polar)


def hemisphere_model(n):
    mesh, numbers = grid(n, n, hemisphere)
    return shell_model(mesh, HomogeneousSection(Isotropic(6.825e7, 0.3, 1.0), 0.04)), numbers


def test_a_pinched_hemisphere_does_not_lock():
    """MacNeal and Harder 1985: 0.094 under the forces; 8 cells a side."""
    model, numbers = hemisphere_model(8)
    free = np.ones((model.mesh.n_nodes, 6), bool)
    free[np.ix_(numbers[:, 0], [1, 3, 5])] = free[np.ix_(numbers[:, -1], [0, 4, 5])] = False
    free[numbers[-1, 0], 2] = False
    load = np.zeros(free.shape)
    load[numbers[-1, 0], 0], load[numbers[-1, -1], 1] = 1, -1
    u = solved(model.stiffness, free, load)
    assert u[numbers[-1, 0], 0] == pytest.approx(0.094, rel=0.04)
    assert u[numbers[-1, -1], 1] == pytest.approx(-u[numbers[-1, 0], 0], rel=0.01)


def test_a_real_fold_stays_one():
    """Of two planes at 20 degrees with one cell each across, the facets are flat."""

    def place(s, t):
        return s, 0.4 * (t - 0.5), -0.4 * np.tan(np.radians(10)) * abs(t - 0.5)

    model = shell_model(grid(4, 2, place)[0], HomogeneousSection(Isotropic(1e7, 0.3, 1.0), 0.01))
    assert model.sections[0].surface_curvature is None


def test_a_part_of_a_curved_wall_keeps_its_curvature():
    """The stiffness of a wall is the sum of those of its parts."""
    model, _ = hemisphere_model(8)
    cells = np.arange(len(model.mesh.cells[CellType.TRIANGLE3]))
    total = np.zeros(model.stiffness.shape)
    parts = tuple(mesh_part(model.mesh, {CellType.TRIANGLE3: own}) for own in (cells[:40], cells[40:]))
    for part, own in zip(parts, parts_of_model(model, DividedMesh(model.mesh, parts, ())), strict=True):
        dofs = (6 * part.nodes[:, None] + np.arange(6)).ravel()
        total[np.ix_(dofs, dofs)] += own.stiffness.toarray()
    K = model.stiffness.toarray()
    np.testing.assert_allclose(total, K, rtol=0, atol=1e-12 * np.abs(K).max())


@pytest.mark.parametrize(("cells", "coarse"), [(4, True), (5, True), (8, False)])
def test_walls_too_coarse_for_their_curvature_are_warned_of(cells, coarse):
    """The pinched hemisphere is 88, 18 and 3 % too stiff."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        hemisphere_model(cells)
    assert any("curved walls are large for their thickness" in str(each.message) for each in caught) is coarse


def test_membranes_and_flat_walls_are_not_warned_of():
    wall = HomogeneousSection(Isotropic(6.825e7, 0.3, 1.0), 0.04)
    none = np.zeros((3, 3))
    shell_model(grid(4, 4, hemisphere)[0], LaminateSection(wall.membrane, none, none, 1.0, 0.0))
    shell_model(grid(2, 2, lambda s, t: (s, t, 0 * s))[0], HomogeneousSection(wall.material, 1e-6))
