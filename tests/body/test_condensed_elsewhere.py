"""Models condensed elsewhere: boundary grids and modal coordinates, in every form of suppliers' files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body
from fixtures.beam_lines import beam_matrices
from fixtures.condensed_beam import POINTS, ROOT, TIP, condensed_beam, inside, write_condensed_hdf5
from scipy import linalg
from scipy.linalg import block_diag
from scipy.sparse import csc_array

from supple.body import (
    FullBody,
    MatrixFiles,
    MeanAxisFrame,
    NodalFixedFrame,
    RayleighDamping,
    Recovery,
    RigidInterface,
    Verdict,
    check_nodal_matrices,
    nodal_matrices,
    read_labelled_superelement,
    read_nodal_matrices,
    superelement,
)
from supple.errors import ImportFormatError, ModelError
from supple.importers import LabelledMatrix, NodeTable
from supple.linearization import linearize, machine_modes
from supple.machine import GROUND, At, Fixed, Spin, System
from supple.methods.floating.full.full_damping import full_damping
from supple.reduction import CompleteBasis, CraigBampton, NoDerivatives, NoLoads, reduce

pytestmark = pytest.mark.usefixtures("hdf5_copied_here")
MODES = 6
ENDS = [RigidInterface("root", [0]), RigidInterface("tip", [1])]


@pytest.fixture(scope="module")
def beam():
    return condensed_beam(MODES)


@pytest.fixture(scope="module")
def labels(beam):
    return beam.labels


def as_reduced(body):
    frame = NodalFixedFrame(body.interfaces[0].name)
    return reduce(body, frame, CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads)


@pytest.fixture(scope="module")
def ours():
    """The same beam, reduced here."""
    body = beam_body("root", "tip").linearized()
    frame = NodalFixedFrame("root")
    return reduce(body, frame, CraigBampton(MODES), derivatives=NoDerivatives(), loads=NoLoads)


def cards_of_grids(beam, cd=""):
    places = dict(zip((ROOT, TIP), beam.grids, strict=True))
    return [
        f"GRID,{grid},,{x!r},{y!r},{z!r},{cd}"
        for grid, (x, y, z) in places.items()
        for x, y, z in [(float(x), float(y), float(z))]
    ]


def write_dmig(path, labels, **matrices):
    rows = []
    for name, matrix in matrices.items():
        rows.append(f"DMIG,{name},0,6,2,0")
        for j in range(len(labels)):
            rows.append(f"DMIG*   {name:<16}{labels[j][0]:16d}{labels[j][1]:16d}")
            rows += [
                f"*,{labels[i][0]},{labels[i][1]},{matrix[i, j]:.16E}".replace("E", "D")
                for i in range(j, len(labels))
                if matrix[i, j]
            ]
    path.write_text("\n".join([*rows, ""]))


MIXED = np.random.default_rng(1).permutation(12 + MODES)


def files_of(form, folder, beam, labels):
    """Arguments of `read_labelled_superelement`, for files in mixed order of freedoms."""
    K, M = (matrix[np.ix_(MIXED, MIXED)] for matrix in (beam.stiffness, beam.mass))
    bdf = folder / "arm.bdf"
    if form == "dmig":
        bdf.write_text("\n".join(cards_of_grids(beam)))
        write_dmig(folder / "arm.pch", labels[MIXED], KAAX=K, MAAX=M)
        return {"nodes": bdf, "stiffness": folder / "arm.pch", "mass": folder / "arm.pch"}
    if form == "hdf5":
        write_condensed_hdf5(folder / "arm.h5", beam, MIXED)
        return dict.fromkeys(("nodes", "stiffness", "mass"), folder / "arm.h5")
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    order = np.lexsort((labels[:, 1], labels[:, 0]))  # Nastran's, by ids
    cards = [f"SPOINT,{POINTS[0]}", "SPOINT,1003,THRU,1009", "BSET1,123456,10,THRU,20"]
    cards.append("QSET1,0," + ",".join(map(str, POINTS)))
    bdf.write_text("\n".join([*cards_of_grids(beam), *cards]))
    op4.write(
        str(folder / "arm.op4"),
        {"KAA": beam.stiffness[np.ix_(order, order)], "MAA": beam.mass[np.ix_(order, order)]},
    )
    return {"nodes": bdf, "stiffness": folder / "arm.op4", "mass": folder / "arm.op4"}


@pytest.mark.parametrize("form", ["dmig", "hdf5", pytest.param("op4", marks=pytest.mark.slow)])
def test_every_form_gives_the_reduced_body(form, tmp_path, beam, labels, ours):
    """Frequencies, motions of the interfaces and inertia are those of the reduction made here."""
    body = read_labelled_superelement("arm", MatrixFiles(**files_of(form, tmp_path, beam, labels)))
    assert body.n_modal == MODES
    assert {each.name for each in body.interfaces} == {f"grid_{ROOT}", f"grid_{TIP}"}
    body = read_labelled_superelement(
        "arm",
        MatrixFiles(**files_of(form, tmp_path, beam, labels)),
        interfaces=[RigidInterface("root", [body.interface(f"grid_{ROOT}").node_ids[0]])],
    )
    found = as_reduced(body)
    np.testing.assert_allclose(found.frequencies, ours.frequencies, rtol=1e-9)
    assert found.mass == pytest.approx(ours.mass, rel=1e-12)
    np.testing.assert_allclose(found.centre_of_mass, ours.centre_of_mass, atol=1e-9)
    np.testing.assert_allclose(found.gram[:6, :6], ours.gram[:6, :6], atol=1e-6 * ours.mass)


def test_a_clamped_beam_bends_at_its_closed_form(beam):
    """omega = (1.8751 / L)^2 sqrt(EI / m), less some of shear and rotary inertia."""
    body = superelement("arm", beam.grids, beam.stiffness, beam.mass, dofs_per_node=6, interfaces=ENDS)
    held = body.interface("root").motion
    lowest = np.sqrt(body.lowest_modes(1, held).values[0])
    width, height, length = 0.1, 0.3, 4.0
    slender = (1.875104 / length) ** 2 * np.sqrt(7e10 * width**2 / 12 / 2700.0)
    assert lowest == pytest.approx(slender, rel=2e-3)
    assert body.mass[:6, :6].sum() != 0
    R = body.rigid_modes
    assert (R.T @ body.mass @ R)[0, 0] == pytest.approx(2700 * width * height * length)
    assert not R[-MODES:].any()


def test_grids_in_coordinate_systems_of_their_own(tmp_path, beam, labels, ours):
    """CD rotates the freedoms of the matrices, not the modal coordinates."""
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # columns: local axes
    whole = np.eye(12 + MODES)
    for first in range(0, 12, 3):
        whole[first : first + 3, first : first + 3] = turn
    K, M = (whole.T @ matrix @ whole for matrix in (beam.stiffness, beam.mass))
    (tmp_path / "arm.bdf").write_text(
        "\n".join(["CORD2R,7,,0.,0.,0.,0.,0.,1.,+", "+,0.,1.,0.", *cards_of_grids(beam, "7")])
    )
    write_dmig(tmp_path / "arm.pch", labels, KAAX=K, MAAX=M)
    found = read_labelled_superelement(
        "arm", MatrixFiles(tmp_path / "arm.bdf", tmp_path / "arm.pch", tmp_path / "arm.pch")
    )
    np.testing.assert_allclose(found.stiffness.toarray(), beam.stiffness, atol=1e-9 * beam.stiffness.max())
    np.testing.assert_allclose(found.mass.toarray(), beam.mass, atol=1e-9 * beam.mass.max())


def test_modal_coordinates_that_grids_bear(tmp_path, beam, labels):
    """QSET1 on GRID points: their places mean nothing. Without the card they are nodes, which do not move."""
    borne = labels.copy()
    borne[12:] = [(77, component) for component in range(1, 7)]
    write_dmig(tmp_path / "arm.pch", borne, KAAX=beam.stiffness, MAAX=beam.mass)
    cards = [*cards_of_grids(beam), "GRID,77,,9.,9.,9."]
    files = {"nodes": tmp_path / "arm.bdf", **dict.fromkeys(("stiffness", "mass"), tmp_path / "arm.pch")}
    files["nodes"].write_text("\n".join([*cards, "QSET1,123456,77"]))
    body = read_labelled_superelement("arm", MatrixFiles(**files))
    assert body.n_modal == MODES
    np.testing.assert_array_equal(body.nodes, beam.grids)

    files["nodes"].write_text("\n".join(cards))
    check = check_nodal_matrices(read_nodal_matrices(MatrixFiles(**files)))
    (found,) = [each for each in check.findings if each.what == "free of supports"]
    assert found.verdict is Verdict.REFUSED
    assert "most at node 77" in found.seen
    assert "list modal coordinates on grids in QSET" in found.remedy


def matrices_of(beam, labels, K=None, M=None, **table):
    nodes = NodeTable(
        "arm.bdf", np.array([ROOT, TIP])[: len(beam.grids)], table.pop("positions", beam.grids), **table
    )
    K, M = beam.stiffness if K is None else K, beam.mass if M is None else M
    return nodal_matrices(nodes, *(LabelledMatrix("arm.pch", csc_array(m), labels) for m in (K, M)))


def refused(matrices):
    check = check_nodal_matrices(matrices)
    return {f.what: f for f in check.findings if f.verdict is Verdict.REFUSED}


def test_a_sound_model_passes_every_gate(beam, labels, ours):
    check = check_nodal_matrices(matrices_of(beam, labels))
    assert [f for f in check.findings if f.verdict is not Verdict.OK] == []
    assert check.mass.mass == pytest.approx(ours.mass)
    assert check.n_zero_modes == 6
    assert (
        "pictures and sensors have only the boundary"
        in {f.what: f.seen for f in check.findings}["points inside"]
    )


def test_points_inside_are_checked(beam, labels):
    points, T, ids = inside(beam)
    matrices = replace(matrices_of(beam, labels), recovery=Recovery(points, ids, T))
    assert {f.what: f.seen for f in check_nodal_matrices(matrices).findings}["points inside"].startswith(
        "9, "
    )
    found = refused(replace(matrices, recovery=Recovery(points, ids, 2 * T)))["points inside"]
    assert "deviates from rigid motion by" in found.seen
    assert "absolute displacements" in found.remedy


def test_rotations_without_mass_pass_every_gate():
    """Positive semidefinite mass, stiff on its kernel: condensed, and named; vibrates as the pencil does."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1]])
    K, M = beam_matrices(points, EA=1e6, EI=1e3, GJ=1e3, mass_per_length=2.0)
    K, M = (block_diag(matrix.toarray(), value) for matrix, value in ((K, 4e4), (M, 1.0)))
    rows = [(grid, component) for grid in (1, 2, 3, 4) for component in range(1, 7)]
    labels = np.array([*rows, (9, 0)])
    nodes = NodeTable("arm.bdf", np.array([1, 2, 3, 4]), points)
    check = check_nodal_matrices(
        nodal_matrices(nodes, *(LabelledMatrix("arm.pch", csc_array(m), labels) for m in (K, M)))
    )
    assert check.is_accepted
    (found,) = [each for each in check.findings if each.what == "positive mass"]
    assert "the motions without mass, at nodes 1, 2, 3, 4, follow the others statically" in found.seen
    shift = 100.0
    mu = linalg.eigh(M, K + shift * M, eigvals_only=True)[::-1]
    exact = np.sqrt(np.sort(1 / mu[6:12] - shift)) / (2 * np.pi)
    np.testing.assert_allclose(check.frequencies, exact, rtol=1e-6)
    body = superelement("arm", points, K, M, dofs_per_node=6)
    reduced = reduce(body, MeanAxisFrame(), CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads)
    np.testing.assert_allclose(reduced.frequencies[:6] / (2 * np.pi), exact, rtol=1e-6)


@pytest.mark.parametrize("rounding", ["none", "of the condensation", "of a large model"])
def test_one_boundary_grid(rounding):
    """A payload on one grid: K is zero in its rows, or the rounding of what cancels in them."""
    beam = condensed_beam(MODES, boundary=(0,))
    K, M, own = beam.stiffness.copy(), beam.mass, np.arange(6 + MODES) < 6
    lowest = K[6, 6] / M[6, 6]
    if rounding == "none":
        K[own] = K[:, own] = 0.0
    elif rounding == "of a large model":
        noise = np.random.default_rng(4).standard_normal(K.shape)
        size = np.sqrt(np.where(own, lowest * np.diag(M), np.diag(K)))
        K += 1e-7 * np.where(own | own[:, None], (noise + noise.T) * np.outer(size, size), 0.0)
    labels = np.array([(ROOT, each) for each in range(1, 7)] + [(point, 0) for point in POINTS[:MODES]])
    matrices = matrices_of(beam, labels, K=K)
    assert refused(matrices) == {}
    damping = 1e-3 * K
    root = [RigidInterface("root", [0])]
    body = superelement("arm", beam.grids, K, M, dofs_per_node=6, interfaces=root, damping=damping)
    clamped = np.sqrt(np.diag(beam.stiffness)[6:] / np.diag(M)[6:])
    np.testing.assert_allclose(as_reduced(body).frequencies, clamped, rtol=1e-9)
    free = linalg.eigvalsh(np.where(own | own[:, None], 0.0, K), M)[6:]
    machine = System(
        [reduce(body, MeanAxisFrame(), CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads)]
    )
    modes = machine_modes(linearize(machine, fulls=()))
    expected = np.sqrt(free * (1 - 0.25e-6 * free))  # with the damping 1e-3 K
    np.testing.assert_allclose(modes.frequencies[6:9], expected[:3], rtol=1e-9)
    K[2, 2] += 1e-3 * lowest * M[2, 2]
    with pytest.raises(ModelError, match=r"its stiffness resists rigid motion: in translation along z"):
        superelement("arm", beam.grids, K, M, dofs_per_node=6, interfaces=root)


@pytest.mark.parametrize("block", ["whole", "modal", "one"])
def test_a_wrong_sign_is_refused(beam, labels, block):
    K = beam.stiffness.copy()
    if block == "whole":
        K = -K
    elif block == "modal":
        K[12:, 12:] *= -1
    else:
        K[1, 7], K[7, 1] = -K[1, 7], -K[7, 1]
    found = refused(matrices_of(beam, labels, K=K))
    wanted = {"whole": "modal coordinates", "modal": "modal coordinates", "one": "free of supports"}[block]
    assert wanted in found
    with pytest.raises(ModelError):
        superelement("arm", beam.grids, K, beam.mass, dofs_per_node=6)


def test_the_worst_freedom_is_named(beam, labels):
    K = beam.stiffness.copy()
    K[13, 13] *= 1.0
    K[8, 8] *= 1.01
    found = refused(matrices_of(beam, labels, K=K))["free of supports"]
    assert f"most at node {TIP} uz" in found.seen
    K = beam.stiffness.copy()
    K[14, 2] = K[2, 14] = 1e-3 * K[2, 2]
    found = refused(matrices_of(beam, labels, K=K))["free of supports"]
    assert "most at modal coordinate 3" in found.seen


def test_nodes_in_another_unit_than_the_matrices(beam, labels):
    found = refused(matrices_of(beam, labels, positions=1000 * beam.grids))["free of supports"]
    assert "all would cancel if the coordinates were 0.001 times as large" in found.seen
    assert "different units of length" in found.remedy


def test_a_mass_without_its_rigid_part(beam, labels):
    """The mass of the modes alone."""
    M = beam.mass.copy()
    M[:12] = M[:, :12] = 0.0
    found = refused(matrices_of(beam, labels, M=M))["mass"]
    assert "not of the modes alone" in found.remedy


def test_a_model_that_was_held_at_its_boundary(beam, labels):
    held = np.zeros(12 + MODES)
    held[12:] = 1.0
    with pytest.raises(
        ModelError, match=r"6 modal coordinates, and no freedom of a node: .* Condense it again"
    ):
        matrices_of(beam, labels, *(m * np.outer(held, held) for m in (beam.stiffness, beam.mass)))


@pytest.mark.slow
def test_a_missing_qset_is_asked_for(tmp_path, beam, labels):
    files = files_of("op4", tmp_path, beam, labels)
    lines = [line for line in files["nodes"].read_text().split("\n") if "QSET" not in line]
    files["nodes"].write_text("\n".join(line for line in lines if "SPOINT" not in line))
    with pytest.raises(
        ImportFormatError, match=r"if the 6 further rows are modal coordinates, name them by QSET1 and SPOINT"
    ):
        read_labelled_superelement("arm", MatrixFiles(**files))


def test_a_component_of_a_scalar_point(tmp_path, beam, labels):
    files = files_of("op4", tmp_path, beam, labels)
    files["nodes"].write_text(files["nodes"].read_text() + "\nQSET1,1,1001\n")
    with pytest.raises(ImportFormatError, match=r"QSET1: scalar point 1001 has no component '1'"):
        read_labelled_superelement("arm", MatrixFiles(**files))
    files["nodes"].write_text(files["nodes"].read_text().replace("QSET1,1,1001", "QSET1,1,5001"))
    with pytest.raises(ImportFormatError, match="names 5001, which is no GRID or SPOINT of the file"):
        read_labelled_superelement("arm", MatrixFiles(**files))


@pytest.mark.parametrize("form", ["hdf5", pytest.param("op4", marks=pytest.mark.slow), "python"])
def test_recovered_points_are_nodes(form, tmp_path, beam, labels, ours):
    """Displacements in the first modes are those of the whole beam's reduction."""
    points, T, ids = inside(beam)
    if form == "python":
        body = superelement(
            *("arm", beam.grids, beam.stiffness, beam.mass),
            dofs_per_node=6,
            interfaces=ENDS,
            recovery=Recovery(points, ids, T),
        )
    elif form == "hdf5":
        write_condensed_hdf5(tmp_path / "arm.h5", beam, MIXED)
        path = tmp_path / "arm.h5"
        body = read_labelled_superelement(
            "arm", MatrixFiles(nodes=path, stiffness=path, mass=path, recovery=path)
        )
    else:
        files = files_of("op4", tmp_path, beam, labels)
        grids = [f"GRID,{i},,{float(x[0])!r},0.,0." for i, x in zip(ids, points, strict=True)]
        files["nodes"].write_text(
            "\n".join([files["nodes"].read_text().replace("10,THRU,20", "10,20"), *grids])
        )
        order = np.lexsort((labels[:, 1], labels[:, 0]))
        from pyyeti.nastran import op4

        op4.write(str(tmp_path / "otm.op4"), {"OTM": T[:, order]})
        body = read_labelled_superelement(
            "arm",
            MatrixFiles(**files, recovery=tmp_path / "otm.op4", recovery_name="OTM"),
            interfaces=[RigidInterface("root", [0])],
        )
    assert len(body.nodes) == 2 + len(points)
    found = as_reduced(body)
    by_node = {tuple(x): i for i, x in enumerate(ours.nodes.tolist())}
    rows = [by_node[tuple(x)] for x in found.nodes.tolist()]
    for mode in range(4):
        one, other = found.displacement_basis[:, :, mode], ours.displacement_basis[rows, :, mode]
        np.testing.assert_allclose(np.abs(one), np.abs(other), atol=1e-6 * np.abs(other).max())


def test_recovered_points_tell_how_modal_coordinates_turn(beam, ours):
    """Centrifugal and Coriolis terms of a spin at a third of the lowest frequency, with and without them."""
    points, T, ids = inside(beam)
    given = (beam.grids, beam.stiffness, beam.mass)
    options = {"dofs_per_node": 6, "interfaces": ENDS}
    bodies = [
        as_reduced(superelement("beams", *given, **options, recovery=recovery))
        for recovery in (None, Recovery(points, ids, T), Recovery(points[:3], ids[:3], T[:9]))
    ]

    def frequencies(body):
        machine = System([body], [Fixed(first=GROUND, second=At("beams", "root"))])
        return machine_modes(linearize(machine, spin=Spin(axis=(0, 0, 1), rate=9.6), fulls=()), 4).frequencies

    exact = frequencies(ours)
    without, with_points, with_few = (np.abs(frequencies(body) / exact - 1).max() for body in bodies)
    assert with_points < 3e-5
    assert 1e-3 < without < 5e-3
    assert with_few == pytest.approx(without)  # whose masses are not those of the body


def test_a_recovery_matrix_that_misses_rigid_motion(beam):
    points, T, ids = inside(beam)
    relative = T.copy()
    relative[:, :12] = 0.0
    with pytest.raises(
        ModelError, match=r"deviates from rigid motion by .* at point 109 uy; it needs absolute"
    ):
        superelement(
            *("arm", beam.grids, beam.stiffness, beam.mass),
            dofs_per_node=6,
            recovery=Recovery(points, ids, relative),
        )
    with pytest.raises(ModelError, match=r"has shape \(27, 17\); 9 points and 18 freedoms need \(27, 18\)"):
        superelement(
            *("arm", beam.grids, beam.stiffness, beam.mass),
            dofs_per_node=6,
            recovery=Recovery(points, ids, T[:, 1:]),
        )


def test_a_damping_matrix_is_that_of_the_body(tmp_path, beam, labels):
    """beta K as a file is Rayleigh's damping by beta, reduced and in full; drag is rejected."""
    beta = 0.01
    (tmp_path / "arm.bdf").write_text("\n".join(cards_of_grids(beam)))
    write_dmig(tmp_path / "arm.pch", labels, KAAX=beam.stiffness, MAAX=beam.mass, BAAX=beta * beam.stiffness)
    files = dict.fromkeys(("stiffness", "mass", "damping"), tmp_path / "arm.pch")
    body = read_labelled_superelement("arm", MatrixFiles(nodes=tmp_path / "arm.bdf", **files))
    frame = NodalFixedFrame(f"grid_{ROOT}")
    plain = replace(body, damping=None)
    one = reduce(body, frame, CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads)
    other = reduce(
        plain,
        frame,
        CompleteBasis(),
        derivatives=NoDerivatives(),
        loads=NoLoads,
        damping=RayleighDamping(0, beta),
    )
    np.testing.assert_allclose(one.damping, other.damping, atol=1e-9 * np.abs(other.damping).max())
    whole = full_damping(FullBody(body, frame)).constant
    assert abs(whole - beta * body.stiffness).max() < 1e-12 * abs(body.stiffness).max()
    drag = beta * beam.stiffness + np.eye(12 + MODES)
    with pytest.raises(ModelError, match="its damping resists rigid motion"):
        superelement("arm", beam.grids, beam.stiffness, beam.mass, dofs_per_node=6, damping=drag)
    broken = beam.stiffness.copy()
    broken[-1, -1] = np.nan
    with pytest.raises(ModelError, match=f"finite in the row of modal coordinate {MODES}$"):
        superelement("arm", beam.grids, beam.stiffness, beam.mass, dofs_per_node=6, damping=broken)
    with pytest.raises(ModelError, match=f"6 freedoms each and {MODES} modal coordinates need"):
        superelement("arm", beam.grids, beam.stiffness, beam.mass[1:, 1:], dofs_per_node=6)


def test_the_mean_axis_frame_carries_no_momentum(beam):
    body = superelement("arm", beam.grids, beam.stiffness, beam.mass, dofs_per_node=6, interfaces=ENDS)
    reduced = reduce(body, MeanAxisFrame(), CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads)
    assert abs(reduced.gram[:6, -reduced.r :]).max() < 1e-6
