"""From body to reduced body: identities, exactness of a complete basis, and the value of derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import (
    MeanAxisFrame,
    ModalDamping,
    RayleighDamping,
    RigidInterface,
    flexible_body,
    inertia_gram,
)
from supple.errors import AccuracyError, LockingWarning, ModelError, ValidityWarning
from supple.fem import HomogeneousSection, Isotropic, shear_share, shell_model, solid_model
from supple.mesh import CellType, block, strip
from supple.reduction import (
    CompleteBasis,
    CompressedDerivatives,
    CondensedQuartic,
    CraigBampton,
    ModalVirtualWork,
    NoDerivatives,
    NoLoads,
    NormalModes,
    PickedDerivatives,
    PlainQuartic,
    Rubin,
    reduce,
)
from supple.reduction.bases import linear_basis


@pytest.fixture(scope="module")
def tiny_body():
    model = solid_model(block(1.0, 0.3, 0.3, 2, 1, 1, CellType.TETRA4), Isotropic(1e6, 0.3, 1000.0))
    return flexible_body("tiny", model, (RigidInterface("root", "root"),))


@pytest.mark.parametrize("recipe", [CraigBampton(n_modes=4), Rubin(n_modes=4)])
@pytest.mark.parametrize("derivatives", [PickedDerivatives(5), CompressedDerivatives(5)])
def test_columns_are_orthonormal_and_at_rest_in_the_frame(solid_body, frame, recipe, derivatives):
    """V^T M V = I in nodal space, D V = 0."""
    reduced = reduce(solid_body, frame, recipe, derivatives=derivatives, loads=NoLoads)
    V = reduced.nodal_basis
    np.testing.assert_allclose(V.T @ (solid_body.nodal_mass @ V), np.eye(reduced.r), atol=1e-9)
    D, columns = frame.constraint(solid_body), _coordinates(solid_body, reduced)
    lengths = np.linalg.norm(D, axis=1)[:, None] * np.linalg.norm(columns, axis=0)
    assert (np.abs(D @ columns) < 1e-10 * lengths).all()


STEPS = {"linear basis", "derivatives", "inertia", "tensors", "condensation", "locking"}


def test_mean_axis_columns_carry_no_momentum(solid_body, mean_axis):
    """S V = 0 with S = R^T M: the blocks of the Gram matrix that couple rigid motion and V vanish."""
    reduced = reduce(
        solid_body, mean_axis, Rubin(n_modes=4), derivatives=CompressedDerivatives(5), loads=NoLoads
    )
    mass = reduced.gram[0, 0]
    coupling = reduced.gram[:6, -reduced.r :]
    assert np.abs(coupling).max() < 1e-9 * np.sqrt(mass)


def test_held_interface_does_not_move(solid_body, root_frame):
    reduced = reduce(
        solid_body, root_frame, Rubin(n_modes=4), derivatives=CompressedDerivatives(5), loads=NoLoads
    )
    assert np.abs(reduced.interface("root").motion).max() < 1e-12 * np.abs(reduced.nodal_basis).max()
    tip = solid_body.interface("tip").node_ids
    mean = reduced.displacement_basis[tip].mean(axis=0)
    np.testing.assert_allclose(reduced.interface("tip").motion[:3], mean, atol=1e-9 * np.abs(mean).max())


def test_complete_basis_is_the_full_body(tiny_body, frame):
    """Energy, force and inertia of any motion in the frame, in other coordinates."""
    reduced = reduce(tiny_body, frame, CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads)
    assert reduced.r == tiny_body.n - 6
    gamma = 1e-1 * np.random.default_rng(0).standard_normal(reduced.r)
    q = np.linalg.lstsq(tiny_body.expansion.toarray(), reduced.nodal_basis @ gamma, rcond=None)[0]
    np.testing.assert_allclose(reduced.tensors.energy(gamma), tiny_body.assembly.energy(q), rtol=1e-10)
    force = tiny_body.assembly.internal_force(q)
    D = frame.constraint(tiny_body)
    back = tiny_body.mass @ _coordinates(tiny_body, reduced) @ reduced.tensors.internal_force(gamma)
    difference = force - back
    reaction = D.T @ np.linalg.lstsq(D.T, difference, rcond=None)[0]
    np.testing.assert_allclose(difference, reaction, atol=1e-9 * np.abs(force).max())


def _coordinates(body, reduced):
    return np.linalg.lstsq(body.expansion.toarray(), reduced.nodal_basis, rcond=None)[0]


def test_derivatives_free_the_strip_to_shorten(cantilever, root_frame, nonlinear_static):
    """A tip load that bends the strip by a twentieth of its length: linear columns alone lock in tension.

    With plain tensors, that is; condensed ones need no derivatives for it. Columns that only bend miss
    the elastica's stiffening, of the deflection a share 2 int w''^2 w'^2 / int w''^2; w' = theta (1 - s^2).
    """
    share = 0.05
    exact, deflection = _tip_load(cantilever, root_frame, nonlinear_static, share)
    with pytest.warns(LockingWarning, match="body 'strip' locks"):
        assert abs(deflection(NoDerivatives(), PlainQuartic()) / exact - 1) > 0.3
    for derivatives in (PickedDerivatives(6), CompressedDerivatives(6)):
        with pytest.warns(LockingWarning, match="under angular acceleration x"):
            assert abs(deflection(derivatives, PlainQuartic()) / exact - 1) < 0.01
        assert abs(deflection(derivatives, CondensedQuartic()) / exact - 1) < 0.001
    stiffening = 2 * (1 / 3 - 2 / 5 + 1 / 7) / (1 / 3) * (1.5 * share) ** 2
    assert abs(deflection(NoDerivatives(), CondensedQuartic()) * (1 - stiffening) / exact - 1) < 0.001


@pytest.mark.slow
def test_what_derivatives_leave_of_locking_is_of_fourth_order(cantilever, root_frame, nonlinear_static):
    """They shorten to second order: motion of third order is missing, and membranes resist it by theta^6."""
    locking_loss = []
    for share in (0.05, 0.1):
        _, deflection = _tip_load(cantilever, root_frame, nonlinear_static, share)
        free = deflection(CompressedDerivatives(6), CondensedQuartic())
        with pytest.warns(LockingWarning, match="under angular acceleration x"):
            locking_loss.append(1 - deflection(CompressedDerivatives(6), PlainQuartic()) / free)
    assert np.log2(locking_loss[1] / locking_loss[0]) == pytest.approx(4, abs=0.3)


def _tip_load(body, frame, nonlinear_static, share):
    """Deflection under a tip load that bends a strip by a share of its length: full, and as reduced."""
    tip = np.argmax(body.nodes[:, 0])
    nodal_load = np.zeros(body.n_nodal)
    nodal_load[6 * tip + 2] = share * 3 * 1.4e4 / 10.0**2
    full = body.expansion @ nonlinear_static(body, frame.constraint(body), body.expansion.T @ nodal_load)

    def deflection(derivatives, quartic):
        reduced = reduce(body, frame, NormalModes(6), derivatives=derivatives, quartic=quartic, loads=NoLoads)
        gamma = np.zeros(reduced.r)
        for _ in range(40):
            residual = reduced.tensors.internal_force(gamma) - reduced.nodal_basis.T @ nodal_load
            gamma -= np.linalg.solve(reduced.tensors.tangent(gamma), residual)
        return reduced.expand(gamma)[tip, 2]

    return full[6 * tip + 2], deflection


def test_frequencies_are_those_of_the_reduced_pair(solid_body, frame):
    reduced = reduce(solid_body, frame, Rubin(n_modes=3), derivatives=CompressedDerivatives(4), loads=NoLoads)
    np.testing.assert_allclose(reduced.frequencies**2, np.linalg.eigvalsh(reduced.stiffness), rtol=1e-12)


def test_inertia_is_the_bodys_gram_matrix(solid_body, mean_axis):
    reduced = reduce(solid_body, mean_axis, NormalModes(3), derivatives=NoDerivatives(), loads=NoLoads)
    V = _coordinates(solid_body, reduced)
    np.testing.assert_allclose(
        reduced.gram, inertia_gram(solid_body, V), atol=1e-10 * np.abs(reduced.gram).max()
    )


def test_rayleigh_damping_acts_on_reduced_matrices(solid_body, root_frame):
    damping = RayleighDamping(alpha=0.3, beta=1e-4)
    reduced = reduce(
        solid_body,
        root_frame,
        NormalModes(3),
        derivatives=CompressedDerivatives(2),
        damping=damping,
        loads=NoLoads,
    )
    np.testing.assert_allclose(reduced.damping, 0.3 * np.eye(5) + 1e-4 * reduced.stiffness, rtol=1e-12)


def test_modal_damping_gives_each_reduced_mode_its_ratio(solid_body, root_frame):
    reduced = reduce(
        solid_body,
        root_frame,
        NormalModes(3),
        derivatives=CompressedDerivatives(2),
        damping=ModalDamping(0.02),
        loads=NoLoads,
    )
    squares, modes = np.linalg.eigh(reduced.stiffness)
    np.testing.assert_allclose(
        modes.T @ reduced.damping @ modes,
        np.diag(2 * 0.02 * np.sqrt(squares)),
        atol=1e-9 * np.sqrt(squares.max()),
    )


def test_report_tells_what_was_kept_dropped_and_what_it_cost(solid_body, root_frame):
    reduced = reduce(
        solid_body, root_frame, Rubin(n_modes=3), derivatives=CompressedDerivatives(4), loads=NoLoads
    )
    report = reduced.report
    assert len(report.linear) == 6 + 3
    assert len(report.derivatives) == 4
    assert report.linear[0] == "attachment tip ux"
    assert report.dropped[:2] == ("attachment root ux", "attachment root uy")
    assert len(report.singular_values_kept) == 4
    assert report.singular_values_kept[0] == 1.0
    assert report.singular_values_dropped[0] <= report.singular_values_kept[-1]
    assert set(report.seconds) == STEPS


def test_size_is_linear_plus_derivative_columns(cantilever, frame):
    """[Wu2019] Table 1: 10 + 10."""
    picked = PickedDerivatives(10, criterion=ModalVirtualWork())
    assert reduce(cantilever, frame, Rubin(n_columns=10), derivatives=picked, loads=NoLoads).r == 20


def test_superelement_has_no_tensors(solid_body, frame):
    reduced = reduce(
        solid_body.linearized(), frame, Rubin(n_modes=3), derivatives=NoDerivatives(), loads=NoLoads
    )
    assert reduced.is_linear
    assert reduced.cubic is None


def test_superelement_asked_for_derivatives_is_refused(solid_body, frame):
    with pytest.raises(ModelError, match="body 'block' has no quadratic strains"):
        reduce(
            solid_body.linearized(),
            frame,
            Rubin(n_modes=3),
            derivatives=CompressedDerivatives(4),
            loads=NoLoads,
        )


def test_basis_that_leaves_its_frame_is_caught(solid_body, root_frame, monkeypatch):
    monkeypatch.setattr(linear_basis, "frame_projector", lambda body, frame: lambda x: x)
    with pytest.raises(AccuracyError, match="the basis of body 'block' moves relative to its frame by"):
        reduce(solid_body, root_frame, _MeanAxisModes(), derivatives=NoDerivatives(), loads=NoLoads)


class _MeanAxisModes:
    """Modes of another frame than the one asked for."""

    def build(self, body, frame):
        return NormalModes(2).build(body, MeanAxisFrame())


def test_mass_that_disagrees_with_the_nodal_mass_is_caught(solid_body, root_frame):
    doubled = replace(solid_body, nodal_mass=2.0 * solid_body.nodal_mass)
    with pytest.raises(
        AccuracyError, match=r"the inertia Gram matrix of body 'block' violates V\^T M V = I by"
    ):
        reduce(doubled, root_frame, NormalModes(2), derivatives=NoDerivatives(), loads=NoLoads)


def test_walls_that_should_shear_are_named_with_their_share():
    """A strip ten times as long as thick: 1 - (omega_shear / omega)^2 of its first mode, to first order.

    At free edges the share is too high: there a wall that shears has less than the forces of a rigid one.
    """
    wall = HomogeneousSection(Isotropic(7e10, 0.3, 2700.0), 0.1)
    mesh = strip(1.0, 0.2, 12, 2)
    body = flexible_body("thick", shell_model(mesh, wall))
    with pytest.warns(ValidityWarning, match="body 'thick': its walls are rigid in transverse shear"):
        rigid = reduce(body, MeanAxisFrame(), NormalModes(3), derivatives=NoDerivatives(), loads=NoLoads)
    shearing = flexible_body("thick", shell_model(mesh, replace(wall, shear_factor=5 / 6)))
    found = reduce(shearing, MeanAxisFrame(), NormalModes(3), derivatives=NoDerivatives(), loads=NoLoads)
    fallen = 1 - (found.frequencies[0] / rigid.frequencies[0]) ** 2
    share = shear_share(body.model, rigid.nodal_basis[:, :1])[0]
    assert share == pytest.approx(fallen, rel=0.4)
