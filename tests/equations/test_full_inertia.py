"""Inertia of full bodies: their tangents, and the same equations by the Gram matrix."""

from __future__ import annotations

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_bodies import beam_body
from scipy.sparse import csc_array

from supple.body import inertia_gram
from supple.equations.floating_inertia import FloatingState, inertia_arrays, inertia_terms
from supple.equations.full_inertia import FullInertia, FullMotion
from supple.integrate import StepFactors

FACTORS = StepFactors(by_position=0.07, by_velocity=0.3)


@pytest.fixture(scope="module")
def body():
    """Beams whose sections have another inertia about each axis, and masses beside their nodes."""
    own = beam_body("root", n=3, length=2.0)
    shift = np.eye(6)
    shift[0, 4], shift[0, 5], shift[1, 3], shift[2, 3] = 0.1, 0.05, -0.05, -0.1
    shifts = csc_array(np.kron(np.eye(len(own.nodes)), shift))
    mass = csc_array(shifts.T @ own.nodal_mass @ shifts)
    return SimpleNamespace(
        **{
            name: getattr(own, name)
            for name in (
                "nodes",
                "dofs_per_node",
                "expansion",
                "rigid_modes",
                "n",
                "n_modal",
                "name",
                "threes",
            )
        },
        nodal_mass=mass,
        mass=csc_array(own.expansion.T @ mass @ own.expansion),
    )


@pytest.fixture(scope="module")
def motion(body):
    rng = np.random.default_rng(8)
    q, rates, accelerations = 0.2 * rng.standard_normal((3, body.n))
    return FullMotion(q, rates, accelerations, *rng.standard_normal((3, 3)))


def joined(terms):
    return np.concatenate([terms.frame, terms.own])


def test_the_forces_are_those_of_the_gram_matrix_of_all_motions(body, motion):
    arrays = inertia_arrays(inertia_gram(body, np.eye(body.n)))
    state = FloatingState(
        motion.coordinates,
        motion.angular_velocity,
        motion.rates,
        motion.frame_acceleration,
        motion.angular_acceleration,
        motion.accelerations,
    )
    expected = np.asarray(jax.jit(inertia_terms)(arrays, jax.tree.map(jnp.asarray, state)).force)
    found = joined(FullInertia(body).terms(motion))
    np.testing.assert_allclose(found, expected, atol=1e-12 * abs(expected).max())


def test_the_tangent_is_how_the_forces_follow_the_accelerations(body, motion):
    """By central differences, exact for what is quadratic in the change but for rounding."""
    inertia, n = FullInertia(body), body.n
    position, velocity = FACTORS

    def moved(change):
        return FullMotion(
            motion.coordinates + position * change[6:],
            motion.rates + velocity * change[6:],
            motion.accelerations + change[6:],
            motion.angular_velocity + velocity * change[3:6],
            motion.angular_acceleration + change[3:6],
            motion.frame_acceleration + change[:3],
        )

    step = 1e-4
    expected = np.array(
        [
            (joined(inertia.terms(moved(step * e))) - joined(inertia.terms(moved(-step * e)))) / (2 * step)
            for e in np.eye(6 + n)
        ]
    ).T
    columns, rows, corner = inertia.border(motion, FACTORS)
    weights = FullInertia.weights(motion.angular_velocity, motion.angular_acceleration, FACTORS)
    own = sum(
        weight * matrix.toarray()
        for kind, matrices in inertia.matrices.items()
        for weight, matrix in zip(weights[kind], matrices, strict=True)
    )
    found = np.block([[corner, rows], [columns, own]])
    np.testing.assert_allclose(found, expected, atol=1e-7 * abs(expected).max())


def test_momenta_are_derivatives_of_the_kinetic_energy(body, motion):
    """T is quadratic in the velocities: the momentum is exactly its central difference."""
    inertia = FullInertia(body)

    def momenta(w, v):
        return inertia.momenta(
            motion.coordinates[:, None], motion.rates[:, None], np.array(w)[:, None], np.array(v)[:, None]
        )

    w, v = motion.angular_velocity, motion.frame_acceleration
    found = momenta(w, v)
    for axis, e in enumerate(np.eye(3)):
        by_spin = momenta(w + e, v).kinetic - momenta(w - e, v).kinetic
        by_velocity = momenta(w, v + e).kinetic - momenta(w, v - e).kinetic
        assert found.angular[axis] == pytest.approx(by_spin / 2, rel=1e-11)
        assert found.linear[axis] == pytest.approx(by_velocity / 2, rel=1e-11)
