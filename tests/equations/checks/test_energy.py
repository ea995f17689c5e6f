"""Energies and momenta against sums over the nodes."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import MeanAxisFrame, flexible_body
from supple.equations.checks.energy import balances
from supple.errors import LockingWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FloatingMotion, Solution, Statistics
from supple.machine import Placed, System
from supple.mesh import strip
from supple.reduction import CompressedDerivatives, NoLoads, NormalModes, PlainQuartic, reduce

GRAVITY = np.array([0.3, -0.2, -9.81])


@pytest.fixture(scope="module")
def blade():
    """A strip none of whose nodes is tied to another: its energy is a sum over them."""
    wall = HomogeneousSection(Isotropic(1e7, 0.3, 1000.0), 0.02)
    return flexible_body("blade", shell_model(strip(1.0, 0.1, 6, 2), wall))


@pytest.fixture(scope="module")
def floating_blade(blade):
    """Without condensed motion, whose inertia is no sum over nodes of what the basis moves."""
    with pytest.warns(LockingWarning):
        return reduce(
            blade,
            MeanAxisFrame(),
            NormalModes(3),
            derivatives=CompressedDerivatives(3),
            quartic=PlainQuartic(),
            loads=NoLoads,
        )


@pytest.fixture(scope="module")
def motion(floating_blade, turned):
    """One instant of a random motion."""
    rng = np.random.default_rng(9)
    r = floating_blade.r
    return FloatingMotion(
        position=rng.standard_normal((1, 3)),
        rotation=(turned(0, 0.4) @ turned(2, -1.1))[None],
        coordinates=0.05 * rng.standard_normal((1, r)),
        velocity=rng.standard_normal((1, 3)),
        angular_velocity=rng.standard_normal((1, 3)),
        coordinate_rates=rng.standard_normal((1, r)),
        acceleration=np.zeros((1, 3)),
        angular_acceleration=np.zeros((1, 3)),
        coordinate_accelerations=np.zeros((1, r)),
    )


@pytest.fixture(scope="module")
def kept(floating_blade, motion):
    system = System((Placed(floating_blade),), gravity=GRAVITY)
    return balances(system, Solution(np.zeros(1), {"blade": motion}, {}, Statistics()))


@pytest.fixture(scope="module")
def nodal(floating_blade, motion):
    """Global positions (N, 3) and velocities (N, 6), translations and rotations, of all nodes."""
    A, spin = motion.rotation[0], motion.angular_velocity[0]
    place = floating_blade.nodes + floating_blade.displacement_basis @ motion.coordinates[0]
    rates = (floating_blade.nodal_basis @ motion.coordinate_rates[0]).reshape(-1, 6)
    velocity = motion.velocity[0] + (np.cross(spin, place) + rates[:, :3]) @ A.T
    return motion.position[0] + place @ A.T, np.hstack([velocity, (spin + rates[:, 3:]) @ A.T])


def momenta_of_nodes(blade, nodal):
    """`M V`, (N, 6); the mass matrix of a shell does not couple directions, so global components will do."""
    return (blade.nodal_mass @ nodal[1].ravel()).reshape(-1, 6)


def turning_momentum(blade, floating_blade, motion):
    """Sum of theta x J theta' / 2, global, that nodes carry beside J (w + theta').

    Of a shell, whose J is the same about all axes.
    """
    theta, rate = (
        (floating_blade.nodal_basis @ each[0]).reshape(-1, 6)[:, 3:]
        for each in (motion.coordinates, motion.coordinate_rates)
    )
    field = np.hstack([np.zeros_like(rate), rate])
    momentum = (blade.nodal_mass @ field.ravel()).reshape(-1, 6)[:, 3:]
    return motion.rotation[0] @ np.cross(theta, momentum).sum(axis=0) / 2


def test_kinetic_energy_and_momentum(blade, floating_blade, motion, kept, nodal):
    momentum = momenta_of_nodes(blade, nodal)
    spin = motion.rotation[0] @ motion.angular_velocity[0]
    expected = (momentum * nodal[1]).sum() / 2 + spin @ turning_momentum(blade, floating_blade, motion)
    np.testing.assert_allclose(kept.kinetic, expected, rtol=1e-12)
    np.testing.assert_allclose(kept.momentum[0], momentum[:, :3].sum(axis=0), atol=1e-12)


def test_angular_momentum_about_the_global_origin(blade, floating_blade, motion, kept, nodal):
    momentum = momenta_of_nodes(blade, nodal)
    expected = np.cross(nodal[0], momentum[:, :3]).sum(axis=0) + momentum[:, 3:].sum(axis=0)
    expected = expected + turning_momentum(blade, floating_blade, motion)
    np.testing.assert_allclose(kept.angular_momentum[0], expected, atol=1e-12)


def test_potential_energy_is_that_of_the_weights(blade, kept, nodal):
    weights = np.zeros_like(nodal[1])
    weights[:, :3] = GRAVITY
    force = (blade.nodal_mass @ weights.ravel()).reshape(-1, 6)[:, :3]
    np.testing.assert_allclose(kept.potential, -(force * nodal[0]).sum(), rtol=1e-12)


def test_strain_energy_is_that_of_the_tensors(floating_blade, kept, motion):
    np.testing.assert_allclose(kept.strain, floating_blade.tensors.energy(motion.coordinates[0]), rtol=1e-12)


def test_total_is_the_sum(kept):
    np.testing.assert_allclose(kept.total, kept.kinetic + kept.strain + kept.potential)
