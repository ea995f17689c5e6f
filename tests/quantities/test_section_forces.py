"""Section forces against closed forms: a clamped beam under a tip force, and under its own weight."""

from __future__ import annotations

import csv

import h5py
import numpy as np
import pytest
from fixtures.beam_bodies import rectangle
from fixtures.beam_lines import beam_line, straight

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.errors import ModelError, SuppleWarning
from supple.export import write_readings
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.integrate import Solution, Statistics
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, System
from supple.mesh import CellType, Mesh, block, strip
from supple.methods.intrinsic import CLAMPED, intrinsic_body
from supple.quantities import Place, SectionForceSensor, read_sensors
from supple.reduction import CraigBampton, NoLoads, reduce
from supple.simulation import equilibrium
from supple.units import UnitSystem

LENGTH, DENSITY = 1.0, 7850.0
STEEL = Isotropic(2.1e11, 0.0, DENSITY)


def model_of(kind):
    if kind == "beams":
        n = 8
        mesh = Mesh(
            np.linspace(0, LENGTH, n + 1)[:, None] * np.eye(3)[0],
            {CellType.LINE2: np.column_stack([np.arange(n), np.arange(1, n + 1)])},
            node_sets={"root": [0], "tip": [n]},
        )
        return shell_model(mesh, rectangle(0.1, 0.3))
    if kind == "shell":
        return shell_model(strip(LENGTH, 0.1, 8, 2), HomogeneousSection(STEEL, 0.01))
    return solid_model(block(LENGTH, 0.1, 0.1, 8, 2, 2, CellType.HEXA8), STEEL)


def clamped(form, kind, load=None, gravity=(0.0, 0.0, 0.0)):
    """A cantilever along x, its elements, and the place in its middle."""
    model = model_of(kind)
    nodes = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    body = flexible_body("beam", model, nodes)
    forms = {
        "full": lambda: FullBody(body, NodalFixedFrame("root")),
        "linear": lambda: FullBody(body.linearized(), MeanAxisFrame()),
        "reduced": lambda: reduce(body, NodalFixedFrame("root"), CraigBampton(6), loads=NoLoads),
    }
    loads = () if load is None else (DeadForce(body="beam", at="tip", force=load),)
    clamp = Fixed(name="clamp", first=GROUND, second=At("beam", "root"))
    middle = np.flatnonzero(np.isclose(model.mesh.nodes[:, 0], LENGTH / 2))
    return System((Placed(forms[form]()),), (clamp,), loads, gravity=gravity), model, tuple(middle.tolist())


def read(system, solution, sensor):
    return read_sensors([sensor], system, solution)[0].values


@pytest.mark.slow
@pytest.mark.parametrize(
    ("form", "kind"),
    [("full", "beams"), ("full", "shell"), ("full", "solid"), ("linear", "shell"), ("reduced", "solid")],
)
def test_a_tip_force_is_carried_as_shear_and_moment(form, kind):
    """`F = P`, `M = (tip - middle) x P`: half the moment at the clamp."""
    force = np.array([5.0, 2.0, -10.0]) * 5e-4
    system, model, middle = clamped(form, kind, tuple(force))
    found = equilibrium(system)
    sensor = SectionForceSensor("mid", Place("beam", middle), (1.0, 0, 0), model)
    seen = read(system, found.solution, sensor)[0]
    exact = np.concatenate([force, np.cross([LENGTH / 2, 0.0, 0.0], force)])
    assert seen == pytest.approx(exact, abs=5e-6 * np.linalg.norm(force))
    other = SectionForceSensor("mid", Place("beam", middle), (-1.0, 0, 0), model)
    assert read(system, found.solution, other)[0] == pytest.approx(-seen, abs=1e-9 * np.linalg.norm(force))


def test_a_section_through_one_kind_of_element_of_several():
    """A beam with a plate at its tip: the section in the beam carries the force on the tip."""
    n = 8
    line = np.linspace(0, LENGTH, n + 1)[:, None] * np.eye(3)[0]
    plate = Mesh(
        np.vstack([line, [(1.1, -0.05, 0.0), (1.1, 0.05, 0.0)]]),
        {
            CellType.LINE2: np.column_stack([np.arange(n), np.arange(1, n + 1)]),
            CellType.TRIANGLE3: np.array([[n, n + 1, n + 2]]),
        },
        node_sets={"root": [0], "tip": [n], "mid": [n // 2]},
        cell_sets={"beam": {CellType.LINE2: range(n)}, "plate": {CellType.TRIANGLE3: [0]}},
    )
    model = shell_model(plate, {"beam": rectangle(0.1, 0.3), "plate": HomogeneousSection(STEEL, 0.01)})
    body = flexible_body("beam", model, [RigidInterface(name, name) for name in ("root", "tip", "mid")])
    system = System(
        (Placed(FullBody(body, NodalFixedFrame("root"))),),
        (Fixed(name="clamp", first=GROUND, second=At("beam", "root")),),
        (DeadForce(body="beam", at="tip", force=(0.0, 0.0, -0.01)),),
    )
    solution = equilibrium(system).solution
    for place in ((n // 2,), "mid"):
        sensor = SectionForceSensor("mid", Place("beam", place), (1.0, 0, 0), model)
        seen = read(system, solution, sensor)[0]
        assert seen == pytest.approx([0.0, 0.0, -0.01, 0.0, 0.005, 0.0], abs=1e-7)


@pytest.mark.slow
def test_own_weight_is_carried_as_shear_and_moment(tmp_path):
    """`F = w (L - x)`, `M = w (L - x)^2 / 2`; the consistent loads of beams give both at every node."""
    weight = 9.81e-3 * 2700.0 * 0.03
    system, model, _ = clamped("full", "beams", gravity=(0.0, 0.0, -9.81e-3))
    found = equilibrium(system)
    places = {2: 0.75, 4: 0.5, 6: 0.25}
    sensors = [SectionForceSensor(f"at {n}", Place("beam", (n,)), (2.0, 0, 0), model) for n in places]
    readings = read_sensors(sensors, system, found.solution)
    for reading, rest in zip(readings, places.values(), strict=True):
        _, _, shear, _, moment, _ = reading.values[0]
        assert shear == pytest.approx(-weight * rest, rel=1e-6)
        assert moment == pytest.approx(weight * rest**2 / 2, rel=1e-6)
    units = UnitSystem("m", "kg", "s")
    with write_readings(tmp_path / "sensors.csv", readings, units=units).open(newline="") as file:
        heads = next(csv.reader(file))
    assert [heads[3], heads[5]] == ["at 2.Fz_[N]", "at 2.My_[N m]"]
    with h5py.File(write_readings(tmp_path / "sensors.h5", readings, units=units)) as file:
        np.testing.assert_array_equal(file["at 4"], readings[1].values)
        assert np.asarray(file["at 4"].attrs["axes"]).tolist() == ["axes of beam"] * 6


@pytest.mark.slow
def test_an_intrinsic_body_carries_the_elastica():
    """`P L^2 / EI = 10`: the force is P wherever it is cut, the moment P times the way to the tip along x."""
    station = 10
    line = beam_line(straight(1.0, 20), EA=1e6, EI=1.0, GJ=1.0, mass_per_length=1.0, radius=0.01)
    body = intrinsic_body(line, CLAMPED, stations={"cut": station})
    clamp = Fixed(first="ground", second="beam.root")
    system = System([body], [clamp], [DeadForce(at="beam.tip", force=(0, 0, 10.0))])
    motion = equilibrium(system).solution.bodies["beam"]
    solution = Solution(np.zeros(1), {"beam": motion}, {}, Statistics(0, 0, 0, 0.0, 0.0))
    sensor = SectionForceSensor("cut", Place("beam", "cut"), (1.0, 0, 0))
    force, moment = np.split(read(system, solution, sensor)[0], 2)
    rotations, positions = (found[0] for found in body.places(motion))
    arm = positions[-1] - positions[station]
    assert np.linalg.norm(force) == pytest.approx(10.0, rel=5e-3)
    assert moment[1] == pytest.approx(-10.0 * arm[0], abs=0.01)
    assert rotations[station] @ force == pytest.approx([0.0, 0.0, 10.0], abs=10.0 * 0.12)
    assert sensor.channels(system)[0].axes == "axes of the section of beam"


@pytest.mark.parametrize("n_modes", [None, 2])
def test_section_forces_of_few_modes_are_warned_of(n_modes):
    """Each section carries the force at the tip; two modes give less than half of it near the tip."""
    line = beam_line(straight(1.0, 8), EA=1e6, EI=1.0, GJ=1.0, mass_per_length=1.0, radius=0.01)
    body = intrinsic_body(line, CLAMPED, n_modes, stations={"last": 7})
    clamp = Fixed(first="ground", second="beam.root")
    system = System([body], [clamp], [DeadForce(at="beam.tip", force=(0, 0, 0.1))])
    solution = equilibrium(system).solution
    sensor = SectionForceSensor("last", Place("beam", "last"), (1.0, 0, 0))
    if n_modes is None:
        assert np.linalg.norm(read(system, solution, sensor)[0, :3]) == pytest.approx(0.1, rel=1e-3)
        return
    with pytest.warns(SuppleWarning, match="keeps .* of its 48 modes: its section forces are inaccurate"):
        force = read(system, solution, sensor)[0, :3]
    assert np.linalg.norm(force) < 0.05


def test_what_has_no_section_forces_is_refused():
    system, model, middle = clamped("full", "shell")
    solution = equilibrium(system).solution
    first = tuple(np.flatnonzero(np.isclose(model.mesh.nodes[:, 0], LENGTH / 8)).tolist())
    along = (1.0, 0.0, 0.0)
    refused = [
        (SectionForceSensor("s", Place("beam", middle), along), "need the elements of body 'beam'"),
        (SectionForceSensor("s", Place("beam", first), along, model), "is at interface 'root'"),
        (SectionForceSensor("s", Place("beam", "tip"), along, model), "move it into the body"),
        (SectionForceSensor("s", Place("beam", middle), (0.0, 0.0, 0.0), model), "normal that is not zero"),
        (SectionForceSensor("s", Place("beam", middle), along, model_of("solid")), "not made of this model"),
    ]
    for sensor, cause in refused:
        with pytest.raises(ModelError, match=cause):
            read(system, solution, sensor)
    stone = System((Placed(RigidBody("stone", 1.0, np.zeros(3), np.eye(3), {"top": (0, 0, 0)})),))
    with pytest.raises(ModelError, match="is rigid, which has no section forces"):
        read(stone, solution, SectionForceSensor("s", Place("stone", "top"), along))
