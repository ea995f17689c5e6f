"""Meshes keep what their files call nodes and elements, and all that names one says that."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from supple.body import AveragingInterface, RigidInterface, flexible_body
from supple.body.model_check import check_elements
from supple.cases import read_case
from supple.errors import MeshError, ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.importers import UnusedNodes, read_mesh
from supple.mesh import CellType, Mesh, strip

NODES = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]])
IDS = np.array([30, 10, 7, 100, 55])
TRIANGLES = [(41, (30, 10, 7)), (12, (30, 7, 100)), (99, (10, 55, 7))]


def abaqus():
    rows = [f"{i}, {x}, {y}, {z}" for i, (x, y, z) in zip(IDS, NODES, strict=True)]
    cells = [f"{e}, {', '.join(map(str, nodes))}" for e, nodes in TRIANGLES]
    return "\n".join(
        ["*NODE", *rows, "*ELEMENT, TYPE=S3, ELSET=all", *cells, "*NSET, NSET=end", "100, 30", ""]
    )


def nastran():
    rows = [f"GRID,{i},,{x},{y},{z}" for i, (x, y, z) in zip(IDS, NODES.astype(float), strict=True)]
    cells = [f"CTRIA3,{e},1,{','.join(map(str, nodes))}" for e, nodes in TRIANGLES]
    made_of = ["PSHELL,1,1,0.01,1,,1", "MAT1,1,2.1+11,,0.3,7850."]
    return "\n".join(["BEGIN BULK", *rows, *cells, *made_of, "ENDDATA", ""])


def gmsh_2():
    rows = [f"{i} {x} {y} {z}" for i, (x, y, z) in zip(IDS, NODES, strict=True)]
    cells = [f"{e} 2 2 1 1 {' '.join(map(str, nodes))}" for e, nodes in TRIANGLES]
    nodes = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(rows)), *rows, "$EndNodes"]
    return "\n".join([*nodes, "$Elements", str(len(cells)), *cells, "$EndElements", ""])


def gmsh_4():
    count = len(IDS)
    return "\n".join(
        ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$Nodes", f"1 {count} 7 100", f"2 1 0 {count}"]
        + [str(i) for i in IDS]
        + [f"{x} {y} {z}" for x, y, z in NODES]
        + ["$EndNodes", "$Elements", f"1 {len(TRIANGLES)} 12 99", f"2 1 2 {len(TRIANGLES)}"]
        + [f"{e} {' '.join(map(str, nodes))}" for e, nodes in TRIANGLES]
        + ["$EndElements", ""]
    )


def gmsh_40():
    rows = [f"{i} {x} {y} {z}" for i, (x, y, z) in zip(IDS, NODES, strict=True)]
    cells = [f"{e} {' '.join(map(str, nodes))}" for e, nodes in TRIANGLES]
    nodes = ["$MeshFormat", "4.0 0 8", "$EndMeshFormat", "$Nodes", "1 5", "1 2 0 5", *rows, "$EndNodes"]
    return "\n".join([*nodes, "$Elements", "1 3", "1 2 2 3", *cells, "$EndElements", ""])


FILES = {"old.msh": gmsh_40, "mesh.inp": abaqus, "mesh.bdf": nastran, "two.msh": gmsh_2, "four.msh": gmsh_4}


@pytest.mark.parametrize("name", FILES)
def test_a_mesh_keeps_the_ids_of_its_file(tmp_path, name):
    path = tmp_path / name
    path.write_text(FILES[name](), encoding="utf-8")
    mesh = read_mesh(path)
    by_id = dict(zip(mesh.node_ids.tolist(), mesh.nodes.tolist(), strict=True))
    assert by_id == dict(zip(IDS.tolist(), NODES.tolist(), strict=True))
    cells = zip(mesh.cell_ids[CellType.TRIANGLE3], mesh.cells[CellType.TRIANGLE3], strict=True)
    assert [(int(e), tuple(mesh.node_ids[nodes].tolist())) for e, nodes in cells] == TRIANGLES
    assert mesh.node_ids[mesh.numbers_of([55, 7])].tolist() == [55, 7]
    with pytest.raises(MeshError, match="no node of this mesh has the id 8; its ids are 7 to 100"):
        mesh.numbers_of([7, 8])


@pytest.mark.parametrize("file_format", ["gmsh22", "gmsh"])
@pytest.mark.parametrize("binary", [False, True])
def test_gmsh_files_of_both_kinds_and_formats(tmp_path, file_format, binary):
    """As meshio writes them: tags count from 1; in format 2 over lines and triangles alike."""
    path = tmp_path / "mesh.msh"
    triangles = ("triangle", np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]]))
    lines = [("line", np.array([[0, 1], [1, 4]]))] if file_format == "gmsh22" else []
    meshio.Mesh(NODES, [*lines, triangles]).write(path, file_format=file_format, binary=binary)
    mesh = read_mesh(path)
    assert mesh.node_ids.tolist() == [1, 2, 3, 4, 5]
    assert mesh.cell_ids[CellType.TRIANGLE3].tolist() == ([3, 4, 5] if lines else [1, 2, 3])


def test_nodes_left_out_and_single_sets_keep_the_others_ids(tmp_path):
    path = tmp_path / "mesh.inp"
    text = abaqus().replace("*ELEMENT", "500, 9., 9., 9.\n*ELEMENT", 1) + "*ELSET, ELSET=part\n12, 41\n"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MeshError, match=r"1 orphan node \(500\): .* node 500 is at \(9, 9, 9\)"):
        read_mesh(path)
    whole = read_mesh(path, unused_nodes=UnusedNodes.DROP)
    assert whole.node_ids.tolist() == IDS.tolist()
    part = read_mesh(path, only="part")
    assert part.node_ids.tolist() == [30, 10, 7, 100]
    assert part.cell_ids[CellType.TRIANGLE3].tolist() == [41, 12]


def test_made_meshes_number_from_0():
    mesh = strip(1.0, 0.2, 4, 2)
    assert not mesh.has_own_ids
    assert mesh.node_ids.tolist() == list(range(mesh.n_nodes))
    assert mesh.cell_ids[CellType.TRIANGLE3].tolist() == list(range(mesh.n_cells))


def test_ids_that_repeat_or_lack_are_refused():
    triangle, cells = NODES[:3], {CellType.TRIANGLE3: [[0, 1, 2]]}
    with pytest.raises(MeshError, match="2 nodes have the id 5"):
        Mesh(triangle, cells, node_ids=np.array([5, 5, 6]))
    with pytest.raises(MeshError, match="node ids have shape"):
        Mesh(triangle, cells, node_ids=np.array([5, 6]))
    with pytest.raises(MeshError, match="ids of cells TRIANGLE3 have shape"):
        Mesh(triangle, cells, cell_ids={CellType.TRIANGLE3: np.array([1, 2])})


@pytest.fixture
def square():
    numbers = {int(i): k for k, i in enumerate(IDS)}
    cells = np.array([[numbers[i] for i in nodes] for _, nodes in TRIANGLES])
    return Mesh(
        NODES,
        {CellType.TRIANGLE3: cells},
        node_ids=IDS,
        cell_ids={CellType.TRIANGLE3: np.array([e for e, _ in TRIANGLES])},
    )


def test_messages_name_nodes_and_elements_by_their_ids(square):
    wall = HomogeneousSection(Isotropic(2.1e11, 0.3, 7850.0), 0.05)
    model = shell_model(square, wall)
    held = [RigidInterface("a", [0, 3]), RigidInterface("b", [4, 3])]
    with pytest.raises(ModelError, match=r"node 100 .* is already rigid in interface 'a'"):
        flexible_body("plate", model, held)
    with pytest.raises(ModelError, match="node 55 is listed 2 times"):
        flexible_body("plate", model, [AveragingInterface("a", [4, 4, 0])])
    flat = np.array(NODES)
    flat[4] = [0.5, 0.0, 0.0]
    flat[2] = [1.5, 0.0, 0.0]
    with pytest.raises(
        MeshError, match=r"degenerate TRIANGLE3 cells? \(41, 99\).*cell 41 has nodes \[30, 10, 7\]"
    ):
        Mesh(flat, square.cells, node_ids=square.node_ids, cell_ids=square.cell_ids)


def test_the_check_of_a_model_names_cells_by_their_ids(square):
    cells = np.vstack([square.cells[CellType.TRIANGLE3], square.cells[CellType.TRIANGLE3][1:2]])
    ids = np.append(square.cell_ids[CellType.TRIANGLE3], 1000)
    twice = Mesh(NODES, {CellType.TRIANGLE3: cells}, node_ids=IDS, cell_ids={CellType.TRIANGLE3: ids})
    check = check_elements(
        shell_model(twice, HomogeneousSection(Isotropic(2e11, 0.3, 7850.0), 0.05)), n_frequencies=0
    )
    (found,) = [each for each in check.findings if each.what == "cells on the same nodes"]
    assert "first at cell 12" in found.seen


def test_a_case_file_names_nodes_by_their_ids(machine):
    """`node_indices` of a mesh file are its ids: the tip of the machine's arm is the same by either name."""
    path = machine("m", {"length": "m", "mass": "kg", "time": "s"})
    mesh = read_mesh(path.parent / "arm.inp")
    ids = mesh.node_ids[mesh.nodes_of("TIP")].tolist()
    text = path.read_text(encoding="utf-8").replace('nodes = "TIP"', f"node_indices = {ids}")
    path.write_text(text, encoding="utf-8")
    case = read_case(path)
    assert case.flexible["arm"].interface("tip").node_ids.tolist() == mesh.nodes_of("TIP").tolist()
    path.write_text(text.replace(str(ids), "[0, 1]"), encoding="utf-8")
    with pytest.raises(MeshError, match="no node of this mesh has the id 0"):
        _ = read_case(path).flexible
