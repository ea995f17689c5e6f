"""The recorded force of a contact is what changes the momentum of both sides, and acts where they touch."""

import numpy as np
import pytest
from fixtures.explicit_bars import explicit_bar

from supple.body import flexible_body
from supple.fem import Isotropic, solid_model
from supple.integrate import Run
from supple.machine import At, Contact, Placed, RigidPlane, RigidSphere, SurfaceContact, System
from supple.mesh import CellType, block
from supple.methods.explicit import CONTACTS, explicit_subdomain, modal_subdomain
from supple.reduction import NormalModes
from supple.simulation import simulate

ROD = Isotropic(100.0, 0.0, 1.0)
"""Waves at 10 m/s."""
SIDE, SPEED = 0.2, 0.1
MASS = 4.0 * SIDE**2


def impulse(solution, force):
    """(t, 3)"""
    steps = np.diff(solution.times)[:, None]
    return np.concatenate([np.zeros((1, 3)), np.cumsum(0.5 * (force[1:] + force[:-1]) * steps, axis=0)])


def rod(name):
    return explicit_subdomain(solid_model(block(4.0, SIDE, SIDE, 20, 1, 1, CellType.HEXA8), ROD), name=name)


@pytest.mark.slow
def test_two_rods_and_a_wall():
    """rho c v A / 2 between equal rods, rho c v A against a wall, until the wave is back [St. Venant]."""
    first = Placed(rod("first"), velocity=(SPEED, 0, 0))
    second = Placed(rod("second"), position=(4.0, 0, 0))
    third = Placed(rod("third"), position=(0.0, 1.0, 0.0), velocity=(SPEED, 0, 0))
    touch = SurfaceContact(At("first", "tip"), At("second", "root"))
    wall = Contact(At("third", "tip"), RigidPlane((4.0, 0, 0), (-1, 0, 0)))
    solution = simulate(System([first, second, third], contacts=[touch, wall]), Run(1.2, 0.005))
    on_wall, between = np.split(solution.series[CONTACTS], 2, axis=1)
    middle = (solution.times > 0.2) & (solution.times < 0.6)
    assert between[middle, 0].mean() == pytest.approx(-0.5 * 10 * SPEED * SIDE**2, rel=0.02)
    assert on_wall[middle, 0].mean() == pytest.approx(-10 * SPEED * SIDE**2, rel=0.02)
    for name, force in (("first", between), ("third", on_wall)):
        start = MASS * np.array([SPEED, 0, 0])
        lumped = np.repeat([0.5, 1.0, 0.5], [4, 4 * 19, 4]) * MASS / 80
        nodes = solution.bodies[name]
        order = np.argsort(nodes.nodes[0, :, 0], kind="stable")
        momentum = np.einsum("n,tni->ti", lumped, nodes.velocities[:, order])
        assert momentum - start == pytest.approx(impulse(solution, force[:, :3]), abs=0.01 * MASS * SPEED)
        assert force[0, 3:] == pytest.approx([4.0, float(name == "third"), 0.0], abs=1e-9)


@pytest.mark.slow
def test_a_ball_on_a_modal_part():
    model = solid_model(block(4.0, 1.0, 1.0, 4, 2, 2, CellType.HEXA8), Isotropic(100.0, 0.3, 1.0))
    part = modal_subdomain(flexible_body("modal", model), NormalModes(6))
    ball = RigidSphere((2.0, 0.0, 1.05), 0.5, velocity=(0.0, 0.0, -0.5), mass=0.5)
    system = System([Placed(part)], contacts=[Contact(At("modal", "z_max"), ball)])
    solution = simulate(system, Run(3.0, 0.01))
    force, place = np.split(solution.series[CONTACTS], 2, axis=1)
    velocity = solution.series["obstacles"][:, 3:]
    on_ball = 0.5 * (velocity - velocity[0])
    assert np.abs(on_ball).max() > 0.05
    assert impulse(solution, -force) == pytest.approx(on_ball, abs=0.02 * np.abs(on_ball).max())
    worst = np.linalg.norm(force, axis=1).argmax()
    assert place[worst] == pytest.approx([2.0, 0.0, 0.5], abs=0.1)


def test_a_run_without_contacts_has_no_such_series():
    solution = simulate(System([explicit_bar(CellType.HEXA8)]), Run(0.1, 0.1))
    assert CONTACTS not in solution.series
