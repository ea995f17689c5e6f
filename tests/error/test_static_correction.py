"""Self-correction at rest: it ends with an error that is true, or says why not."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.error import ReductionStart, SelfCorrection, SelfCorrectionError, correct_at_rest
from supple.errors import ModelError
from supple.fem import Isotropic, solid_model
from supple.machine import GROUND, At, Fixed, System
from supple.mesh import CellType, block
from supple.reduction import CraigBampton, NoDerivatives
from supple.simulation import equilibrium

ROOT = NodalFixedFrame("root")
GRAVITY = (0.3, 0.2, -1.0)
CLAMP = Fixed(name="clamp", first=GROUND, second=At("bar", "root"))


@pytest.fixture(scope="module")
def full():
    model = solid_model(block(1.0, 0.1, 0.05, 4, 1, 1, CellType.HEXA8), Isotropic(1e9, 0.3, 1000.0))
    bar = flexible_body("bar", model, (RigidInterface("root", "root"),)).linearized()
    return FullBody(bar, ROOT)


def start(**target):
    return ReductionStart(SelfCorrection(**target), CraigBampton(1), NoDerivatives())


def test_one_column_a_rest_is_enough(full):
    system = System((full,), (CLAMP,), gravity=GRAVITY)
    found, corrected = correct_at_rest(system, start(relative=1e-4))
    exact = equilibrium(system).system.bodies[0]
    (placed,) = found.system.bodies
    apart = placed.positions() - exact.positions()
    deflection = np.linalg.norm(exact.positions() - full.nodes, axis=1).max()
    assert np.sqrt(np.mean(np.sum(apart**2, axis=1))) < 1e-6 * deflection
    assert corrected.bases["bar"].r == 2
    first, last = corrected.missed["bar"]
    assert first.error > 1e-4 * deflection > last.error
    assert corrected.system.bodies[0].body.r == 2


def test_what_is_not_reached_is_said_with_its_errors(full):
    system = System((full,), (CLAMP,), gravity=GRAVITY)
    with pytest.raises(SelfCorrectionError, match=r"at rest did not reach .* 2 coordinates, more than 1 all"):
        correct_at_rest(system, start(relative=1e-4, largest_size=1))


@pytest.mark.parametrize(
    ("target", "message"),
    [({}, "name at least one body"), ({"beam": start(relative=1e-3)}, "'beam' must be in the system as a")],
)
def test_bodies_that_are_not_there_are_named(full, target, message):
    with pytest.raises(ModelError, match=message):
        correct_at_rest(System((full,), (CLAMP,)), target)
