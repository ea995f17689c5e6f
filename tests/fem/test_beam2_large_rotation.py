"""Beams that turn far against the mesh axes: rigid rotation, bending-torsion coupling, the elastica."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from supple.fem import GREEN_LAGRANGE, VON_KARMAN, BeamSection, Isotropic, assemble, shell_model
from supple.fem.quadratic_strain import energy, stiffness, strain
from supple.mesh import CellType, Mesh
from supple_benchmarks.references.elastica import elastica
from supple_benchmarks.references.lateral_buckling import lateral_buckling_load

ALUMINIUM = Isotropic(7e10, 0.3, 2700.0)
OBLIQUE = np.array([1.0, 2.0, 3.0]) / np.sqrt(14)


def blade(width, height):
    """A rectangle, high along y; bending in the x-y plane is the strong one."""
    area = width * height
    return BeamSection(
        ALUMINIUM,
        area,
        area * height**2 / 12,
        area * width**2 / 12,
        height * width**3 / 3,
        5 / 6,
        5 / 6,
        orientation=(0, 1, 0),
    )


def along_x(n, length, section, kinematics=GREEN_LAGRANGE):
    nodes = np.linspace(0, length, n + 1)[:, None] * np.eye(3)[0]
    mesh = Mesh(nodes, {CellType.LINE2: np.column_stack([np.arange(n), np.arange(1, n + 1)])})
    return shell_model(mesh, section, kinematics=kinematics)


def clamped(assembly, load, n_steps=1):
    """Displacements (N, 6) of a beam clamped at its first node, by Newton's method."""
    q = np.zeros(assembly.n)
    for share in np.arange(1, n_steps + 1) / n_steps:
        for _ in range(30):
            residual = (share * load.ravel() - assembly.internal_force(q))[6:]
            step = np.linalg.solve(assembly.tangent(q).toarray()[6:, 6:], residual)
            q[6:] += step
            if np.abs(step).max() < 1e-11:
                break
        else:
            raise AssertionError("no equilibrium")
    return q.reshape(-1, 6)


def turned(block, ends, angle):
    """Freedoms of one element turned as a rigid body about an oblique axis: true rotation vectors."""
    turn = Rotation.from_rotvec(angle * OBLIQUE).as_matrix()
    move = ends @ (turn - np.eye(3)).T
    return np.concatenate([np.concatenate([u, angle * OBLIQUE]) for u in move])[None]


@pytest.fixture
def element():
    ends = np.array([[0.2, -0.3, 0.4], [1.1, 0.5, 1.0]])
    model = shell_model(Mesh(ends, {CellType.LINE2: [[0, 1]]}), blade(0.03, 0.05))
    return model.blocks[0], ends


def test_a_rigid_rotation_costs_energy_of_eighth_order(element):
    """Strains of a turned element are of fourth order (with linear curvature: of third)."""
    block, ends = element
    angles = np.array([0.05, 0.1, 0.2, 0.4])
    spent = [energy(block, turned(block, ends, angle))[0] for angle in angles]
    slopes = np.diff(np.log(spent)) / np.diff(np.log(angles))
    np.testing.assert_allclose(slopes, 8, atol=0.1)
    # What strains cut after their linear terms (but for the chord's, which are Green's) would spend.
    q = turned(block, ends, 0.2)
    linear = np.einsum("egsn,en->egs", block.B, q)
    linear[..., 0] = 0.0
    cut = 0.5 * np.einsum("egs,est,egt->", linear, block.D, linear)
    assert spent[2] < 2e-6 * cut
    # In units in which the linear strains spend 4.8 mJ.
    assert spent[2] * 4.8e-3 / cut < 1e-8


def test_a_rotation_about_the_beam_itself_is_free(element):
    block, ends = element
    axis = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    q = np.tile(np.concatenate([np.zeros(3), 0.7 * axis]), 2)[None]
    assert np.abs(strain(block, q)).max() < 1e-15


def test_curvature_is_the_rotation_between_the_sections():
    """In a plane k is exact; in space log(R_1^T R_2) to second order, so that the difference is of third."""
    model = along_x(1, 2.0, blade(0.03, 0.05))
    block = model.blocks[0]
    rng = np.random.default_rng(2)
    first, second = rng.normal(size=(2, 3))
    sizes = np.array([0.05, 0.1, 0.2])
    gaps = []
    for size in sizes:
        q = np.concatenate([np.zeros(3), size * first, np.zeros(3), size * second])
        between = Rotation.from_rotvec(size * first).inv() * Rotation.from_rotvec(size * second)
        # The section's y axis is y, so local axes are those of the mesh.
        gaps.append(np.linalg.norm(strain(block, q[None])[0, 0, 1:4] - between.as_rotvec()))
    assert np.polyfit(np.log(sizes), np.log(gaps), 1)[0] == pytest.approx(3, abs=0.1)
    q = np.concatenate([np.zeros(3), [0, 0, 0.3], np.zeros(3), [0, 0, 0.9]])
    np.testing.assert_allclose(strain(block, q[None])[0, 0, 1:4], [0, 0, 0.6], atol=1e-15)


def test_a_narrow_cantilever_buckles_sideways_as_theory_says():
    """Where the tangent of the bent state loses its definiteness sideways: within 2 %, second order."""
    section = blade(0.005, 0.1)
    E, G = ALUMINIUM.youngs_modulus, ALUMINIUM.shear_modulus
    critical = lateral_buckling_load(E * section.I2, E * section.I1, G * section.J, 1.0)

    def buckling_load(n):
        assembly = assemble(along_x(n, 1.0, section))
        sideways = (6 * np.arange(1, n + 1)[:, None] + np.array([2, 3, 4])).ravel()

        def lowest(force):
            load = np.zeros((n + 1, 6))
            load[-1, 1] = force
            tangent = assembly.tangent(clamped(assembly, load).ravel()).toarray()
            return np.linalg.eigvalsh(tangent[np.ix_(sideways, sideways)])[0]

        return brentq(lowest, 0.5 * critical, 1.5 * critical, rtol=1e-6)

    loads = np.array([buckling_load(n) for n in (5, 10, 20)]) / critical
    assert loads[1] == pytest.approx(1, abs=0.02)
    assert np.log2((loads[0] - loads[1]) / (loads[1] - loads[2])) == pytest.approx(2, abs=0.1)
    assert loads[2] + (loads[2] - loads[1]) / 3 == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize(("load", "tolerance"), [(0.6, 4e-4), (1.2, 2e-3)])
def test_a_cantilever_follows_the_elastica(load, tolerance):
    """Tip rotations of 0.29 and 0.54 rad against the mesh axes; what is left is of fourth order in them."""
    length, section = 2.0, blade(0.1, 0.004)
    bending = ALUMINIUM.youngs_modulus * section.I1
    force = load * bending / length**2
    along, across, angle = elastica(bending, length, force)
    outer = np.zeros((21, 6))
    outer[-1, 1] = force
    tip = clamped(assemble(along_x(20, length, section)), outer, n_steps=4)[-1]
    np.testing.assert_allclose([length + tip[0], tip[1], tip[5]], [along, across, angle], rtol=tolerance)


def test_von_karman_keeps_the_slopes_of_the_chord_alone():
    """For small rotations: eps = g_x + (g_y^2 + g_z^2) / 2, the rest linear, the same stiffness."""
    section = blade(0.03, 0.05)
    (block,) = along_x(1, 2.0, section, VON_KARMAN).blocks
    (full,) = along_x(1, 2.0, section).blocks
    np.testing.assert_array_equal(stiffness(block), stiffness(full))
    q = 0.1 * np.random.default_rng(4).normal(size=(1, 12))
    g = (q[0, 6:9] - q[0, :3]) / 2.0
    found = strain(block, q)[0, 0]
    assert found[0] == pytest.approx(g[0] + (g[1] ** 2 + g[2] ** 2) / 2)
    np.testing.assert_allclose(found[1:], np.einsum("sn,n->s", block.B[0, 0], q[0])[1:], rtol=1e-14)
