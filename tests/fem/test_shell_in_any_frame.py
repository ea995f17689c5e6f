"""Shell triangle at finite rotation: thin strips in closed form, and the same answer in every frame."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import brentq
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from supple.fem import (
    HomogeneousSection,
    Isotropic,
    LaminateSection,
    ShellSection,
    assemble,
    shell_model,
    stress_recovery,
)
from supple.fem.quadratic_strain import strain
from supple.mesh import CellType, Mesh, strip

LENGTH, WIDTH, THICKNESS, MODULUS = 1.0, 0.1, 0.005, 2.1e11
EI = MODULUS * WIDTH * THICKNESS**3 / 12
GJ = MODULUS / 2 * WIDTH * THICKNESS**3 / 3
FRAMES = [[0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.2]]
STEEL = Isotropic(MODULUS, 0.0, 7800.0)
WALL = HomogeneousSection(STEEL, THICKNESS)


def turned_rigidly(mesh, q, turn):
    """Nodal freedoms (N, 6) of the motion q followed by a rotation about the origin."""
    R = Rotation.from_rotvec(turn)
    moved = R.apply(mesh.nodes + q[:, :3]) - mesh.nodes
    return np.column_stack([moved, (R * Rotation.from_rotvec(q[:, 3:])).as_rotvec()])


class Cantilever:
    """A strip whose root is prescribed exactly, in any attitude against the frame."""

    def __init__(self, wall: ShellSection = WALL, n_along=20):
        self.mesh = strip(LENGTH, WIDTH, n_along, 2)
        self.model = shell_model(self.mesh, wall)
        self.assembly = assemble(self.model)
        free = np.ones((self.mesh.n_nodes, 6), dtype=bool)
        free[self.mesh.nodes_of("root")] = False
        self.free = np.flatnonzero(free)
        self.tip = self.mesh.nodes_of("tip")
        self.centre = self.mesh.nodes_of("tip_centre")[0]

    def tip_force(self, force):
        load = np.zeros((self.mesh.n_nodes, 6))
        load[self.tip, :3] = np.outer([0.25, 0.5, 0.25], force)
        return load

    def tip_couple(self, torque):
        """Two dead forces at the edges."""
        load = np.zeros((self.mesh.n_nodes, 6))
        load[self.tip[[0, -1]], 2] = -torque / WIDTH, torque / WIDTH
        return load

    def tangent(self, q):
        return self.assembly.tangent(q.ravel())[self.free][:, self.free]

    def equilibrium(self, load, q, steps=1):
        """Nodal freedoms under a dead load in the frame's axes, from those of a start."""
        q, load = q.copy(), load.ravel()
        for step in np.linspace(0, 1, steps + 1)[1:]:
            for _ in range(30):
                residual = (step * load - self.assembly.internal_force(q.ravel()))[self.free]
                change = splu(self.tangent(q)).solve(residual)
                q.reshape(-1)[self.free] += change
                if np.abs(change).max() < 1e-9:
                    break
            else:
                raise AssertionError(f"Newton did not converge at load {step}")
        return q

    def bent(self, load, steps=3):
        return self.equilibrium(load, np.zeros((self.mesh.n_nodes, 6)), steps)

    def seen_from(self, turn, load, q):
        """The same equilibrium in a frame against which all stands turned, back in the axes of the root."""
        R = Rotation.from_rotvec(turn)
        load = R.apply(load.reshape(-1, 3)).reshape(-1, 6)
        found = self.equilibrium(load, turned_rigidly(self.mesh, q, turn))
        return turned_rigidly(self.mesh, found, -np.asarray(turn))


def elastica(tip_rotation):
    """Force and tip position (x, z) of an inextensible cantilever: EI theta'' = -F cos(theta)."""

    def backwards(force):
        def slope(_, y):
            return [y[1], -force / EI * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

        return solve_ivp(slope, (0, -LENGTH), [tip_rotation, 0, 0, 0], rtol=1e-11, atol=1e-13).y[:, -1]

    force = brentq(lambda f: backwards(f)[0], 0.1 * EI, 10 * EI, xtol=1e-10 * EI)
    return force, -backwards(force)[2:]


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


def lateral_buckling_force():
    """Dead force at the tip, in the plane of the strip, under which it turns over sideways.

    E Gamma phi'''' = GJ phi'' + P^2/EI (L - x)^2 phi,   phi = phi' = 0 at the root, no moments at the tip
    Source: V. Z. Vlasov, Thin-walled elastic beams (1961); without warping P L^2 = 4.013 sqrt(EI GJ)
    (Timoshenko and Gere, Theory of elastic stability, article 6.3).
    """
    warping = MODULUS * WIDTH**3 * THICKNESS**3 / 144

    def slope(x, y, square):
        return np.array([y[1], y[2], y[3], GJ / warping * (y[2] + square[0] * (LENGTH - x) ** 2 * y[0])])

    def ends(root, tip, _):
        return np.array([root[0], root[1], tip[2], warping * tip[3] - GJ * tip[1], tip[0] - 1])

    x = LENGTH * (1 - np.cos(np.linspace(0, np.pi, 400))) / 2
    s = np.pi / 2 * x / LENGTH
    guess = np.array([np.sin(s), np.cos(s), -np.sin(s), -np.cos(s)])
    solution = solve_bvp(slope, ends, x, guess, p=[16 / LENGTH**4], tol=1e-6)
    assert solution.success
    return np.sqrt(solution.p[0] * EI * GJ)


@pytest.fixture(scope="module")
def cantilever():
    return Cantilever()


@pytest.mark.parametrize(("rotation", "error"), [(0.291, 3e-4), (0.573, 3e-3), (0.874, 1e-2)])
def test_a_cantilever_follows_the_elastica(rotation, error, cantilever):
    force, (x, z) = elastica(rotation)
    q = cantilever.bent(cantilever.tip_force([0, 0, force]))
    found = cantilever.mesh.nodes[cantilever.centre] + q[cantilever.centre, :3]
    assert np.linalg.norm(found - [x, 0, z]) < error * z


@pytest.mark.parametrize("turn", FRAMES)
def test_a_bent_cantilever_is_the_same_in_a_frame_turned_by_02_rad(turn, cantilever):
    load = cantilever.tip_force([0, 0, elastica(0.291)[0]])
    q = cantilever.bent(load)
    moved = cantilever.seen_from(turn, load, q) - q
    assert np.linalg.norm(moved[cantilever.centre, :3]) < 1e-3 * np.linalg.norm(q[cantilever.centre, :3])


def test_a_twisted_strip_follows_vlasov(cantilever):
    torque = 0.3 * GJ / LENGTH
    q = cantilever.bent(cantilever.tip_couple(torque))
    assert q[cantilever.centre, 3] == pytest.approx(twisted_strip(torque), rel=0.01)


@pytest.mark.parametrize("turn", FRAMES)
def test_a_twisted_strip_is_the_same_in_a_frame_turned_by_02_rad(turn, cantilever):
    load = cantilever.tip_couple(0.3 * GJ / LENGTH)
    q = cantilever.bent(load)
    angle = cantilever.seen_from(turn, load, q)[cantilever.centre, 3]
    assert angle == pytest.approx(q[cantilever.centre, 3], rel=0.003)


@pytest.mark.parametrize("roll", [0.05, 0.1, 0.2])
def test_a_rolled_strip_is_as_flexible_as_before(roll, cantilever):
    """Small bending about its own weak axis after a roll about its span."""
    rest = np.zeros((cantilever.mesh.n_nodes, 6))
    load = cantilever.tip_force([0, 0, 1.0])
    rolled = Rotation.from_rotvec([roll, 0, 0]).apply(load.reshape(-1, 3)).ravel()
    q = turned_rigidly(cantilever.mesh, rest, [roll, 0, 0])
    compliance = [
        f[cantilever.free] @ splu(cantilever.tangent(state)).solve(f[cantilever.free])
        for f, state in ((load.ravel(), rest), (rolled, q))
    ]
    assert compliance[1] == pytest.approx(compliance[0], rel=5e-4)


def test_a_strip_bent_in_its_plane_buckles_sideways_at_the_load_of_vlasov(cantilever):
    """The tangent of the bent state turns indefinite within 2 % of it."""
    critical = lateral_buckling_force()
    lowest = [
        np.linalg.eigvalsh(cantilever.tangent(q).toarray())[0]
        for q in (cantilever.bent(cantilever.tip_force([0, f * critical, 0]), steps=1) for f in (0.98, 1.02))
    ]
    assert lowest[0] > 0 > lowest[1]


def test_stress_at_the_faces_is_the_bending_moment_over_the_section(cantilever):
    """sigma = M t/2 / I with M = F (x_tip - x), half way along a strip whose tip stands at 0.573 rad."""
    force, _ = elastica(0.573)
    q = cantilever.bent(cantilever.tip_force([0, 0, force]))
    stress = stress_recovery(cantilever.model).at_nodes(q.ravel())
    middle = cantilever.mesh.nodes_of("axis")[10]
    x = cantilever.mesh.nodes[:, 0] + q[:, 0]
    moment = force * (x[cantilever.centre] - x[middle])
    face = moment * THICKNESS / 2 * MODULUS / EI
    np.testing.assert_allclose(stress[middle, [0, 2], 0], [face, -face], rtol=0.01)
    assert np.abs(stress[middle, 1]).max() < 0.01 * face


@pytest.mark.parametrize("turn", FRAMES)
def test_stress_of_a_bent_strip_stays_when_it_turns(turn, cantilever):
    """Second Piola-Kirchhoff stress, in the axes of the mesh: no rotation changes it."""
    q = cantilever.bent(cantilever.tip_force([0, 0, elastica(0.291)[0]]))
    recovery = stress_recovery(cantilever.model)
    before = recovery.at_nodes(q.ravel())
    after = recovery.at_nodes(turned_rigidly(cantilever.mesh, q, turn).ravel())
    assert np.abs(after - before).max() < 0.02 * np.abs(before).max()


def test_a_coupled_laminate_is_the_same_in_a_frame_turned_by_02_rad():
    """Stretching, bending and twisting at once: B couples all of them."""
    A, D = WALL.membrane, WALL.bending
    B = 0.4 * np.sqrt(A[0, 0] * D[0, 0]) * np.array([[1.0, 0.1, 0.3], [0.1, -0.5, 0.1], [0.3, 0.1, 0.2]])
    strip_of_it = Cantilever(LaminateSection(A, B, D, 39.0, 1e-4))
    load = strip_of_it.tip_force([0, 0, elastica(0.2)[0]])
    q = strip_of_it.bent(load)
    assert np.abs(q[strip_of_it.tip, 3]).min() > 0.01
    for turn in FRAMES:
        moved = strip_of_it.seen_from(turn, load, q) - q
        assert np.linalg.norm(moved[strip_of_it.centre, :3]) < 1e-3 * np.linalg.norm(
            q[strip_of_it.centre, :3]
        )


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
        both = [strain(block, turned_rigidly(mesh, s * 1e-5 * bend, turn).reshape(1, 18)) for s in (1, -1)]
        return (both[0] - both[1])[0, 0] / 2e-5

    def energy_norm(strains):
        return np.sqrt(strains @ block.D[0] @ strains)

    left = [energy_norm(rate(angle) - rate(0)) for angle in (0.05, 0.1, 0.2)]
    assert np.diff(np.log2(left)).min() > 2.9
    assert left[-1] < 0.005 * energy_norm(rate(0))
