"""Bodies that correct themselves and start deformed: their first bases hold that deformation."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.error import ReductionStart, SelfCorrection, self_correct
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, Run
from supple.machine import GROUND, At, Fixed, System
from supple.mesh import strip
from supple.reduction import CompressedDerivatives, CraigBampton
from supple.simulation import equilibrium

RUN = Run(duration=0.5, output_step=0.05, step=FixedStep(0.01))
START = ReductionStart(SelfCorrection(relative=1e-3, instants=5), CraigBampton(1), CompressedDerivatives(1))


@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(NodalFixedFrame("root"), id="nodal-fixed", marks=pytest.mark.slow),
        pytest.param(MeanAxisFrame(), id="mean-axis"),
    ],
)
def test_a_machine_that_rests_in_full_rests_on_its_bases(frame):
    """A strip that sags by 6 % of its length stays so, though a mode and a derivative do not hold its sag."""
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    body = flexible_body("strip", shell_model(strip(1.0, 0.1, 6, 2), wall), [RigidInterface("root", "root")])
    clamp = Fixed(name="clamp", first=GROUND, second=At("strip", "root"))
    found = equilibrium(System((FullBody(body, frame),), (clamp,), gravity=(0, 0, -4.0)))
    rest = found.system.bodies[0].positions()
    sag = np.linalg.norm(rest - body.nodes, axis=1).max()
    assert 0.04 < sag < 0.1
    corrected = self_correct(found.system, RUN, START)
    first = corrected.bodies["strip"].rounds[0]
    assert first.size == 3
    assert first.estimated_error < 1e-6 * sag
    placed = corrected.system.bodies[0]
    assert np.abs(placed.positions() - rest).max() < 1e-9 * sag
    for solution in (first.solution, corrected.solution):
        moved = solution.bodies["strip"].coordinates
        assert np.ptp(moved, axis=0).max() < 1e-8 * np.abs(moved).max()
