"""The march as one program: over cases, and differentiated by loads."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_lines import beam_line, rest_state, straight

from supple.integrate import RungeKutta4
from supple.machine import Constant
from supple.methods.intrinsic import CLAMPED, intrinsic_modes
from supple.methods.intrinsic.line_march import Stepping, first_march_state, march_lines
from supple.methods.intrinsic.line_model import line_model
from supple.methods.intrinsic.line_system import LineSystem, places_of
from supple.methods.intrinsic.station_loads import Follower

AXES = np.vstack([np.eye(3), np.zeros((3, 3))])


@pytest.fixture(scope="module")
def tip_after():
    """Place of the tip after some steps under a follower force (3,), frequencies times a factor."""
    line = beam_line(straight(1.0, 4), EA=1e3, EI=1.0, GJ=1.0, mass_per_length=1.0, radius=0.1)
    model = line_model(intrinsic_modes(line, CLAMPED, 6))

    def tip(force, factor=1.0):
        own = replace(model, omega=factor * model.omega)
        law = Constant(jnp.asarray(force))
        system = LineSystem((own,), (None,), (Follower(AXES, law, 4, 0),))
        start = first_march_state(system, RungeKutta4(), 0.0, (rest_state(own),))
        end = march_lines(Stepping(RungeKutta4(), 20), system, start, jnp.array([0.2]))
        state = jax.tree.map(lambda leaf: leaf[-1], end.states[0])
        return places_of(own, None, state, 0.2).positions[-1]

    return tip


@pytest.mark.slow
def test_cases_are_marched_together(tip_after):
    forces = np.array([[0, 0, 1.0], [0, 0.5, 2.0], [1.0, 0, 0]])
    together = jax.vmap(tip_after)(forces)
    assert np.asarray(together) == pytest.approx(np.array([tip_after(f) for f in forces]), abs=1e-13)


@pytest.mark.slow
def test_the_tip_is_differentiated_by_the_load(tip_after):
    force, step = jnp.array([0.1, 0.2, 3.0]), 1e-6
    slope = jax.grad(lambda f: tip_after(f)[2])(force)
    difference = [
        float(tip_after(force + step * e)[2] - tip_after(force - step * e)[2]) / (2 * step) for e in np.eye(3)
    ]
    assert np.asarray(slope) == pytest.approx(np.array(difference), rel=1e-6, abs=1e-9)


@pytest.mark.slow
def test_the_tip_is_differentiated_by_the_data_of_the_modes(tip_after):
    """Softer frequencies, at the same shapes: both through the march and through the places."""
    force, step = jnp.array([0.1, 0.2, 3.0]), 1e-6
    slope = jax.grad(lambda factor: tip_after(force, factor)[2])(1.0)
    difference = float(tip_after(force, 1 + step)[2] - tip_after(force, 1 - step)[2]) / (2 * step)
    assert abs(difference) > 1e-3
    assert float(slope) == pytest.approx(difference, rel=1e-6)
