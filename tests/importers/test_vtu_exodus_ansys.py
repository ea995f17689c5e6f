"""VTU, Exodus and Ansys meshes: volumes, sets and ids of small files; messages of broken ones."""

from __future__ import annotations

import base64
import builtins
import re

import h5py
import meshio
import numpy as np
import pytest
from scipy.io import netcdf_file

from supple.body import mesh_mass_properties
from supple.errors import ImportFormatError
from supple.fem import Isotropic, solid_model
from supple.importers import UnusedNodes, read_mesh
from supple.mesh import CellType, Mesh, block

CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
# Cells of each type that fill the cube, or a part of it: corners, and volume.
PARTS = {
    "hexahedron": ([0, 1, 2, 3, 4, 5, 6, 7], 1.0),
    "wedge": ([0, 1, 2, 4, 5, 6], 0.5),
    "pyramid": ([0, 1, 2, 3, 4], 1 / 3),
    "tetra": ([0, 1, 2, 4], 1 / 6),
}
QUADRATIC = {"hexahedron": "hexahedron20", "wedge": "wedge15", "pyramid": "pyramid13", "tetra": "tetra10"}
LINEAR_TYPES = {kind.meshio_name: kind for kind in CellType}


def with_middles(kind, corners):
    """Nodes of the cube, and those of a cell with the middles of its edges behind them."""
    edges = np.array(corners)[np.array(LINEAR_TYPES[kind].edges)]
    return np.concatenate([CUBE, CUBE[edges].mean(axis=1)]), [*corners, *(8 + np.arange(len(edges)))]


def volume(mesh):
    return mesh_mass_properties(solid_model(mesh, Isotropic(1.0, 0.0, 1.0))).mass


UNKNOWN_TO_MESHIO = {"wedge15": 26, "pyramid13": 27}


def meshes():
    for kind, (corners, size) in PARTS.items():
        yield kind, CUBE, corners, size
        points, cell = with_middles(kind, corners)
        yield QUADRATIC[kind], points, cell, size


def used(nodes, cell):
    """Without unused nodes."""
    kept = np.unique(cell)
    return nodes[kept], np.searchsorted(kept, cell)


@pytest.mark.parametrize("form", ["ascii", "binary", "packed"])
@pytest.mark.parametrize(
    ("kind", "points", "cell", "size"), [each for each in meshes() if each[0] not in UNKNOWN_TO_MESHIO]
)
def test_vtu_cells_of_every_type(tmp_path, form, kind, points, cell, size):
    x, nodes = used(points, cell)
    path = tmp_path / "part.vtu"
    given = meshio.Mesh(
        x, [(kind, [nodes])], point_data={"foot": (x[:, 2] == 0).astype(int)}, cell_data={"region": [[7]]}
    )
    meshio.vtu.write(path, given, binary=form != "ascii", compression="zlib" if form == "packed" else None)
    mesh = read_mesh(path)
    assert list(mesh.cells) == [LINEAR_TYPES[kind]]
    assert volume(mesh) == pytest.approx(size)
    np.testing.assert_array_equal(mesh.nodes_of("foot"), np.flatnonzero(x[:, 2] == 0))
    assert list(mesh.cell_sets) == ["region_7"]


@pytest.mark.parametrize("kind", UNKNOWN_TO_MESHIO)
def test_vtu_quadratic_wedges_and_pyramids(tmp_path, kind):
    base = kind.rstrip("0123456789")
    x, nodes = used(*with_middles(base, PARTS[base][0]))
    cells = ASCII_CELLS.replace("0 1 2 3", " ".join(map(str, nodes))).replace(">4<", f">{len(nodes)}<")
    points = POINTS.replace("0 0 0 1 0 0 0 1 0 0 0 1", " ".join(map(str, x.ravel())))
    text = vtu(points, cells.replace(">10<", f">{UNKNOWN_TO_MESHIO[kind]}<"))
    (tmp_path / "part.vtu").write_text(text)
    assert volume(read_mesh(tmp_path / "part.vtu")) == pytest.approx(PARTS[base][1])


def test_nodes_inside_a_cell_are_left_out(tmp_path):
    x, nodes = used(*with_middles("hexahedron", PARTS["hexahedron"][0]))
    inside = [x[nodes[list(face)]].mean(axis=0) for face in LINEAR_TYPES["hexahedron"].faces]
    given = np.vstack([x, *inside, x.mean(axis=0)])
    cell = [*nodes, *range(len(x), len(given))]
    meshio.vtu.write(tmp_path / "part.vtu", meshio.Mesh(given, [("hexahedron27", [cell])]))
    mesh = read_mesh(tmp_path / "part.vtu")
    assert (list(mesh.cells), mesh.n_nodes) == ([CellType.HEXA20], 20)


def test_vtu_wedges_as_vtk_turns_them(tmp_path):
    """Its first triangle looks outwards: the axis from it to the other is against its normal."""
    x, nodes = used(CUBE, PARTS["wedge"][0])
    meshio.vtu.write(tmp_path / "part.vtu", meshio.Mesh(x, [("wedge", [nodes[[3, 4, 5, 0, 1, 2]]])]))
    assert volume(read_mesh(tmp_path / "part.vtu")) == pytest.approx(0.5)


def test_vtu_ids_of_pieces_with_vertices(tmp_path):
    """A vertex has an id, though it is no cell."""
    cells = ASCII_CELLS.replace("0 1 2 3", "0 1 0 1 2 3").replace(">4<", ">1 2 6<")
    piece = f"<Piece><Points>{POINTS}</Points><Cells>{cells.replace('>10<', '>1 1 10<')}</Cells><CellData>"
    piece += '<DataArray type="Int32" Name="part" format="ascii">0 0 {}</DataArray></CellData></Piece>'
    text = vtu(POINTS, ASCII_CELLS)
    both = piece.format(1) + piece.format(2)
    (tmp_path / "part.vtu").write_text(re.sub("<Piece.*</Piece>", both, text, flags=re.DOTALL))
    assert read_mesh(tmp_path / "part.vtu", only="part_2").cell_ids[CellType.TETRA4].tolist() == [6]


def test_vtu_pieces_share_the_points_of_their_border_and_omit_ghost_cells(tmp_path):
    """Two tetrahedra on opposite sides of the triangle x = 0; the second piece repeats the first."""
    other = POINTS.replace("0 0 0 1 0 0 0 1 0 0 0 1", "0 0 0 0 1 0 0 0 1 -1 0 0 1 0 0")
    cells = (
        ASCII_CELLS.replace("0 1 2 3", "0 2 1 3 0 4 1 2").replace(">4<", ">4 8<").replace(">10<", ">10 10<")
    )
    ghost = '<CellData><DataArray type="UInt8" Name="vtkGhostType" format="ascii">0 1</DataArray></CellData>'
    text = vtu(POINTS, ASCII_CELLS)
    second = f"</Piece><Piece><Points>{other}</Points><Cells>{cells}</Cells>{ghost}</Piece>"
    (tmp_path / "part.vtu").write_text(text.replace("</Piece>", second))
    mesh = read_mesh(tmp_path / "part.vtu")
    np.testing.assert_array_equal(mesh.cells[CellType.TETRA4], [[0, 1, 2, 3], [0, 3, 2, 4]])
    assert mesh.n_nodes == 5
    assert volume(mesh) == pytest.approx(1 / 3)


def vtu(points, cells, appended=""):
    return f"""<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1">
<Points>{points}</Points>
<Cells>{cells}</Cells>
</Piece></UnstructuredGrid>{appended}</VTKFile>"""


ASCII_CELLS = """<DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray>"""
APPENDED = '<DataArray type="Float64" NumberOfComponents="3" format="appended" offset="{}"/>'


@pytest.mark.parametrize("encoding", ["raw", "base64"])
def test_vtu_appended_data(tmp_path, encoding):
    x = CUBE[[0, 1, 3, 4]]
    data = np.uint64(x.nbytes).tobytes() + x.tobytes()
    coded = data if encoding == "raw" else base64.b64encode(data)
    path = tmp_path / "part.vtu"
    whole = vtu(APPENDED.format(0), ASCII_CELLS, f'<AppendedData encoding="{encoding}">_DATA</AppendedData>')
    before, after = whole.encode().split(b"DATA<")
    path.write_bytes(before + coded + b"<" + after)
    np.testing.assert_array_equal(read_mesh(path).nodes, x)
    path.write_bytes(before + coded[:40] + b"<" + after)
    with pytest.raises(ImportFormatError, match="not readable as VTU: the points are broken"):
        read_mesh(path)


POINTS = '<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray>'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (vtu(POINTS, ASCII_CELLS)[:200], "no well-formed XML"),
        (vtu(POINTS, ASCII_CELLS).replace("UnstructuredGrid", "PolyData"), "a PolyData file; write an Unstr"),
        (vtu(POINTS, ASCII_CELLS).replace(" byte", ' compressor="vtkLZ4" byte'), "compressed by vtkL"),
        (vtu(POINTS, ASCII_CELLS.replace(">10<", ">42<")), "cells of type 'VTK 42' are not read; write"),
        (vtu(POINTS, ASCII_CELLS.replace("0 1 2 3", "0 1 2 9")), "tetra cells name node 9"),
        (vtu(POINTS, ASCII_CELLS.replace(">4<", ">5<")), "1 cell types, 1 offsets, 4 nodes of cells"),
        (vtu(POINTS.replace("1 0 0", "1 x 0"), ASCII_CELLS), "the points are broken"),
        (vtu(POINTS.replace("1 0 0", "1 0", 1), ASCII_CELLS), "11 coordinates of points"),
        (vtu("", ASCII_CELLS), "the points are missing"),
        (vtu(POINTS, ASCII_CELLS).replace("<VTK", "<!DOCTYPE x><VTK", 1), "declares entities"),
    ],
)  # fmt: skip
def test_broken_vtu(tmp_path, text, message):
    (tmp_path / "part.vtu").write_text(text)
    with pytest.raises(ImportFormatError, match=message):
        read_mesh(tmp_path / "part.vtu")


EXODUS_ORDERS = {
    "hexahedron20": [*range(12), *range(16, 20), *range(12, 16)],
    "wedge15": [*range(9), *range(12, 15), *range(9, 12)],
}
EXODUS_NAMES = {
    "hexahedron": "HEX", "wedge": "WEDGE", "pyramid": "PYRAMID", "tetra": "TETRA", "quad": "SHELL4",
}  # fmt: skip


def exodus_variables(points, blocks, names=(), node_sets=(), sides=()):
    """Arrays of an Exodus file, with element types; ids in the maps are ours plus 100."""
    found = {"coordx": points[:, 0], "coordy": points[:, 1], "coordz": points[:, 2]}
    n = 0
    for i, (kind, cells) in enumerate(blocks, start=1):
        base = re.sub(r"\d+", "", kind)
        order = EXODUS_ORDERS.get(kind)
        own = np.array(cells)[:, order] if order else np.array(cells)
        found[f"connect{i}"] = ((own + 1).astype(np.int32), EXODUS_NAMES[base])
        n += len(own)
    found["eb_prop1"] = np.array([10 * i for i in range(1, len(blocks) + 1)], np.int32)
    if names:
        found["eb_names"] = np.array([list(name.ljust(8, "\0")) for name in names], "S1")
    for i, members in enumerate(node_sets, start=1):
        found[f"node_ns{i}"] = (np.array(members) + 1).astype(np.int32)
    for i, (elements, which) in enumerate(sides, start=1):
        found[f"elem_ss{i}"], found[f"side_ss{i}"] = (np.array(v, np.int32) for v in (elements, which))
    found["node_num_map"] = (100 + np.arange(len(points))).astype(np.int32)
    found["elem_num_map"] = (100 + np.arange(n)).astype(np.int32)
    return found


def write_exodus(path, variables, form):
    if form == "hdf5":
        with h5py.File(path, "w") as file:
            for name, value in variables.items():
                array, kind = value if isinstance(value, tuple) else (value, "")
                file[name] = array
                if kind:
                    file[name].attrs["elem_type"] = np.bytes_(kind)
        return
    with netcdf_file(str(path), "w") as file:
        for name, value in variables.items():
            array, kind = value if isinstance(value, tuple) else (value, "")
            for axis, size in enumerate(array.shape):
                file.createDimension(f"{name}_{axis}", size)
            made = file.createVariable(
                name,
                "c" if array.dtype.kind == "S" else array.dtype,
                tuple(f"{name}_{a}" for a in range(array.ndim)),
            )
            made[:] = array
            if kind:
                made.elem_type = kind


@pytest.mark.parametrize("form", ["classic", pytest.param("hdf5", marks=pytest.mark.slow)])
@pytest.mark.parametrize(("kind", "points", "cell", "size"), [*meshes()])
def test_exodus_cells_of_every_type(tmp_path, form, kind, points, cell, size):
    x, nodes = used(points, cell)
    path = tmp_path / "part.exo"
    write_exodus(path, exodus_variables(x, [(kind, [nodes])], ["body"], [[0, 1]]), form)
    mesh = read_mesh(path)
    assert volume(mesh) == pytest.approx(size)
    np.testing.assert_array_equal(mesh.nodes_of("nodeset_1"), [0, 1])
    np.testing.assert_array_equal(mesh.nodes_of("body"), np.arange(len(x)))
    np.testing.assert_array_equal(mesh.node_ids, 100 + np.arange(len(x)))
    assert list(mesh.cell_sets) == ["body"]


@pytest.mark.parametrize("kind", ["hexahedron", "hexahedron20", "tetra10", "wedge15", "pyramid13"])
def test_exodus_side_sets(tmp_path, kind):
    """The sides with z = 0, middle nodes as well."""
    base = kind.rstrip("0123456789")
    points, cell = with_middles(base, PARTS[base][0]) if kind != base else (CUBE, PARTS[base][0])
    x, nodes = used(points, cell)
    side = {"hexahedron": 5, "tetra": 4, "wedge": 4, "pyramid": 5}[base]
    write_exodus(
        tmp_path / "part.e", exodus_variables(x, [(kind, [nodes])], sides=[([1], [side])]), "classic"
    )
    found = read_mesh(tmp_path / "part.e")
    np.testing.assert_array_equal(found.nodes_of("sideset_1"), np.flatnonzero(x[:, 2] == 0))
    assert list(found.cell_sets) == ["block_10"]


@pytest.mark.parametrize(
    ("word", "axes", "n", "side", "nodes"),
    [
        ("QUAD4", 3, 4, 1, [0, 1]), ("QUAD4", 2, 4, 4, [0, 3]), ("TRI3", 2, 3, 2, [1, 2]),
        ("TRI3", 3, 3, 1, [0, 1, 2]), ("TRI3", 3, 3, 4, [1, 2]), ("SHELL4", 3, 4, 3, [0, 1]),
        ("SHELL3", 3, 3, 5, [0, 2]), ("SHELL6", 3, 6, 5, [0, 2, 5]),
    ],
)  # fmt: skip
def test_exodus_sides_of_surfaces(tmp_path, word, axes, n, side, nodes):
    """Edges alone of QUAD and of TRI in two dimensions; else both faces come first."""
    x = np.concatenate([CUBE[:3], (CUBE[:3] + CUBE[[1, 2, 0]]) / 2]) if n == 6 else CUBE[:n]
    made = exodus_variables(x, [("quad", [range(n)])], sides=[([1], [side])])
    made["connect1"] = (made["connect1"][0], word)
    if axes == 2:
        del made["coordz"]
    write_exodus(tmp_path / "part.e", made, "hdf5")
    np.testing.assert_array_equal(read_mesh(tmp_path / "part.e").nodes_of("sideset_1"), nodes)


def test_exodus_names_of_sets_beside_empty_ones(tmp_path):
    """Empty blocks and sets have a number, id and name, but no variable of members."""
    made = exodus_variables(CUBE[:4], [("quad", [[0, 1, 2, 3]])], ["none", "wall"], [[0, 1], [2]])
    made["connect2"], made["eb_prop1"] = made.pop("connect1"), np.array([10, 20], np.int32)
    made["node_ns3"] = made.pop("node_ns1")
    made["ns_names"] = np.array([list(name.ljust(8, "\0")) for name in ("left", "top", "foot")], "S1")
    write_exodus(tmp_path / "part.g", made, "hdf5")
    mesh = read_mesh(tmp_path / "part.g")
    assert list(mesh.cell_sets) == ["wall"]
    np.testing.assert_array_equal(mesh.nodes_of("foot"), [0, 1])
    np.testing.assert_array_equal(mesh.nodes_of("top"), [2])
    assert "left" not in mesh.node_sets


def test_exodus_shells_are_cut_and_sets_are_checked(tmp_path):
    x = CUBE[:4]
    write_exodus(tmp_path / "part.g", exodus_variables(x, [("quad", [[0, 1, 2, 3]])]), "hdf5")
    mesh = read_mesh(tmp_path / "part.g")
    assert len(mesh.cells[CellType.TRIANGLE3]) == 2
    np.testing.assert_array_equal(mesh.cell_ids[CellType.TRIANGLE3], [100, 100])
    write_exodus(
        tmp_path / "part.g", exodus_variables(x, [("quad", [[0, 1, 2, 3]])], node_sets=[[7]]), "hdf5"
    )
    with pytest.raises(ImportFormatError, match="set 'nodeset_1' names a node that the file lacks"):
        read_mesh(tmp_path / "part.g")
    broken = exodus_variables(x, [("quad", [[0, 1, 2, 3]])])
    broken["connect1"] = (broken["connect1"][0], "SUPER")
    write_exodus(tmp_path / "part.g", broken, "classic")
    with pytest.raises(
        ImportFormatError, match="block 'block_10' has SUPER elements of 4 nodes, which are not"
    ):
        read_mesh(tmp_path / "part.g")
    (tmp_path / "part.g").write_bytes((tmp_path / "part.g").read_bytes()[:150])
    with pytest.raises(ImportFormatError, match="not readable as Exodus"):
        read_mesh(tmp_path / "part.g")
    (tmp_path / "part.g").write_text("solid")
    with pytest.raises(ImportFormatError, match="neither netCDF nor HDF5"):
        read_mesh(tmp_path / "part.g")


BRICKS = {
    "hexahedron": [0, 1, 2, 3, 4, 5, 6, 7],
    "wedge": [0, 1, 2, 2, 4, 5, 6, 6],
    "pyramid": [0, 1, 2, 3, 4, 4, 4, 4],
    "tetra": [0, 1, 2, 2, 4, 4, 4, 4],
}


def cdb(points, routine, nodes, extra=""):
    """An archive as CDWRITE makes it; node ids count by tens."""
    rows = [
        f"{10 * (i + 1):9d}{0:9d}{0:9d}" + "".join(f"{v:21.13E}" for v in x) for i, x in enumerate(points)
    ]
    ids = [10 * (n + 1) for n in nodes]
    head = [3, 1, 1, 1, 0, 0, 0, 0, len(ids), 0, 77, *ids[:8]]
    elements = ["".join(f"{v:9d}" for v in head)]
    if ids[8:]:
        elements.append("".join(f"{v:9d}" for v in ids[8:]))
    return "\n".join(
        [
            "/PREP7", f"ET,1,{routine}",
            f"NBLOCK,6,SOLID,{10 * len(points)},{len(points)}", "(3i9,6e21.13e3)",
            *rows, "N,R5.3,LOC,       -1,", "EBLOCK,19,SOLID,77,1", "(19i9)", *elements, "       -1", extra,
            "FINISH", "",
        ]
    )  # fmt: skip


def brick_with_middles(kind):
    corners = BRICKS[kind]
    edges = np.array(corners)[np.array(CellType.HEXA8.edges)]
    middles, nodes = [], list(corners)
    for a, b in edges:
        if a == b:
            nodes.append(a)
        else:
            pair = tuple(sorted((a, b)))
            if pair not in middles:
                middles.append(pair)
            nodes.append(8 + middles.index(pair))
    return np.concatenate([CUBE, np.array([CUBE[list(pair)].mean(axis=0) for pair in middles])]), nodes


@pytest.mark.parametrize("quadratic", [False, True])
@pytest.mark.parametrize("kind", list(BRICKS))
def test_ansys_bricks_and_their_degenerate_forms(tmp_path, kind, quadratic):
    pytest.importorskip("mapdl_archive")
    points, nodes = brick_with_middles(kind) if quadratic else (CUBE, BRICKS[kind])
    extra = "CMBLOCK,FOOT,NODE,2\n(8i10)\n        10        20\nCMBLOCK,ALL,ELEM,1\n(8i10)\n        77"
    (tmp_path / "part.cdb").write_text(cdb(points, 186 if quadratic else 185, nodes, extra))
    mesh = read_mesh(tmp_path / "part.cdb", unused_nodes=UnusedNodes.DROP)
    assert list(mesh.cells) == [LINEAR_TYPES[QUADRATIC[kind] if quadratic else kind]]
    assert volume(mesh) == pytest.approx(PARTS[kind][1])
    assert set(mesh.cell_sets) == {"material_3", "ALL"}
    np.testing.assert_array_equal(mesh.node_ids[mesh.nodes_of("FOOT")], [10, 20])
    assert mesh.cell_ids[next(iter(mesh.cells))].tolist() == [77]


def test_ansys_shells_and_what_is_not_read(tmp_path):
    pytest.importorskip("mapdl_archive")
    (tmp_path / "part.cdb").write_text(cdb(CUBE[:4], 181, [0, 1, 2, 3]))
    assert len(read_mesh(tmp_path / "part.cdb").cells[CellType.TRIANGLE3]) == 2
    (tmp_path / "part.cdb").write_text(cdb(CUBE[:4], 55, [0, 1, 2, 3]))
    with pytest.raises(ImportFormatError, match="element 77 is of type 55, which is not read"):
        read_mesh(tmp_path / "part.cdb")
    (tmp_path / "part.cdb").write_text("/PREP7\n")
    with pytest.raises(ImportFormatError, match="no NBLOCK; write it by CDWRITE"):
        read_mesh(tmp_path / "part.cdb")


def test_ansys_without_its_library(tmp_path, monkeypatch):
    (tmp_path / "part.cdb").write_text(cdb(CUBE[:4], 181, [0, 1, 2, 3]))
    real = builtins.__import__

    def missing(name, *rest):
        if name == "mapdl_archive":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(ImportFormatError, match=r"pip install 'supple\[ansys\]'"):
        read_mesh(tmp_path / "part.cdb")


def test_one_mesh_in_two_formats(tmp_path):
    mesh = block(1.0, 0.5, 0.2, 2, 1, 1, CellType.HEXA20)
    cells = mesh.cells[CellType.HEXA20]
    meshio.vtu.write(tmp_path / "part.vtu", meshio.Mesh(mesh.nodes, [("hexahedron20", cells)]))
    write_exodus(tmp_path / "part.exo", exodus_variables(mesh.nodes, [("hexahedron20", cells)]), "hdf5")
    for name in ("part.vtu", "part.exo"):
        found = read_mesh(tmp_path / name)
        assert isinstance(found, Mesh)
        np.testing.assert_array_equal(found.cells[CellType.HEXA20], cells)
        np.testing.assert_array_equal(found.nodes, mesh.nodes)
