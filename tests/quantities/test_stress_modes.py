"""Stress modes: the stress of the unreduced body, at any node and time, from its reduced coordinates."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.body import MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import (
    VON_KARMAN,
    HomogeneousSection,
    Isotropic,
    LaminateSection,
    shell_model,
    solid_model,
    strain_recovery,
    stress_recovery,
    von_mises,
    von_mises_strain,
)
from supple.mesh import CellType, Mesh, block, box_beam, strip
from supple.quantities import strain_modes, stress_modes, tensor_modes
from supple.reduction import (
    CompressedDerivatives,
    Guyan,
    NoDerivatives,
    NoLoads,
    NormalModes,
    Rubin,
    reduce,
)

STEEL = Isotropic(youngs_modulus=2.1e11, poissons_ratio=0.3, density=7800.0)
ALLOY = Isotropic(youngs_modulus=7.0e10, poissons_ratio=0.35, density=2700.0)


def solid(cell_type=CellType.TETRA10):
    return solid_model(block(1.0, 0.2, 0.1, 6, 2, 1, cell_type), STEEL)


def shell():
    return shell_model(box_beam(1.0, 0.2, 0.1, 4, 2, 2), HomogeneousSection(STEEL, 0.004))


def flat():
    return shell_model(strip(1.0, 0.1, 6, 2), HomogeneousSection(STEEL, 0.004), kinematics=VON_KARMAN)


def two_walls():
    """A shell of two materials and thicknesses that meet in the middle."""
    mesh = strip(1.0, 0.1, 6, 2)
    (cells,) = mesh.cells.values()
    left = mesh.nodes[cells][:, :, 0].mean(axis=1) < 0.5
    parts = {"left": np.flatnonzero(left), "right": np.flatnonzero(~left)}
    sets = {name: {CellType.TRIANGLE3: part} for name, part in parts.items()}
    walls = {"left": HomogeneousSection(STEEL, 0.004), "right": HomogeneousSection(ALLOY, 0.006)}
    return shell_model(Mesh(mesh.nodes, mesh.cells, mesh.node_sets, sets), walls)


MODELS = {"solid": solid, "shell": shell, "von-karman": flat, "two walls": two_walls}


def reduced(model, derivatives=3):
    body = flexible_body("beam", model, [RigidInterface("root", "root")])
    return reduce(
        body,
        NodalFixedFrame("root"),
        Rubin(n_modes=4),
        derivatives=CompressedDerivatives(derivatives),
        loads=NoLoads,
    )


def large_motion(body, n_times=5, seed=0):
    """Coordinates that displace the body by a fifth of its length: the quadratic strain counts."""
    gamma = np.random.default_rng(seed).normal(size=(n_times, body.r)) / body.frequencies
    return 0.2 * gamma / np.abs(body.expand(gamma)).max()


@pytest.fixture(params=MODELS)
def model(request):
    return MODELS[request.param]()


@pytest.mark.parametrize(
    ("modes_of", "recovery_of", "measure"),
    [(stress_modes, stress_recovery, von_mises), (strain_modes, strain_recovery, von_mises_strain)],
    ids=["stress", "strain"],
)
def test_modes_give_what_the_whole_body_gives(model, modes_of, recovery_of, measure):
    """To round-off, with the quadratic part of the strain, not small here, and the condensed motion."""
    body = reduced(model)
    modes, recovery = modes_of(body, model), recovery_of(model)
    gamma = large_motion(body)
    full = np.array([recovery.at_nodes(body.nodal_basis @ g) for g in gamma])
    follows = body.condensed.fields @ body.condensed.amplitudes_at(gamma).T
    full += np.array([recovery.linearized().at_nodes(z) for z in follows.T])
    np.testing.assert_allclose(modes.at(gamma), full, atol=1e-12 * np.abs(full).max())
    np.testing.assert_allclose(modes.at(gamma[2]), full[2], atol=1e-12 * np.abs(full).max())
    np.testing.assert_allclose(modes.von_mises(gamma), measure(full).max(axis=2), rtol=1e-9)
    without = replace(modes, quadratic=None).at(gamma)
    assert np.abs(without - full).max() > 0.02 * np.abs(full).max()


def test_a_linear_body_has_the_stress_of_its_linear_strain(model):
    body = flexible_body("beam", model, [RigidInterface("root", "root")]).linearized()
    body = reduce(body, MeanAxisFrame(), NormalModes(4), derivatives=NoDerivatives(), loads=NoLoads)
    modes = stress_modes(body, model)
    assert modes.quadratic is None
    tiny = 1e-7 * large_motion(body)
    full = np.array([stress_recovery(model).at_nodes(body.nodal_basis @ g) for g in tiny])
    np.testing.assert_allclose(1e7 * modes.at(tiny), modes.at(1e7 * tiny), rtol=1e-9)
    np.testing.assert_allclose(modes.at(tiny), full, atol=1e-4 * np.abs(full).max())


def test_chosen_nodes_are_those_of_the_whole(model):
    body = reduced(model)
    gamma = large_motion(body)
    some = stress_modes(body, model, [7, 0, 3])
    np.testing.assert_array_equal(some.nodes, [7, 0, 3])
    whole = stress_modes(body, model).at(gamma)
    np.testing.assert_allclose(some.at(gamma), whole[:, [7, 0, 3]], atol=1e-13 * np.abs(whole).max())


def affine(model):
    """A body whose nine coordinates are the gradients H of u = H x, among which is every rigid rotation."""
    body = flexible_body("beam", model)
    body = reduce(body, MeanAxisFrame(), NormalModes(9), derivatives=NoDerivatives(), loads=NoLoads)
    u = np.zeros((model.mesh.n_nodes, model.dofs_per_node, 9))
    for i in range(3):
        u[:, i, 3 * i : 3 * i + 3] = model.mesh.nodes
    return replace(body, nodal_basis=u.reshape(-1, 9), condensed=None)


@pytest.mark.parametrize("cell_type", [CellType.TETRA4, CellType.TETRA10, CellType.HEXA20])
def test_a_turned_solid_has_no_stress(cell_type):
    """u = (R - 1) x for a turn by 1.3 rad; the linear strain alone would be of order one."""
    model = solid(cell_type)
    modes = stress_modes(affine(model), model)
    turn = (Rotation.from_rotvec([0.3, -0.9, 0.9]).as_matrix() - np.eye(3)).ravel()
    wrong = replace(modes, quadratic=None).von_mises(turn)
    assert wrong.min() > 0.1 * STEEL.youngs_modulus
    assert np.abs(modes.at(turn)).max() < 1e-13 * STEEL.youngs_modulus


def test_a_turned_shell_has_no_membrane_stress():
    """The membrane knows any rotation; only the linear curvature has a limit."""
    model = shell()
    modes = stress_modes(affine(model), model)
    turn = (Rotation.from_rotvec([0.3, -0.9, 0.9]).as_matrix() - np.eye(3)).ravel()
    middle = modes.at(turn)[:, 1]
    assert np.abs(middle).max() < 1e-13 * STEEL.youngs_modulus


def test_blocks_of_times_change_nothing(model, monkeypatch):
    body = reduced(model)
    modes, gamma = stress_modes(body, model), large_motion(body, n_times=11)
    whole = modes.von_mises(gamma)
    monkeypatch.setattr(tensor_modes, "_FIELD_NUMBERS", 2 * modes.linear[..., 0].size)
    np.testing.assert_allclose(modes.von_mises(gamma), whole, rtol=1e-12)
    np.testing.assert_allclose(modes.von_mises(gamma.reshape(1, 11, -1)), whole[None], rtol=1e-12)


def test_modes_formed_in_parts_are_the_same(model, monkeypatch):
    body = reduced(model)
    whole = stress_modes(body, model)
    monkeypatch.setattr(tensor_modes, "_FIELD_NUMBERS", 500)
    parts = stress_modes(body, model)
    for name in ("linear", "quadratic"):
        one, other = getattr(whole, name), getattr(parts, name)
        np.testing.assert_allclose(other, one, atol=1e-13 * np.abs(one).max())


# --- closed forms


def test_tension_and_shear_of_a_bar():
    """Tension: sigma = E eps, von Mises sigma and strain 2 (1 + nu)/3 eps. Pure shear: sqrt(3) tau."""
    model, (E, nu, G) = solid(), (STEEL.youngs_modulus, STEEL.poissons_ratio, STEEL.shear_modulus)
    body, tension = affine(model), 1e-9 * np.diag([1.0, -nu, -nu]).ravel()
    stress, strain = stress_modes(body, model), strain_modes(body, model)
    np.testing.assert_allclose(stress.at(tension)[..., 0], 1e-9 * E, rtol=1e-6)
    np.testing.assert_allclose(stress.von_mises(tension), 1e-9 * E, rtol=1e-6)
    np.testing.assert_allclose(strain.von_mises(tension), 1e-9 * 2 * (1 + nu) / 3, rtol=1e-6)
    shear = 1e-9 * np.eye(9)[1]  # u = y e_x
    np.testing.assert_allclose(stress.von_mises(shear), 1e-9 * G * 3**0.5, rtol=1e-6)
    np.testing.assert_allclose(strain.von_mises(shear), 1e-9 / 3**0.5, rtol=1e-6)


def test_a_shell_also_thins():
    """Plane stress: the strain across the wall is -nu/(1 - nu) (eps_x + eps_y)."""
    model = shell_model(strip(1.0, 0.1, 6, 2), HomogeneousSection(STEEL, 0.004))
    body, stretch = affine(model), 1e-9 * np.diag([1.0, 0.5, 0.0]).ravel()
    nu = STEEL.poissons_ratio
    strain = strain_modes(body, model).at(stretch)
    expected = 1e-9 * np.array([1.0, 0.5, -nu / (1 - nu) * 1.5, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(strain, np.broadcast_to(expected, strain.shape), atol=1e-15)


def bending_error(cell_type, n_thick):
    """Largest relative error of sigma_x = -F (L - x) z / I on top of a cantilever, away from its ends."""
    L, h, F = 1.0, 0.1, 1000.0
    model = solid_model(block(L, h, h, 10 * n_thick, n_thick, n_thick, cell_type), STEEL)
    ends = [RigidInterface("root", "root"), RigidInterface("tip", "tip")]
    body = flexible_body("beam", model, ends).linearized()
    body = reduce(body, NodalFixedFrame("root"), Guyan(), derivatives=NoDerivatives(), loads=NoLoads)
    gamma = np.linalg.solve(body.stiffness, F * body.interface("tip").motion[2])
    x, _, z = model.mesh.nodes.T
    top = np.flatnonzero((np.abs(x - L / 2) < 0.2) & (z > z.max() - 1e-9))
    expected = -F * (L - x[top]) * (h / 2) / (h**4 / 12)
    found = stress_modes(body, model, top).at(gamma)[:, 0, 0]
    return np.abs(found - expected).max() / np.abs(expected).max()


def test_bending_stress_of_a_cantilever_is_my_over_i():
    """The cubic bending line lies beyond quadratic tetrahedra: second order; 20-node bricks hit it."""
    errors = [bending_error(CellType.TETRA10, n) for n in (1, 2)]
    assert errors[1] < 0.01
    assert np.log2(errors[0] / errors[1]) > 1.8
    assert bending_error(CellType.HEXA20, 1) < 3e-4


# --- what cannot be


def test_other_models_and_coordinates_are_refused():
    model = solid()
    body = reduced(model)
    with pytest.raises(ModelError, match="was not made of this model"):
        stress_modes(body, shell())
    with pytest.raises(ModelError, match="was not made of this model"):
        strain_modes(body, solid_model(replace(model.mesh, nodes=model.mesh.nodes + 1.0), STEEL))
    with pytest.raises(ModelError, match=r"node numbers 2 to 999; the body has \d+ nodes"):
        stress_modes(body, model, [2, 999])
    with pytest.raises(ModelError, match=r"coordinates of shape \(3,\): these modes are of a body with"):
        stress_modes(body, model, [0]).at(np.zeros(3))
    laminate = LaminateSection(1e7 * np.eye(3), np.zeros((3, 3)), 1e2 * np.eye(3), 10.0, 1e-4)
    layered = shell_model(strip(1.0, 0.1, 6, 2), laminate)
    with pytest.raises(ModelError, match="stress needs a HomogeneousSection"):
        stress_modes(reduced(layered), layered)
