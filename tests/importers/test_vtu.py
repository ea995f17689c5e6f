"""VTK unstructured grids: every encoding has the same mesh; sets by arrays; errors name the file."""

from __future__ import annotations

import base64

import meshio
import numpy as np
import pytest

from supple.errors import ImportFormatError
from supple.importers import read_mesh
from supple.importers.vtu import read_vtu
from supple.mesh import CellType, block
from supple.mesh.reference_cell import reference_nodes


def written(path, kind, **options):
    mesh = block(2.0, 1.0, 1.0, 4, 1, 1, kind)
    cells = mesh.cells[kind]
    data = {"part": [np.arange(len(cells)) * 2 // len(cells) + 7], "ids": [np.arange(len(cells))]}
    flags = {"root": (mesh.nodes[:, 0] == 0).astype(np.int32), "x": mesh.nodes[:, 0]}
    meshio.vtu.write(
        path, meshio.Mesh(mesh.nodes, {kind.meshio_name: cells}, flags, cell_data=data), **options
    )
    return mesh


@pytest.mark.parametrize("kind", [CellType.TETRA4, CellType.TETRA10, CellType.HEXA8, CellType.HEXA20])
@pytest.mark.parametrize(
    "options",
    [{"binary": False}, {"compression": None}, {"compression": "zlib"}, {"compression": "lzma"}],
    ids=str,
)
def test_solids_by_another_program(kind, options, tmp_path):
    mesh = written(tmp_path / "block.vtu", kind, **options)
    again = read_vtu(tmp_path / "block.vtu")
    np.testing.assert_allclose(again.nodes, mesh.nodes, rtol=1e-10, atol=1e-12)
    np.testing.assert_array_equal(again.cells[kind], mesh.cells[kind])
    assert set(again.cell_sets) == {"part 7", "part 8"}
    np.testing.assert_array_equal(again.nodes_of("root"), np.flatnonzero(mesh.nodes[:, 0] == 0))
    half = read_mesh(tmp_path / "block.vtu", only="part 8")
    assert half.nodes[:, 0].min() == 1


GRID = """\
<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid><Piece NumberOfPoints="{n}" NumberOfCells="1">
<Points>
<DataArray type="Float64" NumberOfComponents="3" format="{form}" offset="0">{points}</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">{cell}</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">{n}</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">{kind}</DataArray></Cells>
</Piece></UnstructuredGrid>{tail}</VTKFile>
"""


def grid(folder, nodes, kind, form="ascii", tail=""):
    path = folder / "one.vtu"
    places = "" if form == "appended" else " ".join(map(str, np.ravel(nodes).tolist()))
    cell = " ".join(map(str, range(len(nodes))))
    path.write_text(GRID.format(n=len(nodes), points=places, cell=cell, kind=kind, form=form, tail=tail))
    return path


@pytest.mark.parametrize(("kind", "number"), [(CellType.WEDGE6, 13), (CellType.WEDGE15, 26)])
@pytest.mark.parametrize("turned", [False, True])
def test_wedges_of_either_orientation(kind, number, turned, tmp_path):
    nodes = reference_nodes(kind)
    if turned:
        nodes = nodes[[0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13][: kind.n_nodes]]
    mesh = read_vtu(grid(tmp_path, nodes, number))
    np.testing.assert_array_equal(mesh.nodes[mesh.cells[kind][0]], reference_nodes(kind))


def test_inner_nodes_are_left_out_and_surfaces_split(tmp_path):
    nodes = np.vstack([reference_nodes(CellType.HEXA20), np.zeros((7, 3))])
    assert read_vtu(grid(tmp_path, nodes, 29)).n_nodes == 20
    square = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0.0]])
    assert len(read_vtu(grid(tmp_path, square, 9)).cells[CellType.TRIANGLE3]) == 2


@pytest.mark.parametrize("encoding", ["raw", "base64"])
def test_appended_points(encoding, tmp_path):
    nodes = reference_nodes(CellType.TETRA4)
    data = np.uint64(nodes.nbytes).tobytes() + np.ascontiguousarray(nodes).tobytes()
    path = grid(tmp_path, nodes, 10, "appended", f'<AppendedData encoding="{encoding}">_@</AppendedData>')
    packed = data if encoding == "raw" else base64.b64encode(data)
    path.write_bytes(path.read_bytes().replace(b"@", packed))
    np.testing.assert_array_equal(read_vtu(path).nodes, nodes)
    path.write_bytes(path.read_bytes().replace(packed, packed[:-24]))
    with pytest.raises(ImportFormatError, match="bytes are announced"):
        read_vtu(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("</UnstructuredGrid>", "", r"one\.vtu: not readable as a VTK unstructured grid \(mismatched tag"),
        ('type="UnstructuredGrid"', 'type="PolyData"', "a file of type PolyData"),
        ("0 1 2 3<", "0 1 2 9<", "a cell names a point that is not there; there are 4"),
        (">10<", ">42<", "cells of VTK's type 42 are not read; remove them"),
        (">4<", ">3<", "a cell of 4 points has other ones"),
        (
            '"1.0" byte',
            '"1.0" compressor="vtkLZ4DataCompressor" byte',
            "compressed by vtkLZ4DataCompressor; save",
        ),
        ("<?xml", "<!DOCTYPE a><?xml", "it declares a document type"),
        (">0.0 ", ">zero ", "could not convert"),
        ("Float64", "Float80", "Float80"),
        (">4<", ">99999999999<", "out of bounds"),
    ],
)
def test_errors(old, new, message, tmp_path):
    path = grid(tmp_path, reference_nodes(CellType.TETRA4), 10)
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ImportFormatError, match=message):
        read_vtu(path)
