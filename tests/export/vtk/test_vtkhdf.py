"""VTKHDF files hold the motion of every form of body, as h5py and VTK itself read it back."""

import errno

import h5py
import numpy as np
import pytest
from fixtures.runs_on_disk import started

from supple.body import RigidBody
from supple.errors import ModelError, ResultFileError
from supple.export import write_vtkhdf, write_vtu
from supple.export.vtk import vtkhdf
from supple.export.vtk.cells import vtk_cells
from supple.export.vtk.pieces import pieces_of
from supple.integrate import FloatingMotion, Solution, Statistics
from supple.machine import GROUND, Placed, Revolute, System
from supple.mesh import CellType, Mesh, block
from supple.quantities import deflections, observer_of, von_mises_history
from supple.results.explicit_fields import element_means
from supple.storage import ResultParts, write_solution
from supple.units import SI

NAMES = ["rigid", "reduced", "full", "intrinsic", "modal", "finite elements", "joints"]


def read(path):
    """Points and fields (t, n, ..) of each partition, by its name, as VTKHDF says that they lie."""
    with h5py.File(path) as file:
        group = file["VTKHDF"]
        steps, n_times = group["Steps"], group["Steps"].attrs["NSteps"]
        counts = {"PointData": group["NumberOfPoints"][()], "CellData": group["NumberOfCells"][()]}
        names = [name.decode() for name in group["FieldData/bodies"]]
        starts = {what: np.cumsum([0, *own]) for what, own in counts.items()}
        found = {name: {} for name in names}
        for number, name in enumerate(names):
            found[name]["points"] = group["Points"][starts["PointData"][number] :][
                : counts["PointData"][number]
            ]
            for what in starts:
                for field, values in group[what].items():
                    offsets = steps[f"{what}Offsets/{field}"][()] + starts[what][number]
                    assert len(offsets) == n_times
                    found[name][field] = np.stack(
                        [values[start : start + counts[what][number]] for start in offsets]
                    )
    return found


@pytest.fixture(scope="module")
def written(machine, meshes, elements, tmp_path_factory):
    path = tmp_path_factory.mktemp("vtk") / "machine.vtkhdf"
    return write_vtkhdf(path, *machine, meshes, elements=elements, units=SI)


def test_points_and_displacement_are_the_positions_of_the_nodes(written, machine):
    found, (system, solution) = read(written), machine
    assert list(found) == NAMES
    for name in NAMES[1:-1]:
        body, motion = system.placed(name).body, solution.bodies[name]
        positions = found[name]["points"] + found[name]["displacement (m)"].astype(float)
        np.testing.assert_allclose(positions, body.positions(motion), rtol=0, atol=1e-6)
        placed = system.placed(name)
        np.testing.assert_allclose(
            found[name]["points"], placed.position + body.nodes @ placed.rotation.T, atol=1e-12
        )


def test_a_rigid_body_and_joints_move_along(written, machine):
    found, (system, solution) = read(written), machine
    motion = solution.bodies["rigid"]
    moved = found["rigid"]["points"] + found["rigid"]["displacement (m)"].astype(float)
    back = np.einsum("tji,tnj->tni", motion.rotation, moved - motion.position[:, None])
    np.testing.assert_allclose(back, np.broadcast_to(found["rigid"]["points"], back.shape), atol=1e-6)
    body = system.placed("rigid").body
    np.testing.assert_allclose(back[0, -2:], body.nodes, atol=1e-6)
    joints = found["joints"]["points"] + found["joints"]["displacement (m)"].astype(float)
    np.testing.assert_allclose(joints[:, 0], body.positions(motion)[:, 0], atol=1e-6)
    other = system.placed("reduced").body
    tip = other.interface_motion(solution.bodies["reduced"], "tip").position
    np.testing.assert_allclose(joints[:, 1], tip, atol=1e-6)


def test_a_rigid_body_is_the_ellipsoid_of_its_mass_and_inertia():
    """A solid ellipsoid of mass m and half axes a, b, c has the moments m (b^2 + c^2) / 5, .."""
    half, mass, centre = np.array([0.5, 0.2, 0.3]), 7.0, np.array([1.0, 2.0, 3.0])
    inertia = mass / 5 * np.diag((half**2).sum() - half**2)
    body = RigidBody("egg", mass, centre, inertia)
    (piece,) = pieces_of(System([Placed(body)]), {})
    on_it = piece.points[:-1] - centre
    np.testing.assert_allclose(((on_it / half) ** 2).sum(axis=1), 1.0, rtol=1e-12)
    assert np.abs(on_it).max(axis=0) == pytest.approx(half)
    corners = piece.points[piece.cells.nodes.reshape(-1, 3)] - centre
    volume = abs(np.linalg.det(corners).sum()) / 6
    assert 0.95 < volume / (4 / 3 * np.pi * half.prod()) < 1.0


def test_deflection_is_what_the_first_interface_does_not_carry_along(written, machine):
    found, (system, solution) = read(written), machine
    for name in ("reduced", "full", "intrinsic", "modal"):
        body, motion = system.placed(name).body, solution.bodies[name]
        seen = observer_of(system, solution, name)
        expected = np.einsum("tij,tnj->tni", seen.axes, deflections(body, motion))
        assert abs(expected).max() > 1e-4
        np.testing.assert_allclose(found[name]["deflection (m)"], expected, atol=1e-6 * abs(expected).max())
    for name in ("rigid", "finite elements", "joints"):
        assert np.isnan(found[name]["deflection (m)"]).all()


def test_stress_is_that_of_the_bodies(written, machine, elements):
    found, (_, solution) = read(written), machine
    for name in ("reduced", "full", "intrinsic", "modal"):
        body = machine[0].placed(name).body
        expected = 1e-6 * von_mises_history(body, elements[name], solution.bodies[name].coordinates)
        np.testing.assert_allclose(found[name]["von Mises stress (MPa)"], expected, rtol=1e-5)
    motion = solution.bodies["finite elements"]
    means = 1e-6 * element_means(machine[0].placed("finite elements").body, motion.von_mises, motion.alive)
    np.testing.assert_allclose(found["finite elements"]["von Mises stress (MPa)"], means, rtol=1e-5)
    assert np.isnan(found["rigid"]["von Mises stress (MPa)"]).all()


def test_deleted_elements_are_hidden_and_plastic_strain_is_of_elements(written, machine):
    found, motion = read(written), machine[1].bodies["finite elements"]
    own = found["finite elements"]
    np.testing.assert_allclose(own["plastic strain"], motion.plastic_strain, rtol=1e-6)
    np.testing.assert_array_equal(own["vtkGhostType"], 32 * (motion.alive == 0))
    assert own["vtkGhostType"].any()
    for name in NAMES[:-2]:
        assert not found[name]["vtkGhostType"].any()
    assert [int(found[name]["body"][0, 0]) for name in NAMES] == list(range(len(NAMES)))


def test_a_file_is_the_same_in_short_parts_and_from_a_result(written, machine, meshes, tmp_path, monkeypatch):
    monkeypatch.setattr(vtkhdf, "_BLOCK_NUMBERS", 3 * 2 * 700)
    result = write_solution(tmp_path / "run.h5", machine[1], case="made up")
    names = ["rigid", "reduced", "full", "finite elements"]
    again = write_vtkhdf(
        tmp_path / "b.vtkhdf", machine[0], ResultParts(result), meshes, bodies=names, units=SI
    )
    expected = read(written)
    for name, fields in read(again).items():
        assert expected[name].keys() - fields.keys() == {"von Mises stress (MPa)"}
        fields.pop("body")
        for field, values in fields.items():
            np.testing.assert_allclose(values, expected[name][field], rtol=1e-5, atol=1e-9)


def test_chosen_bodies_and_instants(machine, meshes, tmp_path):
    path = write_vtkhdf(
        tmp_path / "a.vtkhdf", machine[0], machine[1].at(np.array([1, 3])), meshes, bodies=["full"]
    )
    found = read(path)
    assert list(found) == ["full"]
    assert set(found["full"]) == {"points", "displacement", "deflection", "body"}
    assert found["full"]["displacement"].shape == (2, len(meshes["full"].nodes), 3)


def test_a_part_without_a_mesh_is_written_as_points_without_values_of_elements(machine, meshes, tmp_path):
    path = write_vtkhdf(tmp_path / "a.vtkhdf", *machine, {"full": meshes["full"]})
    found = read(path)
    assert "vtkGhostType" not in found["finite elements"]
    assert write_vtu(tmp_path / "a.vtu", machine[0], machine[1].at(slice(1))).is_file()


def test_meshes_and_elements_are_of_bodies(machine, meshes, elements, tmp_path):
    path = tmp_path / "a.vtkhdf"
    for kwargs in ({"meshes": {"fill": meshes["full"]}}, {"elements": {"fill": elements["full"]}}):
        with pytest.raises(ModelError, match="there is no body 'fill'; did you mean 'full'"):
            write_vtkhdf(path, *machine, **kwargs)
    large = block(1.0, 1.0, 1.0, 9, 9, 9, CellType.HEXA8)
    with pytest.raises(ModelError, match="the mesh given for body 'full' has 1000 nodes and the body"):
        write_vtkhdf(path, *machine, {"full": large})
    few = block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8)
    with pytest.raises(ModelError, match="part 'finite elements' has 1 cells and the part 8 elements"):
        write_vtkhdf(path, *machine, {"finite elements": few})
    assert not path.exists()


def test_a_body_may_be_named_as_the_joints_are(tmp_path):
    bar = RigidBody("joints", 1.0, np.ones(3), np.eye(3), {"pin": np.zeros(3)})
    system = System([Placed(bar)], [Revolute(name="pin", first=GROUND, second="joints.pin", axis=(0, 0, 1))])
    moved = np.array([[3.0, 0.0, 0.0]])
    still, none = np.zeros((1, 3)), np.zeros((1, 0))
    motion = FloatingMotion(moved, np.eye(3)[None], none, still, still, none, still, still, none)
    path = write_vtkhdf(
        tmp_path / "a.vtkhdf", system, Solution(np.zeros(1), {"joints": motion}, {}, Statistics())
    )
    with h5py.File(path) as file:
        displacement = file["VTKHDF/PointData/displacement"][()]
        assert file["VTKHDF/NumberOfPoints"][1] == 1
    np.testing.assert_array_equal(displacement, np.tile(moved, (len(displacement), 1)))


def test_a_full_disk_leaves_what_was_there(machine, meshes, tmp_path, monkeypatch):
    def full(_path, size):
        assert size > 1000
        raise OSError(errno.ENOSPC, "no space")

    path = tmp_path / "a.vtkhdf"
    path.write_text("before")
    monkeypatch.setattr(vtkhdf, "reserve_space", full)
    with pytest.raises(ResultFileError, match="the disk is full"):
        write_vtkhdf(path, *machine, meshes)
    assert [each.name for each in tmp_path.iterdir()] == ["a.vtkhdf"]
    assert path.read_text() == "before"


LIMITED = """
import resource, signal, sys
import numpy as np
from fixtures.runs_on_disk import pendulum
from supple.errors import ResultFileError
from supple.export import write_vtkhdf, write_vtu
from supple.integrate import FloatingMotion, Solution, Statistics
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
n = 2000
still, none = np.zeros((n, 3)), np.zeros((n, 0))
motion = FloatingMotion(still, np.tile(np.eye(3), (n, 1, 1)), none, still, still, none, still, still, none)
solution = Solution(np.arange(float(n)), {"bar": motion}, {}, Statistics())
for size in (100, 5_000, 1_000_000):
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    try:
        write_vtkhdf(sys.argv[1], pendulum(), solution)
    except ResultFileError as error:
        print(error)
"""


@pytest.mark.slow
def test_hdf5_survives_a_limit_of_file_sizes_wherever_it_is_met(tmp_path):
    """In the headers, in the mesh and in the arrays."""
    process = started(LIMITED, tmp_path / "a.vtkhdf")
    output, errors = process.communicate()
    assert process.returncode == 0, errors
    assert output.count("the file has reached the size limit") == 3
    assert not list(tmp_path.iterdir())


def test_mistakes_are_named(machine, tmp_path):
    with pytest.raises(ModelError, match=r"end the path in \.vtkhdf"):
        write_vtkhdf(tmp_path / "a.h5", *machine)
    with pytest.raises(ModelError, match="no body 'ful' to write; did you mean 'full'"):
        write_vtkhdf(tmp_path / "a.vtkhdf", *machine, bodies=["ful"])
    with pytest.raises(ModelError, match="no output time is selected"):
        write_vtkhdf(tmp_path / "a.vtkhdf", machine[0], machine[1].at(slice(0, 0)))
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_vtk_reads_it(written, machine):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(written))
    reader.UpdateInformation()
    expected = read(written)
    for step, time in enumerate(machine[1].times):
        reader.UpdateTimeStep(time)
        output = reader.GetOutputDataObject(0)
        for number, name in enumerate(NAMES):
            grid = output.GetPartition(number)
            data = grid.GetPointData()
            numbers = range(data.GetNumberOfArrays())
            own = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in numbers}
            np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), expected[name]["points"])
            assert len(own) == 3
            for field, values in own.items():
                np.testing.assert_array_equal(values, expected[name][field][step])
            if name == "finite elements":
                surface = vtk.vtkGeometryFilter()
                surface.SetInputData(grid)
                surface.Update()
                assert surface.GetOutput().GetNumberOfCells() == (34 if step < 2 else 30)


WEDGE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1.0]])
PYRAMID = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1.0]])
VOLUMES = {"TETRA": 1.0, "HEXA": 1.0, "WEDGE": 0.5, "PYRAMID": 1 / 3}


def solid_of(kind):
    """A mesh of one kind: a unit cube, or one wedge or pyramid."""
    corners = {6: WEDGE, 5: PYRAMID}.get(kind.n_corners)
    if corners is None:
        return block(1, 1, 1, 1, 1, 1, kind)
    middles = [corners[list(edge)].mean(axis=0) for edge in kind.edges]
    nodes = np.concatenate([corners, middles])[: kind.n_nodes]
    return Mesh(nodes, {kind: np.arange(kind.n_nodes)[None]})


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in CellType if kind.dimension == 3])
def test_vtk_sees_cells_the_right_way_round(kind):
    """VTK's faces turn about their outward normals, and its volume is that of the body."""
    vtk = pytest.importorskip("vtk")
    mesh, cells = solid_of(kind), vtk_cells(solid_of(kind))
    grid, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
    for point in mesh.nodes:
        points.InsertNextPoint(point)
    grid.SetPoints(points)
    for number, type_ in enumerate(cells.types):
        nodes = cells.nodes[cells.offsets[number] : cells.offsets[number + 1]]
        grid.InsertNextCell(int(type_), len(nodes), nodes.tolist())
    volume = 0.0
    for number in range(len(cells.types)):
        cell = grid.GetCell(number)
        centre = mesh.nodes[list(cells.nodes[cells.offsets[number] : cells.offsets[number + 1]])].mean(axis=0)
        # Before 9.7 VTK turned the faces of wedges the other way round.
        version = vtk.vtkVersion()
        before = (version.GetVTKMajorVersion(), version.GetVTKMinorVersion()) < (9, 7)
        is_turned = kind.n_corners == 6 and before
        for side in () if is_turned else range(cell.GetNumberOfFaces()):
            face = cell.GetFace(side).GetPoints()
            first, second, third = (np.array(face.GetPoint(k)) for k in range(3))
            assert np.cross(second - first, third - first) @ (first - centre) > 0
        measured = vtk.vtkCellSizeFilter()
        one = vtk.vtkUnstructuredGrid()
        one.SetPoints(points)
        one.InsertNextCell(cell.GetCellType(), cell.GetPointIds())
        measured.SetInputData(one)
        measured.Update()
        volume += measured.GetOutput().GetCellData().GetArray("Volume").GetValue(0)
    assert volume == pytest.approx(VOLUMES[kind.name.rstrip("0123456789")], rel=1e-6)
