"""What can be asked of every form of a body: the table of `feature_table`, cell by cell.

The machines are as small as they can be and still have a closed form: a soft bar that flies and spins, the
same on a hinge, on a sprung hinge, and with one thing more. What a form does not have is refused in one
sentence before anything is compiled.
"""

from __future__ import annotations

import json
import re
import warnings
from contextlib import contextmanager
from dataclasses import replace
from functools import cache

import jax
import numpy as np
import pytest
from fixtures import feature_table
from fixtures.bar_of_every_form import (
    ACROSS,
    CENTRE,
    DENSITY,
    LENGTH,
    LIFT,
    MASS,
    PERIOD,
    PULL,
    RUN,
    SECTION,
    bar_as,
    centre,
    model,
    on_a_sprung_hinge,
    write_case,
)
from fixtures.bar_of_every_form import (
    HINGE as HINGE_TABLE,
)
from fixtures.feature_table import DASH, TABLE, YES, page, parts
from fixtures.report_page import ReadPage
from scipy import linalg
from typer.testing import CliRunner

from supple.cli.main import app
from supple.error import ErrorStudy, ReductionStart, SelfCorrection, self_correct, state_errors
from supple.errors import SuppleError, ValidityWarning
from supple.integrate import AdaptiveStep, FixedStep, Kinematic, Run
from supple.linearization import campbell_diagram, linearize, machine_modes
from supple.machine import (
    At,
    BaseAcceleration,
    Bushing,
    Contact,
    Controller,
    DeadForce,
    EndReading,
    Fixed,
    FollowerForce,
    FollowerPressure,
    ForceBetween,
    HingeFriction,
    Placed,
    PrescribedRotation,
    Revolute,
    RigidPlane,
    SampledController,
    Spin,
    SpringDamper,
    System,
    TorsionSpringDamper,
    Universal,
)
from supple.methods.intrinsic import enough_modes
from supple.quantities import (
    AccelerationSensor,
    AngularVelocitySensor,
    Component,
    EnergySensor,
    JointForceSensor,
    JointMotionSensor,
    Place,
    PositionSensor,
    SectionForceSensor,
    StressSensor,
    VelocitySensor,
    tracked_places,
)
from supple.report import write_report
from supple.simulation import equilibrium, place_errors, simulate, simulate_batch
from supple.storage import read_solution

RATE = 5.0
"""rad/s, of what spins: slow beside the vibrations, fast enough to pull."""
SPIN = np.array([0.0, 0.0, RATE])
VELOCITY = np.array([1.0, 0.5, 0.0])
GRAVITY = np.array([0.0, 0.0, -9.81])
FORCE = np.array([20.0, 0.0, 0.0])
STEP = FixedStep(5e-4)
SHORT = Run(PERIOD, PERIOD / 20, step=STEP)
LONG = Run(2 * PERIOD, PERIOD / 20, step=STEP)
TORSION = 100.0
MIDDLE = tuple(np.flatnonzero(np.isclose(model().mesh.nodes[:, 0], LENGTH / 2)).tolist())
HINGE = Revolute(first="ground", second="bar.root", axis=(0, 0, 1), name="hinge")

CHECKS = {}
QUICK = (
    "motion in time",
    "fixed steps of the run",
    "equilibrium",
    "linearisation and modes",
)
"""Rows whose machines are few; `make test-all` marches those of all others, and every refusal is quick."""
QUICK_OF_ONE = ("case file: info", "case file: check", "case file: export to CalculiX")
"""Rows of commands that ask every form alike: of reduced bodies."""


def row(name):
    """Names what does the thing of a row with a form, and checks the numbers."""

    def named(check):
        CHECKS[name] = check
        return check

    return named


def turned(angle):
    """About z."""
    return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])


def mean(values):
    """Over the time of a run at its equal output times."""
    return np.trapezoid(values, axis=0) / (len(values) - 1)


def flying(form):
    """Thrown, and spinning about z."""
    placed = Placed(bar_as(form), angular_velocity=SPIN).with_centre_velocity(VELOCITY)
    return System([placed], gravity=GRAVITY)


@cache
def flight(form):
    return flying(form), simulate(flying(form), SHORT)


def hinged(form, loads=(), controllers=()):
    """Spinning about z at its root."""
    return System([Placed(bar_as(form), angular_velocity=SPIN)], [HINGE], loads, controllers=controllers)


@cache
def swing(form):
    return hinged(form), simulate(hinged(form), LONG)


def pushed(form, *loads, run=SHORT, **more):
    """Displacement of the centre (3,) of a bar that begins at rest."""
    system = System([Placed(bar_as(form))], loads=loads, **more)
    motion = simulate(system, run).bodies["bar"]
    return centre(bar_as(form), motion)[-1] - CENTRE


def sprung(form, *loads):
    """On a hinge about y with a torsion spring."""
    hinge = Revolute(first="ground", second="bar.root", axis=(0, 1, 0), name="hinge")
    spring = TorsionSpringDamper(first="ground", second="bar.root", axis=(0, 1, 0), stiffness=TORSION)
    return System([bar_as(form)], [hinge], [spring, *loads])


def blade(form):
    """Free to turn about z and to flap."""
    joint = Universal(
        first="ground", second="bar.root", first_axis=(0, 0, 1), second_axis=(0, 1, 0), name="hub"
    )
    return System([bar_as(form)], [joint])


# ---- motion


@row("motion in time")
def _(form):
    system, solution = flight(form)
    body, motion, end = bar_as(form), solution.bodies["bar"], PERIOD
    expected = CENTRE + VELOCITY * end + GRAVITY * end**2 / 2
    assert centre(body, motion)[-1] == pytest.approx(expected, abs=2e-5)
    tip = expected + turned(RATE * end) @ CENTRE
    assert PositionSensor("tip", "bar.tip").values(system, solution)[-1] == pytest.approx(tip, abs=1e-3)


@row("fixed steps of the run")
def _(form):
    _, solution = flight(form)
    assert solution.statistics.steps == round(PERIOD / STEP.size)


@row("steps by an error estimate")
def _(form):
    if form == "intrinsic":  # of lines that joints hold
        system, end = hinged(form), 2 * PERIOD
        expected = turned(RATE * end) @ CENTRE
    else:
        system, end = flying(form), PERIOD
        expected = CENTRE + VELOCITY * end + GRAVITY * end**2 / 2
    solution = simulate(system, Run(end, end / 4, step=AdaptiveStep(1e-4)))
    # On a hinge what stretches turns more slowly, by some 2 sigma / E.
    within = 5e-4 if form == "intrinsic" else 5e-5
    assert centre(bar_as(form), solution.bodies["bar"])[-1] == pytest.approx(expected, abs=within)


@row("result file, resumed to the same bits")
def _(form, tmp_path):
    system, whole = flight(form)
    path = tmp_path / "flight.h5"

    def stop(fraction):
        if fraction > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(system, SHORT, file=path, progress=stop)
    cut = read_solution(path)
    assert 0 < len(cut.times) < len(whole.times)
    resumed = simulate(system, SHORT, file=path)
    for name, values in whole.bodies["bar"].arrays().items():
        assert np.array_equal(resumed.bodies["bar"].arrays()[name], values), name


def _beside(form, other):
    """Two bars in a row, welded, spin about their end in common: it pulls each with m omega^2 L / 2."""
    mate = bar_as(other, "mate")
    weld = Fixed(first="bar.tip", second="mate.root", name="weld")
    middle = np.array([LENGTH, 0, 0])
    placed = [
        Placed(bar_as(form), velocity=np.cross(SPIN, -middle), angular_velocity=SPIN),
        Placed(mate, position=middle, angular_velocity=SPIN),
    ]
    system = System(placed, [weld])
    solution = simulate(system, LONG)
    end = PositionSensor("end", "mate.tip").values(system, solution)[-1]
    assert end == pytest.approx(middle + turned(RATE * 2 * PERIOD) @ middle, abs=1e-3)
    # The weld moves the mate: its force, along axes that turn with the first end, integrated twice.
    times = solution.times
    force = np.array(
        [turned(RATE * t) @ f[:3] for t, f in zip(times, solution.joint_forces["weld"], strict=True)]
    )
    pulled = mean((times[-1] - times)[:, None] * force) * times[-1] / MASS
    own = centre(mate, solution.bodies["mate"])
    moved = own[-1] - own[0] - np.cross(SPIN, CENTRE) * times[-1]
    assert pulled == pytest.approx(moved, abs=0.02 * np.linalg.norm(moved))


for _article, _other in zip(
    ["a", "a", "a", "an", "a"], ("rigid", "reduced", "full", "intrinsic", "modal"), strict=True
):
    CHECKS[f"joined to {_article} {_other} body"] = lambda form, other=_other: _beside(form, other)


# ---- joints, forces, loads


@row("joints")
def _(form):
    system, solution = swing(form)
    tip = PositionSensor("tip", "bar.tip").values(system, solution)[-1]
    assert tip == pytest.approx(turned(RATE * 2 * PERIOD) @ (2 * CENTRE), abs=1e-3)


@row("springs and dampers")
def _(form):
    stiffness, start = 1000.0, 0.1
    spring = SpringDamper(
        first="ground", second="bar.root", stiffness=stiffness, rest_length=1.0, anchor=(-1.0 - start, 0, 0)
    )
    moved = pushed(form, spring)[0]
    assert moved == pytest.approx(start * (np.cos(np.sqrt(stiffness / MASS) * PERIOD) - 1), rel=0.01)


@row("bushings")
def _(form):
    stiffness = 1000.0
    bushing = Bushing(
        first="ground",
        second="bar.root",
        stiffness=(0, 0, stiffness, 0, 0, 0),
        axis=(1, 0, 0),
        offset=(0, 0, -0.1),
    )
    moved = pushed(form, bushing)[0]
    assert moved == pytest.approx(0.1 * (np.cos(np.sqrt(stiffness / MASS) * PERIOD) - 1), rel=0.02)


@row("friction of joints")
def _(form):
    pull = 400.0
    loads = [
        HingeFriction(joint=HINGE, coefficient=0.1, radius=0.01, width=0.01),
        DeadForce(at="bar.root", force=(pull, 0, 0)),
    ]
    rubbed = simulate(hinged(form, loads), LONG)
    system, free = swing(form)
    energies = EnergySensor("energy")
    slowed = energies.values(system, rubbed)[-1, 3]
    # The pin carries the pull and, on the mean, m omega^2 L / 2.
    lost = 0.1 * 0.01 * (pull + MASS * RATE**2 * LENGTH / 2) * RATE * 2 * PERIOD
    assert energies.values(system, free)[-1, 3] - slowed == pytest.approx(lost, rel=0.05)


@row("forces on interfaces and nodes")
def _(form):
    assert pushed(form, DeadForce(at="bar.tip", force=FORCE)) == pytest.approx(
        FORCE / MASS * PERIOD**2 / 2, rel=0.01, abs=1e-6
    )


@row("follower forces")
def _(form):
    """Along a bar that stands along y; the force's components are those of space at the start."""
    along_y = FORCE[[1, 0, 2]]
    push = FollowerForce(first="bar.tip", force=along_y)
    system = System([Placed(bar_as(form), rotation=(0, 0, np.pi / 2))], loads=[push])
    motion = simulate(system, SHORT).bodies["bar"]
    moved = centre(bar_as(form), motion)[-1] - CENTRE[[1, 0, 2]]
    assert moved == pytest.approx(along_y / MASS * PERIOD**2 / 2, rel=0.01, abs=1e-6)


@row("pressure on faces")
def _(form):
    face = np.flatnonzero(np.isclose(model().mesh.nodes[:, 0], LENGTH))
    ring = face[np.argsort(np.arctan2(*model().mesh.nodes[face, 2:0:-1].T))]
    moved = pushed(form, FollowerPressure(body="bar", faces=[ring], pressure=2000.0))
    assert moved == pytest.approx([-2000.0 * SECTION / MASS * PERIOD**2 / 2, 0, 0], rel=0.01, abs=1e-6)


@row("base acceleration")
def _(form):
    moved = pushed(form, BaseAcceleration(acceleration=(3.0, 0, 0)))
    assert moved == pytest.approx([-3.0 * PERIOD**2 / 2, 0, 0], rel=1e-3, abs=1e-6)


@row("contact with obstacles")
def _(form):
    wall = RigidPlane((-1e-3, 0, 0), (1, 0, 0))
    speed = 1.0
    system = System(
        [Placed(bar_as(form), velocity=(-speed, 0, 0))], contacts=[Contact(At("bar", "root"), wall)]
    )
    motion = simulate(system, LONG).bodies["bar"]
    # A bar leaves a wall with the speed of its arrival, once the wave has come back from its far end.
    x = centre(bar_as(form), motion)[:, 0]
    assert (x[-1] - x[-2]) / LONG.output_step == pytest.approx(speed, rel=0.1)


# ---- control


def _spring_law(time, readings, states):
    return {"push": -1000.0 * (readings["end"].point[0] + 0.1)}


@row("controllers in every step")
def _(form):
    control = Controller(
        reads={"end": EndReading("bar.root")},
        drives={"push": ForceBetween(first="ground", second="bar.root", axis=(1, 0, 0))},
        outputs=_spring_law,
    )
    moved = pushed(form, controllers=[control])[0]
    assert moved == pytest.approx(0.1 * (np.cos(10 * PERIOD) - 1), rel=0.02)


@row("sampled controllers")
def _(form):
    every = PERIOD / 4
    control = SampledController(
        reads={"end": EndReading("bar.root")},
        drives={"push": ForceBetween(first="ground", second="bar.root", axis=(1, 0, 0))},
        law=lambda time, readings, memory: ({"push": 100.0 * (1 + time)}, memory),
        every=every,
    )
    moved = pushed(form, controllers=[control])[0]
    speed = place = 0.0
    for time in every * np.arange(4):  # forces that hold from instant to instant
        acceleration = 100.0 * (1 + time) / MASS
        place += speed * every + acceleration * every**2 / 2
        speed += acceleration * every
    assert moved == pytest.approx(place, rel=0.005)


@row("kinematic run")
def _(form):
    drive = PrescribedRotation(
        first="ground", second="bar.root", axis=(0, 0, 1), angle=lambda t: 10.0 * t**2, name="drive"
    )
    system = System([bar_as(form)], [drive])
    with warnings.catch_warnings():  # a body that could deform is held in its shape
        warnings.simplefilter("ignore", ValidityWarning)
        solution = simulate(system, Run(0.2, 0.05, step=FixedStep(0.05), method=Kinematic()))
    tip = PositionSensor("tip", "bar.tip").values(system, solution)[-1]
    assert tip == pytest.approx(turned(0.4) @ (2 * CENTRE), abs=1e-9)
    moment = (ACROSS + MASS * LENGTH**2 / 4) * 20.0
    assert solution.joint_forces["drive"][-1, 5] == pytest.approx(moment, rel=0.01)


@row("limits of validity checked")
def _(form):
    """Few modes, linear modes that spin fast: warned of. Green-Lagrange strains have no such limit."""
    body = bar_as(form).truncated(2) if form == "intrinsic" else bar_as(form, linear=True)
    push = DeadForce(at="bar.tip", force=(0, 0, 3000.0))
    with pytest.warns(ValidityWarning, match="'bar'"):
        simulate(System([Placed(body, angular_velocity=10 * SPIN)], loads=[push]), SHORT)


# ---- rest, small motions, many cases, errors


def _lifted(form):
    """Where 1 N lifts the tip of the bar on its sprung hinge."""
    stiffness, _, row = on_a_sprung_hinge(TORSION)
    return LENGTH**2 / TORSION if form == "rigid" else row @ np.linalg.solve(stiffness, row)


def _slowest(form):
    """Frequency of the bar on its sprung hinge, rad/s."""
    if form == "rigid":
        return np.sqrt(TORSION / (ACROSS + MASS * LENGTH**2 / 4))
    stiffness, mass, _ = on_a_sprung_hinge(TORSION)
    return np.sqrt(linalg.eigh(stiffness, mass, eigvals_only=True, subset_by_index=(0, 0))[0])


@row("equilibrium")
def _(form):
    found = equilibrium(sprung(form, DeadForce(at="bar.tip", force=(0, 0, 1.0))))
    tip = bar_as(form).interface_motion(found.solution.bodies["bar"], "tip").position[-1, 2]
    assert tip == pytest.approx(_lifted(form), rel=2e-3)


@row("linearisation and modes")
def _(form):
    found = machine_modes(linearize(sprung(form)), 1).frequencies[0]
    assert found == pytest.approx(_slowest(form), rel=5e-3)


@row("Campbell diagram")
def _(form):
    """A uniform blade, hinged on the axis, flaps once in a turn, however it bends."""
    rates = (4.0, 8.0)
    found = campbell_diagram(blade(form), [Spin(rate, (0, 0, 1)) for rate in rates], n_modes=3)
    for rate, frequencies in zip(rates, found.frequencies, strict=True):
        assert np.abs(frequencies / rate - 1).min() < 0.01


@row("batch of cases")
def _(form):
    cases = [System([bar_as(form)], loads=[DeadForce(at="bar.tip", force=n * FORCE)]) for n in (1, 2)]
    found = simulate_batch(cases, SHORT)
    moved = [centre(bar_as(form), each.bodies["bar"])[-1] - CENTRE for each in found.solutions]
    for n, each in zip((1, 2), moved, strict=True):
        assert each == pytest.approx(n * FORCE / MASS * PERIOD**2 / 2, rel=0.01, abs=1e-6)


def _stated(system, run, solution, part, **study):
    """A part of the error that is stated of a run."""
    parts = {"basis": False, "integration": False, "model": False} | study
    fulls = [bar_as("full")] if system.bodies[0].body.kind == "reduced" else ()
    stated = state_errors(system, run, solution, ErrorStudy(**parts), fulls=fulls)
    return getattr(list(stated.errors.values())[-1], part).value


@row("error of the basis")
def _(form):
    """What stretches as a bar spins is within the steady answers of its basis; 1e-5 of the length."""
    system, solution = flight(form)
    assert 0 <= _stated(system, SHORT, solution, "basis", basis=True) < 1e-5 * LENGTH


@row("error of an equilibrium")
def _(form):
    """Of what the tip is deflected by: all but the turn of the sprung hinge, F L / k."""
    force = DeadForce(at="bar.tip", force=(0, 0, 1.0))
    place = Place("bar", "tip")
    found = equilibrium(sprung(form, force), fulls=[bar_as("full")])
    error = place_errors(found, {"tip": place})["tip"].deflection[2]
    shown = tracked_places(found.system, found.solution, {"tip": place})["tip"].deflection[0, 2]
    exact = _lifted("full") - LENGTH**2 / TORSION
    assert shown - error == pytest.approx(exact, rel=0.02)
    assert abs(error) < 1e-3 * exact


@row("error of modes")
def _(form):
    found = machine_modes(linearize(sprung(form), fulls=[bar_as("full")]), 1)
    assert abs(found.error.eigenvalues[0]) == pytest.approx(_slowest("full"), rel=5e-3)
    apart = abs(found.eigenvalues[0] - found.error.eigenvalues[0]) / abs(found.error.eigenvalues[0])
    assert found.error.relative[0] == pytest.approx(apart, rel=1e-6, abs=1e-12)
    assert apart < 1e-3


@row("error of the time step")
def _(form):
    """Of the place of the tip, against a run at a quarter of the step."""
    system, solution = flight(form)
    tip = PositionSensor("tip", "bar.tip")
    found = _stated(system, SHORT, solution, "step", integration=True, quantities=(tip,))
    fine = simulate(system, replace(SHORT, step=FixedStep(STEP.size / 4)))
    apart = tip.values(system, solution) - tip.values(system, fine)
    true = np.linalg.norm(apart, axis=1).max()
    assert true / 5 - 1e-9 < found < 5 * true + 1e-9


@row("error of the model")
def _(form):
    system, solution = flight(form)
    assert 0 <= _stated(system, SHORT, solution, "model", model=True) < 1e-5 * LENGTH


@row("self-correction")
def _(form):
    """To 1 % of the deflection."""
    if form == "intrinsic":
        found = enough_modes(hinged(form), lambda machine: simulate(machine, LONG), tolerance=0.01)
    else:
        body = bar_as("full") if form == "reduced" else bar_as(form)
        system = System([Placed(body, angular_velocity=SPIN)], [HINGE])
        found = self_correct(system, LONG, ReductionStart(SelfCorrection(relative=0.01)))
    other = PositionSensor("tip", "bar.tip").values(found.system, found.solution)[-1]
    assert other == pytest.approx(turned(RATE * 2 * PERIOD) @ (2 * CENTRE), abs=1e-3)


# ---- what is read off


@row("sensor: position")
def _(form):
    system, solution = flight(form)
    nodes = Place("bar", (0, 1))
    where = PositionSensor("nodes", nodes).values(system, solution)
    body = bar_as(form)
    assert where == pytest.approx(body.positions(solution.bodies["bar"], [0, 1]).mean(axis=1), abs=1e-12)


@row("sensor: velocity")
def _(form):
    found = VelocitySensor("tip", "bar.tip").values(*flight(form))
    times = flight(form)[1].times
    arms = np.array([turned(RATE * t) @ CENTRE for t in times])
    expected = VELOCITY + GRAVITY * times[:, None] + np.cross(SPIN, arms)
    assert mean(found) == pytest.approx(mean(expected), abs=0.01)


@row("sensor: acceleration")
def _(form):
    found = mean(AccelerationSensor("tip", "bar.tip").values(*flight(form)))
    change = np.cross(SPIN, turned(RATE * PERIOD) @ CENTRE - CENTRE)
    assert found == pytest.approx(GRAVITY + change / PERIOD, abs=0.5)


@row("sensor: angular velocity")
def _(form):
    found = AngularVelocitySensor("tip", At("bar", "tip")).values(*flight(form))
    assert mean(found) == pytest.approx(SPIN, abs=0.01)


@row("sensor: angle of a joint")
def _(form):
    system, solution = swing(form)
    angle = JointMotionSensor("angle", "hinge").values(system, solution)[:, 0]
    assert angle == pytest.approx(RATE * solution.times, abs=2e-3)


@row("sensor: force of a joint")
def _(form):
    system, solution = swing(form)
    found = JointForceSensor("pull", "hinge").values(system, solution)[:, :3]
    arms = np.array([turned(RATE * t) @ CENTRE for t in solution.times])
    pull = mean(found @ HINGE.initial_axes.T)
    assert pull == pytest.approx(mean(-MASS * RATE**2 * arms), abs=0.03 * MASS * RATE**2 * LENGTH / 2)


@row("sensor: stress")
def _(form):
    """rho omega^2 L^2 / 8 in the middle of a bar that spins about it."""
    sensor = StressSensor("stress", "bar", model(), MIDDLE[0], Component("xx"))
    found = mean(sensor.values(*flight(form)))
    assert found == pytest.approx(DENSITY * RATE**2 * LENGTH**2 / 8, rel=0.1)


@row("sensor: force across a section")
def _(form):
    place = Place("bar", "tip" if form == "rigid" else MIDDLE)
    sensor = SectionForceSensor("section", place, (1.0, 0, 0), None if form == "intrinsic" else model())
    found = mean(sensor.values(*flight(form)))[0]
    assert found == pytest.approx(SECTION * DENSITY * RATE**2 * LENGTH**2 / 8, rel=0.1)


@row("sensor: energies")
def _(form):
    kinetic, _, potential, total = EnergySensor("energy").values(*flight(form)).T
    assert kinetic[0] == pytest.approx(MASS * VELOCITY @ VELOCITY / 2 + ACROSS * RATE**2 / 2, rel=0.01)
    fallen = MASS * GRAVITY @ GRAVITY * PERIOD**2 / 2
    assert potential[-1] - potential[0] == pytest.approx(-fallen, rel=0.01)
    assert np.abs(total - total[0]).max() < 2e-3 * kinetic[0]


# ---- pages


@row("report in a browser")
def _(form, tmp_path):
    """Its page has it where the run has it, as drawn by the script."""
    system, solution = flight(form)
    body, motion = bar_as(form), solution.bodies["bar"]
    meshes = {} if form == "rigid" else {"bar": model().mesh}
    page = ReadPage(write_report(tmp_path / "run.html", system, solution, meshes))
    exact, largest = body.positions(motion), 0.0
    if form == "rigid":
        position, rotation = page.poses("bar")
        found = position[:, None] + np.einsum("tij,nj->tni", rotation, body.nodes)
    else:
        found = page.positions("bar")
        largest = np.linalg.norm(page.field(page.body("bar")["displacement"]), axis=2).max()
        assert largest > 1e-6
    assert np.abs(found - exact).max() < 1e-4 * largest + 5e-7


# ---- case files


def called(*arguments):
    """Output of a command, its lines joined; what it refuses is raised."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    printed = re.sub(r"\s+", " ", result.output)
    if result.exit_code:
        refused = re.search(r"(?:error|Error): (.*)", printed)
        raise SuppleError(refused.group(1) if refused else printed)
    return printed


@row("case file: run, tables")
def _(form, tmp_path):
    """Pulled at its tip; that is where a rigid bar would have it when the wave is back, by F t^2 / 2 m."""
    case = write_case(tmp_path, form, PULL, RUN)
    called("run", case, "-o", tmp_path / "out", "--no-errors")
    (place,) = json.loads((tmp_path / "out" / "bar.json").read_text())["tracked"].values()
    moved = np.array(place["last position"]) - 2 * CENTRE
    assert moved == pytest.approx([PERIOD**2 / 2 / MASS, 0, 0], rel=0.05, abs=1e-8)


def _hinge_of(form):
    """Nodes of explicit elements have no place that it could be put on."""
    return "" if form == "finite elements" else HINGE_TABLE


@row("case file: static")
def _(form, tmp_path):
    called("static", write_case(tmp_path, form, _hinge_of(form), LIFT, RUN), "-o", tmp_path)
    (place,) = json.loads((tmp_path / "bar-static.json").read_text())["tracked"].values()
    assert place["last position"][2] == pytest.approx(_lifted(form), rel=2e-3)


@row("case file: modes")
def _(form, tmp_path):
    called("modes", write_case(tmp_path, form, _hinge_of(form), RUN), "-o", tmp_path, "-n", 1)
    (mode,) = json.loads((tmp_path / "bar-modes.json").read_text())["modes"]
    assert 2 * np.pi * mode["frequency"] == pytest.approx(_slowest(form), rel=5e-3)


@row("case file: info")
def _(form, tmp_path):
    assert "body bar" in called("info", write_case(tmp_path, form, RUN))


@row("case file: check")
def _(form, tmp_path):
    printed = called("check", write_case(tmp_path, form, RUN), "--modes", 1)
    assert "body 'bar'" in printed


@row("case file: export to CalculiX")
def _(form, tmp_path):
    lift = "" if form == "rigid" else LIFT.replace("{end}", "TIP")
    called("export", write_case(tmp_path, form, _hinge_of(form), lift, RUN), "-o", tmp_path / "deck.inp")
    assert "*CLOAD" in (tmp_path / "deck.inp").read_text().upper()


@row("case file: pictures, animations")
def _(form, tmp_path):
    case = write_case(tmp_path, form, PULL, RUN, pictures=True)
    called("run", case, "-o", tmp_path / "out", "--no-errors")
    assert (tmp_path / "out" / "motion.gif").stat().st_size > 1000


# ---- the walk


@contextmanager
def nothing_compiled():
    """Within the block no program is compiled, nor fetched from where they are kept, but those of one line.

    A law of time is looked at where a run begins: its operations one by one are programs to JAX.
    """
    noted = []

    def note(event, _seconds, **_):
        noted.append(event)

    jax.monitoring.register_event_duration_secs_listener(note)
    try:
        yield
    finally:  # whatever ends the block: a refusal does
        jax.monitoring.unregister_event_duration_listener(note)
        assert sum(event.startswith("/jax/core/compile/backend") for event in noted) <= 3


def checked(feature, form, folder):
    """Do what a row is about."""
    check = CHECKS[feature]
    with_folder = "tmp_path" in check.__code__.co_varnames[: check.__code__.co_argcount]
    return check(form, folder) if with_folder else check(form)


def _is_quick(feature, form):
    reads_the_flight = feature.startswith(("sensor", "report")) and "joint" not in feature
    return feature in QUICK or reads_the_flight or (feature in QUICK_OF_ONE and form == "reduced")


def cells(answer):
    """Row and column where the answer is, or is not, yes; those with nothing to ask left out."""
    return [
        pytest.param(
            feature,
            form,
            id=f"{feature}, {form}",
            marks=() if not answer or _is_quick(feature, form) else pytest.mark.slow,
        )
        for feature, row in TABLE.items()
        for form, cell in row.items()
        if (cell == YES) == answer and not cell.startswith(DASH)
    ]


@pytest.mark.parametrize(("feature", "form"), cells(True))
def test_what_a_form_does(feature, form, tmp_path):
    checked(feature, form, tmp_path)


@pytest.mark.parametrize(("feature", "form"), cells(False))
def test_what_a_form_does_not_is_refused_before_anything_is_compiled(feature, form, tmp_path):
    flight(form)
    with pytest.raises(SuppleError) as refusal, nothing_compiled():
        checked(feature, form, tmp_path)
    assert TABLE[feature][form] in str(refusal.value)


def test_every_row_has_a_check_and_the_page_prints_the_table():
    assert list(TABLE) == list(CHECKS)
    assert parts()[1] == page(), f"python {feature_table.__file__} writes the page anew"
