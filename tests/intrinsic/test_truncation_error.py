"""What modes left out would be: beside what they are when they are kept."""

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import ModalDamping
from supple.errors import ModelError
from supple.integrate import FixedStep, GeneralizedAlpha, Run
from supple.intrinsic import CLAMPED, intrinsic_body, truncation_error
from supple.machine import Fixed, FollowerTorque, System
from supple.simulation import simulate

LINE = beam_line(straight(1.0, 8), EA=1e4, EI=1.0, GJ=1.0, mass_per_length=1.0, radius=0.05)
CLAMP = Fixed(first="ground", second="beam.root")


def held(n_modes):
    """Bent by a moment at its middle, that sets in slowly."""
    body = intrinsic_body(LINE, CLAMPED, n_modes, stations={"middle": 4}, damping=ModalDamping(0.5))
    load = FollowerTorque(first="beam.middle", torque=lambda t: jnp.array([0.0, 1.2 * t, 0.0]))
    return body, System([body], [CLAMP], [load])


def test_the_estimate_is_what_the_modes_left_out_are_when_they_are_kept():
    run = Run(0.6, 0.1, step=FixedStep(5e-3), method=GeneralizedAlpha(0.9))
    whole, complete = held(None)
    exact = whole.forces_of(simulate(complete, run).bodies["beam"].coordinates)
    errors = []
    for n in (6, 12):
        _, system = held(n)
        found = truncation_error(system, simulate(system, run), [whole])["beam"]
        true = np.linalg.norm(exact[:, n:], axis=1) / np.linalg.norm(exact, axis=1).max()
        assert found.forces[-1] == pytest.approx(true[-1], rel=0.2)
        assert found.largest >= found.forces.max()
        errors.append(found.forces[-1])
    assert errors[1] < errors[0]


def test_a_body_without_more_modes_is_refused():
    body, system = held(6)
    run = Run(0.01, 0.01, step=FixedStep(5e-3), method=GeneralizedAlpha(0.9))
    solution = simulate(system, run)
    with pytest.raises(ModelError, match="give the same body with more of them"):
        truncation_error(system, solution, [body])
