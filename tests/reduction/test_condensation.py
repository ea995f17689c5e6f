"""Condensed quartic tensors: their definition, their energy, and what they are for."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body
from scipy import linalg
from scipy.optimize import minimize

from supple.body import MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.mesh import CellType, block, strip
from supple.reduction import (
    CompleteBasis,
    CompressedDerivatives,
    Condensation,
    CondensedQuartic,
    CraigBampton,
    InternalForceTensors,
    NoDerivatives,
    NormalModes,
    PlainQuartic,
    Rubin,
    condensation,
    enrich,
    internal_force_tensors,
    project,
    reduction_basis,
)

THICKNESS = 0.006**0.5


def strip_of(n_length: int, *interfaces: str):
    """The rotating beam of [Wu2019]; nu = 0, so that bending about z is inextensible."""
    material = Isotropic(2.8e7 / (THICKNESS * 0.5), 0.0, 1.2 / (THICKNESS * 0.5))
    model = shell_model(strip(10.0, 0.5, n_length, 2), HomogeneousSection(material, THICKNESS))
    return flexible_body("strip", model, [RigidInterface(name, name) for name in interfaces])


@pytest.fixture(scope="module")
def beam():
    return strip_of(12, "root")


@pytest.fixture(scope="module")
def link():
    return strip_of(8, "root", "tip")


@pytest.fixture(scope="module")
def bar():
    """A slender solid with an interface at either end."""
    model = solid_model(block(4.0, 0.3, 0.1, 8, 1, 1, CellType.HEXA20), Isotropic(1e7, 0.3, 1000.0))
    return flexible_body("bar", model, [RigidInterface("root", "root"), RigidInterface("tip", "tip")])


@pytest.fixture(scope="module")
def beams():
    return beam_body("root", "tip", n=8)


BASES = {
    "strip, mean-axis": ("beam", MeanAxisFrame(), Rubin(n_columns=10), CompressedDerivatives(10)),
    "strip, fixed": ("beam", NodalFixedFrame("root"), CraigBampton(n_modes=6), CompressedDerivatives(2)),
    "link, mean-axis": ("link", MeanAxisFrame(), CraigBampton(n_modes=4), NoDerivatives()),
    "link, modes alone": ("link", MeanAxisFrame(), NormalModes(4), NoDerivatives()),
    "beams, mean-axis": ("beams", MeanAxisFrame(), Rubin(n_modes=4), CompressedDerivatives(4)),
    "beams, fixed": ("beams", NodalFixedFrame("root"), CraigBampton(n_modes=4), NoDerivatives()),
    "solid, mean-axis": ("bar", MeanAxisFrame(), Rubin(n_modes=4), CompressedDerivatives(4)),
    "solid, fixed": ("bar", NodalFixedFrame("root"), CraigBampton(n_modes=4), NoDerivatives()),
}


@pytest.fixture(params=BASES)
def left_out(request):
    name, frame, recipe, derivatives = BASES[request.param]
    body = request.getfixturevalue(name)
    return Condensation(body, reduction_basis(body, frame, recipe, derivatives=derivatives))


def strain_forces(body, q):
    """sum w B^T D N(G q, G q), element by element with its virtual nodes, in the coordinates of the body."""
    u = body.force.expansion @ q
    total = np.zeros_like(u)
    for each in body.force.blocks:
        a = np.einsum("egdn,en->egd", each.G, u[each.dofs])
        N = np.broadcast_to(each.N, (*a.shape[:2], *each.N.shape[-3:]))
        strain = np.einsum("egsdf,egd,egf->egs", N, a, a)
        D = np.broadcast_to(each.D, (len(a), *each.D.shape[-2:]))
        force = np.einsum("eg,egsn,est,egt->en", each.w, each.B, D, strain)
        np.add.at(total, each.dofs, force)
    return body.force.expansion.T @ total


def least_energy(body, basis, gamma):
    """z and min over z of the energy, by Lagrange multipliers: K-orthogonal to V, interfaces at rest."""
    V, K = basis.vectors, body.stiffness.toarray()
    force = strain_forces(body, V @ gamma) / 2
    motion = np.vstack([interface.motion.toarray() for interface in body.interfaces])
    # Rigid motions store nothing; the frame chooses among them.
    free = linalg.null_space(motion)
    # Static shapes among the columns are K-orthogonal to motion with interfaces at rest: no condition.
    _, lengths, rows = np.linalg.svd(V.T @ K @ free / np.linalg.norm(V.T @ K, axis=1)[:, None], False)
    allowed = free @ linalg.null_space(rows[lengths > 1e-9])
    z = -allowed @ np.linalg.solve(allowed.T @ K @ allowed, allowed.T @ force)
    return z, z @ K @ z / 2 + z @ force


def test_energy_and_motion_are_those_of_the_least_energy_outside_the_columns(left_out):
    """The definition: one dense minimisation with multipliers."""
    body, basis = left_out.body, left_out.basis
    plain = internal_force_tensors(body, basis.vectors)
    condensed = plain.condensed(left_out.energy)
    rng = np.random.default_rng(0)
    for _ in range(3):
        gamma = rng.standard_normal(basis.r) / np.sqrt(np.diag(plain.stiffness))
        z, released = least_energy(body, basis, gamma)
        assert released < 0
        change = condensed.energy(gamma) - plain.energy(gamma)
        np.testing.assert_allclose(change, released, rtol=1e-6)
        found = left_out.bilinear(gamma[None], gamma[None])[:, 0]
        D, R = basis.frame.constraint(body), body.rigid_modes
        z = z - R @ np.linalg.solve(D @ R, D @ z)
        np.testing.assert_allclose(found, z, atol=1e-5 * np.abs(z).max())


def test_fields_at_the_nodes_are_the_same_motion(left_out):
    """But for the frame: there the interfaces rest, where joints have them."""
    kept, body = left_out.motion(), left_out.body
    rng = np.random.default_rng(1)
    stiffness = internal_force_tensors(left_out.body, left_out.basis.vectors).stiffness
    gamma = rng.standard_normal((4, left_out.basis.r)) / np.sqrt(np.diag(stiffness))
    z = left_out.bilinear(gamma, gamma)
    root = body.interfaces[0].motion
    at_rest = z - body.rigid_modes @ np.linalg.solve(root @ body.rigid_modes, root @ z)
    exact = body.expansion @ at_rest
    np.testing.assert_allclose(
        kept.fields @ kept.amplitudes_at(gamma).T, exact, atol=2e-3 * np.abs(exact).max()
    )


def test_motion_is_bilinear_and_symmetric(left_out):
    rng = np.random.default_rng(2)
    a, b, c = rng.standard_normal((3, 1, left_out.basis.r))
    both = left_out.bilinear(a, b)
    size = np.abs(both).max()
    np.testing.assert_allclose(both, left_out.bilinear(b, a), atol=1e-8 * size)
    np.testing.assert_allclose(
        left_out.bilinear(a + c, b), both + left_out.bilinear(c, b), atol=1e-8 * size * 10
    )


def test_motion_moves_no_interface_against_another(left_out):
    gamma = np.random.default_rng(3).standard_normal((1, left_out.basis.r))
    z = left_out.bilinear(gamma, gamma)[:, 0]
    interfaces = left_out.body.interfaces
    motion = np.vstack([interface.motion.toarray() for interface in interfaces])
    R = motion @ left_out.body.rigid_modes
    moved = motion @ z
    rigid = np.linalg.lstsq(R, moved, rcond=None)[0]
    assert np.abs(moved - R @ rigid).max() < 1e-8 * np.abs(z).max()


def test_condensed_energy_is_never_negative(left_out):
    """A minimum of squares: the fourth-order term over directions of unit energy, minimised."""
    plain = internal_force_tensors(left_out.body, left_out.basis.vectors)
    condensed = plain.condensed(left_out.energy)
    assert condensed.quartic is not None
    fourth = InternalForceTensors(
        np.zeros_like(plain.stiffness), np.zeros_like(plain.cubic), condensed.quartic
    )
    unit = np.linalg.inv(np.linalg.cholesky(plain.stiffness)).T
    rng = np.random.default_rng(4)
    samples = rng.standard_normal((200, plain.r))
    samples /= np.linalg.norm(samples, axis=1)[:, None]
    a4 = fourth.energy(samples @ unit.T)
    largest = a4.max()

    def value(x):
        u = x / np.linalg.norm(x)
        slope = unit.T @ fourth.internal_force(unit @ u)
        return fourth.energy(unit @ u) / largest, (slope - (slope @ u) * u) / np.linalg.norm(x) / largest

    lowest = [minimize(value, samples[i], jac=True, method="L-BFGS-B").fun for i in np.argsort(a4)[:3]]
    assert min(lowest) >= -1e-12


def test_blocks_of_pairs_give_the_same(beam, monkeypatch):
    basis = reduction_basis(beam, MeanAxisFrame(), Rubin(n_modes=6), derivatives=NoDerivatives())
    whole, motion = Condensation(beam, basis).energy, Condensation(beam, basis).motion()
    monkeypatch.setattr(condensation, "NUMBERS_AT_ONCE", 1)
    parts = Condensation(beam, basis)
    assert len(parts._blocks) > 2
    np.testing.assert_allclose(parts.energy, whole, atol=1e-9 * np.abs(whole).max())
    assert parts.motion().shape == motion.shape


def test_with_all_answers_among_the_columns_nothing_is_left_to_condense(beam):
    """R -> 0: on the pairs of the linear columns the tensor is the plain one."""
    frame = MeanAxisFrame()
    linear = reduction_basis(beam, frame, NormalModes(4), derivatives=NoDerivatives())
    unit = np.eye(linear.r)
    j, k = np.triu_indices(linear.r)
    answers = Condensation(beam, linear).bilinear(unit[j], unit[k])
    basis = enrich(beam, linear, answers, answers.shape[1]).basis
    plain, condensed = (
        project(beam, basis, quartic=quartic).quartic for quartic in (PlainQuartic(), CondensedQuartic())
    )
    first, second = np.triu_indices(basis.r)
    own = np.flatnonzero(second < linear.r)
    among = np.ix_(own, own)
    # The linear columns come first and stay as they are.
    np.testing.assert_array_equal(first[own] <= second[own], True)
    np.testing.assert_allclose(condensed[among], plain[among], atol=1e-8 * np.abs(plain[among]).max())
    assert np.abs(condensed - plain).max() > 1e-3 * np.abs(plain).max()


def test_a_complete_basis_leaves_nothing_out():
    model = solid_model(block(1.0, 0.3, 0.3, 2, 1, 1, CellType.TETRA4), Isotropic(1e6, 0.3, 1000.0))
    body = flexible_body("tiny", model, (RigidInterface("root", "root"),))
    basis = reduction_basis(body, MeanAxisFrame(), CompleteBasis(), derivatives=NoDerivatives())
    reduced = project(body, basis)
    plain = internal_force_tensors(body, basis.vectors)
    np.testing.assert_allclose(reduced.quartic, plain.quartic, atol=1e-10 * np.abs(plain.quartic).max())
    assert reduced.report.locking.largest_plain < 1e-8


def test_linear_bodies_have_nothing_to_condense(beam):
    linear = beam.linearized()
    basis = reduction_basis(linear, MeanAxisFrame(), Rubin(n_modes=3), derivatives=NoDerivatives())
    reduced = project(linear, basis)
    assert reduced.condensed is None
    assert reduced.report.locking is None


def test_condensed_motion_of_another_body_is_refused(beam):
    one, other = (
        project(beam, reduction_basis(beam, MeanAxisFrame(), Rubin(n_modes=n), derivatives=NoDerivatives()))
        for n in (2, 3)
    )
    with pytest.raises(ModelError, match="condensed motion of shape"):
        type(one)(**{**vars(one), "condensed": other.condensed})
