"""A quantity that stops being a number must stop the run, not pass for a converged step."""

import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import RigidBody
from supple.errors import ConvergenceError
from supple.integrate import Run
from supple.machine import GROUND, DeadForce, Placed, PrescribedRotation, System
from supple.simulation import simulate


def _rod() -> RigidBody:
    return RigidBody(
        "rod",
        mass=2.0,
        centre=(0.5, 0.0, 0.0),
        inertia=np.diag([0.01, 0.2, 0.2]),
        points={"end": (0.0, 0.0, 0.0)},
    )


def _until_half(time):
    return jnp.where(time < 0.5, time**3, jnp.nan)


@pytest.mark.slow
@pytest.mark.parametrize("cause", ["angle", "force"])
def test_nan_in_a_law_is_an_error(cause):
    hinge = PrescribedRotation(first=GROUND, second=("rod", "end"), axis=(0.0, 0.0, 1.0), angle=_until_half)
    push = DeadForce(body="rod", at="end", force=lambda time: _until_half(time) * jnp.ones(3))
    system = System(
        bodies=(Placed(_rod()),),
        joints=(hinge,) if cause == "angle" else (),
        loads=(push,) if cause == "force" else (),
    )
    recorded = []
    with pytest.raises(ConvergenceError, match=r"no convergence at t = 0\.(4|5)"):
        simulate(system, Run(duration=1.0, output_step=0.05), record=recorded.append)
    assert all(np.isfinite(part.bodies["rod"].position).all() for part in recorded)
    assert recorded[-1].times[-1] == pytest.approx(0.45)
