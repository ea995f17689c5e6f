"""Extrusion: solid cells from quadrilaterals of a cross-section repeated along x."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from supple.arguments import check_instance
from supple.arrays import FloatArray, IntArray
from supple.errors import MeshError
from supple.mesh.cell_type import CellType
from supple.mesh.mesh import Mesh
from supple.mesh.quadratic import to_quadratic


def extrude(
    section: FloatArray,
    quads: IntArray,
    stations: FloatArray,
    cell_type: CellType,
    *,
    section_sets: Mapping[str, IntArray],
) -> Mesh:
    """Solid mesh of a cross-section in the y-z plane, repeated at stations along x.

    Tetrahedra come six to a hexahedron (Kuhn); quadratic cells get straight edges.

    Parameters
    ----------
    section : float array (P, 2)         y, z of the section's points
    quads : int array (Q, 4)             right-handed about x
    stations : float array (S,)          x, ascending
    cell_type : CellType                 TETRA4, TETRA10, HEXA8 or HEXA20
    section_sets : {name: int array}     section points; the mesh's sets contain them at every station
    Returns
    -------
    Mesh   node sets root (first station), tip (last station) and those of the section
    Raises
    ------
    MeshError   any other cell type
    """
    check_instance(
        "a parametric shape, cell_type", cell_type, CellType, "a CellType, such as CellType.TETRA4"
    )
    if cell_type.n_corners not in (4, 8):
        raise MeshError(f"{cell_type.name} is no cell of this shape; choose TETRA4, TETRA10, HEXA8 or HEXA20")
    n_points, n_stations = len(section), len(stations)
    nodes = np.column_stack([np.repeat(stations, n_points), np.tile(section, (n_stations, 1))])
    first_node = n_points * np.arange(n_stations)  # of each station
    ends = {"root": np.arange(n_points), "tip": first_node[-1] + np.arange(n_points)}
    sides = {name: (first_node[:, None] + members).ravel() for name, members in section_sets.items()}

    if cell_type.n_corners == 8:
        linear, layer = CellType.HEXA8, np.hstack([quads, quads + n_points])
    else:
        linear, layer = CellType.TETRA4, _layer_of_tetrahedra(section, quads, n_points)
    cells = (first_node[:-1, None, None] + layer).reshape(-1, linear.n_nodes)
    mesh = Mesh(nodes, {linear: cells}, ends | sides)
    return mesh if cell_type is linear else to_quadratic(mesh)


def _layer_of_tetrahedra(section: FloatArray, quads: IntArray, n_points: int) -> IntArray:
    """Divide the quads into triangles, and the prism over each triangle a < b < c into three tetrahedra.

    The diagonal of a prism's side runs from the lower point number at the bottom to the higher at the top,
    which makes neighbours compatible.
    """
    triangles = np.sort(np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), axis=1)
    a, b, c = triangles.T
    tetrahedra = np.vstack(
        [
            np.column_stack([a, b, c, c + n_points]),
            np.column_stack([a, b, c + n_points, b + n_points]),
            np.column_stack([a, a + n_points, b + n_points, c + n_points]),
        ]
    )
    # Sorting reversed some triangles; swapping two nodes of their tetrahedra restores the orientation.
    edge_1, edge_2 = section[b] - section[a], section[c] - section[a]
    over = np.tile(edge_1[:, 0] * edge_2[:, 1] < edge_1[:, 1] * edge_2[:, 0], 3)
    tetrahedra[over] = tetrahedra[over][:, [1, 0, 2, 3]]
    return tetrahedra
