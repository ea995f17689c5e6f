"""The Newmark family on the linear oscillator: order, spectral radius, members, local error."""

from __future__ import annotations

import numpy as np
import pytest

from supple.integrate import Coefficients, GeneralizedAlpha, HilberHughesTaylor, Newmark, StepRule

METHODS = [
    GeneralizedAlpha(),
    GeneralizedAlpha(rho_inf=0.0),
    GeneralizedAlpha(rho_inf=0.5),
    GeneralizedAlpha(rho_inf=1.0),
    HilberHughesTaylor(),
    HilberHughesTaylor(alpha=1 / 3),
    Newmark(),
]
OMEGA, RATIO = 2.0, 0.05


def one_step(rule, q, v, vdot, a):
    """One step for `vdot = -omega^2 q - 2 ratio omega v`, whose new acceleration is found in closed form."""
    stiffness, damping = OMEGA**2, 2 * RATIO * OMEGA
    guess = rule.auxiliary(0.0, vdot, a)
    q_guess, v_guess = q + rule.increment(v, a, guess), rule.new_velocity(v, a, guess)
    new = -(stiffness * q_guess + damping * v_guess) / (
        1 + stiffness * rule.factors.by_position + damping * rule.factors.by_velocity
    )
    a_new = rule.auxiliary(new, vdot, a)
    return q + rule.increment(v, a, a_new), rule.new_velocity(v, a, a_new), new, a_new


def exact(t):
    """q(0) = 1, v(0) = 0."""
    damped = OMEGA * np.sqrt(1 - RATIO**2)
    decay = np.exp(-RATIO * OMEGA * t)
    return decay * (np.cos(damped * t) + RATIO * OMEGA / damped * np.sin(damped * t))


def largest_error(method, n, duration=3.0):
    """Over n steps."""
    rule = StepRule(method.coefficients, duration / n)
    state = (1.0, 0.0, -(OMEGA**2), -(OMEGA**2))
    errors = []
    for i in range(n):
        state = one_step(rule, *state)
        errors.append(abs(state[0] - exact((i + 1) * rule.h)))
    return max(errors)


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_order_is_two(method):
    errors = np.array([largest_error(method, n) for n in (200, 400, 800)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.01)


def amplification(method, h_omega):
    """Matrix that takes `(q, h v, h^2 vdot, h^2 a)` over one step of the undamped oscillator."""
    rule = StepRule(method.coefficients, 1.0)
    columns = []
    for q, v, vdot, a in np.eye(4):
        guess = rule.auxiliary(0.0, vdot, a)
        new = -(h_omega**2) * (q + rule.increment(v, a, guess)) / (1 + h_omega**2 * rule.factors.by_position)
        a_new = rule.auxiliary(new, vdot, a)
        columns.append([q + rule.increment(v, a, a_new), rule.new_velocity(v, a, a_new), new, a_new])
    return np.array(columns).T


def spectral_radius(method, h_omega):
    return np.max(abs(np.linalg.eigvals(amplification(method, h_omega))))


@pytest.mark.parametrize("rho_inf", [0.0, 0.3, 0.5, 0.8, 1.0])
def test_spectral_radius_at_infinite_frequency_is_rho_inf(rho_inf):
    """The defining property (Chung & Hulbert 1993); multiple eigenvalues there cost half the digits."""
    np.testing.assert_allclose(spectral_radius(GeneralizedAlpha(rho_inf), 1e7), rho_inf, atol=2e-3)


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_unconditionally_stable(method):
    radii = [spectral_radius(method, x) for x in np.logspace(-3, 6, 200)]
    assert max(radii) <= 1 + 1e-7


def test_low_frequencies_are_not_damped():
    """A mode of twenty steps a period keeps its amplitude to second order of the step and better."""
    losses = [1 - spectral_radius(GeneralizedAlpha(0.8), 2 * np.pi / n) for n in (20, 40)]
    assert 0 < losses[0] < 1e-4
    assert losses[0] / losses[1] > 7  # third order


def test_generalized_alpha_without_damping_is_the_midpoint_member():
    assert GeneralizedAlpha(1.0).coefficients == Coefficients(0.5, 0.5, 0.25, 0.5)


def test_newmark_is_the_trapezoidal_rule():
    assert Newmark().coefficients == Coefficients(0.0, 0.0, 0.25, 0.5)


def test_newmark_conserves_the_energy_of_the_oscillator():
    np.testing.assert_allclose(abs(np.linalg.eigvals(amplification(Newmark(), 0.7))).max(), 1.0, rtol=1e-14)


def test_hilber_hughes_taylor_without_damping_is_newmark():
    assert HilberHughesTaylor(0.0).coefficients == Newmark().coefficients


def test_hilber_hughes_taylor_coefficients():
    """beta = (1 + alpha)^2 / 4, gamma = 1/2 + alpha (Hilber, Hughes & Taylor 1977)."""
    alpha = 0.2
    np.testing.assert_allclose(
        HilberHughesTaylor(alpha).coefficients, (0.0, alpha, (1 + alpha) ** 2 / 4, 0.5 + alpha), rtol=1e-15
    )


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_step_rule_states_its_own_derivatives(method):
    """`by_position` and `by_velocity` are d increment / d vdot and d velocity / d vdot."""
    rule = StepRule(method.coefficients, 0.3)
    unit = rule.auxiliary(1.0, 0.0, 0.0)
    kappa = (1 - rule.coefficients.alpha_f) / (1 - rule.coefficients.alpha_m)
    np.testing.assert_allclose(unit, kappa, rtol=1e-15)
    np.testing.assert_allclose(rule.increment(0.0, 0.0, unit), rule.factors.by_position, rtol=1e-15)
    np.testing.assert_allclose(rule.new_velocity(0.0, 0.0, unit), rule.factors.by_velocity, rtol=1e-15)


def test_constant_acceleration_is_exact():
    rule = StepRule(GeneralizedAlpha().coefficients, 0.2)
    np.testing.assert_allclose(rule.auxiliary(3.0, 3.0, 3.0), 3.0, rtol=1e-15)
    np.testing.assert_allclose(rule.increment(2.0, 3.0, 3.0), 2.0 * 0.2 + 3.0 * 0.2**2 / 2, rtol=1e-15)
    np.testing.assert_allclose(rule.new_velocity(2.0, 3.0, 3.0), 2.0 + 3.0 * 0.2, rtol=1e-15)


@pytest.mark.parametrize("method", [Newmark(), GeneralizedAlpha(), HilberHughesTaylor()], ids=str)
def test_position_error_is_the_leading_local_error(method):
    """One step with accelerations `a(t) = t`: q = h^3/6 exactly, and h^3 beta by the rule."""
    h = 0.1
    rule = StepRule(method.coefficients, h)
    local = rule.increment(0.0, 0.0, h) - h**3 / 6
    np.testing.assert_allclose(rule.position_error(0.0, h), local, rtol=1e-12)


@pytest.mark.parametrize("rho_inf", [-0.1, 1.1, float("nan")])
def test_rho_inf_outside_its_range_is_refused(rho_inf):
    with pytest.raises(ValueError, match=r"rho_inf must lie in \[0, 1\], got"):
        GeneralizedAlpha(rho_inf)


@pytest.mark.parametrize("alpha", [-0.01, 0.34, float("nan")])
def test_hht_parameter_outside_its_range_is_refused(alpha):
    with pytest.raises(ValueError, match=r"the HHT parameter must lie in \[0, 1/3\], got"):
        HilberHughesTaylor(alpha)
