"""The U-beam of [Wang2015] 5.2: three legs of about 5 m with a solid section, free.

Values chosen here: a square section of one mesh cell, whose side is 5 m over the number of cells per leg;
E = 3e5, Poisson's ratio 0.3, density 10, in consistent units.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from supple.body import AveragingInterface, FlexibleBody, flexible_body
from supple.errors import ModelError
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, Mesh
from supple.methods.intrinsic import (
    FREE,
    CondensedLine,
    IntrinsicBody,
    LoadPath,
    LoadPaths,
    condense,
    intrinsic_body,
)
from supple_benchmarks.intrinsic.beams import beam_line

__all__ = ["of_beam_elements", "on_stations", "solid_u"]

LEG, MODULUS, NU, DENSITY = 5.0, 3e5, 0.3, 10.0
SQUARE_TORSION = 0.1406
"""Torsion constant of a square over the fourth power of its side; Saint-Venant."""


def solid_u(n_leg: int) -> FlexibleBody:
    """The U in the x-y plane: a leg along x, a leg along y, and a leg back along x.

    n_leg : cells per leg, 20-node hexahedra with edges of 5 m / n_leg. With the corners there are 3 n_leg + 1
        cells: the axes of the legs along x are half a cell longer than 5 m, up to the centre of the corner.
    """
    h = LEG / n_leg
    # The cells of the U, selected from a grid of square cells.
    cells = [(i, 0) for i in range(n_leg + 1)]
    cells += [(n_leg, j) for j in range(1, n_leg + 1)]
    cells += [(i, n_leg) for i in range(n_leg - 1, -1, -1)]
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    corners = np.array([[*corner, z] for z in (0, 1) for corner in square])
    middle = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    local = np.vstack([2 * corners, [corners[a] + corners[b] for a, b in middle]])
    numbers = 2 * np.array([(i, j, 0) for i, j in cells])[:, None] + local
    unique, inverse = np.unique(numbers.reshape(-1, 3), axis=0, return_inverse=True)
    nodes = unique / 2 * np.array([h, h, h])
    mesh = Mesh(nodes, {CellType.HEXA20: inverse.reshape(len(cells), 20)})
    return flexible_body("u", solid_model(mesh, Isotropic(MODULUS, NU, DENSITY)), _ends(nodes, h, n_leg))


def _ends(nodes: np.ndarray, h: float, n_leg: int) -> list[AveragingInterface]:
    x, y = nodes[:, 0] / h, nodes[:, 1] / h
    first, last = (y <= 1 + 1e-9), (y >= n_leg - 1e-9)
    near, far = x < 1e-9, x >= n_leg - 1e-9
    sets = {"tip": near & first, "corner": far & first, "other corner": far & last, "other tip": near & last}
    return [AveragingInterface(name, np.flatnonzero(inside)) for name, inside in sets.items()]


def on_stations(body: FlexibleBody, n_stations: int, n_modes: int | None = None) -> IntrinsicBody:
    """A free line with the same number of segments on each of the three legs.

    n_stations : 4, 7, 10, ..: one more than the segments of all legs. Raises ModelError for other numbers.
    """
    if n_stations < 4 or (n_stations - 1) % 3:
        raise ModelError(
            f"{n_stations} stations cannot divide the three legs of the U equally: give 3 m + 1 stations "
            "with a whole number m of at least 1, such as 4, 7 or 10"
        )
    k = (n_stations - 1) // 3 + 1
    names = ("tip", "corner", "other corner", "other tip")
    legs = [LoadPath(a, b, k) for a, b in pairwise(names)]
    return condense(body, LoadPaths(legs), support=FREE, n_modes=n_modes)


def of_beam_elements(line: CondensedLine, n_leg: int) -> IntrinsicBody:
    """A free line of beam elements between the stations of `line`, with mass lumped at the stations.

    n_leg : cells per leg of `solid_u`; determines the side of the square section
    """
    side = LEG / n_leg
    beams = beam_line(
        "u",
        line.tree.points,
        axial=MODULUS * side**2,
        bending=MODULUS * side**4 / 12,
        torsion=MODULUS / (2 * (1 + NU)) * SQUARE_TORSION * side**4,
        mass=DENSITY * side**2,
        radius=side / np.sqrt(6),
    )
    return intrinsic_body(beams, FREE, stations={"tip": 0})
