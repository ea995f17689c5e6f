"""Every form of a body is on the page where `node_positions` has it, after a march of its own method."""

import numpy as np
import pytest
from fixtures.bar_of_every_form import PERIOD, bar_as, model
from fixtures.report_page import ReadPage

import supple as sp
from supple.machine import DeadForce, Placed, System
from supple.report import write_report

MESH = model().mesh
FORMS = ("rigid", "reduced", "full", "intrinsic", "modal", "finite elements")
N_OUTPUTS = 12


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_positions_are_those_of_the_run(tmp_path, form):
    """A bar that spins about a skew axis, flies, and is pushed at its tip."""
    bar = bar_as(form)
    tip = "tip" if form != "finite elements" else np.flatnonzero(MESH.nodes[:, 0] == 1.0)
    placed = Placed(
        bar,
        position=(1.0, 2.0, 3.0),
        rotation=(0.3, -0.2, 0.5),
        velocity=(1.0, 0.0, 2.0),
        angular_velocity=(1.0, 2.0, 9.0),
    )
    push = DeadForce(body="bar", at=tip, force=lambda time: 100 * time / PERIOD * np.array([0.0, 1.0, 0.5]))
    system = System([placed], loads=[push])
    run = sp.Run(2 * PERIOD, 2 * PERIOD / N_OUTPUTS, step=sp.FixedStep(PERIOD / 400))
    solution = sp.simulate(system, run)
    meshes = {} if form == "rigid" else {"bar": MESH}
    page = ReadPage(write_report(tmp_path / "run.html", system, solution, meshes, elements={"bar": model()}))
    motion = solution.bodies["bar"]
    if form == "rigid":
        position, rotation = page.poses("bar")
        assert position == pytest.approx(motion.position, abs=1e-6)
        assert rotation == pytest.approx(motion.rotation, abs=1e-6)
        return
    exact = sp.node_positions(bar, motion)
    deflection = page.field(page.body("bar")["displacement"])
    largest = np.linalg.norm(deflection, axis=2).max()
    assert largest > 1e-3
    assert len(page.positions("bar")[0]) == len(MESH.nodes)
    assert np.abs(page.positions("bar") - exact).max() < 1e-4 * largest + 5e-7
    assert page.head["scene"]["scales"]["von Mises stress"]["high"] > 0
