"""The four-point frame against the floating frame: same body and modes, other coordinates and steps."""

import numpy as np
import pytest

from supple.body import MeanAxisFrame, flexible_body
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, Newmark, Run, Tolerances
from supple.machine import (
    Placed,
    System,
)
from supple.mesh import CellType, block
from supple.methods.explicit import (
    Explicit,
    modal_subdomain,
)
from supple.reduction import NoDerivatives, NoLoads, NormalModes, reduce
from supple.simulation import simulate

SPIN = np.array([0.05, 0.08, 0.1])
VELOCITY = np.array([0.2, 0.0, -0.1])
GRAVITY = np.array([0.0, 0.0, -0.02])
SPAN = 20.0


@pytest.fixture(scope="module")
def body():
    model = solid_model(block(8, 1, 1, 8, 2, 2, CellType.TETRA4), Isotropic(100.0, 0.3, 1.0))
    return flexible_body("box", model).linearized()


def _floating(body, n):
    """Positions (t, N, 3) by the trapezoidal rule in a mean-axis frame."""
    reduced = reduce(body, MeanAxisFrame(), NormalModes(8), derivatives=NoDerivatives(), loads=NoLoads)
    run = Run(
        SPAN, SPAN / 4, step=FixedStep(SPAN / n), method=Newmark(), tolerances=Tolerances(residual=1e-11)
    )
    solution = simulate(
        System((Placed(reduced, velocity=VELOCITY, angular_velocity=SPIN),), gravity=GRAVITY), run
    )
    return reduced.positions(solution.bodies["box"])


def _four_points(body, largest):
    part = modal_subdomain(body, NormalModes(8))
    system = System([Placed(part, velocity=VELOCITY, angular_velocity=SPIN)], gravity=GRAVITY)
    solution = simulate(system, Run(SPAN, SPAN / 4, method=Explicit(safety=largest)))
    return part.positions(solution.bodies["box"])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.SuppleWarning")
def test_free_flight_agrees_and_the_difference_is_that_of_the_steps(body):
    reference = _floating(body, 4000)
    near = np.abs(_four_points(body, 0.1) - reference).max()
    far = np.abs(_four_points(body, 0.4) - reference).max()
    assert near < 1e-4 * 8  # of the length
    assert near < far / 8  # second order: a sixteenth
