"""Mesh: immutable, and its lookups say what there is."""

import pickle
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from supple.errors import MeshError
from supple.mesh import CellType, Mesh, box_beam, strip


def test_arrays_are_copied_and_read_only():
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    edge = np.array([0, 1])
    mesh = Mesh(nodes, {CellType.TRIANGLE3: [[0, 1, 2]]}, {"edge": edge})
    nodes[0] = edge[0] = 7
    assert mesh.nodes[0, 0] == 0
    assert mesh.nodes_of("edge")[0] == 0
    for array in (mesh.nodes, mesh.cells[CellType.TRIANGLE3], mesh.nodes_of("edge")):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_fields_and_mappings_cannot_be_replaced():
    mesh = strip(1.0, 1.0, 1, 2)
    with pytest.raises(FrozenInstanceError):
        mesh.nodes = mesh.nodes
    with pytest.raises(TypeError):
        mesh.node_sets["root"] = mesh.nodes_of("tip")


def test_replace_checks_again():
    mesh = strip(1.0, 1.0, 1, 2)
    assert np.array_equal(replace(mesh, nodes=2 * mesh.nodes).nodes, 2 * mesh.nodes)
    with pytest.raises(MeshError, match="degenerate"):
        replace(mesh, nodes=0 * mesh.nodes)


def test_unknown_node_set_lists_those_there_are():
    with pytest.raises(MeshError, match="no node set 'hub' in this mesh; it has 'root', 'tip'"):
        box_beam(1.0, 1.0, 1.0, 1, 1, 1).nodes_of("hub")


def test_unknown_cell_set_lists_those_there_are():
    mesh = box_beam(1.0, 1.0, 1.0, 1, 1, 1)
    with pytest.raises(MeshError, match="no cell set 'lid' in this mesh; it has 'z_min', 'y_max'"):
        mesh.cells_of("lid")
    with pytest.raises(MeshError, match="no cell set 'lid' in this mesh; it has none"):
        strip(1.0, 1.0, 1, 2).cells_of("lid")
    assert list(mesh.cells_of("z_min")) == [CellType.TRIANGLE3]


def test_only_cell_type():
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]])
    tetra, triangle = {CellType.TETRA4: [[0, 1, 2, 3]]}, {CellType.TRIANGLE3: [[1, 4, 2]]}
    assert Mesh(nodes[:4], tetra).only_cell_type() is CellType.TETRA4
    with pytest.raises(MeshError, match=r"mixes cell types \(1 TETRA4, 1 TRIANGLE3\)"):
        Mesh(nodes, tetra | triangle).only_cell_type()


def test_pickled_mesh_is_the_same_and_still_read_only():
    mesh = box_beam(2.0, 1.0, 1.0, 2, 1, 1)
    again = pickle.loads(pickle.dumps(mesh))
    assert np.array_equal(again.nodes, mesh.nodes)
    assert repr(again) == repr(mesh)
    assert not again.nodes.flags.writeable


def test_repr_is_short():
    assert repr(strip(1.0, 1.0, 1, 2)) == "<Mesh of 6 nodes, 4 TRIANGLE3>"
