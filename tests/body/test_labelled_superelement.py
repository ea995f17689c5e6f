"""Matrices of another program: every format gives the same body; maps that do not fit are rejected."""

from __future__ import annotations

from dataclasses import replace

import h5py
import numpy as np
import pytest
from scipy.sparse import block_diag, csc_array, diags_array, kron

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    MatrixFiles,
    MeanAxisFrame,
    RigidInterface,
    connection_named,
    flexible_body,
    labelled_superelement,
    nodal_matrices,
    read_labelled_superelement,
    read_nodal_matrices,
)
from supple.errors import ImportFormatError, ModelError
from supple.importers import Connection, LabelledMatrix, NodeTable

# Ids that are neither consecutive nor in the order of the nodes.
FIRST_ID = 1000


def ids_of(model):
    return FIRST_ID - 3 * np.arange(model.mesh.n_nodes)


def labels_of(model):
    d = model.dofs_per_node
    return np.column_stack([np.repeat(ids_of(model), d), np.tile(np.arange(1, d + 1), model.mesh.n_nodes)])


def lower(matrix):
    entries = matrix.tocoo()
    keep = entries.row >= entries.col
    return entries.row[keep], entries.col[keep], entries.data[keep]


def write_grids(folder, model, *cards):
    nodes = zip(ids_of(model), model.mesh.nodes, strict=True)
    rows = [",".join(["GRID", str(i), "", *map(repr, map(float, x))]) for i, x in nodes]
    (folder / "arm.bdf").write_text("\n".join([*rows, *cards, ""]))


def write_nodes(folder, model):
    nodes = zip(ids_of(model), model.mesh.nodes, strict=True)
    rows = [", ".join([str(i), *map(repr, map(float, x))]) for i, x in nodes]
    left, right = ends(model)
    sets = [
        "*NSET, NSET=left",
        *map(str, ids_of(model)[left]),
        "*NSET, NSET=right",
        *map(str, ids_of(model)[right]),
    ]
    (folder / "arm.inp").write_text("\n".join(["*NODE", *rows, *sets, ""]))


def ends(model):
    x = model.mesh.nodes[:, 0]
    return np.flatnonzero(x == x.min()), np.flatnonzero(x == x.max())


def write_dmig(path, model, digits=16):
    labels, rows = labels_of(model), []
    for name, matrix in (("KAAX", model.stiffness), ("MAAX", model.mass)):
        rows.append(f"DMIG,{name},0,6,2,0")
        i, j, values = lower(matrix)
        for column in np.unique(j):
            node, component = labels[column]
            rows.append(f"DMIG*   {name:<16}{node:16d}{component:16d}")
            for row, value in zip(i[j == column], values[j == column], strict=True):
                number = f"{value:.{digits}E}".replace("E", "D")
                rows.append(f"*,{labels[row][0]},{labels[row][1]},{number}")
    path.write_text("\n".join([*rows, ""]))


def write_hdf5(path, model):
    with h5py.File(path, "w") as file:
        file["nodes"], file["node_ids"], file["freedoms"] = model.mesh.nodes, ids_of(model), labels_of(model)
        for name, matrix in (("stiffness", model.stiffness), ("mass", model.mass)):
            for part in ("data", "indices", "indptr"):
                file[f"{name}/{part}"] = getattr(matrix, part)
        file["node_sets/left"], file["node_sets/right"] = (ids_of(model)[end] for end in ends(model))


def write_abaqus(path, model, matrix):
    labels = labels_of(model)
    i, j, values = lower(matrix)
    rows = [
        f"{labels[r][0]},{labels[r][1]}, {labels[c][0]},{labels[c][1]}, {v!r}"
        for r, c, v in zip(i, j, values.tolist(), strict=True)
    ]
    path.write_text("\n".join(["** written by *MATRIX OUTPUT", *rows, ""]))


def write_calculix(path, matrix):
    i, j, values = lower(matrix)
    path.write_text(
        "\n".join(f"{c + 1} {r + 1} {v!r}" for r, c, v in zip(i, j, values.tolist(), strict=True))
    )


def write_all(folder, model):
    write_grids(folder, model)
    write_nodes(folder, model)
    write_dmig(folder / "arm.pch", model)
    write_hdf5(folder / "arm.h5", model)
    write_abaqus(folder / "K.mtx", model, model.stiffness)
    write_abaqus(folder / "M.mtx", model, model.mass)
    write_calculix(folder / "arm.sti", model.stiffness)
    write_calculix(folder / "arm.mas", model.mass)
    (folder / "arm.dof").write_text("\n".join(f"{node}.{component}" for node, component in labels_of(model)))


pytestmark = pytest.mark.usefixtures("hdf5_copied_here")
FORMATS = {
    "dmig": ("arm.bdf", "arm.pch", "arm.pch"),
    "hdf5": ("arm.h5", "arm.h5", "arm.h5"),
    "abaqus": ("arm.inp", "K.mtx", "M.mtx"),
    "calculix": ("arm.inp", "arm.sti", "arm.mas"),
    "mixed": ("arm.h5", "arm.sti", "arm.pch"),
}


def read(folder, files, interfaces=None, **names):
    nodes, stiffness, mass = (folder / name for name in files)
    return read_labelled_superelement("arm", MatrixFiles(nodes, stiffness, mass, **names), interfaces)


def same_body(one, other):
    np.testing.assert_array_equal(one.nodes, other.nodes)
    assert one.dofs_per_node == other.dofs_per_node
    assert abs(one.stiffness - other.stiffness).max() <= 1e-14 * abs(other.stiffness).max()
    assert abs(one.mass - other.mass).max() <= 1e-14 * abs(other.mass).max()
    for a, b in zip(one.interfaces, other.interfaces, strict=True):
        assert a.name == b.name
        np.testing.assert_array_equal(a.position, b.position)
        assert abs(a.motion - b.motion).max() == 0


@pytest.fixture(params=["shell", pytest.param("solid", marks=pytest.mark.slow)])
def model(request):
    return request.getfixturevalue(request.param)


@pytest.fixture
def folder(tmp_path, model):
    write_all(tmp_path, model)
    return tmp_path


def test_every_format_gives_the_body_of_the_elements(folder, model):
    left, right = ends(model)
    by_number = [RigidInterface("root", left), AveragingInterface("tip", right)]
    expected = flexible_body("arm", model, by_number)
    for files in FORMATS.values():
        same_body(read(folder, files, interfaces=by_number), expected)


@pytest.mark.parametrize("binary", [True, False], ids=["binary", "text"])
@pytest.mark.parametrize("sparse", [True, False], ids=["sparse", "dense"])
def test_output4_gives_the_body_of_the_elements(folder, model, binary, sparse):
    """The g-set: six freedoms of every grid, sorted by id; solids leave their rotations empty."""
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    d = model.dofs_per_node
    pad = csc_array(np.eye(6)[:, :d])
    wide = csc_array(kron(np.eye(model.mesh.n_nodes)[::-1], pad))  # ids fall with the node number
    matrices = {name: wide @ m @ wide.T for name, m in (("KGG", model.stiffness), ("MGG", model.mass))}
    if not sparse:
        matrices = {name: matrix.toarray() for name, matrix in matrices.items()}
    op4.write(str(folder / "arm.op4"), matrices, binary=binary, sparse="bigmat" if sparse else "dense")
    left, right = ends(model)
    interfaces = [RigidInterface("root", left), AveragingInterface("tip", right)]
    files = ("arm.bdf", "arm.op4", "arm.op4")
    same_body(read(folder, files, interfaces=interfaces), flexible_body("arm", model, interfaces))


@pytest.mark.parametrize("nodes", ["arm.inp", "arm.h5"])
def test_interfaces_by_the_node_sets_of_the_mesh_file(folder, model, nodes):
    interfaces = [RigidInterface("root", "left"), AveragingInterface("tip", "right")]
    left, right = ends(model)
    expected = flexible_body("arm", model, [RigidInterface("root", left), AveragingInterface("tip", right)])
    same_body(read(folder, (nodes, "arm.pch", "arm.pch"), interfaces=interfaces), expected)
    with pytest.raises(ModelError, match=r"no node set 'middle' in the mesh file; it has 'left', 'right'"):
        read(folder, (nodes, "arm.pch", "arm.pch"), interfaces=[RigidInterface("root", "middle")])


def test_interfaces_by_the_connections_of_the_mesh_file(folder, model):
    left, right = ends(model)
    ids = ids_of(model)
    root, tip = (",".join(map(str, ids[end])).split(",") for end in (left, right))

    def card(*words):
        rows = [words[1:][i : i + 8] for i in range(0, len(words) - 1, 8)]
        return "\n".join(",".join([words[0] if i == 0 else "", *row]) for i, row in enumerate(rows))

    write_grids(
        folder,
        model,
        "GRID,5000,,-1.,0.,0.\nGRID,5001,,4.,0.,0.",
        card("RBE2", "1", "5000", "123456", *root),
        card("RBE3", "2", "", "5001", "123456", "1.0", "123", *tip),
    )
    expected = flexible_body(
        "arm",
        model,
        [RigidInterface("rbe2_1", left, (-1, 0, 0)), AveragingInterface("rbe3_2", right, (4, 0, 0))],
    )
    same_body(read(folder, FORMATS["dmig"]), expected)  # the reference grids carry nothing and are left out


def test_few_digits_are_allowed_for(tmp_path, solid):
    write_grids(tmp_path, solid)
    write_dmig(tmp_path / "arm.pch", solid, digits=8)
    body = read(tmp_path, FORMATS["dmig"])
    D = MeanAxisFrame().constraint(body)
    exact = flexible_body("arm", solid)
    frequencies = [lowest_modes(b.stiffness, b.mass, 4, constraint=D).values for b in (body, exact)]
    np.testing.assert_allclose(*frequencies, rtol=1e-6)
    matrices = read_nodal_matrices(
        MatrixFiles(tmp_path / "arm.bdf", tmp_path / "arm.pch", tmp_path / "arm.pch")
    )
    assert matrices.rigid_tolerance == pytest.approx(100 * 5e-9)
    with pytest.raises(ModelError, match="resists rigid motion"):
        labelled_superelement("arm", matrices, rigid_tolerance=1e-12)


def labelled(model, matrix, labels=None):
    return LabelledMatrix("arm.pch", matrix, labels_of(model) if labels is None else labels)


def table(model, **options):
    return NodeTable("arm.bdf", ids_of(model), model.mesh.nodes, **options)


def test_freedoms_along_the_axes_of_each_node(model):
    """K in axes turned at every node, turned back: K = T K' T^T."""
    rng = np.random.default_rng(0)
    axes = np.linalg.qr(rng.normal(size=(model.mesh.n_nodes, 3, 3))).Q
    turn = np.zeros((model.n_dofs, model.n_dofs))
    for node in range(model.mesh.n_nodes):
        for part in range(model.dofs_per_node // 3):
            first = node * model.dofs_per_node + 3 * part
            turn[first : first + 3, first : first + 3] = axes[node]
    local = [
        0.5 * (turn.T @ m.toarray() @ turn + (turn.T @ m.toarray() @ turn).T)
        for m in (model.stiffness, model.mass)
    ]
    made = nodal_matrices(table(model, axes=axes), *(labelled(model, csc_array(m)) for m in local))
    assert abs(made.stiffness - model.stiffness).max() <= 1e-12 * abs(model.stiffness).max()
    assert abs(made.mass - model.mass).max() <= 1e-12 * abs(model.mass).max()


def test_unused_rotations_and_reference_points_are_left_out(solid):
    """A g-set of solids: six freedoms a node, half of them empty, and a point that nothing uses."""
    pad = np.zeros((6, 3))
    pad[:3] = np.eye(3)
    wide = csc_array(kron(np.eye(solid.mesh.n_nodes), pad))
    ids = np.append(ids_of(solid), 7)
    labels = np.column_stack([np.repeat(ids, 6), np.tile(np.arange(1, 7), len(ids))])
    K, M = (
        csc_array(block_diag([wide @ m @ wide.T, np.zeros((6, 6))])) for m in (solid.stiffness, solid.mass)
    )
    nodes = NodeTable("arm.bdf", ids, np.vstack([solid.mesh.nodes, [9, 9, 9]]))
    made = nodal_matrices(nodes, labelled(solid, K, labels), labelled(solid, M, labels))
    assert made.dofs_per_node == 3
    np.testing.assert_array_equal(made.node_ids, ids_of(solid))
    assert abs(made.stiffness - solid.stiffness).max() <= 1e-15 * abs(solid.stiffness).max()


def test_an_average_over_nodes_that_carry_nothing_is_no_interface(solid):
    """A rigid tie of such a node changes nothing; the mean of the others would be another motion."""
    ids = np.append(ids_of(solid), 7)
    last = len(ids) - 1
    positions = np.vstack([solid.mesh.nodes, [9, 9, 9]])
    ties = tuple(
        Connection(name, np.array([0, 3, last]), np.zeros(3), weights)
        for name, weights in (("rbe2_1", None), ("rbe3_2", np.ones(3)))
    )
    K, M = labelled(solid, solid.stiffness), labelled(solid, solid.mass)
    (left,) = nodal_matrices(NodeTable("arm.bdf", ids, positions, connections=ties), K, M).connections
    assert left.name == "rbe2_1"
    np.testing.assert_array_equal(left.nodes, [0, 3])
    with pytest.raises(ModelError, match=r"no connection 'rbe3_2' .*RBE3 on nodes that all carry stiffness"):
        connection_named("rbe3_2", [left])


def test_a_map_that_does_not_fit_the_nodes(solid):
    K, M = labelled(solid, solid.stiffness), labelled(solid, solid.mass)
    fewer = replace(table(solid), ids=np.where(ids_of(solid) == 997, 5, ids_of(solid)))
    with pytest.raises(
        ModelError, match=r"arm\.pch: has node 997, which arm\.bdf does not define; take nodes and"
    ):
        nodal_matrices(fewer, K, M)
    held = np.ones(solid.n_dofs, dtype=bool)
    held[4] = False
    parts = [LabelledMatrix("arm.pch", m.matrix[held][:, held], m.freedoms[held]) for m in (K, M)]
    with pytest.raises(
        ModelError, match=r"node 997 uy has neither stiffness nor mass.*without supports, and name modal"
    ):
        nodal_matrices(table(solid), *parts)
    with pytest.raises(ModelError, match="no freedom has any stiffness or mass; check the name"):
        nodal_matrices(table(solid), labelled(solid, 0 * K.matrix), labelled(solid, 0 * M.matrix))


def test_a_supported_model_is_refused(solid):
    """Springs to ground, as a K with supports by penalty has them."""
    ground = np.zeros(solid.n_dofs)
    ground[:3] = 1e6
    K = csc_array(solid.stiffness + diags_array(ground))
    with pytest.raises(ModelError, match="resists rigid motion"):
        labelled_superelement(
            "arm", nodal_matrices(table(solid), labelled(solid, K), labelled(solid, solid.mass))
        )


@pytest.mark.parametrize("files", [("arm.msh", "arm.pch"), ("arm.bdf", "arm.txt")])
def test_unknown_suffixes_are_refused(folder, files):
    with pytest.raises(ImportFormatError, match="for this suffix; give a file that ends in"):
        read(folder, (*files, "arm.pch"))


def test_a_name_where_a_file_has_none(folder):
    with pytest.raises(
        ImportFormatError, match=r"a \.h5 file holds no named matrices; leave the name 'K' out"
    ):
        read(folder, FORMATS["hdf5"], stiffness_name="K")
