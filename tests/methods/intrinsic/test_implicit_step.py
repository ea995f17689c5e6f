"""Implicit steps: their slope, and their derivatives in both directions."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_lines import beam_line, rest_state, straight
from jax.flatten_util import ravel_pytree

from supple.body import RayleighDamping
from supple.integrate import GeneralizedAlpha
from supple.machine import Constant, DeadForce, Fixed, System
from supple.methods.intrinsic import CLAMPED, FREE, intrinsic_body
from supple.methods.intrinsic.line_march import Stepping, first_march_state, march_lines
from supple.methods.intrinsic.line_system import LineSystem, places_of, system_rates, system_slope
from supple.methods.intrinsic.machine_of_lines import machine_of_lines
from supple.methods.intrinsic.station_loads import Follower

SOFT = {"EA": 1e3, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.1}
AXES = np.vstack([np.eye(3), np.zeros((3, 3))])


@pytest.mark.parametrize("support", [CLAMPED, pytest.param(FREE, marks=pytest.mark.slow)])
def test_the_slope_is_the_derivative_of_the_rates(support):
    line = beam_line(straight(1.0, 4), **SOFT)
    body = intrinsic_body(line, support, 6, damping=RayleighDamping(0.1, 1e-3))
    joints = [Fixed(first="ground", second="beam.root")] if support is CLAMPED else []
    loads = [DeadForce(at="beam.tip", force=(0, 1.0, 2.0))]
    machine = machine_of_lines(System([body], joints, loads, gravity=np.array([0, 0, -9.81])), 0.0)
    draw = np.random.default_rng(3)
    states = jax.tree.map(lambda leaf: leaf + 0.1 * draw.normal(size=np.shape(leaf)), machine.start)
    flat, unravel = ravel_pytree(states)
    rates = jax.jit(jax.jacfwd(lambda y: ravel_pytree(system_rates(machine.lines, 0.3, unravel(y)))[0]))
    exact, slope = rates(flat), jax.jit(system_slope)(machine.lines, 0.3, states)
    assert np.abs(slope - exact).max() < 1e-13 * np.abs(exact).max()


@pytest.fixture(scope="module")
def tip_after():
    """Place of the tip after some implicit steps under a follower force (3,)."""
    model = intrinsic_body(beam_line(straight(1.0, 4), **SOFT), CLAMPED, 6).model

    def tip(force):
        rule = GeneralizedAlpha(0.9)
        system = LineSystem((model,), (None,), (Follower(AXES, Constant(jnp.asarray(force)), 4, 0),))
        start = first_march_state(system, rule, 0.0, (rest_state(model),))
        end = march_lines(Stepping(rule, 5), system, start, jnp.array([0.1, 0.2]), 1e-13)
        state = jax.tree.map(lambda leaf: leaf[-1], end.states[0])
        return places_of(model, None, state, 0.2).positions[-1]

    return jax.jit(tip)


@pytest.mark.slow
@pytest.mark.parametrize("direction", [jax.jacfwd, jax.jacrev])
def test_implicit_steps_are_differentiated_in_either_direction(tip_after, direction):
    force, step = jnp.array([0.1, 0.2, 3.0]), 1e-5
    slope = np.asarray(jax.jit(direction(tip_after))(force))
    differences = [
        np.asarray(tip_after(force + step * e) - tip_after(force - step * e)) / (2 * step) for e in np.eye(3)
    ]
    assert np.abs(slope[2, 2]) > 1e-3
    assert slope == pytest.approx(np.transpose(differences), rel=1e-5, abs=1e-8)
