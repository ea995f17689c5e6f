"""Section and cell types of decks: sandwich walls, coupled and tapered beams, wedges, pyramids, fibres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from supple.algebra import factorize_symmetric, lowest_modes
from supple.fem import (
    Anisotropic,
    BeamSection,
    CoupledBeamSection,
    FiniteElementModel,
    Isotropic,
    LaminateSection,
    Section,
    finite_element_model,
    shell_model,
    solid_model,
)
from supple.mesh import CellType, Mesh, block, plate, to_quadratic
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES"]

Array = NDArray[np.float64]

ALUMINIUM = Isotropic(7e10, 0.3, 2700.0)


def _moved(model: FiniteElementModel, free: NDArray[np.bool_], load: Array) -> Array:
    """Linear nodal displacements (N, d) under nodal loads (N, d); `free` (N, d) is False at supports."""
    rows = np.flatnonzero(free.ravel())
    u = np.zeros(free.size)
    u[rows] = factorize_symmetric(csc_array(model.stiffness[rows][:, rows])).solve(load.ravel()[rows])
    return u.reshape(free.shape)


def sandwich_plate() -> Sequence[Comparison]:
    """Three frequencies of a simply supported sandwich plate, all more than halved by shear of the core."""
    sides, face, core, core_shear, core_density = np.array([0.6, 0.4]), 0.5e-3, 0.02, 10e6, 60.0
    h = core + face
    A = 2 * face * ALUMINIUM.plane_stress
    D = (face * h**2 / 2 + face**3 / 6) * ALUMINIUM.plane_stress
    mass = 2 * ALUMINIUM.density * face + core_density * core
    rotary = ALUMINIUM.density * face * h**2 / 2 + core_density * core**3 / 12
    H = core_shear * h**2 / core
    mesh = plate(sides[0], sides[1], 24, 16)
    model = shell_model(mesh, LaminateSection(A, 0 * A, D, mass, rotary, shear=H * np.eye(2)))
    free = np.zeros((mesh.n_nodes, 6), dtype=bool)
    free[:, 2:5] = True
    place = mesh.nodes[:, :2] - mesh.nodes[:, :2].min(axis=0)
    on_edge = np.isclose(place, 0) | np.isclose(place, sides)
    free[on_edge.any(axis=1), 2] = False
    free[:, 3:5] &= ~on_edge
    rows = np.flatnonzero(free.ravel())
    values = lowest_modes(model.stiffness[rows][:, rows], model.mass[rows][:, rows], 3).values
    source = "Mindlin's plate theory: w = W s, slopes b grad s, s = sin sin"
    compared = []
    for value, waves in zip(values, ((1, 1), (2, 1), (1, 2)), strict=True):
        k2 = ((np.pi * np.array(waves) / sides) ** 2).sum()
        K = np.array([[D[0, 0] * k2 + H, -H], [-H * k2, H * k2]])
        exact = np.sqrt(np.linalg.eigvals(np.linalg.solve(np.diag([rotary, mass]), K)).real.min())
        name = f"frequency of {waves[0]} x {waves[1]} half waves, Hz"
        compared.append(
            Comparison(name, float(np.sqrt(value)) / (2 * np.pi), exact / (2 * np.pi), source, 0.012)
        )
    return compared


def _cantilever(section: BeamSection | CoupledBeamSection, length: float, load: Array) -> Array:
    """Motion (6,) of the tip of one beam element, clamped at its root, under tip forces and moments (6,)."""
    mesh = Mesh(np.array([[0, 0, 0], [length, 0, 0]]), {CellType.LINE2: np.array([[0, 1]])})
    free = np.array([[False] * 6, [True] * 6])
    return _moved(shell_model(mesh, section), free, np.array([np.zeros(6), load]))[1]


def coupled_beam() -> Sequence[Comparison]:
    """A laminated beam with bending-twist coupling: one element under a transverse tip force."""
    length, force = 2.0, 50.0
    stiffness = np.diag([4e7, 6e6, 3e6, 4e4, 3e4, 2e5])
    stiffness[3, 4] = stiffness[4, 3] = 1.5e4
    moved = _cantilever(CoupledBeamSection(stiffness, np.eye(6), (0, 1, 0)), length, np.eye(6)[2] * force)
    flexibility = np.linalg.inv(stiffness)
    # The moment about y at x is -P (L - x).
    bent = force * (flexibility[4, 4] * length**3 / 3 + flexibility[2, 2] * length)
    twist = -force * flexibility[3, 4] * length**2 / 2
    source = "integral of the section's flexibility along the beam"
    return (
        Comparison("deflection, m", float(moved[2]), bent, source, 1e-9),
        Comparison("twist, rad", float(moved[3]), twist, source, 1e-9),
    )


def tapered_beam() -> Sequence[Comparison]:
    """A spring whose width decreases linearly to a half: one element under a transverse tip force."""
    length, width, height, force = 0.5, 0.04, 0.005, 10.0

    def of(b: float) -> BeamSection:
        second = (b**3 * height / 12, b * height**3 / 12, b * height**3 / 3)
        return BeamSection(ALUMINIUM, b * height, *second, orientation=(0, 1, 0))

    moved = _cantilever(replace(of(width), second=of(width / 2)), length, np.eye(6)[2] * force)
    rigidity = ALUMINIUM.youngs_modulus * width * height**3 / 12
    exact = force * length**3 / rigidity * (2 * np.log(2) - 1)
    return (Comparison("deflection, m", float(moved[2]), exact, "int (L - x)^2 / E I(x) dx", 1e-8),)


def wedges_and_pyramids() -> Sequence[Comparison]:
    """A cantilever of quadratic wedges, and one of pyramids, under a transverse tip force."""
    length, width, height, E, force = 5.0, 0.5, 1.0, 1e6, 1.0
    bending, shear = 3 * E * width * height**3 / 12, E / 2 * width * height / 1.2
    exact = force * length**3 / bending + force * length / shear
    bricks = block(length, width, height, 8, 1, 2, CellType.HEXA8)
    cells, nodes = bricks.cells[CellType.HEXA8], bricks.nodes
    wedges = {CellType.WEDGE6: cells[:, ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))].reshape(-1, 6)}
    middle = len(nodes) + np.arange(len(cells))
    bases = cells[:, [face[::-1] for face in CellType.HEXA8.faces]]
    apex = np.broadcast_to(middle[:, None, None], (*bases.shape[:2], 1))
    pyramids = {CellType.PYRAMID5: np.concatenate([bases, apex], axis=2).reshape(-1, 5)}
    with_middles = np.vstack([nodes, nodes[cells].mean(axis=1)])
    compared = []
    for name, linear in (("wedges", Mesh(nodes, wedges)), ("pyramids", Mesh(with_middles, pyramids))):
        mesh = to_quadratic(linear)
        x = mesh.nodes[:, 0]
        free = np.repeat(~np.isclose(x, 0), 3).reshape(-1, 3)
        load = np.zeros((mesh.n_nodes, 3))
        tip = np.isclose(x, length)
        load[tip, 2] = force / tip.sum()
        moved = _moved(solid_model(mesh, Isotropic(E, 0.0, 1.0)), free, load)
        found = float(moved[tip, 2].mean())
        compared.append(Comparison(f"deflection, {name}, m", found, exact, "Timoshenko's beam", 5e-3))
    return compared


def fibres_across_a_bar() -> Sequence[Comparison]:
    """A bar with fibres at 30 degrees to its axis, stretched: the modulus along the axis."""
    E1, E2, nu, G, angle = 130e9, 9e9, 0.3, 5e9, np.radians(30)
    compliance = np.diag([1 / E1, 1 / E2, 1 / E2, 1 / 3e9, 1 / G, 1 / G])
    compliance[0, 1:3] = compliance[1:3, 0] = -nu / E1
    compliance[1, 2] = compliance[2, 1] = -0.4 / E2
    c, s = np.cos(angle), np.sin(angle)
    mesh = block(1.0, 0.3, 0.2, 2, 2, 1, CellType.HEXA20)
    n = mesh.n_cells
    axes = np.tile([[c, -s, 0], [s, c, 0], [0, 0, 1]], (n, 1, 1))
    fibres = Anisotropic(np.linalg.inv(compliance), 1600.0)
    model = finite_element_model(mesh, (Section(CellType.HEXA20, np.arange(n), fibres, directions=axes),))
    # A uniform axial stress of 1 Pa: the nodal forces of its uniform strain.
    i, j = np.array([(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]).T
    R = axes[0]
    local = R.T @ np.diag([1.0, 0, 0]) @ R
    strain = np.zeros((3, 3))
    strain[i, j] = strain[j, i] = (compliance @ local[i, j]) * np.where(i == j, 1.0, 0.5)
    load = (model.stiffness @ (mesh.nodes @ (R @ strain @ R.T)).ravel()).reshape(-1, 3)
    free = np.ones((mesh.n_nodes, 3), dtype=bool)
    # Six supported freedoms at three corners prevent rigid motions, and no uniform strain.
    for place, freedoms in (((0, -0.15, -0.1), [0, 1, 2]), ((0, 0.15, -0.1), [0, 2]), ((0, -0.15, 0.1), [0])):
        corner = np.flatnonzero(np.isclose(mesh.nodes, place).all(axis=1))[0]
        free[corner, freedoms] = False
    moved = _moved(model, free, load)
    tip, root = mesh.nodes[:, 0] == 1.0, mesh.nodes[:, 0] == 0.0
    modulus = float(1 / (moved[tip, 0].mean() - moved[root, 0].mean()))
    exact = 1 / (c**4 / E1 + (1 / G - 2 * nu / E1) * s**2 * c**2 + s**4 / E2)
    source = "R. M. Jones, Mechanics of Composite Materials (1999), eq. (2.97)"
    return (Comparison("modulus along the bar, Pa", modulus, exact, source, 1e-6),)


CASES = (
    ValidationCase("sandwich plate", sandwich_plate),
    ValidationCase("beam with coupled bending and twist", coupled_beam),
    ValidationCase("tapered beam", tapered_beam),
    ValidationCase("cantilevers of wedges and of pyramids", wedges_and_pyramids),
    ValidationCase("bar of fibres", fibres_across_a_bar),
)
