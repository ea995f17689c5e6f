"""Walls that shear: patches, sandwich plates against Reissner and Mindlin, the thin limit, turns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.errors import ModelError
from supple.fem import (
    HomogeneousSection,
    Isotropic,
    LaminateSection,
    Section,
    assemble,
    finite_element_model,
    shear_share,
    shell_model,
)
from supple.mesh import CellType, Mesh, plate, strip

FACE = Isotropic(70e9, 0.3, 2700.0)


def sandwich(core_shear=30e6, face=0.5e-3, core=0.02, nu=0.3):
    """Two faces on a core that shears: D = E t h^2/2 / (1 - nu^2) and some, H = G (c + t)^2/c."""
    plane = replace(FACE, poissons_ratio=nu).plane_stress
    h = core + face
    A = 2 * face * plane
    D = (face * h**2 / 2 + face**3 / 6) * plane
    mass = 2 * FACE.density * face + 60.0 * core
    rotary = FACE.density * face * h**2 / 2 + 60.0 * core**3 / 12
    return LaminateSection(A, 0 * A, D, mass, rotary, shear=core_shear * h**2 / core * np.eye(2))


def plate_frequencies(wall, sides, waves):
    """omega of a simply supported plate of Mindlin's theory: w = W s, beta = -b grad s, s = sin sin.

    (D k^2 b + H (b - W) = omega^2 J b,  H k^2 (W - b) = omega^2 m W), the lower root.
    """
    k2 = ((np.pi * np.array(waves) / sides) ** 2).sum()
    D, J, m = wall.bending[0, 0], wall.rotary_inertia_per_area, wall.mass_per_area
    H = wall.shear[0, 0]
    K = np.array([[D * k2 + H, -H], [-H * k2, H * k2]])
    return np.sqrt(np.linalg.eigvals(np.linalg.solve(np.diag([J, m]), K)).real.min())


def supported(wall, sides, n):
    """Model and free freedoms. Hard supports: no deflection, and no rotation about the normal of an edge."""
    mesh = plate(*sides, *n)
    model = shell_model(mesh, wall)
    free = np.zeros((mesh.n_nodes, 6), dtype=bool)
    free[:, 2:5] = True
    x, y = (mesh.nodes - mesh.nodes.min(axis=0))[:, :2].T
    across_x, across_y = (
        np.isclose(c, 0) | np.isclose(c, side) for c, side in zip((x, y), sides, strict=True)
    )
    free[across_x, 2] = free[across_y, 2] = False
    free[across_x, 3] = free[across_y, 4] = False
    rows = np.flatnonzero(free.ravel())
    return model, rows


def supported_plate(wall, sides, n):
    model, rows = supported(wall, sides, n)
    return np.sqrt(lowest_modes(model.stiffness[rows][:, rows], model.mass[rows][:, rows], 6).values)


@pytest.mark.parametrize("core_shear", [300e6, 30e6, 3e6], ids=["stiff", "usual", "soft"])
def test_sandwich_plates_vibrate_as_mindlin_says(core_shear):
    """Of a plate 0.6 x 0.4 the first three modes; the soft core halves the first one more than once."""
    wall, sides = sandwich(core_shear), np.array([0.6, 0.4])
    exact = np.array([plate_frequencies(wall, sides, w) for w in ((1, 1), (2, 1), (1, 2))])
    coarse, fine = (supported_plate(wall, sides, n)[:3] for n in ((12, 8), (24, 16)))
    np.testing.assert_allclose(fine, exact, rtol=1.2e-2)
    np.testing.assert_allclose(fine + (fine - coarse) / 3, exact, rtol=1e-3)  # second order


def test_the_thin_limit_is_the_element_without_shear():
    """Side by side: shear changes the frequencies of a plate of t/a = 1/1000 by 1e-5, and no mesh locks."""
    sides = np.array([1.0, 1.0])
    rigid, shearing = (
        supported_plate(HomogeneousSection(FACE, 1e-3, shear_factor=k), sides, (8, 8))[:2]
        for k in (0.0, 5 / 6)
    )
    np.testing.assert_allclose(shearing, rigid, rtol=2e-3)
    stiff = supported_plate(HomogeneousSection(FACE, 1e-3, shear_factor=1e6), sides, (8, 8))[:2]
    np.testing.assert_allclose(stiff, rigid, rtol=1e-6)


def test_a_sandwich_strip_deflects_by_bending_and_shear(held, solve_linear):
    """P L^3 / 3 D b + P L / H b of a cantilever, nu = 0; of each, shear is the larger share here."""
    wall, L, b = sandwich(3e6, nu=0.0), 0.3, 0.1
    mesh = strip(L, b, 12, 4)
    model = shell_model(mesh, wall)
    load = np.zeros((mesh.n_nodes, 6))
    tip = mesh.nodes_of("tip")
    weights = np.where(np.isclose(np.abs(mesh.nodes[tip, 1]), b / 2), 0.5, 1.0)
    load[tip, 2] = weights / weights.sum()
    found = solve_linear(model, held(model, (mesh.nodes_of("root"), range(6))), load)
    bending, shear = L**3 / (3 * wall.bending[0, 0] * b), L / (wall.shear[0, 0] * b)
    assert shear > 2 * bending
    assert found[tip, 2].mean() == pytest.approx(bending + shear, rel=1e-3)


def patch(distorted, rng):
    mesh = plate(1.0, 0.8, 4, 3)
    inner = (np.abs(mesh.nodes[:, :2] - mesh.nodes[:, :2].mean(axis=0)) < [0.49, 0.39]).all(axis=1)
    moved = mesh.nodes.copy()
    moved[inner, :2] += 0.05 * rng.uniform(-1, 1, size=(inner.sum(), 2))
    return Mesh(moved, mesh.cells), inner


def test_patch_of_constant_curvature(distorted, rng):
    """w = -1/2 x^T k x, beta = k x without any shear: energy A/2 kappa^T D kappa, no force inside."""
    wall = sandwich(3e6)
    mesh, inner = patch(distorted, rng)
    model = shell_model(mesh, wall)
    k = np.array([[1.0, 0.4], [0.4, -0.7]])
    x = mesh.nodes[:, :2]
    beta = x @ k
    u = np.zeros((mesh.n_nodes, 6))
    u[:, 2], u[:, 3], u[:, 4] = -0.5 * (x * beta).sum(axis=1), -beta[:, 1], beta[:, 0]
    kappa = np.array([k[0, 0], k[1, 1], 2 * k[0, 1]])
    area = 0.8
    assert 0.5 * u.ravel() @ model.stiffness @ u.ravel() == pytest.approx(
        0.5 * area * kappa @ wall.bending @ kappa, rel=1e-10
    )
    force = (model.stiffness @ u.ravel()).reshape(-1, 6)
    assert np.abs(force[inner]).max() < 1e-9 * np.abs(force).max()


def test_patch_of_constant_shear_in_a_wall_that_only_shears(distorted, rng):
    """w = g.x, beta = 0 where bending is far stiffer than the side is long: A/2 g^T H g."""
    soft = sandwich()
    wall = replace(soft, shear=1e-9 * soft.shear @ np.diag([1.0, 2.0]))
    mesh, inner = patch(distorted, rng)
    model = shell_model(mesh, wall)
    g = np.array([0.3, -0.8])
    u = np.zeros((mesh.n_nodes, 6))
    u[:, 2] = mesh.nodes[:, :2] @ g
    assert u.ravel() @ model.stiffness @ u.ravel() == pytest.approx(0.8 * g @ wall.shear @ g, rel=1e-6)
    force = (model.stiffness @ u.ravel()).reshape(-1, 6)
    assert np.abs(force[inner, 2]).max() < 1e-6 * np.abs(force[:, 2]).max()


@pytest.mark.parametrize("core_shear", [3e6, 3e2])
def test_six_zero_modes_and_no_more(core_shear, distorted, rigid_modes):
    mesh = distorted(strip(1.0, 0.7, 1, 2), 0.05)
    model = shell_model(mesh, sandwich(core_shear))
    K = model.stiffness.toarray()
    scale = np.sqrt(np.diag(K))
    values = np.linalg.eigvalsh(K / np.outer(scale, scale))
    assert np.abs(K @ rigid_modes(model)).max() < 1e-11 * np.abs(K).max()
    assert values[5] < 1e-12
    assert values[6] > 1e-9


def test_a_turned_plate_keeps_its_shear(rng):
    """Bend and shear a strip, then turn it by 0.2 rad about each axis: the energy stays as it was."""
    wall = sandwich(3e5)
    mesh = strip(0.4, 0.1, 8, 2)
    assembly = assemble(shell_model(mesh, wall))
    x = mesh.nodes[:, 0] - 0.2
    small = np.zeros((mesh.n_nodes, 6))
    small[:, 2], small[:, 4] = 2e-3 * x + 5e-3 * x * x, -1e-2 * x + 3e-3
    before = assembly.energy(small.ravel())
    for axis in np.eye(3):
        turn = rotation(0.2 * axis)
        q = np.zeros_like(small)
        place = mesh.nodes - [0.2, 0, 0]
        q[:, :3] = (place + small[:, :3]) @ turn.T - place
        q[:, 3:] = [log_rotation(turn @ rotation(each)) for each in small[:, 3:]]
        assert assembly.energy(q.ravel()) == pytest.approx(before, rel=2e-2)


def rotation(vector):
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    W = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W


def log_rotation(R):
    angle = np.arccos((np.trace(R) - 1) / 2)
    return angle / (2 * np.sin(angle)) * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])


def orthotropic():
    A = 1e6 * np.array([[10.0, 1, 0], [1, 2, 0], [0, 0, 0.8]])
    return LaminateSection(A, 0.1 * A * 1e-3, 1e-4 * A, 2.0, 1e-4, shear=np.diag([3e5, 1e5]))


def test_directions_of_cells_take_the_place_of_that_of_the_section():
    mesh = strip(1.0, 0.3, 4, 2)
    cells = np.arange(mesh.n_cells)
    along = replace(orthotropic(), reference_direction=(1.0, 2.0, 0.0))
    own = Section(
        CellType.TRIANGLE3, cells, orthotropic(), directions=np.tile([1.0, 2.0, 0.3], (len(cells), 1))
    )
    expected = shell_model(mesh, along).stiffness
    found = finite_element_model(mesh, (own,)).stiffness
    assert abs(found - expected).max() < 1e-12 * abs(expected).max()
    across = np.tile([0.0, 0, 1], (len(cells), 1))
    with pytest.raises(ModelError, match="is normal to the laminate's reference_direction"):
        finite_element_model(mesh, (replace(own, directions=across),))


def test_a_homogeneous_wall_beside_its_nodes_is_a_wall_at_its_nodes(held, solve_linear):
    """A cantilever held and loaded at its middle plane, by arms of the length of the offset."""
    mesh, z = strip(0.5, 0.1, 6, 2), 0.03
    plain, offset = (shell_model(mesh, HomogeneousSection(FACE, 0.01, offset=o)) for o in (0.0, z))
    load = np.zeros((mesh.n_nodes, 6))
    load[mesh.nodes_of("tip"), :] = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]
    root = held(plain, (mesh.nodes_of("root"), range(6)))
    expected = solve_linear(plain, root, load)
    # Nodes at z below the middle: u_node = u_middle - theta x z e_z, and forces make moments there.
    moved = load.copy()
    moved[:, 3:] += np.cross([0, 0, z], load[:, :3])
    found = solve_linear(offset, root, moved)
    middle = found[:, :3] + np.cross(found[:, 3:], [0, 0, z])
    np.testing.assert_allclose(middle[:, 2], expected[:, 2], rtol=1e-3, atol=1e-9)


@pytest.mark.parametrize("n", [8, 16])
def test_the_share_of_shear_in_bending_is_that_of_a_plate(n):
    """First mode of a thick supported square: omega^2 falls by D k^2 / H to first order, on any mesh."""
    wall, side = HomogeneousSection(FACE, 0.03), 1.0
    model, rows = supported(wall, (side, side), (n, n))
    shape = np.zeros((model.n_dofs, 1))
    shape[rows] = lowest_modes(model.stiffness[rows][:, rows], model.mass[rows][:, rows], 1).vectors
    H = 5 / 6 * FACE.shear_modulus * 0.03
    expected = wall.bending[0, 0] * 2 * np.pi**2 / H
    assert shear_share(model, shape)[0] == pytest.approx(expected, rel=12 / n**2)
    shearing, _ = supported(replace(wall, shear_factor=5 / 6), (side, side), (n, n))
    assert shear_share(shearing, shape)[0] == 0.0


def test_membranes_do_not_bend_and_what_only_bends_does_not_stretch():
    """Both parts, alone, add up to the whole wall."""
    mesh, wall = strip(1.0, 0.3, 4, 2), HomogeneousSection(FACE, 0.01)
    none = np.zeros((3, 3))
    membrane = LaminateSection(wall.membrane, none, none, 1.0, 0.0)
    plate = LaminateSection(none, none, wall.bending, 1.0, 0.0)
    whole = shell_model(mesh, wall).stiffness
    found = shell_model(mesh, membrane).stiffness + shell_model(mesh, plate).stiffness
    assert abs(found - whole).max() < 1e-12 * abs(whole).max()
