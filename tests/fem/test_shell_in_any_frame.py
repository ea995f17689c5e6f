"""Shell triangle at finite rotation: thin strips in closed form, and the same answer in every frame."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from supple.fem import (
    HomogeneousSection,
    Isotropic,
    LaminateSection,
    shell_model,
    stress_recovery,
)
from supple.fem.quadratic_strain import strain
from supple.mesh import CellType, Mesh
from supple_benchmarks.invariance.strip import (
    BENDING,
    LENGTH,
    MODULUS,
    THICKNESS,
    TORSION,
    WALL,
    WARPING,
    WIDTH,
    ClampedStrip,
    rotated_rigidly,
    strip_mesh,
)
from supple_benchmarks.references.elastica import force_for_rotation
from supple_benchmarks.references.lateral_buckling import warped_buckling_load

EI, GJ = BENDING, TORSION
force_for_rotation = cache(force_for_rotation)
FRAMES = [[0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.2]]
STEEL = Isotropic(MODULUS, 0.0, 7800.0)
CENTRE = strip_mesh().nodes_of("tip_centre")[0]


def twisted_strip(torque):
    """Rotation of the tip under two dead forces at its edges, warping held at the root.

    GJ phi' - E Gamma phi''' + 1/2 E I_n phi'^3 = T cos(phi_tip)
    Gamma = b^3 t^3/144 (warping of a thin rectangle), I_n = t b^5/180 (its edges are stretched)
    Source: V. Z. Vlasov, Thin-walled elastic beams (1961); the cubic term is Wagner's.
    """
    warping = MODULUS * WIDTH**3 * THICKNESS**3 / 144
    stretch = 0.5 * MODULUS * THICKNESS * WIDTH**5 / 180

    def slope(_, y, tip):
        return np.array([y[1], y[2], (GJ * y[1] + stretch * y[1] ** 3 - torque * np.cos(tip[0])) / warping])

    def ends(root, tip, given):
        return np.array([root[0], root[1], tip[2], tip[0] - given[0]])

    x = LENGTH * (1 - np.cos(np.linspace(0, np.pi, 400))) / 2
    angle = torque / GJ
    guess = np.array([angle * x, angle + 0 * x, 0 * x])
    solution = solve_bvp(slope, ends, x, guess, p=[angle], tol=1e-6)
    assert solution.success
    return solution.p[0]


@pytest.fixture(scope="module")
def cantilever():
    return ClampedStrip()


@pytest.mark.parametrize(
    ("rotation", "error"),
    [(0.291, 3e-4), (0.573, 3e-3), pytest.param(0.874, 1e-2, marks=pytest.mark.slow)],
)
def test_a_cantilever_follows_the_elastica(rotation, error, cantilever):
    force, (x, z) = force_for_rotation(EI, LENGTH, rotation)
    q = cantilever.bent(cantilever.tip_force([0, 0, force]))
    found = cantilever.mesh.nodes[CENTRE] + q[CENTRE, :3]
    assert np.linalg.norm(found - [x, 0, z]) < error * z


@pytest.mark.parametrize("turn", FRAMES)
def test_a_bent_cantilever_is_the_same_in_a_frame_turned_by_02_rad(turn, cantilever):
    load = cantilever.tip_force([0, 0, force_for_rotation(EI, LENGTH, 0.291)[0]])
    q = cantilever.bent(load)
    moved = cantilever.seen_from(turn, load, q) - q
    assert np.linalg.norm(moved[CENTRE, :3]) < 1e-3 * np.linalg.norm(q[CENTRE, :3])


def test_a_twisted_strip_follows_vlasov(cantilever):
    torque = 0.3 * GJ / LENGTH
    q = cantilever.bent(cantilever.tip_couple(torque))
    assert q[CENTRE, 3] == pytest.approx(twisted_strip(torque), rel=0.01)


@pytest.mark.parametrize("turn", FRAMES)
def test_a_twisted_strip_is_the_same_in_a_frame_turned_by_02_rad(turn, cantilever):
    load = cantilever.tip_couple(0.3 * GJ / LENGTH)
    q = cantilever.bent(load)
    angle = cantilever.seen_from(turn, load, q)[CENTRE, 3]
    assert angle == pytest.approx(q[CENTRE, 3], rel=0.003)


@pytest.mark.parametrize("roll", [0.05, 0.1, 0.2])
def test_a_rolled_strip_is_as_flexible_as_before(roll, cantilever):
    """Small bending about its own weak axis after a roll about its span."""
    rest = np.zeros((cantilever.mesh.n_nodes, 6))
    load = cantilever.tip_force([0, 0, 1.0])
    rolled = Rotation.from_rotvec([roll, 0, 0]).apply(load.reshape(-1, 3)).ravel()
    q = rotated_rigidly(cantilever.mesh, rest, Rotation.from_rotvec([roll, 0, 0]))
    compliance = [
        f[cantilever.free] @ splu(cantilever.tangent(state)).solve(f[cantilever.free])
        for f, state in ((load.ravel(), rest), (rolled, q))
    ]
    assert compliance[1] == pytest.approx(compliance[0], rel=5e-4)


def test_a_strip_bent_in_its_plane_buckles_sideways_at_the_load_of_vlasov(cantilever):
    """The tangent of the bent state turns indefinite within 2 % of it."""
    critical = warped_buckling_load(EI, GJ, WARPING, LENGTH)
    lowest = [
        np.linalg.eigvalsh(cantilever.tangent(q).toarray())[0]
        for q in (cantilever.bent(cantilever.tip_force([0, f * critical, 0]), steps=1) for f in (0.98, 1.02))
    ]
    assert lowest[0] > 0 > lowest[1]


def test_stress_at_the_faces_is_the_bending_moment_over_the_section(cantilever):
    """sigma = M t/2 / I with M = F (x_tip - x), half way along a strip whose tip stands at 0.573 rad."""
    force, _ = force_for_rotation(EI, LENGTH, 0.573)
    q = cantilever.bent(cantilever.tip_force([0, 0, force]))
    stress = stress_recovery(cantilever.model).at_nodes(q.ravel())
    middle = cantilever.mesh.nodes_of("axis")[10]
    x = cantilever.mesh.nodes[:, 0] + q[:, 0]
    moment = force * (x[CENTRE] - x[middle])
    face = moment * THICKNESS / 2 * MODULUS / EI
    np.testing.assert_allclose(stress[middle, [0, 2], 0], [face, -face], rtol=0.01)
    assert np.abs(stress[middle, 1]).max() < 0.01 * face


@pytest.mark.parametrize("turn", FRAMES)
def test_stress_of_a_bent_strip_stays_when_it_turns(turn, cantilever):
    """Second Piola-Kirchhoff stress, in the axes of the mesh: no rotation changes it."""
    q = cantilever.bent(cantilever.tip_force([0, 0, force_for_rotation(EI, LENGTH, 0.291)[0]]))
    recovery = stress_recovery(cantilever.model)
    before = recovery.at_nodes(q.ravel())
    after = recovery.at_nodes(rotated_rigidly(cantilever.mesh, q, Rotation.from_rotvec(turn)).ravel())
    assert np.abs(after - before).max() < 0.02 * np.abs(before).max()


def test_a_coupled_laminate_is_the_same_in_a_frame_turned_by_02_rad():
    """Stretching, bending and twisting at once: B couples all of them."""
    A, D = WALL.membrane, WALL.bending
    B = 0.4 * np.sqrt(A[0, 0] * D[0, 0]) * np.array([[1.0, 0.1, 0.3], [0.1, -0.5, 0.1], [0.3, 0.1, 0.2]])
    strip_of_it = ClampedStrip(wall=LaminateSection(A, B, D, 39.0, 1e-4))
    load = strip_of_it.tip_force([0, 0, force_for_rotation(EI, LENGTH, 0.2)[0]])
    q = strip_of_it.bent(load)
    assert np.abs(q[strip_of_it.mesh.nodes_of("tip"), 3]).min() > 0.01
    for turn in FRAMES:
        moved = strip_of_it.seen_from(turn, load, q) - q
        assert np.linalg.norm(moved[CENTRE, :3]) < 1e-3 * np.linalg.norm(q[CENTRE, :3])


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [3, 2, -2]])
@pytest.mark.parametrize("curvature", [[1, 0, 0], [0.3, -1, 0], [0, 0, 1]], ids=["bent", "saddle", "twisted"])
def test_a_small_bend_of_a_turned_triangle_is_right_to_third_order(axis, curvature):
    """Strains of exp(rho) exp(delta) to first order in delta, against those without the turn: rho^3."""
    triangle = np.array([[0.1, -0.2, 0], [1.0, 0.3, 0], [0.4, 0.9, 0]])
    mesh = Mesh(triangle, {CellType.TRIANGLE3: np.array([[0, 1, 2]])})
    (block,) = shell_model(mesh, HomogeneousSection(STEEL, 0.1)).blocks
    kxx, kyy, kxy = curvature
    x = triangle[:, :2] - triangle[:, :2].mean(axis=0)
    slope = x @ [[kxx, kxy], [kxy, kyy]]
    bend = np.column_stack([0 * x, 0.5 * (x * slope).sum(axis=1), slope[:, 1], -slope[:, 0], 0 * x[:, 0]])

    def rate(angle):
        turn = angle * np.array(axis) / np.linalg.norm(axis)
        both = [
            strain(block, rotated_rigidly(mesh, s * 1e-5 * bend, Rotation.from_rotvec(turn)).reshape(1, 18))
            for s in (1, -1)
        ]
        return (both[0] - both[1])[0, 0] / 2e-5

    def energy_norm(strains):
        return np.sqrt(strains @ block.D[0] @ strains)

    left = [energy_norm(rate(angle) - rate(0)) for angle in (0.05, 0.1, 0.2)]
    assert np.diff(np.log2(left)).min() > 2.9
    assert left[-1] < 0.005 * energy_norm(rate(0))
