"""The beam's energy, force, tangent and mass against their definitions and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

from supple.errors import ModelError
from supple_benchmarks.planar_beam import BANDWIDTH, ROTATING_BEAM, BeamElements


def dense(banded):
    n = banded.shape[1]
    row, column = np.indices((n, n))
    inside = abs(row - column) <= BANDWIDTH
    matrix = np.zeros((n, n))
    matrix[inside] = banded[(BANDWIDTH + row - column)[inside], column[inside]]
    return matrix


def crumpled(elements, seed=0):
    rng = np.random.default_rng(seed)
    return elements.straight(0.3) + 0.1 * rng.normal(size=(elements.n_nodes, 3))


def central_differences(function, q, step=1e-6):
    directions = np.eye(q.size).reshape(q.size, *q.shape)
    return np.array([(function(q + step * d) - function(q - step * d)) / (2 * step) for d in directions])


def test_force_is_the_gradient_of_the_energy():
    elements = BeamElements(ROTATING_BEAM, 5)
    q = crumpled(elements)
    force = elements.internal_force(q)
    difference = central_differences(elements.strain_energy, q)
    np.testing.assert_allclose(force, difference, atol=1e-8 * np.abs(force).max())


def test_tangent_is_the_gradient_of_the_force_and_symmetric():
    elements = BeamElements(ROTATING_BEAM, 5)
    q = crumpled(elements)
    _, _, banded = elements.residual_and_tangent(q, np.zeros_like(q), 0.0)
    tangent = dense(banded)
    difference = central_differences(elements.internal_force, q)
    np.testing.assert_allclose(tangent, difference, atol=1e-8 * np.abs(tangent).max())
    np.testing.assert_allclose(tangent, tangent.T, atol=1e-15 * np.abs(tangent).max())


def test_residual_adds_mass_times_acceleration():
    elements = BeamElements(ROTATING_BEAM, 4)
    q = crumpled(elements)
    acceleration = np.random.default_rng(1).normal(size=q.shape)
    residual, internal, _ = elements.residual_and_tangent(q, acceleration, 0.0)
    np.testing.assert_allclose(internal, elements.internal_force(q))
    inertia = dense(elements.banded_mass()) @ acceleration.reshape(-1)
    np.testing.assert_allclose(residual - internal, inertia, atol=1e-9 * np.abs(internal).max())


def test_a_rigid_turn_stores_no_energy():
    elements = BeamElements(ROTATING_BEAM, 6)
    scale = ROTATING_BEAM.axial_stiffness * ROTATING_BEAM.length
    assert abs(elements.strain_energy(elements.straight(2.5))) < 1e-25 * scale


def test_mass_matrix_carries_the_rigid_bodys_inertia():
    beam = ROTATING_BEAM
    elements = BeamElements(beam, 3)
    s = elements.arc_length
    push = np.stack([np.ones_like(s), 0 * s, 0 * s], axis=-1)
    turn = np.stack([0 * s, s, np.ones_like(s)], axis=-1)
    mass = beam.mass_per_length * beam.length
    inertia = mass * beam.length**2 / 3 + beam.rotary_inertia_per_length * beam.length
    assert 2 * elements.kinetic_energy(push) == pytest.approx(mass, rel=1e-13)
    assert 2 * elements.kinetic_energy(turn) == pytest.approx(inertia, rel=1e-13)


def straight_matrices(elements):
    q = elements.straight(0.0)
    _, _, banded = elements.residual_and_tangent(q, np.zeros_like(q), 0.0)
    return dense(banded), dense(elements.banded_mass())


def clamped_frequencies(elements):
    # The inverse problem M x = (1/lambda) K x keeps the lowest modes clear of the axial ones' round-off.
    stiffness, mass = straight_matrices(elements)
    return 1.0 / np.sqrt(eigh(mass[3:, 3:], stiffness[3:, 3:], eigvals_only=True)[::-1])


def test_clamped_frequencies_are_those_of_a_slender_cantilever():
    # Roots of 1 + cos x cosh x = 0; shear and rotary inertia lower them by (x/L)^2 (EI/GA + rho I/rho A).
    beam = replace(ROTATING_BEAM, shear_stiffness=1e9, rotary_inertia_per_length=1e-6)
    roots = np.array([1.8751040687, 4.6940911330, 7.8547574382])
    expected = roots**2 * math.sqrt(beam.bending_stiffness / beam.mass_per_length) / beam.length**2
    np.testing.assert_allclose(clamped_frequencies(BeamElements(beam, 20))[:3], expected, rtol=1e-4)


def test_free_beam_has_three_rigid_modes_and_no_more():
    eigenvalues = eigh(*straight_matrices(BeamElements(ROTATING_BEAM, 8)), eigvals_only=True)
    first = (
        4.7300407449**4
        * ROTATING_BEAM.bending_stiffness
        / ROTATING_BEAM.mass_per_length
        / ROTATING_BEAM.length**4
    )
    assert abs(eigenvalues[:3]).max() < 1e-4 * first
    assert eigenvalues[3] == pytest.approx(first, rel=1e-2)


def test_frequencies_converge_with_fourth_order():
    reference = clamped_frequencies(BeamElements(ROTATING_BEAM, 96))[1]
    counts = np.array([6, 12, 24])
    errors = [abs(clamped_frequencies(BeamElements(ROTATING_BEAM, n))[1] / reference - 1) for n in counts]
    rate = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert rate == pytest.approx(4.0, abs=0.3)


def test_properties_must_be_positive():
    with pytest.raises(ModelError, match="bending_stiffness is -1"):
        replace(ROTATING_BEAM, bending_stiffness=-1.0)
    with pytest.raises(ModelError, match="length is nan"):
        replace(ROTATING_BEAM, length=math.nan)


def test_at_least_one_element():
    with pytest.raises(ModelError, match="n_elements is 0"):
        BeamElements(ROTATING_BEAM, 0)
