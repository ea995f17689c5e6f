"""Exodus meshes, classic and HDF5: cells in their order, blocks, node sets, side sets; errors."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from scipy.io import netcdf_file

from supple.errors import ImportFormatError
from supple.importers import read_mesh
from supple.importers.exodus import read_exodus
from supple.mesh import CellType, block
from supple.mesh.reference_cell import reference_nodes

MESH = block(2.0, 1.0, 1.0, 2, 1, 1, CellType.HEXA8)
# Places of our nodes in the order of Exodus: middles of vertical edges before those of the top.
ORDER = {
    CellType.HEXA20: [*range(12), *range(16, 20), *range(12, 16)],
    CellType.WEDGE15: [*range(9), *range(12, 15), *range(9, 12)],
}


def variables(nodes, blocks, **more):
    """Arrays with their dimensions' names, and the element type of connections."""
    made = {"coord": (np.asarray(nodes, float).T, ""), "eb_prop1": (np.arange(len(blocks)) + 10, "")}
    for k, (kind, cells) in enumerate(blocks, 1):
        made[f"connect{k}"] = (np.asarray(cells) + 1, kind)
    return made | {name: (np.asarray(array), "") for name, array in more.items()}


def classic(path, arrays):
    with netcdf_file(path, "w") as file:
        for name, (array, kind) in arrays.items():
            dimensions = [f"{name}_{i}" for i in range(array.ndim)]
            for dimension, n in zip(dimensions, array.shape, strict=True):
                file.createDimension(dimension, n)
            code = "c" if array.dtype.kind == "S" else "d" if array.dtype.kind == "f" else "i"
            made = file.createVariable(name, code, dimensions)
            made[:] = array
            if kind:
                made.elem_type = kind


def hdf5(path, arrays):
    with h5py.File(path, "w") as file:
        for name, (array, kind) in arrays.items():
            made = file.create_dataset(name, data=array)
            if kind:
                made.attrs["elem_type"] = np.bytes_(kind)


SETS = {
    "ns_prop1": [4],
    "node_ns1": np.flatnonzero(MESH.nodes[:, 0] == 0) + 1,
    "ss_prop1": [5],
    "elem_ss1": [2, 1],
    "side_ss1": [6, 6],
    "ss_names": np.array([list("top") + [""] * 3], dtype="S1"),
    "node_num_map": np.arange(12) * 10 + 5,
}


@pytest.mark.parametrize("write", [classic, hdf5])
def test_blocks_and_sets(write, tmp_path):
    cells = MESH.cells[CellType.HEXA8]
    write(tmp_path / "m.exo", variables(MESH.nodes, [("HEX8", cells[:1]), ("HEX", cells[1:])], **SETS))
    mesh = read_mesh(tmp_path / "m.exo")
    np.testing.assert_array_equal(mesh.nodes, MESH.nodes)
    np.testing.assert_array_equal(mesh.cells[CellType.HEXA8], cells)
    np.testing.assert_array_equal(mesh.node_ids, SETS["node_num_map"])
    assert set(mesh.cell_sets) == {"block 10", "block 11"}
    assert (mesh.nodes[mesh.nodes_of("nodes 4")][:, 0] == 0).all()
    np.testing.assert_array_equal(mesh.nodes_of("top"), np.unique(cells[:, 4:]))
    assert read_mesh(tmp_path / "m.exo", only="block 11").n_cells == 1


@pytest.mark.parametrize(
    ("kind", "name", "side", "normal"),
    [
        (CellType.TETRA4, "TETRA", 1, (0, -1, 0)), (CellType.TETRA10, "TETRA10", 4, (0, 0, -1)),
        (CellType.PYRAMID5, "PYRAMID5", 5, (0, 0, -1)), (CellType.PYRAMID13, "PYRAMID13", 5, (0, 0, -1)),
        (CellType.WEDGE6, "WEDGE", 4, (0, 0, -1)), (CellType.WEDGE15, "WEDGE15", 5, (0, 0, 1)),
        (CellType.HEXA8, "HEX8", 2, (1, 0, 0)), (CellType.HEXA20, "HEX20", 4, (-1, 0, 0)),
    ],
)  # fmt: skip
def test_cells_and_their_sides(kind, name, side, normal, tmp_path):
    nodes = reference_nodes(kind)
    cells = [ORDER.get(kind, np.arange(kind.n_nodes))]
    sides = {"ss_prop1": [1], "elem_ss1": [1], "side_ss1": [side]}
    classic(tmp_path / "m.exo", variables(nodes, [(name, cells)], **sides))
    mesh = read_exodus(tmp_path / "m.exo")
    np.testing.assert_array_equal(mesh.cells[kind], [np.arange(kind.n_nodes)])
    far = nodes @ normal
    np.testing.assert_array_equal(mesh.nodes_of("sides 1"), np.flatnonzero(np.isclose(far, far.max())))


def test_surfaces_and_inner_nodes(tmp_path):
    square = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0.0]])
    classic(tmp_path / "s.exo", variables(square, [("SHELL4", [[0, 1, 2, 3]])]))
    assert len(read_exodus(tmp_path / "s.exo").cells[CellType.TRIANGLE3]) == 2
    nodes = np.vstack([reference_nodes(CellType.HEXA20), np.zeros((7, 3))])
    cells = [[*ORDER[CellType.HEXA20], *range(20, 27)]]
    classic(tmp_path / "h.exo", variables(nodes, [("HEX27", cells)]))
    assert read_exodus(tmp_path / "h.exo").n_nodes == 20


@pytest.mark.parametrize("write", [classic, hdf5])
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"connect1": ([[1, 2, 3, 99]], "TETRA")}, r"m\.exo: element 1 of block 1 names a node that is"),
        ({"connect1": ([[1, 2, 3, 4]], "NSIDED")}, r"m\.exo: block 1 is of the unknown type 'NSIDED'"),
        ({"node_ns1": ([9], ""), "ns_prop1": ([3], "")}, "node set 3 names a node that is not there"),
        (
            {"elem_ss1": ([1], ""), "side_ss1": ([7], ""), "ss_prop1": ([3], "")},
            "a side set names side 7 of a tetra",
        ),
    ],
)
def test_errors(write, change, message, tmp_path):
    arrays = variables(reference_nodes(CellType.TETRA4), [("TETRA", [[0, 1, 2, 3]])])
    arrays |= {name: (np.array(array), kind) for name, (array, kind) in change.items()}
    write(tmp_path / "m.exo", arrays)
    with pytest.raises(ImportFormatError, match=message):
        read_exodus(tmp_path / "m.exo")


@pytest.mark.parametrize(
    "content", [b"CDF\x01", b"CDF\x01" + 60 * b"\0", b"nothing", b"\x89HDF\r\n\x1a\n", b""]
)
def test_files_that_are_not_exodus(content, tmp_path):
    (tmp_path / "m.exo").write_bytes(content)
    with pytest.raises(ImportFormatError, match=r"m\.exo: (not readable as Exodus|no coordinates)"):
        read_exodus(tmp_path / "m.exo")
