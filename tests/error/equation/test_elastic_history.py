"""Forces and tangents along a run, seen by other columns, against the sums over the elements."""

from __future__ import annotations

import numpy as np
import pytest
from error.equation.machines import soft_strip
from scipy.linalg import eigh

from supple.error.equation import elastic_history
from supple.error.equation.elastic_history import (
    force_polynomial,
    strain_rate_history,
    strain_rate_polynomial,
    tangent_history,
)

N_STEPS = 60


@pytest.fixture(scope="module")
def along():
    """A body, columns of a motion through it, columns to look at it by, coordinates and rates over time."""
    body = soft_strip("strip", 1.0)
    rng = np.random.default_rng(3)
    motion, onto = rng.standard_normal((body.n, 4)), rng.standard_normal((body.n, 9))
    times = np.linspace(0, 1, N_STEPS)
    frequencies = np.array([3.0, 7.0, 11.0, 2.0])
    sizes = np.array([0.3, 0.2, 0.01, 0.1])
    coordinates = sizes * np.sin(np.outer(times, frequencies))
    rates = sizes * frequencies * np.cos(np.outer(times, frequencies))
    return body, motion, onto, coordinates, rates


def test_the_force_is_that_of_the_elements(along):
    body, motion, onto, coordinates, _ = along
    gained = force_polynomial(body.assembly.works(motion, onto))(coordinates)
    for row in (1, 20, 59):
        q = motion @ coordinates[row]
        exact = onto.T @ (body.assembly.internal_force(q) - body.stiffness @ q)
        np.testing.assert_allclose(gained[row], exact, rtol=1e-9, atol=1e-11 * np.abs(exact).max())


def test_tangents_between_the_chosen_instants_are_those_of_the_elements(along):
    body, motion, onto, coordinates, _ = along
    tangents = tangent_history(body, motion, coordinates, onto, material=True, proven=0.0)
    assert len(tangents.whole) < N_STEPS / 2
    for row in range(1, N_STEPS):
        q = motion @ coordinates[row]
        whole = onto.T @ ((body.assembly.tangent(q) - body.stiffness) @ onto)
        geometric = onto.T @ (body.assembly.tangent(q, material=0.0) @ onto)
        material, told = (
            np.tensordot(tangents.weights[row], s, axes=1) for s in (tangents.material, tangents.whole)
        )
        size = np.abs(whole).max()
        np.testing.assert_allclose(told, whole, atol=1e-5 * size)
        np.testing.assert_allclose(told - material, geometric, atol=1e-5 * size)


def test_fewer_instants_are_taken_where_they_give_the_tangents_of_all(along):
    """Of less deformation: in no direction more than a thousandth of the stiffness at rest is missed."""
    body, motion, onto, coordinates, _ = along
    onto = onto - body.rigid_modes @ np.linalg.lstsq(body.rigid_modes, onto, rcond=None)[0]
    stiffness = onto.T @ (body.stiffness @ onto)
    sizes = []
    for scale in (1.0, 0.03, 1e-6):
        tangents = tangent_history(body, motion, scale * coordinates, onto)
        sizes.append(len(tangents.whole))
        for row in range(1, N_STEPS, 5):
            exact = onto.T @ (body.assembly.tangent(scale * motion @ coordinates[row]) @ onto) - stiffness
            missed = np.tensordot(tangents.weights[row], tangents.whole, axes=1) - exact
            assert np.abs(eigh(missed, stiffness, eigvals_only=True)).max() < 1e-3
    assert sizes[2] == elastic_history.AT_ONCE < sizes[0]


def test_the_force_of_strain_rates_is_that_of_the_elements(along):
    body, motion, onto, coordinates, rates = along
    gained = strain_rate_polynomial(body.assembly.works(motion, onto))(coordinates, rates)
    for row in (1, 20, 59):
        q, rate = motion @ coordinates[row], motion @ rates[row]
        exact = onto.T @ (body.assembly.strain_rate_force(q, rate) - body.stiffness @ rate)
        np.testing.assert_allclose(gained[row], exact, rtol=1e-9, atol=1e-11 * np.abs(exact).max())


@pytest.mark.parametrize("smallest", [1e-6, elastic_history.SMALLEST_RATE])
def test_what_strain_rates_add_is_the_derivative_of_their_force(along, monkeypatch, smallest):
    """Central difference over the coordinates at constant rates; the force is quadratic in them: exact."""
    monkeypatch.setattr(elastic_history, "SMALLEST_RATE", smallest)
    body, motion, onto, coordinates, rates = along
    told = strain_rate_history(body, motion, coordinates, rates, onto, 1.0, proven=0.0)
    assert len(told.samples) < N_STEPS / 2
    for row in (3, 30, 52):
        q, rate = motion @ coordinates[row], motion @ rates[row]
        ahead, behind = (
            np.column_stack([body.assembly.strain_rate_force(q + sign * z, rate) for z in onto.T])
            for sign in (1, -1)
        )
        exact = onto.T @ (ahead - behind) / 2
        assert np.abs(exact - exact.T).max() > 0.03 * np.abs(exact).max()
        found = np.tensordot(told.weights[row], told.samples, axes=1)
        np.testing.assert_allclose(found, exact, atol=10 * smallest * np.abs(exact).max())


def test_a_motion_without_strain_energy_changes_no_tangent(along):
    """Its energy is round-off, of either sign."""
    body, motion, onto, coordinates, rates = along
    rng = np.random.default_rng(0)
    rigid = body.rigid_modes @ rng.standard_normal((6, 20))
    energies = np.sum(rigid * (body.stiffness @ rigid), axis=0)
    moved = np.column_stack([motion, rigid[:, np.argmin(energies)]])
    assert energies.min() < 0
    more = np.pad(coordinates, ((0, 0), (0, 1))), np.pad(rates, ((0, 0), (0, 1)))
    known = tangent_history(body, motion, coordinates, onto)
    np.testing.assert_allclose(tangent_history(body, moved, more[0], onto).weights, known.weights, atol=1e-9)
    assert np.isfinite(strain_rate_history(body, moved, *more, onto, 1.0).weights).all()


def test_a_body_that_does_not_deform_gains_nothing(along):
    body, motion, onto, coordinates, rates = along
    tangents = tangent_history(body, motion, 0 * coordinates, onto)
    assert tangents.whole.shape == tangents.material.shape == (0, 9, 9)
    assert strain_rate_history(body, motion, 0 * coordinates, 0 * rates, onto, 1.0).samples.shape == (0, 9, 9)
    assert not force_polynomial(body.assembly.works(motion, onto))(0 * coordinates).any()
