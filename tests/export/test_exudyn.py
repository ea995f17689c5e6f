"""The arrays for Exudyn are its own definitions of them, evaluated on the mesh."""

from dataclasses import replace

import numpy as np
import pytest

from supple.body import AveragingInterface, MeanAxisFrame, NodalFixedFrame, flexible_body
from supple.errors import ModelError
from supple.export import exudyn_arrays, interface_nodes, write_exudyn
from supple.fem import HomogeneousSection, Isotropic, shell_model, stress_recovery
from supple.mesh import strip
from supple.quantities import stress_modes
from supple.reduction import CompleteBasis, NoDerivatives, NoLoads, NormalModes, reduce
from supple_benchmarks.validation.rotors import disc_on_massless_shaft


def cross(vectors):
    """Cross matrices of 3 k numbers stacked: (3 k, 3)."""
    x, y, z = np.asarray(vectors).reshape(-1, 3).T
    o = 0.0 * x
    return np.stack([[o, -z, y], [z, o, -x], [-y, x, o]]).transpose(2, 0, 1).reshape(-1, 3)


@pytest.fixture(scope="module")
def of_points(model):
    """A body none of whose nodes is tied: its inertia is that of points."""
    body = flexible_body("points", model, [AveragingInterface(name, name) for name in ("root", "tip")])
    return reduce(
        body.linearized(), MeanAxisFrame(), NormalModes(5), derivatives=NoDerivatives(), loads=NoLoads
    )


def test_inertia_integrals_are_those_of_the_mesh(model, of_points):
    """With x~ and Psi~ formed node by node and the mass matrix of the mesh, as Exudyn's FEMinterface does."""
    linear = of_points
    found = exudyn_arrays(linear)
    M, x, N = model.mass, model.mesh.nodes.ravel(), model.mesh.n_nodes
    Psi = linear.nodal_basis
    Phi_t, x_cross = np.tile(np.eye(3), (N, 1)), cross(x)
    Psi_cross = np.hstack([cross(column) for column in Psi.T])
    mass = (Phi_t.T @ M @ Phi_t)[0, 0]
    expected = {
        "Mtt": Phi_t.T @ M @ Phi_t,
        "totalMass": mass,
        "chiU": Phi_t.T @ M @ x / mass,
        "chiUtilde": cross(Phi_t.T @ M @ x / mass),
        "inertiaLocal": x_cross.T @ M @ x_cross,
        "massMatrixReduced": Psi.T @ M @ Psi,
        "stiffnessMatrixReduced": Psi.T @ model.stiffness @ Psi,
        "mPhitTPsi": Phi_t.T @ M @ Psi,
        "mPhitTPsiTilde": Phi_t.T @ M @ Psi_cross,
        "mXRefTildePsi": x_cross.T @ M @ Psi,
        "mXRefTildePsiTilde": x_cross.T @ M @ Psi_cross,
        "mPsiTildePsi": Psi_cross.T @ M @ Psi,
        "mPsiTildePsiTilde": Psi_cross.T @ M @ Psi_cross,
    }
    for name, value in expected.items():
        scale = np.abs(value).max() + np.abs(M @ Psi).max()
        np.testing.assert_allclose(found[name], value, atol=1e-12 * scale, err_msg=name)
    np.testing.assert_array_equal(found["modeBasis"][: 3 * N], Psi)
    np.testing.assert_array_equal(found["xRef"][: 3 * N], x)
    np.testing.assert_array_equal(found["infoList"], [linear.r, N + 12, 3, 4, 7, 7 + linear.r])


def test_the_nodes_of_an_interface_move_as_it_does(linear):
    found = exudyn_arrays(linear)
    gamma = np.random.default_rng(0).normal(size=linear.r)
    rest, moved = found["xRef"].reshape(-1, 3), (found["modeBasis"] @ gamma).reshape(-1, 3)
    seen = []
    for interface in linear.interfaces:
        nodes = interface_nodes(linear, interface.name)
        seen += nodes
        arms = rest[nodes] - interface.position
        u, theta = interface.motion[:3] @ gamma, interface.motion[3:] @ gamma
        np.testing.assert_allclose(rest[nodes].mean(axis=0), interface.position, atol=1e-15)
        np.testing.assert_allclose(moved[nodes].mean(axis=0), u, atol=1e-14 * np.abs(moved).max())
        np.testing.assert_allclose(moved[nodes], u + np.cross(theta, arms), atol=1e-14 * np.abs(moved).max())
    assert seen == list(range(len(linear.nodes), len(rest)))
    with pytest.raises(ModelError, match="no interface 'middle'"):
        interface_nodes(linear, "middle")


def test_stress_columns_give_the_linear_stress(model, linear):
    found = exudyn_arrays(linear, stress=stress_modes(linear, model))["postProcessingModes"].item()
    assert found["outputVariableType"] == "OutputVariableType.StressLocal"
    gamma = np.random.default_rng(0).normal(size=linear.r)
    stress = found["matrix"].reshape(-1, linear.r, 6).transpose(0, 2, 1) @ gamma
    expected = stress_recovery(model).linearized().at_nodes(linear.nodal_basis @ gamma)[:, 0]
    N = len(linear.nodes)
    np.testing.assert_allclose(stress[:N], expected, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_array_equal(stress[N:], 0.0)


def test_the_file_holds_the_arrays(tmp_path, model, linear):
    triangles = np.array([[0, 1, 2], [2, 1, 3]])
    path = write_exudyn(
        tmp_path / "body.npz", linear, triangles=triangles, stress=stress_modes(linear, model)
    )
    expected = exudyn_arrays(linear, triangles=triangles, stress=stress_modes(linear, model))
    with np.load(path, allow_pickle=True) as file:
        assert set(file) == set(expected)
        for name in set(expected) - {"postProcessingModes"}:
            np.testing.assert_array_equal(file[name], expected[name])
        np.testing.assert_array_equal(
            file["postProcessingModes"].item()["matrix"], expected["postProcessingModes"].item()["matrix"]
        )


def test_kinetic_energy_by_exudyns_formula_is_that_of_the_nodes(model, of_points):
    """T of a turning, deforming body from the exported integrals, against the sum over the mesh."""
    linear = of_points
    a = exudyn_arrays(linear)
    rng = np.random.default_rng(1)
    gamma, rate = 0.1 * rng.normal(size=(2, linear.r))
    v, w = rng.normal(size=(2, 3))  # both in the body's axes
    spread = np.kron(gamma[:, None], np.eye(3))
    m_tr = -a["totalMass"] * a["chiUtilde"] - a["mPhitTPsiTilde"] @ spread
    m_rr = a["inertiaLocal"] + spread.T @ a["mPsiTildePsiTilde"] @ spread
    m_rr = m_rr + a["mXRefTildePsiTilde"] @ spread + (a["mXRefTildePsiTilde"] @ spread).T
    m_rf = -(a["mXRefTildePsi"] + spread.T @ a["mPsiTildePsi"])
    energy = 0.5 * (a["totalMass"] * v @ v + w @ m_rr @ w + rate @ a["massMatrixReduced"] @ rate)
    energy += v @ m_tr @ w + v @ a["mPhitTPsi"] @ rate + w @ m_rf @ rate
    u = (linear.nodal_basis @ gamma).reshape(-1, 3)
    velocity = v + np.cross(w, linear.nodes + u) + (linear.nodal_basis @ rate).reshape(-1, 3)
    expected = 0.5 * velocity.ravel() @ (model.mass @ velocity.ravel())
    assert energy == pytest.approx(expected, rel=1e-12)


def test_gyroscopic_and_centrifugal_forces_of_nodes_that_turn_are_exported():
    """By Exudyn's formula on modes at a steady spin, 2 w . mPsiTildePsi rate and what is quadratic in w."""
    linear = reduce(
        disc_on_massless_shaft(),
        NodalFixedFrame("hub"),
        CompleteBasis(),
        derivatives=NoDerivatives(),
        loads=NoLoads,
    )
    a, r, rate = exudyn_arrays(linear), linear.r, 60.0
    w = rate * np.eye(3)[0]
    gyroscopic = -2 * np.einsum("kil,i->lk", a["mPsiTildePsi"].reshape(r, 3, r), w)
    softening = np.einsum("kilj,i,j->kl", a["mPsiTildePsiTilde"].reshape(r, 3, r, 3), w, w)
    own = np.block([[np.zeros((r, r)), np.eye(r)], [softening - linear.stiffness, -gyroscopic]])
    found = np.sort(np.linalg.eigvals(own).imag)
    for expected in (81.26720, 92.17629):
        assert np.min(abs(found - expected)) < 1e-4


# --- what Exudyn cannot take


def test_bodies_and_stress_of_other_kinds_are_refused(tmp_path, model, linear, nonlinear):
    with pytest.raises(
        ModelError, match=r"is nonlinear and Exudyn's reduced body is linear: reduce body\.lin"
    ):
        exudyn_arrays(nonlinear)
    assert exudyn_arrays(replace(nonlinear, cubic=None, quartic=None))["totalMass"] > 0.0
    with pytest.raises(ModelError, match="stress modes of the same linear body at all of its"):
        exudyn_arrays(linear, stress=stress_modes(linear, model, [1, 2]))
    with pytest.raises(ModelError, match="stress modes of the same linear body at all of its"):
        exudyn_arrays(linear, stress=stress_modes(nonlinear, model))
    with pytest.raises(ModelError, match=r"Exudyn loads \.npz files"):
        write_exudyn(tmp_path / "body.h5", linear)


def test_a_shell_goes_without_stress():
    shell = shell_model(strip(1.0, 0.2, 4, 2), HomogeneousSection(Isotropic(2.1e11, 0.3, 7800.0), 0.01))
    body = reduce(
        flexible_body("strip", shell).linearized(),
        MeanAxisFrame(),
        NormalModes(3),
        derivatives=NoDerivatives(),
        loads=NoLoads,
    )
    assert exudyn_arrays(body)["modeBasis"].shape == (3 * shell.mesh.n_nodes, 3)
    with pytest.raises(ModelError, match="is a shell with 3 layers of stress"):
        exudyn_arrays(body, stress=stress_modes(body, shell))
