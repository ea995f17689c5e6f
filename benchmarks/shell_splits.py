"""Quadrilateral shells as two triangles, on coarse meshes as in decks: curved walls and plates.

Every problem is solved on a grid of quadrilaterals that are divided along one diagonal (as in the readers),
along alternating diagonals, and along both diagonals with half the wall each. Plates are also solved with a
lumped mass, and with the discrete Kirchhoff quadrilateral of J.-L. Batoz and M. Ben Tahar (Int. J. Numer.
Methods Eng. 18 (1982) 1655-1677) with a bilinear mass. Six- and eight-node shells, divided into triangles
over all their nodes, correspond to a grid twice as fine.

Run: python benchmarks/shell_splits.py
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from measure import keep
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.linalg import spsolve

from supple.algebra import lowest_modes
from supple.fem import HomogeneousSection, Isotropic, lumped_mass, shell_model
from supple.mesh import CellType, Mesh

Array = NDArray[np.float64]
Place = Callable[[Array, Array], Array]

ONE, OTHER = [[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]
CUTS = ("one diagonal", "alternating", "both")


class Grid:
    """Quadrilaterals n x m over a square of parameters s, t, at places in space."""

    def __init__(self, n: int, m: int, place: Place):
        self.numbers = np.arange((n + 1) * (m + 1)).reshape(n + 1, m + 1)
        s, t = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, m + 1), indexing="ij")
        self.nodes = place(s.ravel(), t.ravel())
        a, b = self.numbers[:-1, :-1], self.numbers[1:, :-1]
        c, d = self.numbers[1:, 1:], self.numbers[:-1, 1:]
        self.quads = np.stack([a, b, c, d], axis=-1).reshape(-1, 4)
        odd = np.indices((n, m)).sum(axis=0).ravel() % 2 == 1
        one, other = self.quads[:, ONE], self.quads[:, OTHER]
        self.triangles = {
            "one diagonal": one.reshape(-1, 3),
            "alternating": np.where(odd[:, None, None], other, one).reshape(-1, 3),
            "other": other.reshape(-1, 3),
        }
        self.edges = {
            "start": self.numbers[0], "end": self.numbers[-1],
            "low": self.numbers[:, 0], "high": self.numbers[:, -1],
        }  # fmt: skip

    def matrices(self, wall: HomogeneousSection, cut: str) -> tuple[csc_array, csc_array]:
        """Stiffness and mass of the shell divided in a given way."""
        if cut != "both":
            triangles = self.triangles["one diagonal" if cut == "lumped mass" else cut]
            model = shell_model(Mesh(self.nodes, {CellType.TRIANGLE3: triangles}), wall)
            lumped = csc_array(diags_array(lumped_mass(model)))
            return model.stiffness, lumped if cut == "lumped mass" else model.mass
        halves = [self.matrices(wall, each) for each in ("one diagonal", "other")]
        K, M = (sum(each) / 2 for each in zip(*halves, strict=True))
        return csc_array(K), csc_array(M)

    def free(self, *holds: tuple[str, list[int]]) -> NDArray[np.int64]:
        """Free DOF if the named edges are supported."""
        free = np.ones((len(self.nodes), 6), dtype=bool)
        for edge, freedoms in holds:
            free[np.ix_(self.edges[edge], freedoms)] = False
        return np.flatnonzero(free.ravel())


def solved(K: csc_array, rows: NDArray[np.int64], load: Array) -> Array:
    u = np.zeros(load.size)
    u[rows] = spsolve(K[rows][:, rows].tocsc(), load.ravel()[rows])
    return u.reshape(load.shape)


def roof(n: int, cut: str) -> float:
    """Scordelis and Lo: sag of the free edge of a quarter over 0.3024 (MacNeal and Harder 1985)."""

    def place(s: Array, t: Array) -> Array:
        angle = np.radians(40) * t
        return np.column_stack([25.0 * s, 25.0 * np.sin(angle), 25.0 * np.cos(angle)])

    grid = Grid(n, n, place)
    K, M = grid.matrices(HomogeneousSection(Isotropic(4.32e8, 0.0, 1.0), 0.25), cut)
    fall = (M @ np.tile([0, 0, -360.0, 0, 0, 0], len(grid.nodes))).reshape(-1, 6)
    rows = grid.free(("start", [1, 2]), ("end", [0, 4, 5]), ("low", [1, 3, 5]))
    return -solved(K, rows, fall)[grid.numbers[-1, -1], 2] / 0.3024


def cylinder(n: int, cut: str) -> float:
    """Pinched cylinder with end diaphragms, an eighth: under the force over 1.8248e-5 (Belytschko 1985)."""

    def place(s: Array, t: Array) -> Array:
        angle = np.pi / 2 * t
        return np.column_stack([300.0 * s, 300.0 * np.sin(angle), 300.0 * np.cos(angle)])

    grid = Grid(n, n, place)
    K, _ = grid.matrices(HomogeneousSection(Isotropic(3e6, 0.3, 1.0), 3.0), cut)
    rows = grid.free(("start", [1, 2]), ("end", [0, 4, 5]), ("low", [1, 3, 5]), ("high", [2, 3, 4]))
    load = np.zeros((len(grid.nodes), 6))
    load[grid.numbers[-1, 0], 2] = -0.25
    return -solved(K, rows, load)[grid.numbers[-1, 0], 2] / 1.8248e-5


def twisted(n: int, cut: str, thickness: float, force: int) -> float:
    """Beam twisted by 90 degrees, 12 x 1.1: tip under a force along y or z over the usual values.

    MacNeal and Harder 1985; the thin one: T. Belytschko, B. L. Wong, H. Stolarski, Int. J. Numer. Methods
    Eng. 28 (1989) 385-414.
    """

    def place(s: Array, t: Array) -> Array:
        angle, across = np.pi / 2 * s, 1.1 * (t - 0.5)
        return np.column_stack([12 * s, across * np.cos(angle), across * np.sin(angle)])

    # Along the width of the tip (z) and across it (y).
    reference = {0.32: {1: 1.754e-3, 2: 5.424e-3}, 0.0032: {1: 1.294e-3, 2: 5.256e-3}}[thickness][force]
    grid = Grid(6 * n, n, place)
    K, _ = grid.matrices(HomogeneousSection(Isotropic(29e6, 0.22, 1.0), thickness), cut)
    load = np.zeros((len(grid.nodes), 6))
    tip = grid.edges["end"]
    weights = np.ones(len(tip))
    weights[[0, -1]] = 0.5
    load[tip, force] = weights / weights.sum() * (1.0 if thickness == 0.32 else 1e-6)
    return solved(K, grid.free(("start", list(range(6)))), load)[tip[len(tip) // 2], force] / reference


def hemisphere(n: int, cut: str) -> float:
    """Hemisphere with a hole of 18 degrees, two pairs of forces: over 0.094 (MacNeal and Harder 1985)."""

    def place(s: Array, t: Array) -> Array:
        polar, around = np.radians(18 + 72 * s), np.pi / 2 * t
        return 10 * np.column_stack(
            [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)]
        )

    grid = Grid(n, n, place)
    K, _ = grid.matrices(HomogeneousSection(Isotropic(6.825e7, 0.3, 1.0), 0.04), cut)
    corner = grid.numbers[-1, 0]
    rows = grid.free(("low", [1, 3, 5]), ("high", [0, 4, 5]))
    load = np.zeros((len(grid.nodes), 6))
    load[corner, 0], load[grid.numbers[-1, -1], 1] = 1.0, -1.0
    return solved(K, rows[rows != 6 * corner + 2], load)[corner, 0] / 0.094


def hook(n: int, cut: str) -> float:
    """Raasch's hook, a strip of two arcs under a force along its width: over 4.9366 in, by solids.

    N. F. Knight, AIAA Journal 35 (1997) 375-381: 14 in over 60 degrees from the clamp, then 46 in over 150.
    """
    bends = np.radians([60.0, 150.0])
    length = [14, 46] @ bends

    def place(s: Array, t: Array) -> Array:
        first = np.minimum(s * length / 14, bends[0])
        second = np.maximum(s * length - 14 * bends[0], 0) / 46
        turned = bends[0] - second
        x = 14 * (1 - np.cos(first)) + 46 * (np.cos(turned) - np.cos(bends[0]))
        y = 14 * np.sin(first) + 46 * (np.sin(bends[0]) - np.sin(turned))
        return np.column_stack([x, y, 20 * t])

    grid = Grid(9 * n, n, place)
    K, _ = grid.matrices(HomogeneousSection(Isotropic(3300.0, 0.35, 1.0), 2.0, shear_factor=5 / 6), cut)
    tip, load = grid.edges["end"], np.zeros((len(grid.nodes), 6))
    weights = np.ones(len(tip))
    weights[[0, -1]] = 0.5
    load[tip, 2] = weights / weights.sum()
    return float(solved(K, grid.free(("start", list(range(6)))), load)[tip, 2].mean()) / 4.9366


SUPPORTED = 2 * np.pi**2 * np.array([1, 2.5, 2.5, 4, 5, 5])
CANTILEVER = np.array([3.4710, 8.5067, 21.285, 27.199, 30.955, 54.187])
"""omega L^2 sqrt(m / D), nu = 0.3: Navier; Leissa, J. Sound Vib. 31 (1973) 257-293 by a Ritz series."""


def plate_frequencies(n: int, cut: str, held: str) -> Array:
    """Six frequencies of a square plate over the exact ones."""
    grid = Grid(n, n, lambda s, t: np.column_stack([s, t, 0 * s]))
    wall = HomogeneousSection(Isotropic(1e7, 0.3, 1.0), 1e-3)
    K, M = dkq_matrices(grid, wall) if cut == "DKQ" else grid.matrices(wall, cut)
    plane = ("start", "end", "low", "high")
    holds = [(edge, [2]) for edge in plane] if held == "supported" else [("start", [2, 3, 4])]
    rows = np.intersect1d(grid.free(*holds), np.add.outer(6 * np.arange(len(grid.nodes)), [2, 3, 4]))
    values = lowest_modes(csc_array(K[rows][:, rows]), csc_array(M[rows][:, rows]), 6).values
    scale = np.sqrt(wall.mass_per_area / wall.bending[0, 0])
    return np.sqrt(values) * scale / (SUPPORTED if held == "supported" else CANTILEVER)


def dkq_matrices(grid: Grid, wall: HomogeneousSection) -> tuple[csc_array, csc_array]:
    """Bending of the discrete Kirchhoff quadrilateral, and the mass of bilinear functions, of a flat grid."""
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    middle = np.array([[0, -1], [1, 0], [0, 1], [-1, 0]])
    gauss = np.array([[x, y] for x in (-1, 1) for y in (-1, 1)]) / np.sqrt(3)
    xy = grid.nodes[grid.quads][..., :2]
    slopes = np.zeros((len(xy), 8, 2, 4, 3))
    for a in range(4):
        slopes[:, a, 0, a, 2], slopes[:, a, 1, a, 1] = 1, -1
    for a in range(4):
        b = (a + 1) % 4
        side = xy[:, b] - xy[:, a]
        length = np.linalg.norm(side, axis=1)
        s = side / length[:, None]
        mean = 0.5 * (slopes[:, a] + slopes[:, b])
        mismatch = np.einsum("ei,eiaf->eaf", s, mean)
        mismatch[:, b, 0] += 1 / length
        mismatch[:, a, 0] -= 1 / length
        slopes[:, 4 + a] = mean - 1.5 * s[:, :, None, None] * mismatch[:, None]
    slopes = slopes.reshape(len(xy), 8, 2, 12)
    K, M = np.zeros((len(xy), 12, 12)), np.zeros((len(xy), 12, 12))
    for point in gauss:
        linear = corner * (1 + corner[:, ::-1] * point[::-1]) / 4
        J = np.einsum("eai,aj->eij", xy, linear)
        area = np.linalg.det(J)
        gradient = np.einsum("aj,eji->eai", _serendipity(point, corner, middle), np.linalg.inv(J))
        by = np.einsum("eai,eacn->eicn", gradient, slopes)
        B = np.stack([by[:, 0, 0], by[:, 1, 1], by[:, 1, 0] + by[:, 0, 1]], axis=1)
        K += area[:, None, None] * (B.swapaxes(1, 2) @ wall.bending @ B)
        shape = np.prod(1 + corner * point, axis=1) / 4
        mass = wall.mass_per_area * np.outer(shape, shape)
        rotary = wall.rotary_inertia_per_area * np.outer(shape, shape)
        M += area[:, None, None] * (np.kron(mass, np.diag([1, 0, 0])) + np.kron(rotary, np.diag([0, 1, 1])))
    dofs = (6 * grid.quads[:, :, None] + np.array([2, 3, 4])).reshape(len(xy), -1)
    rows, columns = np.repeat(dofs, 12, axis=1).ravel(), np.tile(dofs, 12).ravel()
    n = 6 * len(grid.nodes)
    made = [coo_array((each.ravel(), (rows, columns)), shape=(n, n)).tocsc() for each in (K, M)]
    return made[0], made[1]


def _serendipity(point: Array, corner: Array, middle: Array) -> Array:
    """Gradients (8, 2) in the parent square of the eight-node functions."""
    powers = np.array([[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [2, 1], [1, 2]])
    P = np.prod(np.concatenate([corner, middle])[:, None] ** powers, axis=2)
    x, y = point
    i, j = powers.T
    d = np.column_stack([i * x ** np.maximum(i - 1, 0) * y**j, j * x**i * y ** np.maximum(j - 1, 0)])
    return np.linalg.solve(P.T, d)


def problems() -> Iterator[tuple[str, str, Sequence[float]]]:
    """Problem, division, and result over reference with 4, 8, 16 cells a side (across strips 1, 2, 4)."""
    for cut in CUTS:
        yield "Scordelis-Lo roof", cut, [roof(n, cut) for n in (4, 8, 16)]
        yield "pinched cylinder", cut, [cylinder(n, cut) for n in (4, 8, 16)]
        for thickness in (0.32, 0.0032):
            for force, along in ((2, "along"), (1, "across")):
                found = [twisted(n, cut, thickness, force) for n in (1, 2, 4)]
                yield f"twisted beam, t = {thickness}, force {along} the tip", cut, found
        yield "pinched hemisphere", cut, [hemisphere(n, cut) for n in (4, 8, 16)]
        yield "Raasch's hook", cut, [hook(n, cut) for n in (1, 2, 4)]
    for held in ("supported", "cantilever"):
        for cut in (*CUTS, "lumped mass", "DKQ"):
            found = [plate_frequencies(n, cut, held) for n in (4, 8, 16)]
            yield f"{held} plate, first frequency", cut, [each[0] for each in found]
            yield f"{held} plate, worst of six", cut, [each[np.argmax(abs(each - 1))] for each in found]


def main() -> None:
    meshes = ("4, %", "8, %", "16, %")
    keep(
        Path(__file__).stem,
        [
            {"problem": problem, "cut": cut}
            | {mesh: 100 * float(ratio - 1) for mesh, ratio in zip(meshes, found, strict=True)}
            for problem, cut, found in problems()
        ],
    )


if __name__ == "__main__":
    main()
