"""Energies and momenta against sums over the nodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.integrate import FloatingMotion, Solution, Statistics
from supple.machine import Placed, System
from supple.multibody.checks.energy import balances

GRAVITY = np.array([0.3, -0.2, -9.81])


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
def in_columns(floating_blade):
    """The blade without the inertia of the motion that follows its columns."""
    return replace(floating_blade, condensed=None)


def balances_of(body, motion):
    system = System((Placed(body),), gravity=GRAVITY)
    return balances(system, Solution(np.zeros(1), {"blade": motion}, {}, Statistics()))


@pytest.fixture(scope="module")
def kept(in_columns, motion):
    return balances_of(in_columns, motion)


@pytest.fixture(scope="module")
def added(floating_blade, kept, motion):
    """What the condensed motion adds to each."""
    whole = balances_of(floating_blade, motion)
    return type(whole)(*(one - other for one, other in zip(whole, kept, strict=True)))


@pytest.fixture(scope="module")
def condensed_motion(floating_blade, motion):
    """z and dz/dt of the nodal freedoms (N, 6), body components."""
    moved = floating_blade.condensed
    first, second = np.triu_indices(floating_blade.r)
    g, rate = motion.coordinates[0], motion.coordinate_rates[0]
    products = g[first] * g[second], g[first] * rate[second] + rate[first] * g[second]
    return tuple((moved.fields @ (moved.amplitudes @ each)).reshape(-1, 6) for each in products)


@pytest.fixture(scope="module")
def nodal(floating_blade, motion):
    """Global positions (N, 3) and velocities (N, 6), translations and rotations, of all nodes."""
    A, spin = motion.rotation[0], motion.angular_velocity[0]
    place = floating_blade.nodes + floating_blade.expand(motion.coordinates[0])
    rates = (floating_blade.nodal_basis @ motion.coordinate_rates[0]).reshape(-1, 6)
    velocity = motion.velocity[0] + (np.cross(spin, place) + rates[:, :3]) @ A.T
    return motion.position[0] + place @ A.T, np.hstack([velocity, (spin + rates[:, 3:]) @ A.T])


def momenta_of_nodes(blade, nodal):
    """`M V`, (N, 6); the mass matrix of a shell does not couple directions, so global components will do."""
    return (blade.nodal_mass @ nodal[1].ravel()).reshape(-1, 6)


def test_kinetic_energy_and_momentum(blade, kept, nodal):
    momentum = momenta_of_nodes(blade, nodal)
    np.testing.assert_allclose(kept.kinetic, (momentum * nodal[1]).sum() / 2, rtol=1e-12)
    np.testing.assert_allclose(kept.momentum[0], momentum[:, :3].sum(axis=0), atol=1e-12)


def test_angular_momentum_about_the_global_origin(blade, kept, nodal):
    momentum = momenta_of_nodes(blade, nodal)
    expected = np.cross(nodal[0], momentum[:, :3]).sum(axis=0) + momentum[:, 3:].sum(axis=0)
    np.testing.assert_allclose(kept.angular_momentum[0], expected, atol=1e-12)


def test_potential_energy_is_that_of_the_weights(blade, kept, nodal):
    weights = np.zeros_like(nodal[1])
    weights[:, :3] = GRAVITY
    force = (blade.nodal_mass @ weights.ravel()).reshape(-1, 6)[:, :3]
    np.testing.assert_allclose(kept.potential, -(force * nodal[0]).sum(), rtol=1e-12)


def test_strain_energy_is_that_of_the_tensors(floating_blade, kept, motion):
    np.testing.assert_allclose(kept.strain, floating_blade.tensors.energy(motion.coordinates[0]), rtol=1e-12)


def test_the_condensed_motion_adds_its_work_against_the_rigid_motion(
    blade, floating_blade, added, motion, condensed_motion
):
    """T_z and its momenta, linear in z, summed over the nodes."""
    A, spin = motion.rotation[0], motion.angular_velocity[0]
    z, rate = condensed_motion
    assert np.abs(z).max() > 1e-3
    rigid = np.zeros(rate.shape)
    rigid[:, :3] = A.T @ motion.velocity[0] + np.cross(spin, blade.nodes)
    rigid[:, 3:] = spin
    moving = rate.copy()
    moving[:, :3] += np.cross(spin, z[:, :3])
    of_rigid, of_z = ((blade.nodal_mass @ each.ravel()).reshape(-1, 6) for each in (rigid, moving))
    np.testing.assert_allclose(added.kinetic, (of_rigid * moving).sum(), rtol=1e-10)
    linear = of_z[:, :3].sum(axis=0)
    np.testing.assert_allclose(added.momentum[0], A @ linear, rtol=1e-10)
    angular = np.cross(blade.nodes, of_z[:, :3]) + np.cross(z[:, :3], of_rigid[:, :3]) + of_z[:, 3:]
    expected = A @ angular.sum(axis=0) + np.cross(motion.position[0], A @ linear)
    np.testing.assert_allclose(added.angular_momentum[0], expected, rtol=1e-10)
    weights = np.zeros(z.shape)
    weights[:, :3] = A.T @ GRAVITY
    np.testing.assert_allclose(added.potential, -z.ravel() @ (blade.nodal_mass @ weights.ravel()), rtol=1e-10)
    assert added.strain == 0


def test_total_is_the_sum(kept):
    np.testing.assert_allclose(kept.total, kept.kinetic + kept.strain + kept.potential)
