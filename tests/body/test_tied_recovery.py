"""Stress beside rigid interfaces that turn against the frame: of the energy, not of the tied nodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from supple.body import FullBody, MeanAxisFrame, RigidInterface, flexible_body
from supple.body.tied_recovery import tied_recovery, with_virtual_freedoms
from supple.fem import (
    HomogeneousSection,
    Isotropic,
    shell_model,
    solid_model,
    strain_recovery,
    stress_recovery,
)
from supple.mesh import CellType, block, box_beam
from supple.quantities import von_mises_history
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce

ALUMINIUM = Isotropic(7e10, 0.3, 2700.0)
ROOT, TIP = RigidInterface("root", "root"), RigidInterface("tip", "tip")


def bar():
    model = solid_model(block(2.0, 0.4, 0.3, 4, 1, 1, CellType.HEXA8), ALUMINIUM)
    return flexible_body("bar", model, [ROOT, TIP])


def box():
    wall = HomogeneousSection(ALUMINIUM, 0.04)
    return flexible_body("box", shell_model(box_beam(10.0, 1.0, 0.5, 6, 2, 1), wall), [ROOT, TIP])


def test_stress_and_strain_at_the_points_make_the_energy_of_the_body():
    """1/2 sum w sigma.eps of solids, for any coordinates: the strains are those that the force comes from."""
    body = bar()
    q = 0.02 * np.random.default_rng(0).normal(size=body.n)
    motions = [interface.motion @ q for interface in body.interfaces]
    u = with_virtual_freedoms(body.expansion @ q, motions, body.interfaces, 3)
    found = 0.0
    assert body.model is not None
    tied = [
        tied_recovery(make(body.model), body.nodes, 3, body.interfaces)
        for make in (stress_recovery, strain_recovery)
    ]
    for section, stress, strains in zip(tied[0].sections, *(each.at_points(u) for each in tied), strict=True):
        work = np.sum(stress * strains, axis=2).reshape(section.arrays.w.shape)
        found += 0.5 * float(np.sum(section.arrays.w * work))
    assert found == pytest.approx(body.assembly.energy(q), rel=1e-12)


def unloaded(body, theta):
    """The body whose root is turned by theta, all else free: Newton's method from a rigid turn."""
    turn = Rotation.from_rotvec(theta).as_matrix() - np.eye(3)
    field = np.zeros((len(body.nodes), body.dofs_per_node))
    field[:, :3] = (body.nodes - body.interfaces[0].position) @ turn.T
    field[:, 3:] = theta[: body.dofs_per_node - 3]
    q = splu((body.expansion.T @ body.expansion).tocsc()).solve(body.expansion.T @ field.ravel())
    held = body.interfaces[0].motion.indices
    q[held] = np.concatenate([np.zeros(3), theta])
    q[body.interfaces[1].motion.indices[3:]] = theta
    free = np.setdiff1d(np.arange(body.n), held)
    for _ in range(20):
        tangent = body.assembly.tangent(q)[free][:, free].tocsc()
        step = splu(tangent).solve(-body.assembly.internal_force(q)[free])
        q[free] += step
        if np.abs(step).max() < 1e-10:
            return q
    raise AssertionError("Newton's method did not converge")


@pytest.mark.parametrize("make", [bar, box])
def test_an_unloaded_body_whose_interface_has_turned_is_nearly_free_of_stress(make):
    """Of third order or higher; nodes tied linearly would show E theta^2 / 2 = 140 MPa at 0.06 rad."""
    body = make()
    full = FullBody(body, MeanAxisFrame())
    peaks = []
    for angle in (0.03, 0.06):
        q = unloaded(body, np.array([0.0, angle, 0.0]))
        peaks.append(von_mises_history(full, body.model, q[None]).max())
    assert np.log2(peaks[1] / peaks[0]) > 2.7
    assert peaks[1] < 0.04 * 7e10 * 0.06**2 / 2


@pytest.mark.parametrize("make", [bar, box])
def test_reduced_bodies_have_the_stress_of_the_full_one(make):
    """Coordinate by coordinate: both are the same polynomial."""
    body = make()
    frame = MeanAxisFrame()
    small = reduce(body, frame, CraigBampton(n_modes=2), derivatives=NoDerivatives(), loads=NoLoads)
    small = replace(small, condensed=None)  # the full body moves in the columns alone
    gamma = np.random.default_rng(1).normal(size=(3, small.r)) / small.frequencies
    gamma *= 0.2 / np.abs(small.expand(gamma)).max()
    left_inverse = np.linalg.pinv(body.expansion.toarray())
    expected = von_mises_history(
        FullBody(body, frame), body.model, gamma @ (left_inverse @ small.nodal_basis).T
    )
    np.testing.assert_allclose(von_mises_history(small, body.model, gamma), expected, rtol=1e-8)
