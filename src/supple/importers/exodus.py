"""Exodus II meshes (.exo, .e, .g): netCDF of either kind, classic or HDF5.

Source: L. A. Schoof and V. R. Yarberry, EXODUS II: A finite element data model, SAND92-2137 (1994).
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray
from scipy.io import netcdf_file

from supple.arguments import checked_arguments
from supple.copied_hdf5 import open_copied
from supple.errors import ImportFormatError
from supple.importers.cell_file import (
    WITHOUT_INNER,
    CellElements,
    cell_elements,
    cell_file_mesh,
    without_inner_nodes,
)
from supple.importers.file_mesh import UnusedNodes
from supple.importers.text_file import file_content
from supple.mesh import CellType, Mesh

__all__ = ["EXODUS_SUFFIXES", "read_exodus"]

IntArray = NDArray[np.int64]

EXODUS_SUFFIXES = (".exo", ".ex2", ".e", ".g")
_HDF5_MARK = b"\x89HDF\r\n\x1a\n"

# First letters of an element type and its nodes: name, dimension.
_TYPES = {
    ("TET", 4): ("tetra", 3), ("TET", 10): ("tetra10", 3), ("HEX", 8): ("hexahedron", 3),
    ("HEX", 20): ("hexahedron20", 3), ("HEX", 27): ("hexahedron27", 3), ("WED", 6): ("wedge", 3),
    ("WED", 15): ("wedge15", 3), ("WED", 18): ("wedge18", 3), ("PYR", 5): ("pyramid", 3),
    ("PYR", 13): ("pyramid13", 3), ("PYR", 14): ("pyramid14", 3), ("TRI", 3): ("triangle", 2),
    ("TRI", 6): ("triangle6", 2), ("QUA", 4): ("quad", 2), ("QUA", 8): ("quad8", 2), ("QUA", 9): ("quad9", 2),
    ("SHE", 3): ("triangle", 2), ("SHE", 4): ("quad", 2), ("SHE", 8): ("quad8", 2), ("SHE", 9): ("quad9", 2),
    ("BAR", 2): ("line", 1), ("BEA", 2): ("line", 1), ("TRU", 2): ("line", 1), ("BAR", 3): ("line3", 1),
    ("BEA", 3): ("line3", 1), ("TRU", 3): ("line3", 1), ("SPH", 1): ("vertex", 0), ("CIR", 1): ("vertex", 0),
}  # fmt: skip
# Exodus lists the middles of the vertical edges before those of the top.
_VERTICAL_FIRST = {
    "hexahedron20": [*range(12), *range(16, 20), *range(12, 16)],
    "hexahedron27": [*range(12), *range(16, 20), *range(12, 16), *range(20, 27)],
    "wedge15": [*range(9), *range(12, 15), *range(9, 12)],
    "wedge18": [*range(9), *range(12, 15), *range(9, 12), *range(15, 18)],
}
# Corners of the sides of a solid, from side 1.
_SIDES = {
    "tetra": ((0, 1, 3), (1, 2, 3), (0, 2, 3), (0, 1, 2)),
    "hexahedron": ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 3, 7, 4), (0, 1, 2, 3), (4, 5, 6, 7)),
    "wedge": ((0, 1, 4, 3), (1, 2, 5, 4), (0, 2, 5, 3), (0, 1, 2), (3, 4, 5)),
    "pyramid": ((0, 1, 4), (1, 2, 4), (2, 3, 4), (0, 3, 4), (0, 1, 2, 3)),
}


@dataclass(frozen=True, eq=False)
class _Variables:
    """Arrays by name, and the element type that an array of connections is of."""

    arrays: Mapping[str, NDArray]
    element_types: Mapping[str, str]


@checked_arguments
def read_exodus(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of an Exodus file: its cells of the highest dimension, element blocks, node sets and side sets.

    Blocks are cell and node sets, node and side sets node sets; one without a name is 'block 7', 'nodes 7',
    'sides 7' by its number. Surfaces and inner nodes as in `read_gmsh`; of side sets of shells the whole
    element counts.

    Parameters
    ----------
    path : str or Path
    only : str or None            a block: read its cells and nodes alone; None reads everything
    unused_nodes : UnusedNodes    REFUSE or DROP nodes that no cell uses
    Returns
    -------
    Mesh   nodes in the order of the file
    Raises
    ------
    ImportFormatError   missing, cut or unreadable file, unknown element type, elements naming missing nodes
    MeshError           what the file describes is no usable mesh
    """
    path = Path(path)
    content = file_content(path)
    try:
        read = _of_hdf5(path) if content.startswith(_HDF5_MARK) else _of_classic(content)
        points, ids = _points(read)
        blocks, names = _blocks(read, len(points))
        node_sets = dict(_node_sets(read, len(points)))
        node_sets |= dict(_side_sets(read, blocks))
    except ImportFormatError as error:
        raise ImportFormatError(f"{path}: {error}") from error
    except (
        OSError,
        ArithmeticError,
        ValueError,
        KeyError,
        IndexError,
        TypeError,
        AttributeError,
        EOFError,
        MemoryError,
    ) as error:
        raise ImportFormatError(
            f"{path}: not readable as Exodus ({type(error).__name__}: {str(error)[:120]}); save it anew"
        ) from error
    numbered = tuple(
        cell_elements(each.type_name, each.dimension, each.ids, ids[each.nodes], each.groups)
        for each in blocks
    )
    file = without_inner_nodes(ids, points, numbered)
    listed = {name: ids[nodes] for name, nodes in node_sets.items()}
    return cell_file_mesh(path, file, names, only=only, unused_nodes=unused_nodes, node_sets=listed)


def _of_classic(content: bytes) -> _Variables:
    with netcdf_file(io.BytesIO(content), "r", mmap=False) as file:
        arrays = {name: np.array(each.data) for name, each in file.variables.items()}
        types = {name: _text(getattr(each, "elem_type", "")) for name, each in file.variables.items()}
    return _Variables(arrays, types)


def _of_hdf5(path: Path) -> _Variables:
    with open_copied(path) as file:
        found = {name: each for name, each in file.items() if isinstance(each, h5py.Dataset)}
        arrays = {name: each[()] for name, each in found.items()}
        types = {name: _text(each.attrs.get("elem_type", "")) for name, each in found.items()}
    return _Variables(arrays, types)


def _text(value: object) -> str:
    return value.decode("latin-1").rstrip("\0 ") if isinstance(value, bytes) else str(value).rstrip("\0 ")


def _points(read: _Variables) -> tuple[NDArray[np.float64], IntArray]:
    """Places (N, 3) and ids (N,) of the nodes."""
    arrays = read.arrays
    if "coord" in arrays:
        rows = list(arrays["coord"])
    else:
        rows = [arrays[name] for name in ("coordx", "coordy", "coordz") if name in arrays]
    if not rows:
        raise ImportFormatError("no coordinates of nodes; is this an Exodus mesh?")
    points = np.zeros((len(rows[0]), 3))
    for i, row in enumerate(rows[:3]):
        points[:, i] = row
    return points, _map(arrays, "node_num_map", len(points))


def _map(arrays: Mapping[str, NDArray], name: str, n: int) -> IntArray:
    """The ids that a map gives, where it gives each once; else 1 .. n."""
    given = np.asarray(arrays.get(name, ()), dtype=np.int64)
    return given if len(given) == n == len(np.unique(given)) else np.arange(1, n + 1)


def _blocks(read: _Variables, n: int) -> tuple[list[CellElements], dict[tuple[int, int], str]]:
    """Elements in blocks, with node numbers in place of ids, and the names of their groups."""
    numbers = np.asarray(read.arrays.get("eb_prop1", ()), dtype=np.int64)
    connections = [
        array for name, array in read.arrays.items() if name.startswith("connect") and array.ndim == 2
    ]
    total = sum(map(len, connections))
    element_ids = _map(read.arrays, "elem_num_map", total)
    found: list[CellElements] = []
    names: dict[tuple[int, int], str] = {}
    first = 0
    for k in range(1, 1 + max(len(numbers), len(connections))):
        name = f"connect{k}"
        if name not in read.arrays:  # a block without elements
            continue
        nodes = np.asarray(read.arrays[name], dtype=np.int64) - 1
        kind = read.element_types[name].upper()
        made_of = _TYPES.get((kind[:3], nodes.shape[1]))
        if made_of is None:
            raise ImportFormatError(
                f"block {k} is of the unknown type '{kind}' with {nodes.shape[1]} nodes; supported are "
                "TETRA, PYRAMID, WEDGE, HEX, TRI, QUAD, SHELL"
            )
        outside = np.flatnonzero(((nodes < 0) | (nodes >= n)).any(axis=1))
        if outside.size:
            raise ImportFormatError(f"element {outside[0] + 1} of block {k} names a node that is not there")
        type_name, dimension = made_of
        if type_name in _VERTICAL_FIRST:
            nodes = nodes[:, _VERTICAL_FIRST[type_name]]
        groups = {k: np.ones(len(nodes), dtype=bool)}
        of_block = element_ids[first : first + len(nodes)]
        found.append(CellElements(type_name, dimension, of_block, nodes, groups, nodes[:, :0]))
        names[dimension, k] = _name(read, "eb_names", k, "block", numbers)
        first += len(nodes)
    if len(set(names.values())) < len(names):
        names = {(d, k): f"{name} ({k})" for (d, k), name in names.items()}
    return found, names


def _name(read: _Variables, table: str, k: int, word: str, numbers: IntArray) -> str:
    """The name of the k-th of its kind, from 1; its word and number where it has none."""
    rows = read.arrays.get(table)
    given = b""
    if rows is not None and k <= len(rows):
        given = b"".join(np.asarray(rows[k - 1]).astype("S1").ravel().tolist())
    number = int(numbers[k - 1]) if k <= len(numbers) else k
    return _text(given.partition(b"\0")[0]).strip() or f"{word} {number}"


def _node_sets(read: _Variables, n: int) -> Iterator[tuple[str, IntArray]]:
    numbers = np.asarray(read.arrays.get("ns_prop1", ()), dtype=np.int64)
    for k in range(1, len(numbers) + 1):
        if f"node_ns{k}" in read.arrays:
            nodes = np.asarray(read.arrays[f"node_ns{k}"], dtype=np.int64) - 1
            if ((nodes < 0) | (nodes >= n)).any():
                raise ImportFormatError(f"node set {numbers[k - 1]} names a node that is not there")
            yield _name(read, "ns_names", k, "nodes", numbers), nodes


def _side_sets(read: _Variables, blocks: list[CellElements]) -> Iterator[tuple[str, IntArray]]:
    numbers = np.asarray(read.arrays.get("ss_prop1", ()), dtype=np.int64)
    for k in range(1, len(numbers) + 1):
        if f"elem_ss{k}" not in read.arrays or f"side_ss{k}" not in read.arrays:
            continue
        elements, sides = (
            np.asarray(read.arrays[f"{part}_ss{k}"], dtype=np.int64) - 1 for part in ("elem", "side")
        )
        nodes = [np.empty(0, dtype=np.int64)]
        first = 0
        for block in blocks:
            mine = (elements >= first) & (elements < first + len(block.nodes))
            for side in np.unique(sides[mine]).tolist():
                rows = block.nodes[elements[mine & (sides == side)] - first]
                nodes.append(rows[:, _side(block.type_name, side)].ravel())
            first += len(block.nodes)
        yield _name(read, "ss_names", k, "sides", numbers), np.unique(np.concatenate(nodes))


def _side(type_name: str, side: int) -> list[int]:
    """Places of the nodes of a side, with mid-edge nodes; of surfaces all."""
    sides = _SIDES.get(type_name.rstrip("0123456789"))
    kind = next(
        (kind for kind in CellType if kind.meshio_name == WITHOUT_INNER.get(type_name, (type_name, 0))[0]),
        None,
    )
    if sides is None:
        return list(range(3 if "tri" in type_name else 4))
    if kind is None or not 0 <= side < len(sides):
        raise ImportFormatError(f"a side set names side {side + 1} of a {type_name}; save the mesh anew")
    corners = sides[side]
    if kind.n_nodes == kind.n_corners:
        return list(corners)
    middle = [kind.n_corners + i for i, edge in enumerate(kind.edges) if set(edge) <= set(corners)]
    return [*corners, *middle]
