"""SID against integrals over the mesh: the forces of any acceleration, spin and deformation of its points."""

import re
from dataclasses import replace

import numpy as np
import pytest

from supple.body import AveragingInterface, MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.export import standard_input_data, write_sid
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, NormalModes, reduce

PRODUCTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


@pytest.fixture(scope="module")
def of_points(model):
    """A body none of whose nodes is tied: its inertia is that of points."""
    body = flexible_body("points", model, [AveragingInterface(name, name) for name in ("root", "tip")])
    return reduce(
        body.linearized(), MeanAxisFrame(), NormalModes(4), derivatives=NoDerivatives(), loads=NoLoads
    )


def read(path):
    """The mass, the blocks, m0 (rows, columns) and m1 (rows, columns, r) or None, and those of the nodes."""
    text = path.read_text().replace("D+", "e+").replace("D-", "e-")

    def blocks(part):
        found = {}
        for name, body in re.findall(r"^(\w+)\n((?:    .*\n)+?)end \1$", part, re.M):
            head = {key: int(value) for key, value in re.findall(r"(\w+) += (\d+)$", body, re.M)}
            m0 = np.zeros((head["nrow"], head["ncol"]))
            m1 = np.zeros((head["nrow"], head["ncol"], head["nq"])) if head["order"] else None
            for i, j, value in re.findall(r"m0\( (\d+), (\d+)\) = (\S+)", body):
                m0[int(i) - 1, int(j) - 1] = float(value)
            for i, k, j, value in re.findall(r"m1\( (\d+), (\d+), (\d+)\) = (\S+)", body):
                m1[int(i) - 1, int(j) - 1, int(k) - 1] = float(value)
            found[name] = (m0, m1)
        return found

    frame, rest = text.split("end frame\n")
    mass = float(re.search(r" mass += (\S+)", text)[1])
    return mass, blocks(rest), [blocks(node) for node in frame.split("new node")[1:]]


def moved(block, q):
    m0, m1 = block
    return m0 if m1 is None else m0 + m1 @ q


def inertia_forces(model, body, a, alpha, w, q, rate, second):
    """Force, moment about the origin (3,) each and modal forces (r,) of all points, by the mesh's mass."""
    V = body.nodal_basis.reshape(-1, 3, body.r)
    r, v = body.nodes + V @ q, V @ rate
    accelerations = a + np.cross(alpha, r) + 2 * np.cross(w, v) + np.cross(w, np.cross(w, r)) + V @ second
    forces = (model.mass @ accelerations.ravel()).reshape(-1, 3)
    return forces.sum(axis=0), np.cross(r, forces).sum(axis=0), np.einsum("nak,na->k", V, forces)


def forces_of_file(mass, b, a, alpha, w, q, rate, second):
    """The same by the blocks, without their second order."""
    c, J6 = moved(b["mdCM"], q)[:, 0], moved(b["J"], q)[:, 0]
    J = np.zeros((3, 3))
    for value, (i, j) in zip(J6, ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)), strict=True):
        J[i, j] = J[j, i] = value
    Ct, Cr = b["Ct"][0], moved(b["Cr"], q)
    omega = np.array([w[i] * w[j] for i, j in PRODUCTS])
    n = len(q)
    Gr = moved(b["Gr"], q).reshape(3, n, 3)
    Ge = b["Ge"][0].reshape(n, 3, n)
    force = mass * a + np.cross(alpha, c) + np.cross(w, np.cross(w, c)) + 2 * np.cross(w, Ct.T @ rate)
    moment = np.cross(c, a) + J @ alpha + np.cross(w, J @ w) + np.einsum("iqj,q,j->i", Gr, rate, w)
    modal = Ct @ a + Cr @ alpha + np.einsum("liq,q,i->l", Ge, rate, w) + moved(b["Oe"], q) @ omega
    return force + Ct.T @ second, moment + Cr.T @ second, modal + b["Me"][0] @ second


def test_forces_of_any_motion_are_those_of_the_points(model, of_points, tmp_path):
    """Force and modal forces exactly; the moment to first order in q, which is its odd part."""
    mass, blocks, _ = read(write_sid(tmp_path / "body.sid", of_points))
    rng = np.random.default_rng(3)
    a, alpha, w = rng.normal(size=(3, 3))
    q, rate, second = rng.normal(size=(3, of_points.r)) * 0.1

    def both(q):
        return [
            (file, mesh)
            for file, mesh in zip(
                forces_of_file(mass, blocks, a, alpha, w, q, rate, second),
                inertia_forces(model, of_points, a, alpha, w, q, rate, second),
                strict=True,
            )
        ]

    for at in (both(q), both(-q), both(0 * q)):
        for file, mesh in (at[0], at[2]):
            np.testing.assert_allclose(file, mesh, rtol=0, atol=1e-11 * abs(mesh).max())
    file, mesh = both(0 * q)[1]
    np.testing.assert_allclose(file, mesh, rtol=0, atol=1e-11 * abs(mesh).max())
    (file, mesh), (file_back, mesh_back) = both(q)[1], both(-q)[1]
    np.testing.assert_allclose(file - file_back, mesh - mesh_back, rtol=0, atol=1e-11 * abs(mesh).max())


def test_nodes_of_the_file_are_the_interfaces(of_points, tmp_path):
    path = write_sid(tmp_path / "body.sid", of_points)
    _, blocks, nodes = read(path)
    assert path.read_text().split()[:2] == ["2", str(of_points.r)]
    np.testing.assert_array_equal(blocks["Ke"][0], of_points.stiffness)
    for node, interface in zip(nodes, of_points.interfaces, strict=True):
        np.testing.assert_array_equal(node["origin"][0][:, 0], interface.position)
        np.testing.assert_array_equal(node["origin"][1][:, 0], interface.motion[:3])
        np.testing.assert_array_equal(node["phi"][0], interface.motion[:3])
        np.testing.assert_array_equal(node["psi"][0], interface.motion[3:])
        turned = node["AP"][1] @ np.ones(of_points.r)
        arm = np.array([0.3, -0.2, 0.5])
        expected = np.cross(interface.motion[3:] @ np.ones(of_points.r), arm)
        np.testing.assert_allclose(turned @ arm, expected, rtol=1e-13)


def test_frequencies_of_the_file_are_in_the_units_of_the_body(of_points, tmp_path):
    """A body in mm and ms has frequencies in kHz: no unit is known here."""
    text = write_sid(tmp_path / "body.sid", of_points).read_text()
    first = of_points.frequencies[0] / (2 * np.pi)
    assert f"Eigen Mode 1 : {first:.9g} per unit of time\n" in text
    assert "Hz" not in text


def test_a_beam_that_spins_stiffens_as_published(tmp_path):
    """Flap of a cantilever: omega^2 = 12.362 + 1.19 eta^2 about eta = 1 and 2 [Wright1982], hub radius 0."""
    wide, thin = 0.5, 0.02
    wall = HomogeneousSection(Isotropic(7e10, 0.0, 2700.0), thin)
    body = flexible_body(
        "blade", shell_model(strip(10.0, wide, 20, 2), wall), [RigidInterface("root", "root")]
    )
    reduced = reduce(body, NodalFixedFrame("root"), CraigBampton(n_modes=3), derivatives=NoDerivatives())
    _, blocks, _ = read(write_sid(tmp_path / "blade.sid", reduced))
    scale = 7e10 * wide * thin**3 / 12 / (2700.0 * wide * thin * 10.0**4)
    for eta, published in ((0.0, 3.5160), (1.0, 3.6816), (2.0, 4.1373)):
        spin = eta * np.sqrt(scale)
        omega = np.array([0.0, 0.0, spin**2, 0.0, 0.0, 0.0])
        stiffness = blocks["Ke"][0] + np.einsum("lck,c->lk", blocks["Oe"][1], omega)
        lowest = np.sqrt(np.linalg.eigvals(np.linalg.solve(blocks["Me"][0], stiffness)).real.min())
        assert lowest / np.sqrt(scale) == pytest.approx(published, rel=3e-3)


def test_a_body_whose_strains_are_not_in_its_tensors_is_refused(of_points):
    with pytest.raises(ModelError, match="strain energy outside its tensors"):
        standard_input_data(replace(of_points, elastic_elsewhere=True))
