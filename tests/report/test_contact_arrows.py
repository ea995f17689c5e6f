"""Contact forces of a run are arrows and curves of its page; no line stands for a contact element."""

from dataclasses import replace

import numpy as np
import pytest
from fixtures.moving_machines import FAR, N_TIMES, eroding, tumbling, two_bodies
from fixtures.report_page import ReadPage

from supple.body import RigidBody
from supple.integrate import Solution, Statistics
from supple.machine import At, Contact, Penalty, Placed, RigidPlane, SphereOnPlane, System, Unbalance
from supple.methods.explicit import CONTACTS, OBSTACLES
from supple.report import write_report
from supple.units import SI


def test_those_of_an_explicit_march(tmp_path):
    system, solution = eroding(np.ones((3, 4)))
    walls = [RigidPlane((9.0, 0, 0), (-1, 0, 0)), RigidPlane((0, 0, -9.0), (0, 0, 1))]
    hit = replace(system, contacts=[Contact(At("bar", "tip"), wall) for wall in walls])
    force = np.array([[[0, 0, 0], [-5.0, 1.0, 0], [-2.0, 0, 0]], [[0, 0, 0], [0, 0, 0], [0, 0, 4.0]]])
    place = np.random.default_rng(3).uniform(-1, 1, (2, 3, 3)) + FAR
    recorded = np.concatenate([force, place], axis=2).transpose(1, 0, 2).reshape(3, 12)
    run = replace(solution, series={CONTACTS: recorded, OBSTACLES: np.zeros((3, 12))})
    page = ReadPage(write_report(tmp_path / "run.html", hit, run, units=SI))
    for number, arrow in enumerate(page.head["scene"]["arrows"]):
        assert arrow["kind"] == "contact"
        assert arrow["name"] == ("contact of bar.tip", "contact of bar.tip (2)")[number]
        assert page.array(arrow["values"]).T == pytest.approx(force[number])
        assert page.place(arrow["place"]) == pytest.approx(place[number], abs=1e-4)
    scene = page.head["scene"]
    length = scene["arrowLength"]
    # The largest of both pushes along -x: its arrow begins so far beyond its place, and is in the picture.
    begins = place[0, 1] + length * np.array([5.0, -1.0, 0.0]) / np.sqrt(26)
    assert (np.abs(begins - scene["middle"]) <= np.array(scene["half"]) * (1 + 1e-9)).all()
    curves = [chart for chart in page.head["charts"] if chart["title"].startswith("contact of bar.tip")]
    assert [page.array(each["curves"]).T.tolist() for each in curves] == force.tolist()
    assert curves[0]["label"] == "force (N)"


def test_a_ball_pressed_into_a_plane_and_an_unbalance(tmp_path):
    """Penalty k times depth along the plane's normal; - omega x (omega x U)."""
    ball = RigidBody("ball", 1.0, np.zeros(3), np.eye(3), {"middle": np.zeros(3)})
    times = np.linspace(0.0, 1.0, N_TIMES)
    motion = tumbling(0)
    height = 0.3 - 0.2 * times
    spin = np.tile([0.0, 0.0, 4.0], (N_TIMES, 1))
    still = np.tile(np.eye(3), (N_TIMES, 1, 1))
    motion = replace(
        motion,
        position=height[:, None] * np.eye(3)[2],
        rotation=still,
        angular_velocity=spin,
        velocity=0 * spin,
    )
    plane = SphereOnPlane(
        first="ball.middle",
        second="ground",
        axis=(0, 0, 1),
        anchor=(0, 0, 0),
        radius=0.25,
        penalty=Penalty(stiffness=200.0),
    )
    system = System(
        [Placed(ball, position=(0, 0, 0.3))],
        loads=[plane, Unbalance(first="ball.middle", moment=(0.1, 0, 0))],
    )
    page = ReadPage(
        write_report(tmp_path / "run.html", system, Solution(times, {"ball": motion}, {}, Statistics()))
    )
    contact, unbalance = page.head["scene"]["arrows"]
    pushed = 200.0 * np.maximum(0.25 - height, 0.0)
    assert (contact["kind"], unbalance["kind"]) == ("contact", "force")
    assert page.array(contact["values"]).T == pytest.approx(pushed[:, None] * np.eye(3)[2], abs=1e-5)
    assert page.place(contact["place"])[:, 2] == pytest.approx(height)
    assert page.array(unbalance["values"])[0] == pytest.approx(np.full(N_TIMES, 0.1 * 16.0))
    assert page.head["scene"]["links"] == []


def test_a_result_that_did_not_record_them_has_none(tmp_path, clamped_blade):
    page = ReadPage(write_report(tmp_path / "run.html", *two_bodies(clamped_blade)))
    assert {arrow["kind"] for arrow in page.head["scene"]["arrows"]} == {"force"}
    assert not [chart for chart in page.head["charts"] if "contact" in chart["title"]]
