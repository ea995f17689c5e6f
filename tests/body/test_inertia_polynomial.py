"""The kinetic energy of bodies whose nodes turn, against finite rotations and integrals over elements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.sparse import csc_array
from scipy.spatial.transform import Rotation

from supple.algebra.cross import cross_matrix
from supple.body import RigidInterface, flexible_body
from supple.body.inertia_polynomial import SPIN_PAIRS, InertiaPolynomial
from supple.fem import BeamSection, Isotropic, shell_model
from supple.mesh import CellType, Mesh

SECTION = BeamSection(Isotropic(2e11, 0.3, 7800.0), 4e-3, 1e-6, 3e-6, 2e-6)
NODES = np.array([[0.0, 0, 0], [0.3, 0.1, 0], [0.7, 0.1, 0.2], [1.0, 0, 0.3]])


def beam(interfaces=()):
    cells = np.array([[0, 1], [1, 2], [2, 3]])
    return flexible_body("beam", shell_model(Mesh(NODES, {CellType.LINE2: cells}), SECTION), interfaces)


def energy(body, w, q, rates):
    """The polynomial, about a frame whose origin rests."""
    parts, momenta = InertiaPolynomial(body), body.mass @ body.rigid_modes[:, 3:]
    total = rates @ (body.mass @ rates) / 2 + w @ (body.rigid_modes[:, 3:].T @ momenta) @ w / 2
    total += w @ momenta.T @ rates + np.einsum("i,ijn,j,n->", w, parts.by_both, w, q)
    total += sum(w[i] * (q @ (matrix @ rates)) for i, matrix in enumerate(parts.by_rate))
    for (i, j), matrix in zip(SPIN_PAIRS, parts.by_spin, strict=True):
        total += (1.0 if i == j else 2.0) * w[i] * w[j] * (q @ (matrix @ q)) / 2
    return total


def finite_energy(inertias, masses, turn):
    """Of nodes that move in space by `turn(t)`: places (N, 3) and rotations."""
    h = 1e-4
    before, after = turn(-h), turn(h)
    velocity = (after[0] - before[0]) / (2 * h)
    spin = (before[1].inv() * after[1]).as_rotvec() / (2 * h)
    return (masses @ np.sum(velocity**2, axis=1) + np.einsum("ni,nij,nj->", spin, inertias, spin)) / 2


@pytest.mark.parametrize("beside", [False, True])
def test_the_error_falls_with_the_third_power_of_the_rotations(beside):
    """Lumped inertias of any kind, against finite rotations; with masses beside their nodes the second."""
    rng = np.random.default_rng(2)
    inertias = np.array([a @ a.T for a in rng.standard_normal((4, 3, 3))])
    masses = np.array([1.0, 2.0, 3.0, 1.5])
    arms = 0.5 * rng.standard_normal((4, 3)) if beside else np.zeros((4, 3))
    shift = block_diag(
        *(np.block([[np.eye(3), -cross_matrix(c)], [np.zeros((3, 3)), np.eye(3)]]) for c in arms)
    )
    own = block_diag(*(block_diag(m * np.eye(3), J) for m, J in zip(masses, inertias, strict=True)))
    mass = csc_array(shift.T @ own @ shift)
    body = replace(beam(), mass=mass, nodal_mass=mass)
    w, q, rates = 2.0 * rng.standard_normal(3), rng.standard_normal(body.n), rng.standard_normal(body.n)
    A = Rotation.from_rotvec(rng.standard_normal(3))

    def error(size):
        def turn(t):
            moved = (size * (q + t * rates)).reshape(-1, 6)
            frame = A * Rotation.from_rotvec(t * w)
            own_turns = Rotation.from_rotvec(moved[:, 3:])
            places = NODES + moved[:, :3] + own_turns.apply(arms)
            return frame.apply(places), frame * own_turns

        return abs(energy(body, w, size * q, size * rates) - finite_energy(inertias, masses, turn))

    # What a place beside its node moves by to second order, theta x (theta x c) / 2, is left out.
    order = 2.0 if beside else 3.0
    assert np.log2(error(0.004) / error(0.002)) == pytest.approx(order, abs=0.25)


def test_a_consistent_rotary_mass_is_integrated_with_the_rotations_between_the_nodes():
    """Three Gauss points an element, where theta is interpolated and J is the section's."""
    body = beam()
    rng = np.random.default_rng(4)
    w, q, rates = rng.standard_normal(3), rng.standard_normal(body.n), rng.standard_normal(body.n)
    theta, turning = q.reshape(-1, 6)[:, 3:], rates.reshape(-1, 6)[:, 3:]
    u, moving = q.reshape(-1, 6)[:, :3], rates.reshape(-1, 6)[:, :3]
    points, weights = np.polynomial.legendre.leggauss(3)
    expected = 0.0
    for a, b in ((0, 1), (1, 2), (2, 3)):
        x = NODES[b] - NODES[a]
        length = np.linalg.norm(x)
        e1 = x / length
        e3 = np.cross(e1, SECTION.orientation)
        e3 /= np.linalg.norm(e3)
        axes = np.array([e1, np.cross(e3, e1), e3])
        own = SECTION.material.density * np.array([SECTION.I1 + SECTION.I2, SECTION.I2, SECTION.I1])
        J = axes.T @ np.diag(own) @ axes
        for point, weight in zip((points + 1) / 2, weights * length / 2, strict=True):
            at = (1 - point) * np.eye(2)[0] + point * np.eye(2)[1]
            place, here, there, rate, spin = (at @ v[[a, b]] for v in (NODES, u, theta, moving, turning))
            velocity = np.cross(w, place + here) + rate
            first = w + np.cross(w, there) + spin
            second = np.cross(there, np.cross(there, w)) - np.cross(there, spin)
            expected += weight * SECTION.mass_per_length * velocity @ velocity / 2
            expected += weight * (first @ J @ first + w @ J @ second) / 2
    assert energy(body, w, q, rates) == pytest.approx(expected, rel=1e-12)


def test_a_rigid_interface_turns_as_the_body_that_its_nodes_make():
    """The energy is that of its mass and inertia about the virtual node, to second order in its rotation."""
    ring = RigidInterface("ring", [1, 2], position=tuple(NODES[1:3].mean(axis=0)))
    body, single = beam([ring]), beam()
    rng = np.random.default_rng(5)
    w, q, rates = rng.standard_normal(3), np.zeros(body.n), np.zeros(body.n)
    q[-3:], rates[-3:] = rng.standard_normal((2, 3))
    inertia = body.mass.toarray()[-3:, -3:]
    theta, turning = q[-3:], rates[-3:]

    def turned(size):
        first = w + size * (np.cross(w, theta) + turning)
        second = size**2 * (np.cross(theta, np.cross(theta, w)) - np.cross(theta, turning))
        return (first @ inertia @ first + w @ inertia @ second) / 2

    sizes = np.array([0.0, 1.0, -1.0])
    found = np.array([energy(body, w, size * q, size * rates) for size in sizes])
    expected = np.array([turned(size) for size in sizes])
    # Even part: what is of second order, whatever the neighbours add to the linear one.
    assert found[1:].sum() - 2 * found[0] == pytest.approx(expected[1:].sum() - 2 * expected[0], rel=1e-12)
    assert single.n == body.n + 6


def test_places_alone_keep_their_energy_at_any_displacement(solid):
    body = flexible_body("block", solid)
    rng = np.random.default_rng(6)
    w, q, rates = rng.standard_normal(3), rng.standard_normal(body.n), rng.standard_normal(body.n)
    velocity = np.cross(w, body.nodes + q.reshape(-1, 3)) + rates.reshape(-1, 3)
    expected = velocity.ravel() @ (body.mass @ velocity.ravel()) / 2
    assert energy(body, w, q, rates) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("interfaces", [(), (RigidInterface("end", np.array([2, 3])),)], ids=["free", "tied"])
@pytest.mark.parametrize("columns", [(), (0,), (1,), (3,)], ids=str)
def test_products_of_all_axes_are_those_of_the_matrices(interfaces, columns):
    """Of one field, of several, and of none."""
    body = beam(interfaces)
    parts = InertiaPolynomial(body)
    fields = np.random.default_rng(3).standard_normal((body.n, *columns))
    back, forth = parts.rate_products(fields)
    spun = parts.spin_products(fields)
    assert back.shape == forth.shape == (3, *fields.shape)
    assert spun.shape == (3, 3, *fields.shape)
    for i, matrix in enumerate(parts.by_rate):
        np.testing.assert_allclose(back[i], matrix.T @ fields, rtol=0, atol=1e-11)
        np.testing.assert_allclose(forth[i], matrix @ fields, rtol=0, atol=1e-11)
    for (i, j), matrix in zip(SPIN_PAIRS, parts.by_spin, strict=True):
        np.testing.assert_allclose(spun[i, j], matrix @ fields, rtol=0, atol=1e-11)
        np.testing.assert_allclose(spun[j, i], matrix.T @ fields, rtol=0, atol=1e-11)
