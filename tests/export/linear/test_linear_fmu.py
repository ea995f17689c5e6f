"""Linear machines as FMUs: the closed form, the march for small motions, one library for all."""

from __future__ import annotations

import zipfile
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from fixtures.beam_bodies import beam_body
from fixtures.compiled_c import needs_compiler
from fixtures.exported_machines import (
    STEP,
    blade,
    chain,
    controlled_arm,
    linked,
    run,
    slider_crank,
    stops_and_friction,
)

from supple.body import NodalFixedFrame, RigidBody
from supple.errors import ModelError
from supple.export.fmu import prebuilt
from supple.export.fmu.platforms import PLATFORMS
from supple.export.fmu.write_fmu import linear_sources, write_linear_fmu
from supple.export.linear.linear_form import linear_form
from supple.integrate import FixedStep, Run
from supple.machine import (
    AngleServo,
    Bushing,
    Controller,
    ForceBetween,
    JointReading,
    Placed,
    Prismatic,
    Revolute,
    Sine,
    SpringDamper,
    System,
    TorqueBetween,
)
from supple.quantities import (
    AccelerationSensor,
    AngularVelocitySensor,
    JointForceSensor,
    JointMotionSensor,
    PositionSensor,
    SpringForceSensor,
    VelocitySensor,
)
from supple.reduction import CraigBampton, NoLoads, reduce
from supple.simulation import equilibrium
from supple.stepping import step_program

M, C, K = 2.0, 0.8, 50.0
AWAY = 0.03


@pytest.fixture(autouse=True)
def _quickly_compiled(monkeypatch):
    monkeypatch.setenv("CFLAGS", "-O1")


def oscillator():
    """A mass on a spring along x, a force on it, that starts away from its rest."""
    mass = RigidBody("mass", M, np.zeros(3), np.eye(3), {"eye": np.zeros(3)})
    guide = Prismatic(first="ground", second="mass.eye", axis=(1, 0, 0), name="guide")
    spring = SpringDamper(
        first="ground", second="mass.eye", anchor=(-1, 0, 0), stiffness=K, damping=C, rest_length=1.0
    )
    force = ForceBetween(first="ground", second="mass.eye", axis=(1, 0, 0), force=0.0)
    sensors = [
        PositionSensor("place", "mass.eye"),
        VelocitySensor("speed", "mass.eye"),
        AccelerationSensor("shake", "mass.eye"),
        JointMotionSensor("slide", "guide"),
        JointForceSensor("carried", "guide"),
    ]
    placed = Placed(mass, position=np.array([AWAY, 0, 0]))
    return System([placed], [guide], loads=[spring, force]), run(), sensors, {"force": force}


def test_the_moment_of_a_servo_follows_its_set_point():
    inertia, k, c, s = 0.5, 40.0, 3.0, 9.0j
    wheel = RigidBody("wheel", 3.0, np.zeros(3), inertia * np.eye(3), {"hub": np.zeros(3)})
    hinge = Revolute(first="ground", second="wheel.hub", axis=(0, 0, 1), name="hinge")
    servo = AngleServo(first="ground", second="wheel.hub", axis=(0, 0, 1), angle=0.0, stiffness=k, damping=c)
    sensors = [SpringForceSensor("moment", servo)]
    form = linear_form(System([wheel], [hinge], loads=[servo]), run(), sensors, {"target": servo})
    transfer = form.c @ np.linalg.solve(s * np.eye(2) - form.a, form.b) + form.d
    expected = k * inertia * s**2 / (inertia * s**2 + c * s + k)
    np.testing.assert_allclose(transfer[:, 0], [0, 0, 0, 0, 0, expected], atol=1e-12 * k)


def beam():
    """A reduced beam on a hinge that a spring holds up, a torque at the hinge; from its equilibrium."""
    body = reduce(
        beam_body("root", "tip", length=4.0), NodalFixedFrame("root"), CraigBampton(3), loads=NoLoads
    )
    hinge = Revolute(first="ground", second=f"{body.name}.root", axis=(0, 1, 0), name="hinge")
    prop = SpringDamper(
        first="ground",
        second=f"{body.name}.tip",
        anchor=(4, 0, 3),
        stiffness=2e3,
        damping=20.0,
        rest_length=2.8,
    )
    motor = TorqueBetween(first="ground", second=f"{body.name}.root", torque=0.0, axis=(0, 1, 0))
    sensors = [
        PositionSensor("tip", f"{body.name}.tip"),
        VelocitySensor("speed", f"{body.name}.tip"),
        AccelerationSensor("shake", f"{body.name}.tip"),
        JointMotionSensor("hinge motion", "hinge"),
        JointForceSensor("root", "hinge"),
    ]
    system = System([Placed(body)], [hinge], loads=[prop, motor], gravity=np.array([0, 0, -9.81]))
    return equilibrium(system).system, run(FixedStep(STEP / 20)), sensors, {"motor": motor}


def test_a_start_at_rest_without_any_force_is_at_the_equilibrium():
    """All accelerations are rounding errors, and no relative difference of them means anything."""
    system, its_run, sensors, inputs = beam()
    hold = AngleServo(
        first="ground", second="beams.root", axis=(0, 1, 0), angle=0.1, stiffness=3e3, damping=9.0
    )
    weightless = replace(system, loads=[hold, *inputs.values()], gravity=np.zeros(3))
    form = linear_form(equilibrium(weightless).system, its_run, sensors, inputs)
    assert form.deviation < 1e-3


def formed(machine):
    system, its_run, sensors, inputs = machine
    return linear_form(system, its_run, sensors, inputs)


def simulated(path, form, inputs, size, number):
    """Outputs (number, o), by FMPy."""
    fmpy = pytest.importorskip("fmpy")
    kinds = [("time", float), *((each.name, float) for each in form.inputs)]
    given = np.array([(size * k, *inputs(k)) for k in range(number)], dtype=kinds)
    names = [each.name for each in form.outputs]
    found = fmpy.simulate_fmu(
        str(path), stop_time=number * size, step_size=size, output_interval=size, input=given, output=names
    )
    return np.array([[row[name] for name in names] for row in found])[1 : number + 1]


@needs_compiler
@pytest.mark.parametrize("fmi", [3, 2])
def test_an_oscillator_moves_as_its_closed_form(fmi, tmp_path, monkeypatch):
    pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    form = formed(oscillator())
    path = write_linear_fmu(tmp_path / "a folder ü" / "machine.fmu", form, "an oscillator", fmi=fmi)
    assert validate_fmu(str(path)) == []
    monkeypatch.chdir(tmp_path)
    size, number, force = 0.05, 40, 3.0  # any step: it is exact
    found = simulated(path, form, lambda _: (force,), size, number)
    decay, w0 = C / (2 * M), K / M
    w = np.sqrt(w0 - decay**2)
    t = size * np.arange(1, number + 1)
    x0 = AWAY - force / K
    x = force / K + x0 * np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    v = -x0 * np.exp(-decay * t) * w0 / w * np.sin(w * t)
    expected = {"place.x": x, "speed.x": v, "shake.x": (force - C * v - K * x) / M, "slide.slide": x - AWAY}
    names = [each.name for each in form.outputs]
    for name, value in expected.items():
        np.testing.assert_allclose(found[:, names.index(name)], value, atol=1e-12)


@needs_compiler
@pytest.mark.slow
def test_small_motions_are_those_of_the_march_and_derivatives_its_matrices(tmp_path):
    fmpy = pytest.importorskip("fmpy")
    system, its_run, sensors, inputs = beam()
    form = linear_form(system, its_run, sensors, inputs)
    step = step_program(system, its_run, sensors, inputs)
    path = write_linear_fmu(tmp_path / "machine.fmu", form, "a beam")
    torque, number, every = 1e-2, 10, 20
    found = simulated(path, form, lambda _: (torque,), every * STEP, number)
    now, rows = step.start, []
    for k in range(1, number + 1):
        now = step.compiled(now._replace(input=np.array([torque])), STEP * every * k)
        rows.append(np.asarray(now.output))
    expected = np.array(rows) - step.start.output
    names = [each.name for each in form.outputs]
    assert names == [each.name for each in step.outputs.variables]
    found -= form.rest
    # The rates have modes up to 27 000 rad/s in them, which the march damps.
    place = names.index("tip.z")
    size = np.abs(expected[:, place]).max()
    assert size > 0
    np.testing.assert_allclose(found[:, place], expected[:, place], atol=0.02 * size)

    kind = fmpy.fmi3.FMU3Slave
    fmu = kind(
        guid=fmpy.read_model_description(str(path)).guid,
        unzipDirectory=fmpy.extract(str(path), unzipdir=str(tmp_path / "own")),
        modelIdentifier="machine",
        instanceName="one",
    )
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    size, m, references = 0.01, len(form.a), list(range(2, 2 + len(names)))
    fmu.doStep(0.0, size)
    block = np.block([[form.a, form.b], [np.zeros((1, m + 1))]]) * size
    held = form.c @ scipy.linalg.expm(block)[:m, m:] + form.d
    own = np.array(fmu.getDirectionalDerivative(references, [1], [1.0]))
    np.testing.assert_allclose(own, held[:, 0], rtol=1e-9, atol=1e-10 * np.abs(held).max())
    kept = fmu.getFMUState()
    data = fmu.serializeFMUState(kept)

    def moved(value):
        fmu.setFloat64([1], [value])
        for k in range(5):
            fmu.doStep(size * (k + 1), size)
        return fmu.getFloat64(references)

    first = moved(2.0)
    fmu.setFMUState(fmu.deserializeFMUState(data))
    assert moved(2.0) == first
    fmu.setFMUState(kept)
    assert moved(1.0) != first
    fmu.reset()
    first = np.array([each.start for each in form.outputs])
    np.testing.assert_allclose(fmu.getFloat64(references), first, atol=1e-14 * np.abs(first).max())


@pytest.mark.slow
@needs_compiler
def test_two_machines_share_one_library_which_refuses_the_numbers_of_another(tmp_path):
    fmpy = pytest.importorskip("fmpy")
    forms = {"one": formed(oscillator()), "other": formed(beam())}
    paths = {name: write_linear_fmu(tmp_path / f"{name}.fmu", form, name) for name, form in forms.items()}
    libraries = []
    for path in paths.values():
        with zipfile.ZipFile(path) as archive:
            libraries.append(archive.read("binaries/x86_64-linux/machine.so"))
    assert libraries[0] == libraries[1]
    folders = {name: fmpy.extract(str(path), unzipdir=str(tmp_path / name)) for name, path in paths.items()}
    numbers = tmp_path / "other" / "resources" / "linear.bin"
    whole = numbers.read_bytes()
    for content in ((tmp_path / "one" / "resources" / "linear.bin").read_bytes(), whole[:-8], whole + b"0"):
        numbers.write_bytes(content)
        fmu = fmpy.fmi3.FMU3Slave(
            guid=fmpy.read_model_description(str(paths["other"])).guid,
            unzipDirectory=folders["other"],
            modelIdentifier="machine",
            instanceName="other",
        )
        with pytest.raises(Exception, match="instantiate"):
            fmu.instantiate()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("machine", "cause"),
    [
        (stops_and_friction, "stops, contacts and friction"),
        (slider_crank, "prescribed motion of 'crank'"),
        (blade, "vary with time"),
        (controlled_arm, "vary with time"),
        (chain, "too far from its equilibrium"),
    ],
)
def test_what_has_no_linear_form_is_refused_with_its_cause(machine, cause):
    with pytest.raises(ModelError, match=cause):
        formed(machine())


def test_a_load_that_vanishes_at_even_times_is_seen_to_vary():
    system, _, sensors, inputs = oscillator()
    shaken = ForceBetween(
        first="ground", second="mass.eye", axis=(1, 0, 0), force=Sine(1.0, frequency_hz=5.0)
    )
    system = System(system.bodies, system.joints, loads=[*system.loads, shaken], gravity=(0, 0, -9.81))
    with pytest.raises(ModelError, match="vary with time"):
        linear_form(system, Run(10.0, 0.1), sensors, inputs)


@pytest.mark.slow
def test_a_controlled_machine_has_the_states_of_its_controller():
    bodies, joints = linked(1)
    motor = TorqueBetween(first="ground", second="l0.a", torque=0.0, axis=(0, 0, 1))
    push = TorqueBetween(first="ground", second="l0.b", torque=0.0, axis=(0, 0, 1))
    controller = Controller(
        reads={"hinge": JointReading("j0")},
        drives={"motor": motor},
        outputs=lambda _, read, z: {"motor": -40 * read["hinge"].angle - 4 * read["hinge"].rate + 20 * z[0]},
        rates=lambda _, read, z: -read["hinge"].angle[None] - 0.1 * z,
        initial=(0.0,),
    )
    sensors = [JointMotionSensor("hinge", "j0"), JointForceSensor("carried", "j0")]
    system = equilibrium(System(bodies, joints, loads=[push], controllers=[controller])).system
    form = linear_form(system, run(), sensors, {"push": push})
    step = step_program(system, run(), sensors, {"push": push})
    torque, m, total = 1e-3, len(form.a), 0.5
    assert m == 3
    block = np.block([[form.a, form.b], [np.zeros((1, m + 1))]]) * total
    found = form.c @ scipy.linalg.expm(block)[:m, m] * torque + form.d[:, 0] * torque
    now = step.compiled(step.start._replace(input=np.array([torque])), total)
    expected = np.asarray(now.output) - step.start.output
    np.testing.assert_allclose(found, expected, atol=2e-3 * np.abs(expected).max())
    assert np.abs(expected).max() > 1e-5


def test_libraries_of_the_package_need_no_compiler(tmp_path, monkeypatch):
    """They are found by the digest of their sources, all or none of the named platforms."""
    monkeypatch.setenv("CC", "no-such-compiler")
    monkeypatch.setattr(prebuilt, "FOLDER", tmp_path)
    sources, form = linear_sources(3), formed(oscillator())
    linux, arm = PLATFORMS["linux"]
    (tmp_path / prebuilt.prebuilt_path(sources, linux, 3)).write_bytes(b"a library")
    assert prebuilt.prebuilt_libraries(sources, 3, ()) == [(linux, b"a library")]
    assert prebuilt.prebuilt_libraries(sources, 3, (linux, arm)) == []
    assert prebuilt.prebuilt_libraries(sources | {"fmi3.c": ""}, 3, (linux,)) == []
    with zipfile.ZipFile(write_linear_fmu(tmp_path / "machine.fmu", form, "machine")) as archive:
        assert archive.read("binaries/x86_64-linux/machine.so") == b"a library"
    with pytest.raises(ModelError, match="no-such-compiler"):
        write_linear_fmu(tmp_path / "machine.fmu", form, "machine", fmi=2)


def rotor(sensor, spring=None):
    """A rotor at 10 rad/s on a hinge, or on a spring of its centre alone; one second of it."""
    rates = np.array([0.0, 0.0, 10.0])
    places = {"hub": np.zeros(3), "rim": np.array([0.1, 0.0, 0.0])}
    body = Placed(
        RigidBody("rotor", 2.0, np.zeros(3), np.diag([2.0, 2.0, 3.0]), places), angular_velocity=rates
    )
    hinge = Revolute(first="ground", second="rotor.hub", axis=(0, 0, 1), name="shaft")
    motor = TorqueBetween(first="ground", second="rotor.hub", torque=0.0, axis=(0, 0, 1))
    joints, loads = ([hinge], [motor]) if spring is None else ([], [motor, spring])
    return System([body], joints, loads=loads), run(FixedStep(0.01), 1.0), [sensor], {"motor": motor}


def test_a_drive_train_may_rotate_by_any_angle():
    form = formed(rotor(JointMotionSensor("shaft", "shaft")))
    after = form.rest + form.c @ scipy.linalg.expm(form.a) @ form.state
    np.testing.assert_allclose(after[:2], [10.0, 10.0], rtol=1e-12)


@pytest.mark.parametrize(
    ("sensor", "spring"),
    [
        # Without the check this point moves on a straight line, to a distance of 10 m from the axis.
        (PositionSensor("point", "rotor.rim"), None),
        # The gyroscopic moment couples the tilts of the rotor.
        (
            AngularVelocitySensor("rate", "rotor.hub"),
            Bushing(
                first="ground",
                second="rotor.hub",
                stiffness=(1e4, 1e4, 1e4, 1e3, 1e3, 0.0),
                damping=(0.0,) * 6,
            ),
        ),
    ],
)
def test_a_rotation_that_changes_the_matrices_is_refused(sensor, spring):
    with pytest.raises(ModelError, match="rotates by more than one radian"):
        formed(rotor(sensor, spring))
