"""`[[element]]` and `control`: what they make, what runs only when allowed, and a run that is resumed."""

from __future__ import annotations

import re

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from supple import machine as m
from supple.cases import modes_case, read_case, run_case
from supple.cases.static_case import starting_system
from supple.cli.main import app
from supple.errors import CaseError, ControlWarning
from supple.quantities import read_sensors
from supple.simulation import simulate

CASE = """\
title = "wheel"
CONTROL

[[body]]
name = "wheel"
rigid = { mass = 2.0, inertia = [[0.3, 0, 0], [0, 0.3, 0], [0, 0, 0.5]] }
interface = [{ name = "axle", position = [0, 0, 0] }, { name = "rim", position = [0.4, 0, 0] }]

[[joint]]
name = "hinge"
kind = "revolute"
first = "ground"
second = "wheel.axle"
axis = [0, 0, 1]

ELEMENTS
[simulation]
duration = 1.0
output_step = 0.01
step = 0.01

[output]
pictures = false
animation = false
report = false
"""

CONTROLLER = '''\
"""PI in plain Python."""
from pathlib import Path

from supple import machine as m


def law(time, reads, memory):
    if time > 0.5 and (Path(__file__).parent / "stop").exists():
        raise KeyboardInterrupt
    error = 0.5 - float(reads["hinge"].angle)
    total = memory["total"] + 0.02 * error
    return {"motor": 30 * error - 3 * float(reads["hinge"].rate) + 20 * total}, {"total": total}


def controllers(system):
    return m.SampledController(
        reads={"hinge": m.JointReading("hinge")},
        drives={"motor": m.TorqueBetween(first="ground", second="wheel.axle", axis=(0, 0, 1))},
        law=law,
        every=0.02,
        memory={"total": 0.0},
    )


def held(system):
    return m.Controller(
        reads={"hinge": m.JointReading("hinge")},
        drives={"motor": m.TorqueBetween(first="ground", second="wheel.axle", axis=(0, 0, 1))},
        outputs=lambda t, reads, z: {"motor": z[0] - 30 * reads["hinge"].angle - 2 * reads["hinge"].rate},
        rates=lambda t, reads, z: (9.0 - z) / 0.1,
        initial=[0.0],
    )


def nothing(system):
    return None


def fails(system):
    raise RuntimeError("no gains")
'''

PUSH = "stiffness = 1e4, exponent = 1.5, dissipation = 0.1"
KEEP = "stiffness = 3.0"
AXIS = 'first = "ground", second = "wheel.rim", axis = [0, 0, 1]'
MADE = {
    'kind = "bushing", first = "ground", second = "wheel.rim", stiffness = [1, 2, 3, 4, 5, 6]': m.Bushing,
    f'kind = "angle-stop", {AXIS}, lower = -0.1, upper = 0.2, {PUSH}': m.AngleStop,
    f'kind = "slide-stop", {AXIS}, lower = -0.1, upper = 0.2, {PUSH}': m.SlideStop,
    f'kind = "distance-stop", first = "wheel.rim", anchor = [1, 1, 0], upper = 2.0, {PUSH}': m.DistanceStop,
    f'kind = "hinge-friction", {AXIS}, value = 2.0, width = 0.01': m.RevoluteFriction,
    f'kind = "slide-friction", {AXIS}, value = 2.0, width = 0.01': m.PrismaticFriction,
    f'kind = "torque-between", {AXIS}, value = 2.0': m.TorqueBetween,
    f'kind = "force-between", {AXIS}, value = 2.0, law = {{ kind = "ramp", value = 1.0, duration = 2.0 }}': (
        m.ForceBetween
    ),
    f'kind = "tabled-torque", {AXIS}, angles = [0, 1], rates = [0, 2, 4], values = [[1, 2, 3], [4, 5, 6]]': (
        m.TabledTorque
    ),
    f'kind = "tabled-force", {AXIS}, slides = [0, 1], speeds = [0, 2], values = [[1, 2], [4, 5]]': (
        m.TabledForce
    ),
    'kind = "tabled-tension", first = "wheel.rim", anchor = [1, 1, 0], distances = [0, 1], speeds = [0, 2], '
    "values = [[1, 2], [4, 5]]": m.TabledTension,
    f'kind = "angle-servo", {AXIS}, law = {{ kind = "constant-rate", rate = 2.0 }}, {KEEP}': (m.AngleServo),
    f'kind = "slide-servo", {AXIS}, law = {{ kind = "constant", value = 2.0 }}, {KEEP}': m.SlideServo,
    f'kind = "motor", {AXIS}, speeds = [0, 1], torques = [3, 1]': m.MotorCurve,
    f'kind = "gear", {AXIS}, teeth = [20, -60], stiffness = 3.0, anchor = [1, 1, 0]': m.Gear,
    f'kind = "screw", {AXIS}, pitch = 0.1, {KEEP}': m.Screw,
    f'kind = "rack-and-pinion", {AXIS}, direction = [1, 0, 0], radius = 0.1, {KEEP}': m.RackAndPinion,
    f'kind = "bearing", {AXIS}, stiffness = [[1, 2], [-2, 1]]': m.JournalBearing,
    f'kind = "bearing", {AXIS}, speeds = [1, 9], stiffness = [[[1, 2], [-2, 1]], [[1, 3], [-3, 1]]]': (
        m.JournalBearing
    ),
    'kind = "unbalance", first = "wheel.rim", moment = [1, 0, 0]': m.Unbalance,
    f'kind = "sphere-on-plane", first = "wheel.rim", axis = [0, 0, 1], anchor = [0, 0, 0], {PUSH}, '
    "friction = 0.3, width = 0.01": m.SphereOnPlane,
    f'kind = "sphere-on-cylinder", first = "wheel.rim", axis = [0, 0, 1], anchor = [0, 0, 0], {PUSH}, '
    "cylinder_radius = 0.2": m.SphereOnCylinder,
    f'kind = "sphere-in-cylinder", first = "wheel.rim", axis = [0, 0, 1], anchor = [0, 0, 0], {PUSH}, '
    "cylinder_radius = 0.2": m.SphereInCylinder,
}


def written(folder, elements=(), control=""):
    tables = "".join(
        "[[element]]\n" + re.sub(r", (?=\w+ = )", "\n", re.sub(r"\{[^}]*\}", _dotted, each)) + "\n\n"
        for each in elements
    )
    path = folder / "wheel.toml"
    path.write_text(CASE.replace("CONTROL", control).replace("ELEMENTS", tables))
    return path


def _dotted(found):
    """An inline table whose commas are not those between keys."""
    return found.group().replace(", ", ",")


def test_every_kind_makes_its_element(tmp_path):
    system = read_case(written(tmp_path, MADE)).system
    assert [type(load) for load in system.loads] == list(MADE.values())
    plane = next(load for load in system.loads if isinstance(load, m.SphereOnPlane))
    assert plane.friction == m.Coulomb(coefficient=0.3, width=0.01)
    assert plane.penalty == m.Penalty(stiffness=1e4, exponent=1.5, dissipation=0.1)
    tabled = next(load for load in system.loads if isinstance(load, m.TabledTorque))
    own = m.Surface(x=[0, 1], y=[0, 2, 4], z=[[1, 2, 3], [4, 5, 6]])
    assert tabled == m.TabledTorque(first="ground", second="wheel.rim", axis=(0, 0, 1), torque=own)


@pytest.mark.parametrize(
    ("element", "message"),
    [
        (f'kind = "angle-stop", {AXIS}, lower = 0.0', "upper"),
        ('kind = "unbalance", first = "whel.rim", moment = [1, 0, 0]', "did you mean 'wheel'"),
        (f'kind = "screw", {AXIS.replace("1]", "0]")}, pitch = 0.1, {KEEP}', "axis of length zero"),
        (
            f'kind = "sphere-on-cylinder", first = "wheel.rim", axis = [0, 0, 1], {PUSH}',
            "needs cylinder_radius",
        ),
        (
            f'kind = "sphere-on-plane", first = "wheel.rim", axis = [0, 0, 1], {PUSH}, friction = 0.1',
            "friction needs width",
        ),
    ],
)
def test_mistakes_of_elements_have_a_line_and_a_remedy(tmp_path, element, message):
    with pytest.raises(CaseError, match=message):
        read_case(written(tmp_path, [element]))


def test_a_bushing_takes_its_diagonal_or_a_matrix(tmp_path):
    """The soil at a pile head couples translation and rotation."""
    soil = np.diag([5.0, 5.0, 9.0, 4.0, 4.0, 2.0])
    soil[0, 4] = soil[4, 0] = -1.5
    ends = 'kind = "bushing", first = "ground", second = "wheel.rim", '
    rows = str(soil.tolist()).replace(", ", ",")
    given = (f"{ends}stiffness = {rows}", f"{ends}stiffness = [5, 5, 9, 4, 4, 2], damping = {rows}")
    coupled, damped = read_case(written(tmp_path, given)).system.loads
    np.testing.assert_array_equal(coupled.stiffness, soil)
    np.testing.assert_array_equal(damped.stiffness, np.diag(np.diag(soil)))
    np.testing.assert_array_equal(damped.damping, soil)


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [
        ("[1, 2, 3]", r"stiffness: 6 items are needed, got \[1, 2, 3\]"),
        ('[1, 2, 3, 4, 5, "6"]', r"stiffness\[6\]: should be a valid number"),
        ("[[1, 2], [2, 1]]", r"stiffness\[1\]: 6 items are needed"),
        ("[[0,1,0,0,0,0]" + ",[0,0,0,0,0,0]" * 5 + "]", "stiffness must be symmetric"),
    ],
)
def test_mistakes_of_a_matrix_have_their_place(tmp_path, stiffness, message):
    element = f'kind = "bushing", first = "ground", second = "wheel.rim", stiffness = {stiffness}'
    with pytest.raises(CaseError, match=message):
        read_case(written(tmp_path, [element]))


def test_springs_are_those_of_python_and_may_end_on_the_ground(tmp_path):
    """Without a free length a straight one has the distance of its ends at the start."""
    ends = '[[spring]]\nfirst = "ground"\nsecond = "wheel.rim"\nstiffness = 3.0\n'
    path = written(tmp_path)
    straight = f'{ends}kind = "straight"\ndamping = 0.1\nanchor = [0.4, 0, 0.8]\n'
    torsion = f'{ends}kind = "torsion"\naxis = [0, 0, 1]\nfree_angle = 0.2\n'
    path.write_text(
        path.read_text().replace(
            "[simulation]", f"{straight}{straight}free_length = 0.5\n{torsion}[simulation]"
        )
    )
    own, given, turning = read_case(path).system.loads
    on = {"first": "ground", "second": "wheel.rim", "stiffness": 3.0}
    assert own == m.SpringDamper(**on, damping=0.1, anchor=(0.4, 0, 0.8), rest_length=None)
    assert given == m.SpringDamper(**on, damping=0.1, anchor=(0.4, 0, 0.8), rest_length=0.5)
    assert turning == m.TorsionSpringDamper(**on, axis=(0, 0, 1), rest_angle=0.2)
    rim = np.array([0.4, 0, 0])
    assert own.assembled(np.array(own.anchor), rim).rest_length == pytest.approx(0.8)
    assert given.assembled(np.array(own.anchor), rim) is given


def test_a_case_with_what_only_python_had_runs(tmp_path):
    """A table of 2 N m turns a wheel of 0.5 kg m2 on a hinge without a name; a spring holds its axle."""
    table = f'kind = "tabled-torque", {AXIS}, angles = [-9, 9], rates = [-9, 9], values = [[2, 2], [2, 2]]'
    spring = (
        '[[spring]]\nkind = "straight"\nfirst = "ground"\nsecond = "wheel.axle"\nanchor = [0, 0, 1]\n'
        "stiffness = 3.0\n"
    )
    sensors = (
        '[[sensor]]\nname = "hinge"\nkind = "joint-motion"\njoint = "revolute ground - wheel.axle"\n'
        '[[sensor]]\nname = "spin"\nkind = "angular-velocity"\nat = "wheel.axle"\n'
    )
    path = written(tmp_path, [table.replace("wheel.rim", "wheel.axle")])
    text = (
        path.read_text()
        .replace('name = "hinge"\n', "")
        .replace("[simulation]", spring + sensors + "[simulation]")
    )
    path.write_text(text)
    case = read_case(path)
    readings = read_sensors(case.sensors, case.system, simulate(case.system, case.run))
    angle, spin = (reading.values for reading in readings)
    t = case.run.times
    assert angle[:, 0] == pytest.approx(2 * t**2, abs=1e-9)
    assert spin == pytest.approx(np.outer(4 * t, [0, 0, 1]), abs=1e-9)


def test_code_runs_only_where_it_is_allowed(tmp_path):
    (tmp_path / "controller.py").write_text("raise SystemExit('it ran')")
    path = written(tmp_path, control='control = "controller.py:controllers"')
    case = read_case(path)
    assert case.system.controllers == ()
    result = CliRunner().invoke(app, ["run", str(path), "-o", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert "--allow-code" in result.output
    assert "read it" in result.output
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("function", "message"),
    [
        ("nothing", "must return a Controller or a SampledController, or a list; it returned a NoneType"),
        ("fails", "fails: RuntimeError: no gains"),
        ("absent", "fails: AttributeError"),
    ],
)
def test_what_a_function_must_give(tmp_path, function, message):
    (tmp_path / "controller.py").write_text(CONTROLLER)
    case = read_case(written(tmp_path, control=f'control = "controller.py:{function}"'))
    with pytest.raises(CaseError, match=message):
        case.controlled(case.system, allow_code=True)


@pytest.mark.slow
def test_a_controller_acts_at_rest_where_its_code_may_run(tmp_path):
    """Its state rests at 9 N m, and turns the wheel by 9 / 30."""
    (tmp_path / "controller.py").write_text(CONTROLLER)
    path = written(tmp_path, control='control = "controller.py:held"')
    path.write_text(path.read_text().replace("[simulation]", '[simulation]\nstart = "equilibrium"'))
    case = read_case(path)
    started = starting_system(case, allow_code=True)
    rotation = started.bodies[0].rotation
    assert np.arctan2(rotation[1, 0], rotation[0, 0]) == pytest.approx(0.3, abs=1e-9)
    assert started.controllers[0].initial == pytest.approx([9.0], rel=1e-9)
    run_case(case, tmp_path / "out", errors=False, allow_code=True)
    head, first, *_ = (tmp_path / "out" / "sensors.csv").read_text().splitlines()
    assert dict(zip(head.split(","), map(float, first.split(",")), strict=True)) == pytest.approx(
        {"Time": 0.0, "controller controller.motor": 0.0},
        abs=1e-9,  # 9 - 30 * 0.3
    )
    modes, _ = modes_case(case, tmp_path, allow_code=True)
    loop = np.roots([0.5, 2.0, 30.0])
    expected = [loop[loop.imag > 0][0], -10.0]
    assert modes.eigenvalues == pytest.approx(expected, rel=1e-7)
    with pytest.warns(ControlWarning, match="give --allow-code to include them"):
        modes, _ = modes_case(case, tmp_path)
    assert modes.eigenvalues == pytest.approx([0.0])


def test_control_names_a_file_and_a_function(tmp_path):
    with pytest.raises(CaseError, match=r"is not FILE\.py:FUNCTION"):
        read_case(written(tmp_path, control='control = "controller.py"'))
    with pytest.raises(CaseError, match="there is no file"):
        read_case(written(tmp_path, control='control = "absent.py:controllers"'))


@pytest.mark.slow
def test_a_killed_run_is_resumed_to_the_last_bit(tmp_path):
    (tmp_path / "controller.py").write_text(CONTROLLER)
    path = written(tmp_path, control='control = "controller.py:controllers"')

    def command(folder, *more):
        given = ["run", str(path), "-o", str(tmp_path / folder), "--no-errors", "--allow-code", *more]
        return CliRunner().invoke(app, given)

    assert command("whole").exit_code == 0
    (tmp_path / "stop").touch()
    assert command("cut").exit_code == 130
    (tmp_path / "stop").unlink()
    result = command("cut", "--resume")
    assert result.exit_code == 0, result.output
    with h5py.File(tmp_path / "whole" / "wheel.h5") as whole, h5py.File(tmp_path / "cut" / "wheel.h5") as cut:
        for item in ("rotation", "angular_velocity", "angular_acceleration"):
            one, other = (file[f"bodies/wheel/{item}"][...] for file in (whole, cut))
            assert len(one) == 101
            np.testing.assert_array_equal(one, other)
    (tmp_path / "controller.py").write_text(CONTROLLER.replace("30 *", "31 *"))
    changed = command("whole", "--resume")
    assert changed.exit_code == 2
    assert "controller.py" in changed.output


def test_a_joint_has_friction_under_its_own_force(tmp_path):
    text = CASE.replace("CONTROL\n", "").replace("ELEMENTS\n", "")
    path = tmp_path / "wheel.toml"
    path.write_text(
        text.replace(
            "axis = [0, 0, 1]\n", "axis = [0, 0, 1]\nfriction = { coefficient = 0.2, width = 0.01 }\n"
        )
    )
    with pytest.raises(CaseError, match="needs the radius of its pin"):
        read_case(path)
    path.write_text(path.read_text().replace("width = 0.01", "width = 0.01, radius = 0.05"))
    system = read_case(path).system
    (friction,) = system.loads
    assert friction == m.HingeFriction(joint=system.joints[0], coefficient=0.2, width=0.01, radius=0.05)
    path.write_text(path.read_text().replace('"revolute"', '"ball"').replace("axis = [0, 0, 1]\n", ""))
    with pytest.raises(CaseError, match="takes no friction"):
        read_case(path)


def test_a_case_with_friction_in_a_joint_runs_with_its_sensors(tmp_path):
    """The moment `coefficient radius m g` slows the wheel; a named spring beside it keeps its sensor."""
    text = (
        CASE.replace("CONTROL", "gravity = [0, -9.81, 0]")
        .replace("ELEMENTS\n", '[[sensor]]\nname = "coil"\nkind = "spring-force"\nspring = "coil"\n\n')
        .replace('name = "wheel"\nrigid', 'name = "wheel"\nangular_velocity = [0, 0, 2]\nrigid')
        .replace(
            "axis = [0, 0, 1]\n",
            "axis = [0, 0, 1]\nfriction = { coefficient = 0.2, width = 1e-4, radius = 0.05 }\n\n"
            '[[spring]]\nname = "coil"\nkind = "torsion"\nfirst = "ground"\nsecond = "wheel.axle"\n'
            "axis = [0, 0, 1]\nstiffness = 1e-9\n",
        )
    )
    (tmp_path / "wheel.toml").write_text(text)
    result = run_case(read_case(tmp_path / "wheel.toml"), tmp_path / "out", errors=False)
    rate = result.solution.bodies["wheel"].angular_velocity[-1, 2]
    assert rate == pytest.approx(2 - 0.2 * 0.05 * 2.0 * 9.81 / 0.5, rel=1e-6)
    assert list(result.numbers["sensors"]) == ["coil"]
