"""Pages of equilibria, modes and Campbell diagrams hold what was found, mode by mode."""

import numpy as np
import pytest
from fixtures.moving_machines import MESH
from fixtures.report_page import ReadPage

import supple as sp
from supple.equations.build_model import system_length
from supple.linearization import CampbellDiagram, mode_motion
from supple.linearization.mode_names import mode_names
from supple.machine import DeadForce, Fixed, System
from supple.quantities import deflections
from supple.report import write_campbell_report, write_modes_report, write_static_report
from supple.report.write_rest_report import AMPLITUDE
from supple.results import summarize
from supple.units import SI


@pytest.fixture(scope="module")
def bent(clamped_blade):
    """A clamped blade under a force at its tip, at rest."""
    clamp = Fixed(first="ground", second="blade.root")
    force = DeadForce(at="blade.tip", force=(0.0, 0.0, 1e-3))
    return sp.equilibrium(System([clamped_blade], joints=[clamp], loads=[force]))


@pytest.mark.slow
def test_an_equilibrium_is_one_instant(tmp_path, bent):
    body, motion = bent.system.placed("blade").body, bent.solution.bodies["blade"]
    numbers = {**summarize(bent.system, bent.solution, units=SI), "errors": {}}
    page = ReadPage(write_static_report(tmp_path / "rest.html", bent, {"blade": MESH}, numbers, units=SI))
    exact = deflections(body, motion)
    assert page.field(page.body("blade")["displacement"]) == pytest.approx(exact, abs=1e-4 * exact.max())
    assert "The equilibrium is stable" in page.text
    assert page.head["charts"] == []


@pytest.mark.slow
def test_each_mode_is_a_clip_that_repeats_itself(tmp_path, bent):
    modes = sp.machine_modes(sp.linearize(bent.system), 3)
    path = write_modes_report(tmp_path / "modes.html", modes, {"blade": MESH}, chosen=[0, 2], units=SI)
    page = ReadPage(path)
    first, third = page.head["clips"]
    names = mode_names(modes)
    assert [first["name"], third["name"]] == [f"1: {names[0]}", f"3: {names[2]}"]
    frequency = modes.frequencies[2] / (2 * np.pi)
    assert third["note"].startswith(f"{frequency:.5g} Hz, damping ")
    assert third["note"].endswith(f"Frequencies are in axes {modes.machine.axes}.")
    assert third["repeats"]
    rows = slice(third["first"], third["first"] + third["number"])
    found = page.field(page.body("blade")["displacement"])[rows]
    body = bent.system.placed("blade").body
    size = AMPLITUDE * system_length(bent.system)
    shape = deflections(body, mode_motion(modes, 2, amplitude=size).bodies["blade"])
    assert found == pytest.approx(shape, abs=1e-4 * np.abs(shape).max())
    times = page.array(page.head["scene"]["times"])[rows]
    assert len(times) * (times[1] - times[0]) == pytest.approx(1 / frequency, rel=1e-5)
    # A mode has no size: its colours are shares.
    assert page.head["scene"]["scales"]["deflection"]["label"] == "deflection, share of the largest"


def test_a_campbell_diagram_is_over_rotations_per_minute(tmp_path):
    rates, frequencies = np.array([0.0, np.pi]), np.array([[2.0, 5.0], [3.0, 4.0]]) * 2 * np.pi
    names = ("flap 1", "edge 1")
    diagram = CampbellDiagram(rates, -0.1 + 1j * frequencies, np.ones((1, 2)), axes="that turn", names=names)
    page = ReadPage(write_campbell_report(tmp_path / "c.html", diagram, units=SI))
    shown, damping = page.head["charts"]
    assert page.array(shown["abscissa"]) == pytest.approx([0.0, 30.0])
    assert page.array(shown["curves"])[:2] == pytest.approx(frequencies.T / (2 * np.pi), rel=1e-6)
    # Once a rotation at 30 rpm is half a Hz.
    assert page.array(shown["curves"])[2:, 1] == pytest.approx([0.5, 1.0, 1.5, 2.0])
    assert page.array(damping["curves"]) == pytest.approx(100 * diagram.damping_ratios.T, rel=1e-6)
    assert shown["names"] == [*names, "1P", "2P", "3P", "4P"]
    assert shown["over"] == "speed (rpm)"
    assert shown["note"] == "seen in axes that turn"
    assert page.head["scene"] is None
