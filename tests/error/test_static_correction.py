"""Self-correction at rest: it ends with an error that is true, or says why not."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.error import ReductionStart, SelfCorrection, SelfCorrectionError, correct_at_rest
from supple.errors import BasisWarning, ModelError
from supple.fem import Isotropic, solid_model
from supple.machine import GROUND, At, Fixed, Placed, System
from supple.mesh import CellType, block
from supple.quantities import WholeBody
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, NormalModes, reduce
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


def test_the_size_of_a_motion_is_above_its_rounding_errors(full):
    """A bar of length 1 that nothing deforms: displacements of 1e-18 would be compared with each other."""
    rest = equilibrium(System((full,), (CLAMP,)))
    assert WholeBody("bar").size(rest.system, rest.solution) == pytest.approx(1e-12, abs=0.0)
    loaded = equilibrium(System((full,), (CLAMP,), gravity=GRAVITY))
    deflection = np.linalg.norm(loaded.system.bodies[0].positions() - full.nodes, axis=1).max()
    assert WholeBody("bar").size(loaded.system, loaded.solution) == pytest.approx(deflection, rel=1e-6)


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


def test_a_fixed_size_beside_a_corrected_body_is_warned_of(full):
    """Both linear: the reduced bar lacks the shape under the force of the other, which moves with its tip."""
    model = solid_model(block(1.0, 0.1, 0.05, 4, 1, 1, CellType.HEXA8), Isotropic(1e9, 0.3, 1000.0))
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    inner = flexible_body("inner", model, ends).linearized()
    poor = reduce(inner, ROOT, NormalModes(1), derivatives=NoDerivatives(), loads=NoLoads)

    def machine(form):
        wall = Fixed(name="wall", first=GROUND, second=At("inner", "root"))
        elbow = Fixed(name="elbow", first=At("inner", "tip"), second=At("bar", "root"))
        load = GRAVITY[0] / 10, GRAVITY[1] / 10, GRAVITY[2] / 10
        return System((Placed(form), Placed(full, position=(1.0, 0.0, 0.0))), (wall, elbow), gravity=load)

    with pytest.warns(BasisWarning, match="basis of 'inner' has a fixed size; its error changes"):
        found, corrected = correct_at_rest(machine(poor), {"bar": start(relative=1e-4)})
    exact = equilibrium(machine(FullBody(inner, ROOT)))
    apart = found.system.bodies[1].positions() - exact.system.bodies[1].positions()
    last = corrected.missed["bar"][-1]
    assert np.sqrt(np.mean(np.sum(apart**2, axis=1))) > 10 * last.allowed > 10 * last.error
