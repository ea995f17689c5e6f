"""Equilibria and modes beyond the limits of the kinematics, which no error of a basis contains."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from supple.body import AveragingInterface, FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.error import ReductionStart, SelfCorrection, correct_at_rest
from supple.errors import ValidityWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.linearization import campbell_diagram, linearize, machine_modes
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, Spin, System
from supple.mesh import CellType, block, strip
from supple.reduction import CraigBampton, NoDerivatives, reduce
from supple.simulation import equilibrium

LENGTH, WIDTH, WALL, E, DENSITY = 1.0, 0.1, 0.01, 1e9, 1000.0
BENDING = E * WIDTH * WALL**3 / 12
LOWEST = 1.875104**2 * np.sqrt(BENDING / (DENSITY * WIDTH * WALL * LENGTH**4))
STIFFENS = 1.193
"""Of the lowest flapping of a uniform beam: w^2 = w_0^2 + 1.193 W^2 (Southwell)."""
ROOT = NodalFixedFrame("root")


@pytest.fixture(scope="module")
def linear():
    wall = HomogeneousSection(Isotropic(E, 0.0, DENSITY), WALL)
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    return flexible_body("arm", shell_model(strip(LENGTH, WIDTH, 12, 2), wall), ends).linearized()


@pytest.fixture(scope="module")
def reduced(linear):
    return reduce(linear, ROOT, CraigBampton(2), derivatives=NoDerivatives())


def clamped(form, force=0.0):
    wall = Fixed(name="wall", first=GROUND, second=At("arm", "root"))
    push = DeadForce(body="arm", at="tip", force=np.array([0.0, 0.0, force]))
    return System((Placed(form),), (wall,), loads=(push,) if force else ())


def messages(work):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = work()
    return found, [str(each.message) for each in caught if each.category is ValidityWarning]


@pytest.mark.parametrize(("turn", "warned"), [(0.08, False), (0.4, True)])
def test_a_linear_body_at_rest_warns_of_the_shortening_that_it_lacks(linear, reduced, turn, warned):
    """Turned at its end by F L^2 / 2 E I. Its basis contains that shape: the error of the basis is zero."""
    force = 2 * BENDING * turn / LENGTH**2
    found, said = messages(lambda: equilibrium(clamped(reduced, force)))
    assert found.errors["arm"].relative < 1e-6
    start = ReductionStart(SelfCorrection(relative=1e-3), CraigBampton(2), NoDerivatives())
    _, of_rounds = messages(lambda: correct_at_rest(clamped(FullBody(linear, ROOT), force), start))
    assert of_rounds == said
    assert len(said) == warned
    assert all(f"is linear and rotates by {turn:.1f}" in each for each in said)


def test_modes_of_a_linear_arm_in_rotation_warn_of_the_stiffness_that_they_lack(reduced):
    """About an axis across it; a shaft that spins about its own axis has no tension."""
    rate = LOWEST
    modes, said = messages(lambda: machine_modes(linearize(clamped(reduced), spin=Spin(rate, (0, 0, 1))), 1))
    assert modes.frequencies[0] == pytest.approx(LOWEST, rel=0.01)
    assert np.sqrt(LOWEST**2 + STIFFENS * rate**2) > 1.4 * modes.frequencies[0]
    assert len(said) == 1
    assert "without geometric stiffness" in said[0]
    spins = [Spin(share * LOWEST, (0, 0, 1)) for share in (0.0, 0.2, 0.4, 0.6)]
    _, said = messages(lambda: campbell_diagram(clamped(reduced), spins, n_modes=1))
    assert [each[:22] for each in said] == ["at 2 of 4 speeds: body"]
    _, said = messages(lambda: linearize(clamped(reduced), spin=Spin(rate, (1, 0, 0))))
    assert said == []


@pytest.mark.parametrize(
    ("tip", "alpha", "warned", "deflection"),
    [
        (RigidInterface, 1.0, False, 0.30172),
        (RigidInterface, 2.0, True, None),
        (AveragingInterface, 2.0, False, 0.49346),
    ],
)
def test_a_rigid_interface_of_solids_warns_of_large_rotations(tip, alpha, warned, deflection):
    """A cantilever under F = alpha E I / L^2 at its tip: the elastica, which rotates by
    0.46 and 0.78 rad. The row beside a rigid tip is strained by the third order of its rotation."""
    mesh = block(1.0, 0.05, 0.05, 20, 1, 1, CellType.HEXA8)
    ends = [RigidInterface("root", "root"), tip("tip", "tip")]
    bar = flexible_body("arm", solid_model(mesh, Isotropic(E, 0.0, DENSITY)), ends)
    force = alpha * E * 0.05**4 / 12
    found, said = messages(lambda: equilibrium(clamped(FullBody(bar, ROOT), force)))
    assert [text[:38] for text in said] == ["a rigid interface of body 'arm' rotates"[:38]] * warned
    if deflection:
        moved = found.system.bodies[0].positions()[mesh.nodes_of("tip"), 2].mean()
        assert moved == pytest.approx(deflection, rel=5e-3)
