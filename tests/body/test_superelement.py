from __future__ import annotations

import numpy as np
import pytest
from scipy.io import mmwrite

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    MeanAxisFrame,
    RigidInterface,
    flexible_body,
    read_superelement,
    superelement,
)
from supple.errors import ImportFormatError, ModelError


def interfaces(model):
    x = model.mesh.nodes[:, 0]
    return [
        RigidInterface("root", np.flatnonzero(x == x.min())),
        AveragingInterface("tip", np.flatnonzero(x == x.max())),
    ]


@pytest.fixture(params=["shell", "solid"])
def model(request):
    return request.getfixturevalue(request.param)


def same_body(one, other):
    for name in ("nodes", "rigid_modes"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for name in ("stiffness", "mass", "nodal_mass", "expansion"):
        assert abs(getattr(one, name) - getattr(other, name)).max() == 0
    for a, b in zip(one.interfaces, other.interfaces, strict=True):
        assert a.name == b.name
        np.testing.assert_array_equal(a.position, b.position)
        assert abs(a.motion - b.motion).max() == 0


def test_the_matrices_of_a_model_make_the_same_body(model):
    made = flexible_body("arm", model, interfaces(model))
    for K, M in ((model.stiffness, model.mass), (model.stiffness.toarray(), model.mass.toarray())):
        imported = superelement(
            "arm", model.mesh.nodes, K, M, dofs_per_node=model.dofs_per_node, interfaces=interfaces(model)
        )
        same_body(imported, made)
        assert imported.model is None


def test_files_make_the_same_body(model, tmp_path):
    mmwrite(tmp_path / "nodes.mtx", model.mesh.nodes, precision=17)
    mmwrite(tmp_path / "K.mtx", model.stiffness, precision=17, symmetry="symmetric")
    mmwrite(tmp_path / "M.mtx", model.mass, precision=17, symmetry="symmetric")
    read = read_superelement(
        "arm",
        nodes=tmp_path / "nodes.mtx",
        stiffness=tmp_path / "K.mtx",
        mass=tmp_path / "M.mtx",
        dofs_per_node=model.dofs_per_node,
        interfaces=interfaces(model),
    )
    expected = superelement(
        "arm",
        model.mesh.nodes,
        model.stiffness,
        model.mass,
        dofs_per_node=model.dofs_per_node,
        interfaces=interfaces(model),
    )
    np.testing.assert_array_equal(read.nodes, expected.nodes)
    D = MeanAxisFrame()
    values = [
        lowest_modes(b.stiffness, b.mass, 5, constraint=D.constraint(b)).values for b in (read, expected)
    ]
    np.testing.assert_allclose(values[0], values[1], rtol=1e-8)


def test_printed_with_few_digits_it_needs_a_tolerance(solid, tmp_path):
    mmwrite(tmp_path / "nodes.mtx", solid.mesh.nodes)
    mmwrite(tmp_path / "K.mtx", solid.stiffness, precision=6, symmetry="symmetric")
    mmwrite(tmp_path / "M.mtx", solid.mass, precision=6, symmetry="symmetric")
    files = {"nodes": tmp_path / "nodes.mtx", "stiffness": tmp_path / "K.mtx", "mass": tmp_path / "M.mtx"}
    with pytest.raises(ModelError, match="for matrices printed with few digits, raise rigid_tolerance"):
        read_superelement("arm", **files, dofs_per_node=3)
    read_superelement("arm", **files, dofs_per_node=3, rigid_tolerance=1e-5)


def test_a_missing_file_is_named(tmp_path):
    missing = tmp_path / "K.mtx"
    with pytest.raises(ImportFormatError, match=r"K\.mtx"):
        read_superelement("arm", nodes=missing, stiffness=missing, mass=missing, dofs_per_node=3)


def test_a_recovery_matrix_needs_its_points(solid, tmp_path):
    """Without the points it was ignored."""
    for name, content in (("nodes", solid.mesh.nodes), ("K", solid.stiffness), ("M", solid.mass)):
        mmwrite(tmp_path / f"{name}.mtx", content)
    files = {"nodes": tmp_path / "nodes.mtx", "stiffness": tmp_path / "K.mtx", "mass": tmp_path / "M.mtx"}
    with pytest.raises(ModelError, match="'arm': recovery without points: give both files, or neither"):
        read_superelement("arm", **files, dofs_per_node=3, recovery=tmp_path / "K.mtx")


def test_an_unsymmetric_matrix_is_named_with_its_file(solid, tmp_path):
    K = solid.stiffness.copy()
    K[0, 1] += 1e9
    mmwrite(tmp_path / "nodes.mtx", solid.mesh.nodes)
    mmwrite(tmp_path / "K.mtx", K, precision=17, symmetry="general")
    mmwrite(tmp_path / "M.mtx", solid.mass, precision=17)
    files = {"nodes": tmp_path / "nodes.mtx", "stiffness": tmp_path / "K.mtx", "mass": tmp_path / "M.mtx"}
    with pytest.raises(ModelError, match=r"the stiffness is not symmetric.*node 0 u.*read from .*K\.mtx"):
        read_superelement("arm", **files, dofs_per_node=3)


def test_it_knows_rotations_where_it_has_them(shell, solid):
    def rotations(model):
        return superelement(
            "arm", model.mesh.nodes, model.stiffness, model.mass, dofs_per_node=model.dofs_per_node
        ).rotation_operator

    assert rotations(solid) is None
    q = np.random.default_rng(0).standard_normal(shell.n_dofs)
    np.testing.assert_array_equal((rotations(shell) @ q).reshape(-1, 3), q.reshape(-1, 6)[:, 3:])


def test_node_sets_and_odd_freedoms_are_refused(solid):
    matrices = (solid.mesh.nodes, solid.stiffness, solid.mass)
    with pytest.raises(
        ModelError, match="interface 'root' names the node set 'left', but a superelement has no node sets"
    ):
        superelement("arm", *matrices, dofs_per_node=3, interfaces=[RigidInterface("root", "left")])
    with pytest.raises(ModelError, match="body 'arm': 4 freedoms per node; only 3 and 6 are possible"):
        superelement("arm", *matrices, dofs_per_node=4)
