"""Machines of URDF and MJCF against the same built by hand, and against MuJoCo's own integration."""

from __future__ import annotations

import sys

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_bodies import beam_body

from supple.algebra.rotation import rotation_exp
from supple.body import NodalFixedFrame, RigidBody
from supple.errors import ImportFormatError, ModelError
from supple.integrate import FixedStep, Run
from supple.machine import (
    GROUND,
    At,
    Ball,
    Cylindrical,
    Fixed,
    Placed,
    Prismatic,
    Revolute,
    SlideStop,
    System,
    TorsionSpringDamper,
    Universal,
    read_mujoco,
)
from supple.machine.pose import Pose
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate

PENDULUM = """
<mujoco model="pendulum"><compiler angle="radian"/><option gravity="0 0 -9.81"/>
<worldbody>
  <body name="upper" pos="0.1 0 1" euler="0 0.4 0">
    <joint name="hip" type="hinge" axis="0 1 0" damping="0.2"/>
    <inertial pos="0 0 -0.5" mass="2" fullinertia="0.2 0.22 0.05 0 0.01 0"/>
    <body name="lower" pos="0 0 -1" euler="0 0.5 0">
      <joint name="knee" type="hinge" axis="0 1 0" stiffness="3" springref="0.3"/>
      <inertial pos="0.05 0 -0.4" mass="1" diaginertia="0.1 0.1 0.02"/>
      <body name="foot" pos="0 0 -0.8">
        <inertial pos="0.1 0 0" mass="0.5" diaginertia="0.01 0.02 0.03"/>
      </body>
    </body>
  </body>
</worldbody></mujoco>
"""
CART = """
<mujoco model="cart"><compiler angle="radian"/>
<worldbody>
  <body name="cart" pos="0 0 0.5">
    <joint name="rail" type="slide" axis="1 0 0" damping="0.5" stiffness="20"/>
    <inertial pos="0 0 0" mass="3" diaginertia="0.1 0.1 0.1"/>
    <body name="bob" euler="0 0.8 0">
      <joint name="pin" type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 -1" mass="1" diaginertia="0.01 0.01 0.01"/>
    </body>
  </body>
</worldbody></mujoco>
"""
RUN = Run(1.0, 0.02, step=FixedStep(0.002))


@pytest.fixture(autouse=True)
def mujoco():
    return pytest.importorskip("mujoco")


def integrated(mujoco, text, times):
    """Positions (t, bodies, 3) of the frames of all bodies by MuJoCo's Runge-Kutta of fourth order."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 1e-4
    data = mujoco.MjData(model)
    found = []
    for time in times:
        while data.time < time - 1e-9:
            mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        found.append(np.array(data.xpos[1:]))
    return np.array(found)


@pytest.mark.parametrize(
    ("text", "names"),
    [(PENDULUM, ["upper", "lower"]), pytest.param(CART, ["cart", "bob"], marks=pytest.mark.slow)],
)
def test_motion_is_that_of_mujoco(mujoco, text, names):
    system = read_mujoco(text)
    motion = simulate(system, RUN)
    exact = integrated(mujoco, text, motion.times)
    for number, name in enumerate(names):
        found = motion.bodies[name].position
        moved = np.abs(exact[:, number] - exact[0, number]).max()
        if moved > 0:
            assert np.abs(found - exact[:, number]).max() < 2e-4 * max(moved, 0.1)
    assert {type(joint) for joint in system.joints} <= {Revolute, Prismatic}


@pytest.mark.slow
def test_a_double_pendulum_is_that_built_by_hand():
    """Welded bodies are one: mass, centre and inertia by Steiner; joints and springs as in the file."""
    system = read_mujoco(PENDULUM)
    upper, lower = (placed.body for placed in system.bodies)
    assert (upper.name, lower.name) == ("upper", "lower")
    assert lower.mass == pytest.approx(1.5)
    foot, own = np.array([0.1, 0, -0.8]), np.array([0.05, 0, -0.4])
    centre = (own + 0.5 * foot) / 1.5
    np.testing.assert_allclose(lower.centre, centre, atol=1e-12)
    inertia = np.diag([0.1, 0.1, 0.02]) + np.diag([0.01, 0.02, 0.03])
    for mass, point in ((1.0, own), (0.5, foot)):
        d = point - centre
        inertia += mass * (d @ d * np.eye(3) - np.outer(d, d))
    np.testing.assert_allclose(lower.inertia, inertia, atol=1e-12)
    np.testing.assert_allclose(upper.inertia, [[0.2, 0, 0.01], [0, 0.22, 0], [0.01, 0, 0.05]], atol=1e-12)

    hip = Placed(
        RigidBody("upper", 2.0, (0, 0, -0.5), upper.inertia, {"hip": (0, 0, 0), "knee": (0, 0, -1)}),
        position=(0.1, 0, 1),
        rotation=(0, 0.4, 0),
    )
    turn = hip.rotation
    knee = Placed(
        RigidBody("lower", 1.5, centre, inertia, {"knee": (0, 0, 0)}),
        position=hip.position + turn @ (0, 0, -1),
        rotation=(0, 0.9, 0),
    )
    by_hand = System(
        bodies=[hip, knee],
        joints=[
            Revolute(first="ground", second="upper.hip", axis=(0, 1, 0)),
            Revolute(first="upper.knee", second="lower.knee", axis=(0, 1, 0)),
        ],
        loads=[
            TorsionSpringDamper(first="ground", second="upper.hip", axis=(0, 1, 0), damping=0.2),
            TorsionSpringDamper(
                first="upper.knee", second="lower.knee", axis=(0, 1, 0), stiffness=3.0, rest_angle=0.3
            ),
        ],
        gravity=(0, 0, -9.81),
    )
    one, other = (simulate(each, RUN).bodies["lower"].position for each in (system, by_hand))
    np.testing.assert_allclose(one, other, atol=1e-9)


def with_joints(joints, *, more="", inside=""):
    return f"""<mujoco><compiler angle="radian"/><worldbody><body name="b" pos="0 0 1">{joints}
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{inside}</body></worldbody>{more}</mujoco>"""


@pytest.mark.parametrize(
    ("joints", "kinds"),
    [
        ('<joint type="ball" name="j"/>', [Ball]),
        ('<freejoint name="j"/>', []),
        ('<joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 0 1"/>', [Cylindrical]),
        ('<joint type="hinge" axis="1 0 0"/><joint type="hinge" axis="0 1 0"/>', [Universal]),
    ],
)
def test_kinds_of_joints(joints, kinds):
    system = read_mujoco(with_joints(joints))
    assert [type(joint) for joint in system.joints] == kinds


@pytest.mark.slow
def test_limits_are_stops():
    """A slide that falls on its stop rests on it: depth = m g / k."""
    text = with_joints(
        '<joint name="j" type="slide" axis="0 0 1" limited="true" range="-0.01 1" damping="40"/>'
    )
    (*_, stop) = read_mujoco(text).loads
    assert isinstance(stop, SlideStop)
    assert (stop.lower, stop.upper) == (-0.01, 1.0)
    assert stop.penalty.stiffness == pytest.approx(1 / 0.02**2)  # of one kilogram
    motion = simulate(read_mujoco(text), Run(2.0, 0.5, step=FixedStep(0.002)))
    assert motion.bodies["b"].position[-1, 2] == pytest.approx(1 - 0.01 - 9.81 * 0.02**2, abs=1e-5)


@pytest.mark.parametrize("kind", ["ball", "free"])
def test_springs_and_dampers_of_balls_and_free_bodies(kind):
    """Moment -k theta - c w about any axes, and for a free body the force -k x - c v, as in MuJoCo."""
    k, c = 3.0, 0.5
    system = read_mujoco(with_joints(f'<joint type="{kind}" stiffness="{k}" damping="{c}"/>'))
    turn, spin, place, velocity = np.array([[1.2, 0, 0.3], [0.2, 2, 1], [0.1, 0.2, 0.3], [1, -2, 3.0]])
    zero = jnp.zeros(3)
    still = Pose(zero, jnp.eye(3), zero, zero)
    moved = Pose(
        jnp.asarray(place), rotation_exp(jnp.asarray(turn)), jnp.asarray(velocity), jnp.asarray(spin)
    )
    force, moment = np.zeros((2, 3))
    for load in system.loads:
        assert load.first == GROUND
        axes = load.initial_axes
        ends = still._replace(axes=still.axes @ axes), moved._replace(axes=moved.axes @ axes)
        parameters = load.assembled(np.zeros(3), np.zeros(3)).parameters
        wrench = load.wrenches(*ends, None if load.law is None else load.law(0.0), parameters)[1]
        force, moment = force + np.asarray(wrench.force), moment + np.asarray(wrench.moment)
    expected = -k * place - c * velocity if kind == "free" else np.zeros(3)
    np.testing.assert_allclose(force, expected, atol=1e-12)
    np.testing.assert_allclose(moment, -k * turn - c * spin, rtol=1e-12)


def test_loops_are_closed():
    inside = """<body name="c" pos="1 0 0"><joint name="k" axis="0 1 0"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>"""
    for word, kind in (("connect", Ball), ("weld", Fixed)):
        anchor = 'anchor="1 0 0"' if word == "connect" else ""
        more = f'<equality><{word} name="end" body1="c" {anchor}/></equality>'
        system = read_mujoco(with_joints('<joint name="j" axis="0 1 0"/>', more=more, inside=inside))
        last = system.joints[-1]
        assert isinstance(last, kind)
        assert (str(last.first), last.second) == ("ground", At("c", "end"))
    system = read_mujoco(
        with_joints(
            '<joint name="j" axis="0 1 0"/>',
            more=more.replace("weld", "connect").replace('body1="c"', 'body1="c" anchor="1 0 0"'),
            inside=inside,
        )
    )
    np.testing.assert_allclose(system.bodies[1].body.points["end"], [1, 0, 0])


def test_unnamed_bodies_and_joints_are_named_by_number():
    """Each joint of a chain has an interface of its own: at its place in both bodies."""
    inertial = '<inertial pos="0 0 -0.2" mass="1" diaginertia="1 1 1"/>'
    inside = f'<body pos="0 0 -0.5"><joint axis="0 1 0"/>{inertial}</body>'
    text = f"<body><joint/>{inertial}{inside}</body>"
    system = read_mujoco(f"<mujoco><worldbody>{text}</worldbody></mujoco>")
    assert [joint.name for joint in system.joints] == ["body_1_joint", "body_2_joint"]
    points = system.bodies[0].body.points
    np.testing.assert_allclose([points["body_1_joint"], points["body_2_joint"]], [[0, 0, 0], [0, 0, -0.5]])


def test_a_loop_may_have_the_name_of_a_joint():
    """Names differ within one kind of object only; the interfaces of both keep their places."""
    system = read_mujoco(
        with_joints(
            '<joint name="j" axis="0 1 0"/>',
            more='<equality><connect name="j" body1="b" anchor="1 0 0"/></equality>',
        )
    )
    assert [joint.name for joint in system.joints] == ["j", "j_loop"]
    points = system.bodies[0].body.points
    np.testing.assert_allclose([points["j"], points["j_loop"]], [[0, 0, 0], [1, 0, 0]])


def test_bodies_of_motion_capture_are_ground():
    """A hand welded to such a body is held by the ground; a joint on it is one to the ground."""
    inertial = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    system = read_mujoco(f"""<mujoco><worldbody>
    <body name="target" mocap="true" pos="0 0 1"><geom size="0.1"/>
      <body name="arm"><joint name="j"/>{inertial}</body></body>
    <body name="hand" pos="0 0 1"><freejoint/>{inertial}</body>
    <body name="base" pos="0 0 1"/>
    </worldbody><equality><weld name="hold" body1="target" body2="hand"/>
    <weld name="none" body1="target" body2="base"/></equality></mujoco>""")
    assert [placed.body.name for placed in system.bodies] == ["arm", "hand"]
    assert [(joint.name, str(joint.first)) for joint in system.joints] == [
        ("j", "ground"),
        ("hold", "ground"),
    ]


def test_urdf(tmp_path):
    (tmp_path / "arm.urdf").write_text(
        """<robot name="arm"><link name="base"/>
        <link name="boom"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
          <inertia ixx="0.1" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="swing" type="revolute"><parent link="base"/><child link="boom"/><origin xyz="0 0 0.3"/>
          <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="0" velocity="0"/></joint></robot>"""
    )
    system = read_mujoco(tmp_path / "arm.urdf")
    (boom,) = (placed.body for placed in system.bodies)
    assert (boom.name, boom.mass) == ("boom", 2.0)
    np.testing.assert_allclose(boom.centre, [0.5, 0, 0])
    assert [joint.name for joint in system.joints] == ["swing"]
    assert len(system.loads) == 1


def test_flexible_bodies_stand_in_place_of_rigid_ones():
    """The interfaces of a beam are the joints of the file; a misplaced one is refused."""
    text = """<mujoco><worldbody><body name="beams" pos="0 0 1"><joint name="root" axis="0 1 0"/>
    <inertial pos="2 0 0" mass="324" diaginertia="1 400 400"/>
    <body name="load" pos="PLACE 0 0"><joint name="tip" axis="0 1 0"/>
    <inertial pos="0 0 -1" mass="5" diaginertia="1 1 1"/></body></body></worldbody></mujoco>"""
    beam = reduce(
        beam_body("root", "tip").linearized(), NodalFixedFrame("root"), CraigBampton(2),
        derivatives=NoDerivatives(), loads=NoLoads,
    )  # fmt: skip
    system = read_mujoco(text.replace("PLACE", "4"), bodies={"beams": beam})
    assert system.bodies[0].body is beam
    np.testing.assert_allclose(system.bodies[0].position, [0, 0, 1])
    with pytest.raises(ModelError, match=r"its interface 'tip' is 0\.5 away from the joint"):
        read_mujoco(text.replace("PLACE", "3.5"), bodies={"beams": beam})
    with pytest.raises(ModelError, match=r"no body 'wing' to replace; the machine has 'beams', 'load'"):
        read_mujoco(text.replace("PLACE", "4"), bodies={"wing": beam})
    with pytest.raises(ModelError, match="replaces 'load': give it the same name"):
        read_mujoco(text.replace("PLACE", "4"), bodies={"load": beam})


def test_what_is_not_read():
    motor = '<actuator><motor joint="j"/></actuator>'
    text = with_joints('<joint name="j" axis="0 1 0" armature="0.1" frictionloss="1"/>', more=motor)
    with pytest.raises(ModelError, match=r"actuators \(1\).*friction \(1\).*armature \(1\).*leave_out="):
        read_mujoco(text)
    assert len(read_mujoco(text, leave_out=["actuators", "friction", "armature"]).joints) == 1
    with pytest.raises(
        ModelError, match="leave_out has no feature 'actuator'; there are: actuators, tendons"
    ):
        read_mujoco(text, leave_out=["actuator"])
    with pytest.raises(ModelError, match="has the joints slide and slide, which no single joint combines"):
        read_mujoco(with_joints('<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'))
    with pytest.raises(ModelError, match="stops must be within half a revolution"):
        read_mujoco(with_joints('<joint name="j" limited="true" range="-4 4"/>'))
    assert not read_mujoco(with_joints('<joint limited="true" range="-4 4"/>'), leave_out=["limits"]).loads
    spring = '<joint name="j" stiffness="1" springref="{}" {}/>'
    with pytest.raises(
        ModelError, match=r"spring of joint 'j' has no moment at 4 rad .* within half a revolution"
    ):
        read_mujoco(with_joints(spring.format(4, "")))
    assert len(read_mujoco(with_joints(spring.format(4, 'limited="true" range="0 1"'))).loads) == 2
    two = '<joint axis="1 0 0" {}/><joint axis="0 1 0"/>'
    with pytest.raises(ModelError, match="dampers in universal joints are not read"):
        read_mujoco(with_joints(two.format('damping="1"')))
    with pytest.raises(ModelError, match="limits of ball and universal joints are not read"):
        read_mujoco(with_joints('<joint type="ball" limited="true" range="0 1"/>'))
    with pytest.raises(ImportFormatError, match="MuJoCo rejects it"):
        read_mujoco("<mujoco><worldbody><body><joint/></body></worldbody></mujoco>")
    with pytest.raises(ImportFormatError, match="no such file"):
        read_mujoco("missing.xml")


@pytest.mark.parametrize(
    ("option", "body", "feature"),
    [
        ('<option density="1.2"/>', "", "fluid"),
        ('<option><flag gravity="disable"/></option>', "", "flags"),
        ("", 'gravcomp="1"', "gravcomp"),
        ('<default><joint damping="1 0.5"/></default>', "", "nonlinear"),
    ],
)
def test_forces_that_are_not_read_are_refused(option, body, feature):
    text = f"""<mujoco>{option}<worldbody><body {body}><joint name="hinge" type="hinge"/>
        <inertial pos="0 0 0.1" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>"""
    with pytest.raises(ModelError, match=rf"{feature} \(1\).*leave_out="):
        read_mujoco(text)
    assert len(read_mujoco(text, leave_out=[feature]).joints) == 1


@pytest.mark.parametrize(("half", "fits"), [(0.15, True), (0.25, False)])
def test_a_weld_at_another_rotation_is_refused(half, fits):
    """The file has the second body turned by 0.3 rad."""
    relpose = f"1 0 0 {np.cos(half)} 0 0 {np.sin(half)}"
    text = with_joints(
        '<joint axis="0 0 1"/>',
        more=f"""<worldbody><body name="c" pos="1 0 1" euler="0 0 0.3"><freejoint/>
        <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>
        <equality><weld name="w" body1="b" body2="c" relpose="{relpose}"/></equality>""",
    )
    if fits:
        assert isinstance(read_mujoco(text).joints[-1], Fixed)
    else:
        with pytest.raises(ModelError, match="the weld 'w' holds its bodies at another relative rotation"):
            read_mujoco(text)


def test_without_the_library(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportFormatError, match=r"pip install 'supple\[mujoco\]'"):
        read_mujoco(CART)
