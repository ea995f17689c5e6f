"""Beam elements along a line, and their condensed line."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from supple.fem import BeamSection, lumped_mass, shell_model
from supple.machine import Fixed, System
from supple.machine.system import Load
from supple.mesh import CellType, Mesh
from supple.methods.intrinsic import CondensedLine, IntrinsicBody, condensed_line
from supple.simulation import equilibrium

__all__ = ["BENDING_ROOTS", "condensed_beam", "line_mesh", "points_along_x", "tip_at_rest"]

BENDING_ROOTS = (1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349)
"""Wave number times length, b L, of a cantilever's bending modes: lowest roots of cos(b L) cosh(b L) = -1."""


def points_along_x(length: float, n: int) -> NDArray[np.float64]:
    """Ends (n + 1, 3) of n equal segments along x, from the origin."""
    return np.linspace(0, length, n + 1)[:, None] * np.eye(3)[0]


def line_mesh(nodes: ArrayLike) -> Mesh:
    """Line elements between consecutive nodes (N, 3); node sets "root" (first node) and "tip" (last node)."""
    places = np.asarray(nodes, dtype=float)
    n = len(places) - 1
    cells = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    return Mesh(places, {CellType.LINE2: cells}, {"root": np.array([0]), "tip": np.array([n])})


def condensed_beam(name: str, points: ArrayLike, section: BeamSection, radius: float) -> CondensedLine:
    """Beam elements through points (n, 3): exact stiffness between stations, mass lumped at the stations.

    radius : radius of gyration of the inertia of the stations, about all three axes
    """
    model = shell_model(line_mesh(points), section)
    masses = lumped_mass(model).reshape(-1, 6)[:, :1]
    diagonal = np.hstack([np.tile(masses, 3), np.tile(masses * radius**2, 3)])
    return condensed_line(name, points, model.stiffness, sparse.diags_array(diagonal.ravel()))


def tip_at_rest(body: IntrinsicBody, load: Load) -> NDArray[np.float64]:
    """Position (3,) of the last station of a line clamped at its root, in equilibrium under a load."""
    clamp = Fixed(first="ground", second=f"{body.name}.root", name="clamp")
    rest = equilibrium(System([body], [clamp], [load])).solution.bodies[body.name]
    return body.places(rest)[1][0, -1]
