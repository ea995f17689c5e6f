"""The check of a model: good ones pass, and every way of being wrong is found, alone and with its remedy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import block_diag, csc_array, diags_array

from supple.algebra import lowest_modes
from supple.body import (
    MassProperties,
    Verdict,
    check_elements,
    check_model,
    check_nodal_matrices,
    mesh_mass_properties,
    nodal_matrices,
    stiff_cells,
)
from supple.errors import ModelError
from supple.fem import (
    HomogeneousSection,
    Isotropic,
    Section,
    finite_element_model,
    shell_model,
    solid_model,
)
from supple.importers import LabelledMatrix, NodeTable
from supple.mesh import CellType, Mesh, block


def refused(check):
    return {finding.what: finding for finding in check.findings if finding.verdict is Verdict.REFUSED}


@pytest.fixture(params=["shell", "solid"])
def model(request):
    return request.getfixturevalue(request.param)


def test_a_good_model_is_accepted_with_its_numbers(model):
    check = check_elements(model)
    assert check.is_accepted
    others = [finding for finding in check.findings if finding.what != "solid cells of first order"]
    assert all(finding.verdict is Verdict.OK and not finding.remedy for finding in others)
    assert check.n_zero_modes == 6
    assert check.rigid_energy.max() < 1e-12
    assert check.mass.mass == pytest.approx(mesh_mass_properties(model).mass)
    expected = np.sqrt(lowest_modes(model.stiffness, model.mass, 12).values[6:]) / (2 * np.pi)
    np.testing.assert_allclose(check.frequencies, expected, rtol=1e-6)
    check.raise_if_refused("arm")


def test_without_modes_it_is_cheap(model):
    check = check_elements(model, n_frequencies=0)
    assert check.is_accepted
    assert check.n_zero_modes is None
    assert check.frequencies == ()


def changed(model, *, K=None, M=None, **options):
    return check_model(
        model.mesh.nodes,
        model.stiffness if K is None else K,
        model.mass if M is None else M,
        dofs_per_node=model.dofs_per_node,
        **options,
    )


def entry(model, row, column, value):
    return csc_array(([value], ([row], [column])), shape=(model.n_dofs, model.n_dofs))


def test_an_unsymmetric_stiffness(model):
    K = model.stiffness + entry(model, 0, 1, 1e-3 * abs(model.stiffness).max())
    check = changed(model, K=K)
    assert "differs from its transpose by 1.0e-03" in refused(check)["symmetry of the stiffness"].seen
    assert check.frequencies == ()  # modes of an unsymmetric pair would mislead


def test_supports_and_where_they_are(model):
    ground = np.zeros(model.n_dofs)
    ground[model.dofs_per_node : model.dofs_per_node + 3] = 1e-3 * model.stiffness.diagonal().max()
    check = changed(
        model,
        K=csc_array(model.stiffness + diags_array(ground)),
        node_ids=100 + np.arange(model.mesh.n_nodes),
    )
    assert "most at node 101 u" in refused(check)["free of supports"].seen
    assert check.n_zero_modes == 3  # a ball joint
    assert refused(check)["modes without energy"].seen == "3 of 6"
    assert check.rigid_energy.max() > 1e-6


def test_a_mechanism_and_where_it_is(solid):
    """A mass on a node of its own, tied by nothing."""
    nodes = np.vstack([solid.mesh.nodes, [2.0, 0, 0]])
    K = csc_array(block_diag([solid.stiffness, np.zeros((3, 3))]))
    M = csc_array(block_diag([solid.mass, np.eye(3)]))
    check = check_model(nodes, K, M, dofs_per_node=3)
    assert check.n_zero_modes == 9
    assert (
        f"9 of 6; the further ones move most at node {solid.mesh.n_nodes} u"
        in refused(check)["modes without energy"].seen
    )


def test_a_freedom_without_mass_follows_the_others(shell):
    keep = np.ones(shell.n_dofs)
    keep[-1] = 0
    D = diags_array(keep)
    check = changed(shell, M=csc_array(D @ shell.mass @ D))
    assert check.is_accepted
    (found,) = (each for each in check.findings if each.what == "positive mass")
    last = shell.mesh.n_nodes - 1
    assert (
        f"all but 1 of {shell.n_dofs} eigenvalues; the motions without mass, at nodes {last}," in found.seen
    )


def test_a_node_with_neither_mass_nor_stiffness_is_refused(shell):
    keep = np.ones(shell.n_dofs)
    keep[-6:-3] = 0
    D = diags_array(keep)
    M, K = (csc_array(D @ matrix @ D) for matrix in (shell.mass, shell.stiffness))
    assert (
        "without mass are some without stiffness" in refused(changed(shell, M=M, K=K))["positive mass"].seen
    )


def test_a_mass_that_is_not_positive_definite(solid):
    pair = entry(solid, 0, 3, 1.0) + entry(solid, 3, 0, 1.0)
    found = refused(changed(solid, M=solid.mass + 2 * solid.mass.diagonal().max() * pair))
    assert "1 negative and 0 zero eigenvalues" in found["positive mass"].seen
    negative = refused(changed(solid, M=-solid.mass))
    assert negative["mass"].seen.startswith("-")


def test_a_stiffness_that_is_not_positive(solid):
    found = refused(changed(solid, K=-solid.stiffness))
    assert "strain energy cannot be negative" in found["lowest modes"].remedy


def test_three_masses(solid):
    M = csc_array(diags_array(np.tile([1.0, 1.0, 2.0], solid.mesh.n_nodes)))
    assert "a body has one positive mass" in refused(changed(solid, M=M))["mass"].remedy


def test_no_mass_at_all(shell):
    """As of a deck without a density."""
    massless = shell_model(shell.mesh, HomogeneousSection(Isotropic(2.1e11, 0.3, 0.0), 0.01))
    (found,) = refused(check_elements(massless)).values()
    assert (found.what, found.seen) == ("mass", "none")
    assert "give the materials a density" in found.remedy
    (found,) = refused(changed(shell, M=0 * shell.mass)).values()
    assert "export the mass matrix" in found.remedy


def test_an_inertia_that_no_body_has(shell):
    """Rotary inertia on one axis alone makes one moment larger than the other two together."""
    extra = np.tile([0.0, 0, 0, 0, 0, 10.0], shell.mesh.n_nodes)
    found = refused(changed(shell, M=csc_array(shell.mass + diags_array(extra))))
    assert "impossible for a mass distribution" in found["principal inertia"].remedy


def test_a_mass_other_than_that_of_the_mesh(solid):
    expected = mesh_mass_properties(solid)
    double = MassProperties(2 * expected.mass, expected.centre, 2 * expected.inertia)
    found = refused(changed(solid, mesh_mass=double))["difference from the mesh"]
    assert found.seen.startswith("mass 5e-01")
    assert "check density, thickness and units" in found.remedy


@pytest.mark.parametrize(
    ("length", "modulus", "density", "verdict"),
    [
        (1.0, 2.1e11, 7850.0, Verdict.OK),  # m, kg, s, Pa
        (1000.0, 2.1e5, 7.85e-9, Verdict.OK),  # mm, t, s, MPa
        (1.0, 1e6, 1000.0, Verdict.OK),  # rubber
        (1000.0, 2.1e2, 7.85e-6, Verdict.OK),  # mm, kg, ms, GPa
        (1.0, 2.1e5, 7850.0, Verdict.DOUBTFUL),  # MPa among SI
        (1.0, 2.1e11, 7.85e-9, Verdict.DOUBTFUL),  # t/mm^3 among SI
        (1000.0, 2.1e11, 7.85e-18, Verdict.REFUSED),
    ],
)
def test_units_that_cannot_be_right(length, modulus, density, verdict):
    mesh = block(length, 0.3 * length, 0.2 * length, 4, 2, 2, CellType.TETRA4)
    check = check_elements(solid_model(mesh, Isotropic(modulus, 0.3, density)), n_frequencies=0)
    (units,) = (finding for finding in check.findings if finding.what == "units")
    assert units.verdict is verdict
    assert check.is_accepted is (verdict is not Verdict.REFUSED)


@pytest.mark.parametrize("kind", [CellType.TETRA4, CellType.TETRA10, CellType.HEXA8])
@pytest.mark.parametrize(
    ("length", "modulus", "density", "of_steel"),
    [(1.0, 2.1e11, 7850.0, 2e4), (39.37, 3e7, 7.34e-4, 8e5), (1000.0, 2.1e5, 7.85e-9, 2e7)],
)
def test_the_waves_of_steel_are_those_the_line_names(kind, length, modulus, density, of_steel):
    """In m, inches and mm, within a factor of two; kilograms among mm and MPa are off by thirty."""
    mesh = block(length, 0.3 * length, 0.2 * length, 4, 2, 2, kind)
    check = check_elements(solid_model(mesh, Isotropic(modulus, 0.3, density)), n_frequencies=0)
    (units,) = (finding for finding in check.findings if finding.what == "units")
    speed = float(units.seen.split("about ")[1].split(" per")[0])
    assert of_steel / 2 < speed < 2 * of_steel
    named = [float(word) for word in units.seen.partition("in steel some")[2].split() if word[0].isdigit()]
    assert of_steel in named


def test_cells_that_lie_twice_are_doubtful(solid):
    mesh = solid.mesh
    cells = {kind: np.vstack([array, array[3:5]]) for kind, array in mesh.cells.items()}
    (kind,) = cells
    twice = solid_model(Mesh(mesh.nodes, cells), Isotropic(2.1e11, 0.3, 7850.0))
    (found,) = (
        f for f in check_elements(twice, n_frequencies=0).findings if f.what == "cells on the same nodes"
    )
    assert found.verdict is Verdict.DOUBTFUL
    assert found.seen == f"2 node groups with several {kind.name} cells, first at cell 3"


def test_linear_cells_on_quadratic_ones_are_doubtful():
    """Two tetrahedra that share a face, of which one has middle nodes: three edges come apart."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    middles = [(corners[a] + corners[b]) / 2 for a, b in CellType.TETRA10.edges]
    cells = {CellType.TETRA10: [[0, 1, 2, 3, *range(5, 11)]], CellType.TETRA4: [[1, 2, 3, 4]]}
    mesh = Mesh(np.vstack([corners, middles]), {kind: np.array(found) for kind, found in cells.items()})
    check = check_elements(solid_model(mesh, Isotropic(2.1e11, 0.3, 7850.0)), n_frequencies=0)
    (found,) = (f for f in check.findings if f.verdict is Verdict.DOUBTFUL)
    assert found.what == "linear cells on quadratic ones"
    assert found.seen.startswith("3 edges")
    assert found.seen.endswith("first at nodes 1 and 2")


@pytest.mark.parametrize(
    ("kind", "bends", "doubtful"),
    [
        (CellType.TETRA4, False, True),
        (CellType.HEXA8, False, True),
        (CellType.HEXA8, True, False),
        (CellType.HEXA20, False, False),
    ],
)
def test_solids_of_first_order_are_doubtful(kind, bends, doubtful):
    mesh = block(2, 1, 1, 2, 1, 1, kind)
    cells = np.arange(len(mesh.cells[kind]))
    model = finite_element_model(
        mesh, (Section(kind, cells, Isotropic(2.1e11, 0.3, 7850.0), incompatible=bends),)
    )
    found = [each for each in check_elements(model).findings if each.what == "solid cells of first order"]
    assert [each.verdict for each in found] == [Verdict.DOUBTFUL] * doubtful
    assert stiff_cells(model) == ({kind.name: len(cells)} if doubtful else {})


def test_entries_that_are_no_numbers(solid):
    K = solid.stiffness.copy()
    K.data[7] = np.nan
    assert list(refused(changed(solid, K=K))) == ["finite entries"]


def test_matrices_of_another_size(solid):
    with pytest.raises(
        ModelError, match=r"the mass has shape \(3, 3\), but its nodes need \(135, 135\), or more"
    ):
        changed(solid, M=np.eye(3))


def test_a_single_node_has_no_waves():
    check = check_model(np.zeros((1, 3)), np.zeros((3, 3)), np.eye(3), dofs_per_node=3, n_frequencies=0)
    assert any(finding.seen == "not checked: a single node has no size" for finding in check.findings)


def test_matrices_of_another_program_are_named_by_their_ids(solid):
    ids = 10 * np.arange(1, solid.mesh.n_nodes + 1)
    labels = np.column_stack([np.repeat(ids, 3), np.tile([1, 2, 3], len(ids))])
    K, M = (LabelledMatrix("arm.pch", matrix, labels) for matrix in (solid.stiffness, solid.mass))
    matrices = nodal_matrices(NodeTable("arm.bdf", ids, solid.mesh.nodes), K, M)
    assert check_nodal_matrices(matrices).is_accepted
    strict = check_nodal_matrices(matrices, rigid_tolerance=1e-30, n_frequencies=0)
    assert "raise rigid_tolerance above" in refused(strict)["free of supports"].remedy
    assert int(refused(strict)["free of supports"].seen.split("node ")[1].split()[0]) % 10 == 0


def test_the_error_lists_every_finding_that_refuses(solid):
    check = changed(solid, K=solid.stiffness + entry(solid, 0, 1, 1e12), M=-solid.mass)
    with pytest.raises(
        ModelError, match=r"(?s)body 'arm' cannot be used:.*symmetry of the stiffness.*positive mass"
    ):
        check.raise_if_refused("arm")
