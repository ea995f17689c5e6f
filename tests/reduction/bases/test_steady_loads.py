"""Static answers to steady motion: a spinning disc against its closed form, accelerated bodies exactly."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.body.rigid_motion import nodal_rigid_modes
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import CellType, Mesh
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, NormalModes, Rubin, SteadyLoads, reduce

INNER, OUTER, MODULUS, NU, DENSITY = 0.1, 0.5, 2.1e11, 0.3, 7800.0
OMEGA = 3000 * 2 * np.pi / 60


def disc(n_radial: int = 12, n_around: int = 32):
    """An annulus of shell triangles whose inner edge is a rigid hub."""
    radius = np.linspace(INNER, OUTER, n_radial + 1)
    angle = 2 * np.pi * np.arange(n_around) / n_around
    x = radius[:, None] * np.cos(angle)
    y = radius[:, None] * np.sin(angle)
    nodes = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n_radial), np.arange(n_around), indexing="ij"))
    k = (j + 1) % n_around
    a, b, c, d = i * n_around + j, (i + 1) * n_around + j, (i + 1) * n_around + k, i * n_around + k
    cells = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    mesh = Mesh(nodes, {CellType.TRIANGLE3: cells}, {"hub": np.arange(n_around)})
    model = shell_model(mesh, HomogeneousSection(Isotropic(MODULUS, NU, DENSITY), 0.01))
    return flexible_body("disc", model, [RigidInterface("hub", "hub")])


def stretch_of_the_rim() -> float:
    """Radial displacement at the free edge of a rotating annulus in plane stress, clamped inside.

    u = A r + B / r - (1 - nu^2) rho omega^2 r^3 / (8 E), with u = 0 inside and no radial stress outside.
    """
    k = (1 - NU**2) * DENSITY * OMEGA**2 / (8 * MODULUS)
    system = np.array([[INNER, 1 / INNER], [1 + NU, -(1 - NU) / OUTER**2]])
    A, B = np.linalg.solve(system, [k * INNER**3, (3 + NU) * k * OUTER**2])
    return A * OUTER + B / OUTER - k * OUTER**3


def answer(body, reduced, acceleration):
    """Nodal displacement under the inertia load of a nodal acceleration (n_nodal,)."""
    load = reduced.nodal_basis.T @ (body.nodal_mass @ acceleration)
    return reduced.nodal_basis @ np.linalg.solve(reduced.stiffness, load)


def test_a_disc_at_3000_rpm_stretches_as_it_should():
    body = disc()
    frame = NodalFixedFrame("hub")
    spin = np.zeros((len(body.nodes), 6))
    spin[:, :2] = OMEGA**2 * body.nodes[:, :2]
    rim = np.argmax(body.nodes[:, 0])
    modes = CraigBampton(n_modes=10)
    found = {}
    for recipe in (modes, SteadyLoads(modes)):
        reduced = reduce(body.linearized(), frame, recipe, derivatives=NoDerivatives(), loads=NoLoads)
        found[recipe] = answer(body, reduced, spin.ravel())[6 * rim]
    assert found[SteadyLoads(modes)] == pytest.approx(stretch_of_the_rim(), rel=0.01)
    assert found[modes] < 0.1 * stretch_of_the_rim()


@pytest.mark.parametrize("held", [NodalFixedFrame("hub"), MeanAxisFrame()], ids=["fixed", "mean-axis"])
@pytest.mark.parametrize("axis", [(1, 1, 0), (1, 0, 1), (1, 2, 3)])
def test_a_disc_that_spins_about_any_axis_has_the_stretch_of_the_full_one(held, axis):
    """x - n (n . x) holds products of the components of n: without their columns two thirds are lacking."""
    body = disc(4, 16).linearized()
    n = np.array(axis) / np.linalg.norm(axis)
    spin = np.zeros((len(body.nodes), 6))
    spin[:, :3] = OMEGA**2 * (body.nodes - np.outer(body.nodes @ n, n))
    exact = body.constrained(held.constraint(body)).solve(body.expansion.T @ (body.nodal_mass @ spin.ravel()))
    recipe = CraigBampton(n_modes=6) if isinstance(held, NodalFixedFrame) else Rubin(n_modes=6)
    found = answer(body, reduce(body, held, SteadyLoads(recipe), derivatives=NoDerivatives()), spin.ravel())
    exact = body.expansion @ exact
    assert np.abs(found - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.mark.parametrize("recipe", [CraigBampton(n_modes=2), Rubin(n_modes=2)])
def test_an_accelerated_body_deflects_exactly(cantilever, frame, recipe):
    """Held at its root, in either frame: against the full model."""
    reduced = reduce(cantilever.linearized(), frame, SteadyLoads(recipe), derivatives=NoDerivatives())
    held = cantilever.interface("root").motion
    for field in nodal_rigid_modes(cantilever.nodes, 6).T:
        load = cantilever.expansion.T @ (cantilever.nodal_mass @ field)
        exact = cantilever.constrained(held).solve(load)
        # Reacted at the root, and seen from the frame.
        balanced = load - held.T @ np.linalg.solve(
            (held @ cantilever.rigid_modes).T, cantilever.rigid_modes.T @ load
        )
        V = np.linalg.lstsq(cantilever.expansion.toarray(), reduced.nodal_basis, rcond=None)[0]
        q = V @ np.linalg.solve(reduced.stiffness, V.T @ balanced)
        rigid = cantilever.rigid_modes
        q = q - rigid @ np.linalg.solve(held @ rigid, held @ q)
        np.testing.assert_allclose(q, exact, atol=1e-6 * np.abs(exact).max())


def test_columns_are_named_and_those_held_already_dropped(cantilever, mean_axis, root_frame):
    fixed = reduce(
        cantilever.linearized(), root_frame, SteadyLoads(CraigBampton(n_modes=3)), derivatives=NoDerivatives()
    ).report
    assert fixed.linear[3] == "static response to acceleration x"
    assert "static response to rotation about z" in fixed.linear + fixed.dropped
    free = reduce(
        cantilever.linearized(), mean_axis, SteadyLoads(Rubin(n_modes=3)), derivatives=NoDerivatives()
    ).report
    assert {f"static response to acceleration {axis}" for axis in "xyz"} <= set(free.dropped)


def test_a_free_body_answers_spins_alone(loose_body, mean_axis):
    raw = SteadyLoads(NormalModes(2)).build(loose_body, mean_axis)
    assert len(raw.labels) <= 2 + 6
    assert all(label.startswith("static response to rotation") for label in raw.labels[2:])
