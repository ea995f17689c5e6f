"""A rotor of four points against one in a floating frame: it spins about its long axis and is pushed aside.

Forces that keep their direction while the shaft turns bend it in ever new directions of its own: gyroscopic,
centrifugal and Euler forces, which the four-point frame has none of, must be inside its kinematics.
"""

import numpy as np
import pytest

from supple.body import MeanAxisFrame, flexible_body
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, Newmark, Run, Tolerances
from supple.machine import (
    DeadForce,
    Placed,
    Ramp,
    Scaled,
    System,
)
from supple.mesh import CellType, block
from supple.methods.explicit import (
    Explicit,
    modal_subdomain,
)
from supple.reduction import NoDerivatives, NoLoads, NormalModes, reduce
from supple.simulation import simulate

SPIN = np.array([0.5, 0.0, 0.02])
PUSH, SPAN = np.array([0.0, 0.01, 0.02]), 10.0
RISE = Ramp(1.0, 2.0)


@pytest.fixture(scope="module")
def body():
    model = solid_model(block(8, 1, 1, 8, 2, 2, CellType.TETRA4), Isotropic(100.0, 0.3, 1.0))
    return flexible_body("shaft", model).linearized()


def _floating(body, n):
    """Positions (t, N, 3) by the trapezoidal rule in a mean-axis frame."""
    reduced = reduce(body, MeanAxisFrame(), NormalModes(8), derivatives=NoDerivatives(), loads=NoLoads)
    run = Run(
        SPAN, SPAN / 4, step=FixedStep(SPAN / n), method=Newmark(), tolerances=Tolerances(residual=1e-11)
    )
    sets = body.model.mesh.node_sets
    loads = [
        DeadForce(body="shaft", at=sets[end], force=Scaled(PUSH / len(sets[end]), RISE))
        for end in ("root", "tip")
    ]
    solution = simulate(System((Placed(reduced, angular_velocity=SPIN),), loads=loads), run)
    return reduced.positions(solution.bodies["shaft"])


def _four_points(body, largest):
    part = modal_subdomain(body, NormalModes(8))
    pushes = [DeadForce(at=f"shaft.{end}", force=Scaled(PUSH, RISE)) for end in ("root", "tip")]
    system = System([Placed(part, angular_velocity=SPIN)], loads=pushes)
    solution = simulate(system, Run(SPAN, SPAN / 4, method=Explicit(safety=largest)))
    return part.positions(solution.bodies["shaft"])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.SuppleWarning")
def test_a_pushed_rotor_agrees_and_the_difference_is_that_of_the_steps(body):
    reference = _floating(body, 2000)
    near_run = _four_points(body, 0.1)
    near = np.abs(near_run - reference).max()
    far = np.abs(_four_points(body, 0.4) - reference).max()
    # It bends: the tips run ahead of the middle.
    sets = body.model.mesh.node_sets
    middle = np.abs(body.nodes[:, 0] - 4.0) < 1e-9
    ends = np.concatenate([sets["root"], sets["tip"]])
    bent = reference[-1, ends].mean(axis=0) - reference[-1, middle].mean(axis=0)
    assert np.linalg.norm(bent) > 1e-2
    assert near < 1e-2 * np.linalg.norm(bent)
    assert near < far / 8  # second order: a sixteenth
