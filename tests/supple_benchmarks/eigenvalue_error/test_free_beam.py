from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from supple.fem import Isotropic
from supple_benchmarks.eigenvalue_error.free_beam import RoundBeam

STEEL = Isotropic(2.1e11, 0.3, 7850.0)


def test_a_slender_beam_bends_as_euler_and_bernoulli_say():
    beam = RoundBeam(10.0, 0.01, STEEL)
    roots = [brentq(lambda x: np.cos(x) * np.cosh(x) - 1, a, a + 2) for a in (4, 7, 10)]
    stiffness, mass = STEEL.youngs_modulus * 0.01**2 / 4, STEEL.density
    exact = np.array(roots) ** 2 / 10.0**2 * np.sqrt(stiffness / mass) / (2 * np.pi)
    np.testing.assert_allclose(beam.bending(3), exact, rtol=1e-4)


def test_bending_satisfies_timoshenkos_frequency_equation():
    """The two wave numbers of each frequency, combined evenly or oddly, leave both ends free of load."""
    beam = RoundBeam(1.0, 0.05, STEEL)
    E, G, rho, k = STEEL.youngs_modulus, beam.shear_modulus, STEEL.density, beam.shear_coefficient
    r2 = 0.05**2 / 4
    for frequency in beam.bending(6):
        w2 = (2 * np.pi * frequency) ** 2
        # w = cos(a x), psi = A sin(a x) and the like: E r2 a^4 .. = 0 from the two equations of motion.
        p, q = rho * w2 / E, rho * w2 / (k * G)
        a2, b2 = (p + q) / 2 + np.array([1, -1]) * np.sqrt(((p - q) / 2) ** 2 + p / r2)
        waves = np.sqrt(np.array([a2, b2], dtype=complex))
        # psi = (a^2 - q) / a times w; the moment psi' and the shear w' - psi vanish at an end.
        slope = (waves**2 - q) / waves
        half = 0.5 * waves
        even = np.array([slope * waves * np.cos(half), (slope - waves) * np.sin(half)])
        odd = np.array([slope * waves * np.sin(half), (slope - waves) * np.cos(half)])

        def singular(matrix):
            scaled = matrix / np.linalg.norm(matrix, axis=1)[:, None]
            return abs(np.linalg.det(scaled))

        assert min(singular(even), singular(odd)) < 1e-8


def test_torsion_is_that_of_a_rod():
    beam = RoundBeam(0.5, 0.01, STEEL)
    speed = np.sqrt(beam.shear_modulus / STEEL.density)
    np.testing.assert_allclose(beam.torsion(3), speed * np.array([1.0, 2.0, 3.0]), rtol=1e-14)


def test_shear_coefficient():
    """6/7 without Poisson's effect, near Cowper's 6 (1 + nu) / (7 + 6 nu) with it."""
    assert RoundBeam(1.0, 0.1, Isotropic(1.0, 0.0, 1.0)).shear_coefficient == pytest.approx(6 / 7)
    assert RoundBeam(1.0, 0.1, STEEL).shear_coefficient == pytest.approx(7.8 / 8.8, rel=0.05)
