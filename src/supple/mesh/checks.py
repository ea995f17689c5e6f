"""Checks of a mesh on entry: one message for each kind of error, with location and remedy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, NoReturn

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from supple.arrays import FloatArray, IntArray
from supple.errors import CellError, MeshError
from supple.mesh.cell_type import CellType
from supple.mesh.quadrature import strain_rule
from supple.mesh.reference_cell import shape_gradients

# A triangle whose height is below this fraction of its longest edge has no usable normal or curvature.
FLATTEST_TRIANGLE = 1e-6
# A line has no direction when it is not longer than this fraction of the mesh's largest extent along an axis.
SHORTEST_LINE = 1e-9
# A solid cell is flat when its smallest Jacobian falls below this fraction of its longest extent cubed, and
# inverted when it falls below minus this value; slender cells (1 : 1000 in two directions) reach 1e-6.
FLATTEST_SOLID = 1e-10


def check_mesh(
    nodes: FloatArray,
    cells: Mapping[CellType, IntArray],
    node_sets: Mapping[str, IntArray],
    cell_sets: Mapping[str, Mapping[CellType, IntArray]],
    node_ids: IntArray,
    cell_ids: Mapping[CellType, IntArray],
    links: IntArray,
) -> None:
    """Raise MeshError at the first error, with node and cell ids; later checks rely on earlier ones."""
    names = _Names(node_ids, cell_ids)
    _check_node_coordinates(nodes, names)
    _check_cell_arrays(cells, links)
    _check_links(nodes, links)
    _check_cell_node_range(nodes, cells, names)
    _check_repeated_nodes(cells, names)
    _check_orphan_nodes(nodes, cells, links, names)
    for name, members in node_sets.items():
        _check_members(f"node set '{name}'", members, len(nodes), "nodes")
    _check_cell_sets(cells, cell_sets)
    _check_cell_geometry(nodes, cells, names)
    _check_connected(nodes, cells, links, names)


def check_ids(
    nodes: FloatArray,
    cells: Mapping[CellType, IntArray],
    node_ids: IntArray,
    cell_ids: Mapping[CellType, IntArray],
) -> None:
    """Raise MeshError unless each node and cell has one id, and node ids differ."""
    if node_ids.shape != np.shape(nodes)[:1]:
        raise MeshError(f"node ids have shape {node_ids.shape} for {len(nodes)} nodes; give one id per node")
    unique, count = np.unique(node_ids, return_counts=True)
    if (count > 1).any():
        raise MeshError(f"{count.max()} nodes have the id {unique[np.argmax(count)]}; node ids must differ")
    for kind, array in cells.items():
        if cell_ids[kind].shape != np.shape(array)[:1]:
            raise MeshError(
                f"ids of cells {kind.name} have shape {cell_ids[kind].shape} for {len(array)} cells; "
                "give one id per cell"
            )


class _Names(NamedTuple):
    """Ids of nodes and cells for messages."""

    node_ids: IntArray
    cell_ids: Mapping[CellType, IntArray]

    def nodes(self, numbers: IntArray) -> str:
        """Ids of some nodes, as a list."""
        return str(self.node_ids[numbers].tolist())


def _check_node_coordinates(nodes: FloatArray, names: _Names) -> None:
    if nodes.ndim != 2 or nodes.shape[1] != 3 or not len(nodes):
        raise MeshError(
            f"nodes have shape {nodes.shape}; expected (N, 3) with N >= 1, one row x, y, z per node"
        )
    bad = np.flatnonzero(~np.isfinite(nodes).all(axis=1))
    if bad.size:
        raise MeshError(
            f"{_some('node', names.node_ids[bad])} not finite; node {names.node_ids[bad[0]]} "
            f"is at {_point(nodes[bad[0]])}"
        )


def _check_links(nodes: FloatArray, links: IntArray) -> None:
    if links.ndim != 2 or links.shape[1] != 2:
        raise MeshError(f"links have shape {links.shape}; expected (L, 2)")
    if links.size and (links.min() < 0 or links.max() >= len(nodes)):
        raise MeshError(f"a link has a node outside 0 .. {len(nodes) - 1}; node numbers start at 0")


def _check_cell_arrays(cells: Mapping[CellType, IntArray], links: IntArray) -> None:
    if not cells and not len(links):
        raise MeshError("the mesh has no cells; give at least one {CellType: node numbers (E, k)}")
    for kind, array in cells.items():
        if array.ndim != 2 or array.shape[1] != kind.n_nodes:
            raise MeshError(f"cells {kind.name} have shape {array.shape}; expected (E, {kind.n_nodes})")
        if not len(array):
            raise MeshError(f"cells {kind.name} are empty; leave the type out instead")


def _check_cell_node_range(nodes: FloatArray, cells: Mapping[CellType, IntArray], names: _Names) -> None:
    for kind, array in cells.items():
        ids = names.cell_ids[kind]
        bad = np.flatnonzero(((array < 0) | (array >= len(nodes))).any(axis=1))
        if bad.size:
            raise MeshError(
                f"{_some(f'{kind.name} cell', ids[bad])} with nodes outside 0 .. {len(nodes) - 1}; "
                f"cell {ids[bad[0]]} has nodes {array[bad[0]].tolist()}; node numbers start at 0"
            )


def _check_repeated_nodes(cells: Mapping[CellType, IntArray], names: _Names) -> None:
    for kind, array in cells.items():
        ids = names.cell_ids[kind]
        ordered = np.sort(array, axis=1)
        bad = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
        if bad.size:
            raise CellError(
                f"{_some(f'{kind.name} cell', ids[bad])} with a repeated node; cell {ids[bad[0]]} has "
                f"nodes {names.nodes(array[bad[0]])}; write a collapsed cell as the simpler cell type",
                kind.name,
                int(bad[0]),
            )


def _check_orphan_nodes(
    nodes: FloatArray, cells: Mapping[CellType, IntArray], links: IntArray, names: _Names
) -> None:
    used = np.zeros(len(nodes), dtype=bool)
    used[links] = True
    for array in cells.values():
        used[array] = True
    bad = np.flatnonzero(~used)
    if bad.size:
        raise MeshError(
            f"{_some('orphan node', names.node_ids[bad])}: no cell uses them; node "
            f"{names.node_ids[bad[0]]} is at {_point(nodes[bad[0]])}; remove unused nodes in the mesher "
            "(Gmsh: define physical groups; only their nodes are then saved), or in Python: "
            "read_mesh(.., unused_nodes=UnusedNodes.DROP)"
        )


def _check_cell_sets(
    cells: Mapping[CellType, IntArray], cell_sets: Mapping[str, Mapping[CellType, IntArray]]
) -> None:
    for name, by_kind in cell_sets.items():
        if not by_kind:
            raise MeshError(f"cell set '{name}' is empty; leave it out, or name its cells")
        for kind, members in by_kind.items():
            _check_members(f"cell set '{name}'", members, len(cells.get(kind, ())), f"{kind.name} cells")


def _check_members(what: str, members: IntArray, count: int, of_what: str) -> None:
    if members.ndim != 1:
        raise MeshError(f"{what} has shape {members.shape}; expected one row of numbers (k,)")
    if not members.size:
        raise MeshError(f"{what} is empty; leave it out, or name its members")
    bad = members[(members < 0) | (members >= count)]
    if bad.size:
        raise MeshError(f"{what} contains {bad[0]}, but the mesh has {count} {of_what}, numbered from 0")
    if len(np.unique(members)) != len(members):
        values, counts = np.unique(members, return_counts=True)
        raise MeshError(f"{what} has {values[counts > 1][0]} more than once; list each member once")


def _check_cell_geometry(nodes: FloatArray, cells: Mapping[CellType, IntArray], names: _Names) -> None:
    for kind, array in cells.items():
        if kind.dimension == 1:
            _check_line_lengths(nodes, array, names)
        elif kind.dimension == 2:
            _check_flat_triangles(nodes, array, names)
        else:
            _check_solid_jacobians(nodes, kind, array, names)


def _check_line_lengths(nodes: FloatArray, lines: IntArray, names: _Names) -> None:
    kind = CellType.LINE2
    length = np.linalg.norm(nodes[lines[:, 1]] - nodes[lines[:, 0]], axis=1)
    bad = np.flatnonzero(length <= SHORTEST_LINE * np.ptp(nodes, axis=0).max())
    if bad.size:
        what = "degenerate", ", with (almost) no length"
        _refuse(nodes, kind, lines, bad, names, what, "move or merge its nodes, or remove it")


def _check_flat_triangles(nodes: FloatArray, triangles: IntArray, names: _Names) -> None:
    """A triangle in space cannot be inverted: only its height relative to its longest edge is checked."""
    kind = CellType.TRIANGLE3
    corners = nodes[triangles]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    twice_area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    bad = np.flatnonzero(twice_area <= FLATTEST_TRIANGLE * longest**2)
    if bad.size:
        what = "degenerate", ", with (almost) no area"
        _refuse(nodes, kind, triangles, bad, names, what, "move or merge its nodes, or remove it")


def _check_solid_jacobians(nodes: FloatArray, kind: CellType, array: IntArray, names: _Names) -> None:
    """Check that the Jacobian det dx/dxi of the cell's own map is positive at its strain points.

    Elsewhere, above all at nodes, the Jacobian of a coarse cell with curved sides may be negative; its mass
    and stiffness are still correct.
    """
    corners = nodes[array]
    extent = np.ptp(corners, axis=1).max(axis=1)
    gradients = shape_gradients(kind, strain_rule(kind).points)
    smallest = np.full(len(array), np.inf)
    for gradient in gradients:  # one point at a time, to limit the memory
        np.minimum(smallest, np.linalg.det(np.einsum("eai,aj->eij", corners, gradient)), out=smallest)
    bad = np.flatnonzero(smallest < -FLATTEST_SOLID * extent**3)
    if bad.size:
        what = "inverted", ": the Jacobian is negative at an integration point"
        remedy = f"reorder its nodes as in CellType.{kind.name}, straighten its sides, or remesh there"
        _refuse(nodes, kind, array, bad, names, what, remedy)
    bad = np.flatnonzero(smallest <= FLATTEST_SOLID * extent**3)
    if bad.size:
        what = "degenerate", ", with (almost) no volume at an integration point"
        _refuse(nodes, kind, array, bad, names, what, "move its nodes, or remesh there")


def _refuse(
    nodes: FloatArray,
    kind: CellType,
    array: IntArray,
    bad: IntArray,
    names: _Names,
    what: tuple[str, str],
    remedy: str,
) -> NoReturn:
    """Raise CellError for cells of one kind; what : words before and after their number and ids."""
    before, after = what
    raise CellError(
        f"{_some(f'{before} {kind.name} cell', names.cell_ids[kind][bad])}{after}; "
        f"{_cell(nodes, kind, array, bad[0], names)}; {remedy}",
        kind.name,
        int(bad[0]),
    )


def _check_connected(
    nodes: FloatArray, cells: Mapping[CellType, IntArray], links: IntArray, names: _Names
) -> None:
    # It is sufficient to connect each node of a cell with the next one.
    start = np.concatenate([links[:, 0], *(array[:, :-1].ravel() for array in cells.values())])
    end = np.concatenate([links[:, 1], *(array[:, 1:].ravel() for array in cells.values())])
    graph = coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=(len(nodes), len(nodes)))
    n_parts, part = connected_components(graph, directed=False)
    if n_parts > 1:
        sizes = np.sort(np.bincount(part))[::-1]
        first = np.flatnonzero(part != np.argmax(np.bincount(part)))[0]
        raise MeshError(
            f"the mesh falls into {n_parts} disconnected parts, of {_first_few(sizes)} nodes; node "
            f"{names.node_ids[first]} at {_point(nodes[first])} is not in the largest; merge coincident "
            "nodes, or make each part a separate body: cells = 'CELL SET' of a body in a case file, "
            "read_mesh(.., only='CELL SET') in Python"
        )


def _some(what: str, found: IntArray) -> str:
    return f"{len(found)} {what}{'s' if len(found) > 1 else ''} ({_first_few(found)})"


def _first_few(numbers: IntArray) -> str:
    return ", ".join(map(str, numbers[:5].tolist())) + (", ..." if len(numbers) > 5 else "")


def _cell(nodes: FloatArray, kind: CellType, array: IntArray, number: int, names: _Names) -> str:
    members = array[number]
    corners = ", ".join(_point(nodes[node]) for node in members[:4]) + (", ..." if len(members) > 4 else "")
    return f"cell {names.cell_ids[kind][number]} has nodes {names.nodes(members)} at {corners}"


def _point(position: FloatArray) -> str:
    return "(" + ", ".join(f"{value:g}" for value in position) + ")"
