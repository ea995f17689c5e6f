"""Large static deflection against the elastica."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from supple.errors import ConvergenceError, ModelError
from supple_benchmarks.beam_statics import bend_beam
from supple_benchmarks.planar_beam import ROTATING_BEAM, BeamElements

FULL_TURN = 2 * math.pi * ROTATING_BEAM.bending_stiffness / ROTATING_BEAM.length


def test_an_end_moment_rolls_the_beam_into_a_circle():
    elements = BeamElements(ROTATING_BEAM, 16)
    q = bend_beam(elements, np.array([0.0, 0.0, FULL_TURN]))
    radius = ROTATING_BEAM.length / (2 * math.pi)
    angle = elements.arc_length / radius
    circle = radius * np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=-1)
    np.testing.assert_allclose(q[:, 2], angle, atol=1e-8)
    np.testing.assert_allclose(q[::2, :2], circle[::2], atol=5e-4 * radius)


def test_the_circle_is_approached_with_fourth_order():
    counts = np.array([8, 16, 32])
    radius = ROTATING_BEAM.length / math.pi
    half_turn = np.array([0.0, 0.0, 0.5 * FULL_TURN])
    errors = [
        abs(bend_beam(BeamElements(ROTATING_BEAM, n), half_turn)[-1, 1] / (2 * radius) - 1) for n in counts
    ]
    rate = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert rate == pytest.approx(4.0, abs=0.3)


def test_a_transverse_end_force_bends_the_beam_to_the_elastica():
    # EI theta'' = -P cos theta with theta(0) = theta'(L) = 0, solved as a boundary-value problem of its own.
    # Stretch and shear, which the elastica lacks, add about P/EA + P/GA = 1e-4.
    beam = ROTATING_BEAM
    P = 5.0 * beam.bending_stiffness / beam.length**2
    s = np.linspace(0.0, beam.length, 101)
    elastica = solve_bvp(
        lambda _, y: np.stack([y[1], -P / beam.bending_stiffness * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]),
        lambda a, b: np.array([a[0], b[1], a[2], a[3]]),
        s,
        np.stack([s / beam.length, 0 * s, s, 0.5 * s]),
        tol=1e-8,
    )
    tip = bend_beam(BeamElements(beam, 20), np.array([0.0, P, 0.0]))[-1]
    assert elastica.y[0, -1] > 1.0
    np.testing.assert_allclose(tip, elastica.y[[2, 3, 0], -1], rtol=3e-4)


def test_load_must_be_three_finite_numbers():
    with pytest.raises(ModelError, match="two force components and a moment"):
        bend_beam(BeamElements(ROTATING_BEAM, 2), np.array([1.0, math.nan, 0.0]))


def test_at_least_one_load_step():
    with pytest.raises(ModelError, match="n_load_steps is 0"):
        bend_beam(BeamElements(ROTATING_BEAM, 2), np.zeros(3), n_load_steps=0)


def test_a_load_taken_in_one_leap_says_what_to_do():
    with pytest.raises(ConvergenceError, match=r"load step 1 of 1 .* take more load steps"):
        bend_beam(BeamElements(ROTATING_BEAM, 8), np.array([0.0, 0.0, 40 * FULL_TURN]), n_load_steps=1)
