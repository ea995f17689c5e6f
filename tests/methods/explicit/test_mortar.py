"""Ties of meshes that do not match: patch tests both ways, the definition, averaging, refusals."""

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT

from supple.body import flexible_body
from supple.errors import ModelError
from supple.fem import solid_model
from supple.integrate import Run
from supple.machine import (
    At,
    Collocated,
    Mortar,
    Placed,
    System,
    Tie,
)
from supple.mesh import CellType, Mesh, block
from supple.mesh.outer_faces import outer_triangles
from supple.methods.explicit import (
    ExplicitEngine,
    explicit_subdomain,
    modal_subdomain,
)
from supple.reduction import NormalModes

FINE, COARSE = (2, 5, 3), (1, 2, 2)


def sides(fixed, tied, kind=CellType.TETRA4):
    """A mesh, points of another one on its face x = 4, and the triangles of these."""
    mesh = block(4, 1, 1, *fixed, kind)
    other = block(2, 1, 1, *tied, CellType.HEXA8)
    nodes = other.node_sets["root"]
    return mesh, other.nodes[nodes] + [4.0, 0, 0], np.searchsorted(nodes, outer_triangles(other, nodes))


def tributary(points, faces, n):
    """Int N_i dA (n,), of linear triangles."""
    u, v = (points[faces[:, i]] - points[faces[:, 0]] for i in (1, 2))
    areas = 0.5 * np.linalg.norm(np.cross(u, v), axis=1)
    return np.bincount(faces.ravel(), np.repeat(areas / 3, 3), minlength=n)


def followed(transfer, mesh, points, faces):
    """The weights as a matrix (n, N)."""
    corners, shares = transfer.weights(points, faces, mesh, 1e-6, "a tie")
    W = np.zeros((len(points), mesh.n_nodes))
    np.add.at(W, (np.arange(len(points))[:, None], corners), shares)
    return W


BOTH_WAYS = pytest.mark.parametrize(("fixed", "tied"), [(FINE, COARSE), (COARSE, FINE)])


@BOTH_WAYS
@pytest.mark.parametrize("kind", [CellType.TETRA4, CellType.HEXA8], ids=lambda kind: kind.name)
def test_linear_displacements_and_constant_tractions_pass(fixed, tied, kind):
    mesh, points, faces = sides(fixed, tied, kind)
    W = followed(Mortar(), mesh, points, faces)
    assert W.sum(axis=1) == pytest.approx(np.ones(len(points)), abs=1e-13)
    assert pytest.approx(points, abs=1e-13) == W @ mesh.nodes
    there = outer_triangles(mesh, mesh.node_sets["tip"])
    expected = tributary(mesh.nodes, there, mesh.n_nodes)
    assert W.T @ tributary(points, faces, len(points)) == pytest.approx(expected, abs=1e-14)


def test_collocation_hands_a_constant_traction_of_the_coarser_side_to_few_nodes():
    """What the mortar is for."""
    mesh, points, faces = sides(FINE, COARSE)
    W = followed(Collocated(), mesh, points, faces)
    assert pytest.approx(points, abs=1e-13) == W @ mesh.nodes
    expected = tributary(mesh.nodes, outer_triangles(mesh, mesh.node_sets["tip"]), mesh.n_nodes)
    assert np.abs(W.T @ tributary(points, faces, len(points)) - expected).max() > 0.5 * expected.max()


@pytest.mark.slow
def test_both_sides_are_equal_in_the_mean_over_dual_functions():
    """int psi_i (W u - u) dA = 0 for any u on the fixed side, by a quadrature of many points."""
    mesh, points, faces = sides(FINE, COARSE)
    W = followed(Mortar(), mesh, points, faces)
    u = np.random.default_rng(0).normal(size=mesh.n_nodes)
    m = 60
    a, b = np.divmod(np.arange(m * m), m)
    inside = a + b < m - 0.5
    s, t = (a[inside] + 1 / 3) / m, (b[inside] + 1 / 3) / m
    N = np.column_stack([1 - s - t, s, t])
    x = np.einsum("qc,fci->fqi", N, points[faces]).reshape(-1, 3)
    at = followed(Collocated(), mesh, x, np.zeros((0, 3), dtype=int)) @ u
    area = 0.5 * np.linalg.norm(
        np.cross(*(points[faces[:, i]] - points[faces[:, 0]] for i in (1, 2))), axis=1
    )
    apart = np.einsum("qc,fc->fq", N, (W @ u)[faces]) - at.reshape(len(faces), -1)
    psi = 4 * N - 1
    missed = np.zeros(len(points))
    np.add.at(missed, faces, np.einsum("qi,fq,f->fi", psi, apart, area / len(N)))
    assert np.abs(missed).max() < 1e-2 * np.abs(u).max() * area.max()


def test_on_a_mesh_that_matches_each_node_follows_its_own():
    mesh, points, faces = sides((2, 3, 3), (1, 3, 3), CellType.HEXA8)
    W = followed(Mortar(), mesh, points, faces)
    assert pytest.approx(followed(Collocated(), mesh, points, faces), abs=1e-12) == W


def test_a_checkerboard_of_the_finer_mesh_is_averaged():
    mesh, points, faces = sides((1, 8, 8), (1, 2, 2), CellType.HEXA8)
    u = np.cos(8 * np.pi * mesh.nodes[:, 1]) * np.cos(8 * np.pi * mesh.nodes[:, 2])
    assert np.abs(followed(Collocated(), mesh, points, faces) @ u).max() > 0.99
    assert np.abs(followed(Mortar(), mesh, points, faces) @ u).max() < 0.4


def test_a_tie_of_a_system_uses_it():
    """Affine motions of the modal nodes are those of the explicit ones that hang on them."""
    model = solid_model(block(4, 1, 1, *FINE, CellType.TETRA4), SOFT)
    body = modal_subdomain(flexible_body("modal", model), NormalModes(30))
    coarse = block(2, 1, 1, *COARSE, CellType.HEXA8)
    end = solid_model(Mesh(coarse.nodes + np.array([4.0, 0, 0]), coarse.cells, coarse.node_sets), SOFT)
    parts = [Placed(body), Placed(explicit_subdomain(end, name="end"))]
    tie = Tie(At("end", "root"), "modal", transfer=Mortar())
    built = ExplicitEngine(System(parts, ties=[tie]), Run(1.0, 1.0)).built
    arrays = built.model.frames[0]
    corners, shares = Mortar().weights(
        np.asarray(built.start.x).T[np.asarray(arrays.nodes)],
        np.searchsorted(coarse.node_sets["root"], outer_triangles(coarse, coarse.node_sets["root"])),
        model.mesh,
        1e-6,
        "a tie",
    )
    own = body.shapes @ built.frames["modal"].turned
    assert np.asarray(arrays.shapes) == pytest.approx(np.einsum("nc,ncik->nik", shares, own[corners]))
    tie = Tie(At("next", "root"), "end", transfer=Mortar())
    with pytest.raises(ModelError, match="a mortar tie needs a modal part"):
        ExplicitEngine(System([parts[1], explicit_subdomain(end, name="next")], ties=[tie]), Run(1.0, 1.0))


def test_faces_that_are_not_covered_and_nodes_without_faces_are_refused():
    mesh, points, faces = sides(FINE, COARSE)
    # A triangle of side 1/2 that stands on its corner, moved out by half its height: a quarter is left.
    with pytest.raises(ModelError, match=r"75 % of the face"):
        Mortar().weights(points + np.array([0.0, 0.25, 0.0]), faces, mesh, 1e-6, "a tie")
    with pytest.raises(ModelError, match="has no match on the other part"):
        Mortar().weights(points + np.array([0.1, 0.0, 0.0]), faces, mesh, 1e-6, "a tie")
    with pytest.raises(ModelError, match="is not a corner of an outer face"):
        Mortar().weights(points, faces[:2], mesh, 1e-6, "a tie")
