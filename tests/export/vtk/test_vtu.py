"""VTU files are read back by our own reader of meshes, and by VTK."""

import numpy as np
import pytest

from supple.errors import ModelError
from supple.export import write_vtu
from supple.importers import read_mesh
from supple.mesh import CellType
from supple.quantities import von_mises_history
from supple.units import SI


def at(machine, row):
    return machine[0], machine[1].at(np.array([row]))


def test_a_mesh_is_read_back_as_it_was(machine, meshes, tmp_path):
    path = write_vtu(tmp_path / "a.vtu", *at(machine, 1), meshes, bodies=["full"])
    mesh, placed = read_mesh(path), machine[0].placed("full")
    np.testing.assert_allclose(mesh.nodes, placed.position + meshes["full"].nodes @ placed.rotation.T)
    np.testing.assert_array_equal(mesh.cells[CellType.HEXA8], meshes["full"].cells[CellType.HEXA8])


def test_bodies_are_cell_sets_and_deleted_elements_are_left_out(machine, meshes, tmp_path):
    names = ["full", "finite elements"]
    before = read_mesh(write_vtu(tmp_path / "a.vtu", *at(machine, 1), meshes, bodies=names), only="body_1")
    assert before.n_cells == 8
    path = write_vtu(tmp_path / "b.vtu", *at(machine, 2), meshes, bodies=names)
    assert read_mesh(path, only="body_1").n_cells == 7
    assert read_mesh(path, only="body_0").n_cells == 8


@pytest.mark.slow
def test_vtk_reads_the_fields(machine, meshes, elements, tmp_path):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    system, then = at(machine, 3)
    path = write_vtu(tmp_path / "a.vtu", system, then, meshes, elements=elements, units=SI)
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    data = grid.GetPointData()
    moved = vtk_to_numpy(grid.GetPoints().GetData()) + vtk_to_numpy(data.GetArray("displacement (m)"))
    first = len(moved) - sum(len(body.body.nodes) for body in system.bodies[1:]) - len(system.joints)
    body, motion = system.placed("reduced").body, then.bodies["reduced"]
    np.testing.assert_allclose(moved[first:][: len(body.nodes)], body.positions(motion)[0], atol=1e-6)
    stress = vtk_to_numpy(data.GetArray("von Mises stress (MPa)"))[first:][: len(body.nodes)]
    expected = 1e-6 * von_mises_history(body, elements["reduced"], motion.coordinates)[0]
    np.testing.assert_allclose(stress, expected, rtol=1e-5)


def test_one_instant_alone(machine, tmp_path):
    with pytest.raises(ModelError, match="holds one output time and 5 are given"):
        write_vtu(tmp_path / "a.vtu", *machine)
    with pytest.raises(ModelError, match=r"must end in \.vtu"):
        write_vtu(tmp_path / "a.vtk", *at(machine, 0))
