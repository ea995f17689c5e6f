"""What modes left out would be: beside what they are when they are kept."""

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import ModalDamping
from supple.errors import ModelError
from supple.integrate import FixedStep, GeneralizedAlpha, Run
from supple.intrinsic import CLAMPED, enough_modes, intrinsic_body, truncation_error
from supple.intrinsic.intrinsic_body import body_of
from supple.machine import Fixed, FollowerTorque, System
from supple.simulation import simulate

LINE = beam_line(straight(1.0, 8), EA=1e4, EI=1.0, GJ=1.0, mass_per_length=1.0, radius=0.05)
CLAMP = Fixed(first="ground", second="beam.root")


def held(n_modes):
    """Bent by a moment at its middle, that sets in slowly."""
    body = intrinsic_body(LINE, CLAMPED, n_modes, stations={"middle": 4}, damping=ModalDamping(0.5))
    load = FollowerTorque(first="beam.middle", torque=lambda t: jnp.array([0.0, 1.2 * t, 0.0]))
    return body, System([body], [CLAMP], [load])


@pytest.mark.slow
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


@pytest.mark.slow
def test_as_many_modes_are_taken_as_the_tolerance_asks_for():
    """Of 48; half as many miss it. Forces jump at the moment and need many modes, the tip's place few."""
    run = Run(0.6, 0.2, step=FixedStep(5e-3), method=GeneralizedAlpha(0.9))
    whole, system = held(None)
    found = enough_modes(system, lambda machine: simulate(machine, run), tolerance=0.3)
    body = body_of(found.system.bodies[0])
    n = body.n_coordinates
    assert 6 < n < whole.n_coordinates
    assert found.errors["beam"].largest <= 0.3
    half = whole.truncated(n // 2)
    fewer = System([half], system.joints, system.loads)
    assert truncation_error(fewer, simulate(fewer, run), [whole])["beam"].largest > 0.3
    exact = whole.positions(simulate(system, run).bodies["beam"])[:, -1]
    away = np.abs(body.positions(found.solution.bodies["beam"])[:, -1] - exact).max()
    assert away < 0.01 * np.abs(exact - exact[0]).max()


@pytest.mark.slow
def test_all_modes_are_kept_where_no_fewer_are_enough():
    run = Run(0.6, 0.2, step=FixedStep(5e-3), method=GeneralizedAlpha(0.9))
    _, system = held(None)
    found = enough_modes(system, lambda machine: simulate(machine, run), tolerance=1e-12, first=24)
    assert found.system is system
    assert found.errors == {}
    with pytest.raises(ModelError, match="between 0 and 1"):
        enough_modes(system, lambda _: found.solution, tolerance=2.0)
    with pytest.raises(ModelError, match="one at least"):
        enough_modes(system, lambda _: found.solution, tolerance=0.1, first=0)
