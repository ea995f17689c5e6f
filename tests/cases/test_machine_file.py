"""Machines of URDF and MJCF files in case files: the same as in Python, and bodies in place of rigid ones."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import RigidBody
from supple.cases import read_case
from supple.errors import CaseError, ModelError
from supple.machine import read_mujoco
from supple.simulation import simulate

pytest.importorskip("mujoco")

ARM = """\
<mujoco model="arm"><compiler angle="radian"/><option gravity="0 0 -9.81"/>
<worldbody>
  <body name="upper" pos="0.1 0 1" euler="0 0.4 0">
    <joint name="hip" type="hinge" axis="0 1 0" damping="0.2" range="-1 2" limited="true"/>
    <inertial pos="0.5 0 0" mass="2" fullinertia="0.05 0.22 0.2 0 0.01 0"/>
    <body name="lower" pos="1 0 0" euler="0 0.5 0">
      <joint name="knee" type="hinge" axis="0 1 0" stiffness="3" springref="0.3"/>
      <inertial pos="0.4 0 0.05" mass="1" diaginertia="0.02 0.1 0.1"/>
      <body name="slider" pos="0.5 0 0">
        <joint name="rail" type="slide" axis="1 0 0" stiffness="20" springref="0.1" damping="0.5"/>
        <inertial pos="0 0 0" mass="1" diaginertia="0.02 0.1 0.1"/>
      </body>
    </body>
  </body>
</worldbody></mujoco>
"""
CASE = """\
title = "an arm"
[machine]
mujoco = "arm.xml"
[simulation]
duration = 0.2
output_step = 0.02
step = 0.002
[output]
track = []
"""
# A straight beam along x from the hip to the knee, in place of the upper arm.
BEAM = "\n".join(
    [
        *(f"GRID,{i + 1},,{i / 8},0.,0." for i in range(9)),
        *(f"CBAR,{i + 1},7,{i + 1},{i + 2},0.,0.,1." for i in range(8)),
        "PBAR,7,5,4.-4,1.3-8,1.3-8,2.-8",
        "MAT1,5,2.1+11,,.3,7850.",
        "",
    ]
)
BODY = """\
[[body]]
name = "upper"
mesh = "beam.bdf"
nastran = {}
frame = { kind = "mean-axis" }
reduction = { basis = "craig-bampton", modes = 4 }
interface = [{ name = "hip", node_indices = [1] }, { name = "knee", node_indices = [9] }]
"""


@pytest.fixture
def read(tmp_path):
    (tmp_path / "arm.xml").write_text(ARM)
    (tmp_path / "beam.bdf").write_text(BEAM)

    def made(text=CASE):
        path = tmp_path / "case.toml"
        path.write_text(text)
        return read_case(path)

    return made


def test_the_machine_of_a_case_is_that_of_python(read, tmp_path):
    case, machine = read(), read_mujoco(tmp_path / "arm.xml")
    system = case.system
    assert [each.name for each in system.joints] == ["hip", "knee", "rail"]
    assert len(system.loads) == len(machine.loads) == 4
    np.testing.assert_array_equal(system.gravity, machine.gravity)


@pytest.mark.slow
def test_the_machine_of_a_case_moves_as_that_of_python(read, tmp_path):
    case, machine = read(), read_mujoco(tmp_path / "arm.xml")
    found, wanted = (simulate(each, case.run).bodies for each in (case.system, machine))
    for name in ("upper", "lower", "slider"):
        np.testing.assert_allclose(found[name].position, wanted[name].position, atol=1e-10)


def test_sensors_joints_and_loads_name_the_bodies_of_the_machine(read):
    text = CASE.replace("track = []", 'track = ["lower.knee", "slider.tool"]') + (
        '[[body]]\nname = "slider"\ninterface = [{ name = "tool", position = [0.1, 0, 0] }]\n'
        '[[load]]\nkind = "force"\nat = "slider.tool"\nvector = [0, 0, 1.0]\n'
        '[[sensor]]\nname = "angle"\nkind = "joint-motion"\njoint = "hip"\n'
    )
    case = read(text)
    (slider,) = [each.body for each in case.system.bodies if each.body.name == "slider"]
    assert isinstance(slider, RigidBody)
    assert list(slider.points) == ["rail", "tool"]
    assert len(case.sensors) == 1


def test_a_flexible_body_stands_in_place_of_a_rigid_one(read):
    case = read(CASE + BODY)
    (upper,) = [each for each in case.system.bodies if each.body.name == "upper"]
    np.testing.assert_allclose(upper.position, [0.1, 0, 1])
    np.testing.assert_allclose(upper.rotation @ [1, 0, 0], [np.cos(0.4), 0, -np.sin(0.4)], atol=1e-12)
    assert [each.name for each in upper.body.interfaces] == ["hip", "knee"]
    np.testing.assert_allclose(upper.body.interface("knee").position, [1, 0, 0], atol=1e-12)
    assert len(case.system.bodies) == 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (CASE.replace("arm.xml", "none.xml"), "line 3, machine.mujoco: there is no file"),
        (CASE.replace('"arm.xml"', '"case.toml"'), "machine.mujoco: .*MuJoCo rejects it"),
        (CASE.replace("[simulation]", 'leave_out = ["wheels"]\nbody = 1\n[simulation]'), "machine.body"),
        (
            CASE + BODY + "position = [0, 0, 0]\n",
            "position: the machine file defines the position of body 'upper'",
        ),
        (
            CASE + BODY.replace('name = "knee"', 'name = "shin"'),
            "has joints at its knee; add interfaces",
        ),
        (CASE + '[[joint]]\nkind = "ball"\nfirst = "ground"\nsecond = "lower.foot"\n', "foot"),
    ],
)
def test_mistakes_have_their_line(read, text, message):
    with pytest.raises(CaseError, match=message):
        read(text)


def test_what_the_file_has_beside_bodies_is_left_out_by_name(read, tmp_path):
    motor = '</worldbody><actuator><motor joint="hip"/></actuator>'
    (tmp_path / "motor.xml").write_text(ARM.replace("</worldbody>", motor))
    text = CASE.replace("arm.xml", "motor.xml")
    with pytest.raises(CaseError, match=r'leave_out=\["actuators"\]'):
        read(text)
    read(text.replace("[simulation]", 'leave_out = ["actuators"]\n[simulation]'))


def test_what_the_case_says_itself_holds(read):
    """Gravity of the case holds; a body off its joint is found when the machine is put together."""
    assert read(CASE.replace("[machine]", "gravity = [0, 0, -1.62]\n[machine]")).system.gravity[2] == -1.62
    off = BODY.replace('"knee", node_indices = [9]', '"knee", node_indices = [8], position = [0.875, 0, 0]')
    with pytest.raises(ModelError, match="knee"):
        simulate(read(CASE + off).system, read().run)


@pytest.mark.parametrize(
    "joints",
    [
        '<joint name="j" type="ball" stiffness="2" damping="0.5"/>',
        '<joint name="j" axis="0 0 1" stiffness="2" range="-1 1" limited="true"/>'
        '<joint name="k" type="slide" axis="0 0 1" stiffness="3" range="-1 1" limited="true"/>',
    ],
)
def test_a_joint_may_have_several_springs_and_stops(read, tmp_path, joints):
    (tmp_path / "arm.xml").write_text(
        f'<mujoco><compiler angle="radian"/><worldbody><body name="b">{joints}'
        '<inertial pos="0 0 0.1" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>'
    )
    loads = read_mujoco(tmp_path / "arm.xml").loads
    kinds = sorted(type(load).__name__ for load in loads)
    assert len(kinds) == 4
    assert sorted(type(load).__name__ for load in read().system.loads) == kinds
