"""Stress of node sets: the largest, the mean or the nearest, beside the bending stress of a beam."""

from __future__ import annotations

from dataclasses import replace

import h5py
import numpy as np
import pytest

from supple.body import FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.error import ErrorStudy
from supple.errors import ArgumentError, ModelError
from supple.export import write_readings
from supple.fem import HomogeneousSection, Isotropic, shell_model, von_mises
from supple.machine import GROUND, At, Fixed, Placed, System
from supple.mesh import strip
from supple.quantities import (
    Component,
    JointForceSensor,
    Maximum,
    Mean,
    Nearest,
    Place,
    PositionSensor,
    Readings,
    StrainSensor,
    StressSensor,
    VelocitySensor,
    largest_stress,
    read_sensors,
    stress_history,
    von_mises_history,
)
from supple.quantities.stress_history import tensor_blocks
from supple.quantities.tensor_modes import STRESS
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import equilibrium
from supple.units import UnitSystem

LENGTH, HEIGHT, DENSITY, GRAVITY = 1.0, 0.01, 7850.0, 9.81


def fibre_stress(x):
    """M c / I of a cantilever under its own weight, on its upper side."""
    return DENSITY * HEIGHT * GRAVITY * (LENGTH - x) ** 2 / 2 * 6 / HEIGHT**2


@pytest.fixture(scope="module")
def bent():
    """A clamped strip under its own weight, in full, at rest; its elements."""
    model = shell_model(
        strip(LENGTH, 0.1, 16, 2), HomogeneousSection(Isotropic(2.1e11, 0.0, DENSITY), HEIGHT)
    )
    body = flexible_body("strip", model, (RigidInterface("root", "root"),))
    system = System(
        (Placed(FullBody(body, NodalFixedFrame("root"))),),
        (Fixed(first=GROUND, second=At("strip", "root")),),
        gravity=np.array([0.0, 0.0, -GRAVITY]),
    )
    return (system, equilibrium(system).solution), model


@pytest.fixture(scope="module")
def two_rows(bent):
    """Nodes across the strip at a quarter and at three quarters of it, as two bolt holes in one set."""
    x = bent[1].mesh.nodes[:, 0]
    return np.flatnonzero(np.isclose(x, 0.25) | np.isclose(x, 0.75))


def reading(bent, two_rows, over, kind=StressSensor):
    machine, model = bent
    return read_sensors([kind("bolts", "strip", model, two_rows, Component("xx"), over)], *machine)[0]


def test_the_maximum_over_a_set_is_the_bending_stress_where_it_is_largest(bent, two_rows):
    found = reading(bent, two_rows, Maximum())
    low, _, high = found.values[0]
    assert high == pytest.approx(fibre_stress(0.25), rel=0.01)
    assert low == pytest.approx(-fibre_stress(0.25), rel=0.01), "the magnitude counts, its sign is kept"
    np.testing.assert_allclose(found.points[0, [0, 2], 0], 0.25)
    ids = bent[1].mesh.node_ids
    assert found.nodes[0, 2] in ids[two_rows]
    assert found.channels[2].place == "largest of 6 nodes"


def test_the_mean_and_the_node_nearest_the_centroid(bent, two_rows):
    mean = reading(bent, two_rows, Mean())
    expected = (fibre_stress(0.25) + fibre_stress(0.75)) / 2
    assert mean.values[0, 2] == pytest.approx(expected, rel=0.01)
    assert mean.nodes is None
    assert mean.channels[0].place == "mean of 6 nodes"
    row = np.flatnonzero(np.isclose(bent[1].mesh.nodes[:, 0], 0.5))
    nearest = reading(bent, row, Nearest())
    np.testing.assert_allclose(nearest.points[0], [[0.5, 0.0, 0.0]] * 3, atol=1e-12)
    assert nearest.channels[0].place.startswith(f"node {nearest.nodes[0, 0]} at (0.5, 0, 0), nearest to")


def test_a_set_of_one_node_names_it(bent, two_rows):
    found = reading(bent, two_rows[:1], Maximum(), StrainSensor)
    node = two_rows[0]
    x, y, z = bent[1].mesh.nodes[node]
    assert found.channels[0].place == f"node {bent[1].mesh.node_ids[node]} at ({x:.4g}, {y:.4g}, {z:.4g})"
    assert found.values[0, 2] * 2.1e11 == pytest.approx(fibre_stress(0.25), rel=0.02)


def test_node_and_place_stand_in_report_file_and_data_set(bent, two_rows, tmp_path):
    found = reading(bent, two_rows, Maximum())
    told = found.plain()["top xx"]
    assert told["node of largest"] == found.nodes[0, 2]
    assert told["point of largest"][0] == pytest.approx(0.25)
    assert told["place"] == "largest of 6 nodes"
    with h5py.File(
        write_readings(tmp_path / "sensors.h5", [found], units=UnitSystem("m", "kg", "s"))
    ) as file:
        np.testing.assert_array_equal(file["bolts.nodes"], found.nodes)
        np.testing.assert_array_equal(file["bolts"].attrs["nodes"], found.nodes[0])
        np.testing.assert_allclose(file["bolts"].attrs["points"], found.points[0])
        assert set(file["bolts"].attrs["places"]) == {"largest of 6 nodes"}
    pytest.importorskip("xarray")
    assert Readings([found]).to_xarray()["bolts.top xx"].attrs["place"] == "largest of 6 nodes"


def test_sensors_are_quantities_of_interest_at_their_points(bent, two_rows):
    """Against the cantilever under its weight w: w/8 L^3/EI at its tip, w at its joint."""
    (system, solution), model = bent
    stress = StressSensor("stress", "strip", model, two_rows)
    expected = von_mises_history(system.bodies[0].body, model, solution.bodies["strip"].coordinates, two_rows)
    np.testing.assert_allclose(stress.at_points(system, solution)[..., 0], expected, rtol=1e-12)
    assert stress.size(system, solution) == expected.max()
    signed = StressSensor("stress", "strip", model, two_rows, Component("xx"))
    layers = read_sensors([signed], system, solution)[0].values[0]
    at_points = signed.at_points(system, solution)
    assert at_points.shape == (1, 6, 1)
    assert np.abs(at_points).max() == np.abs(layers).max()
    weight = DENSITY * HEIGHT * 0.1 * LENGTH * GRAVITY
    force = JointForceSensor("force", system.joints[0].name)
    assert force.size(system, solution) == pytest.approx(weight, rel=1e-6)
    ends = np.flatnonzero(np.isclose(model.mesh.nodes[:, 0], LENGTH))
    tip = PositionSensor("tip", Place("strip", ends))
    # The mean is a product: it differs from `mean` by rounding.
    means = tip.at_points(system, solution).mean(axis=1)
    np.testing.assert_allclose(tip.values(system, solution), means, rtol=1e-14, atol=1e-17)
    deflection = weight * LENGTH**3 / (8 * 2.1e11 * 0.1 * HEIGHT**3 / 12)
    assert tip.size(system, solution) == pytest.approx(deflection, rel=0.01)
    with pytest.raises(ArgumentError, match="ErrorStudy, quantities: expected the sensor of a position"):
        ErrorStudy(quantities=(VelocitySensor("tip", Place("strip", ends)),))


@pytest.mark.parametrize("is_reduced", [False, True])
def test_blocks_of_nodes_and_instants_change_nothing(bent, two_rows, monkeypatch, is_reduced):
    """Many nodes over many instants are read in parts: the parts are those of the whole."""
    module = stress_history
    (system, solution), model = bent
    form = system.bodies[0].body
    coordinates = np.linspace(0.1, 1.0, 7)[:, None] * solution.bodies["strip"].coordinates
    if is_reduced:
        form = reduce(
            form.body, NodalFixedFrame("root"), CraigBampton(3), derivatives=NoDerivatives(), loads=NoLoads
        )
        coordinates = np.random.default_rng(0).normal(size=(7, form.r)) * 1e-4

    def stresses():
        found = np.full((7, len(two_rows), 3, 6), np.nan)
        for times, nodes, field in tensor_blocks(STRESS, form, model, coordinates, two_rows):
            found[times, nodes] = field
        return found

    whole = stresses()
    largest = largest_stress(form, model, coordinates)
    everywhere = von_mises_history(form, model, coordinates)
    assert largest.value == pytest.approx(everywhere.max(), rel=1e-9)
    assert everywhere[largest.instant, largest.node] == pytest.approx(everywhere.max(), rel=1e-9)
    monkeypatch.setattr(module, "_MODE_NUMBERS", 1)
    monkeypatch.setattr(module, "_FIELD_NUMBERS", 1)
    np.testing.assert_allclose(stresses(), whole, rtol=1e-9, atol=1e-3)
    values = von_mises(whole).max(axis=2)
    np.testing.assert_allclose(everywhere[:, two_rows], values, rtol=1e-9)
    assert largest_stress(form, model, coordinates)[1:] == largest[1:]
    of_interest = StressSensor("s", "strip", model, two_rows)
    machine = replace(system, bodies=(Placed(form),))
    still = replace(solution.bodies["strip"], coordinates=coordinates)
    at_points = of_interest.at_points(machine, replace(solution, bodies={"strip": still}))
    np.testing.assert_allclose(at_points[..., 0], values, rtol=1e-9)


@pytest.mark.parametrize(
    ("nodes", "cause"),
    [
        ([], "sensor 's' has no node"),
        ([10_000], r"sensor 's': nodes \[10000\]"),
        ("tip", "StressSensor, nodes: expected a whole number or a list"),
    ],
)
def test_nodes_that_have_no_stress_are_refused(bent, nodes, cause):
    machine, model = bent
    with pytest.raises((ModelError, ArgumentError), match=cause):
        read_sensors([StressSensor("s", "strip", model, nodes)], *machine)


def test_a_short_event_away_from_the_steady_stress_has_the_largest():
    """Seven of a thousand times, between the evenly spaced ones, at nodes with little stress otherwise."""
    model = shell_model(strip(1.0, 0.1, 30, 4), HomogeneousSection(Isotropic(2.1e11, 0.0, DENSITY), HEIGHT))
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    body = flexible_body("strip", model, ends)
    form = reduce(body, NodalFixedFrame("root"), CraigBampton(6), derivatives=NoDerivatives(), loads=NoLoads)
    unit = von_mises_history(form, model, 1e-6 * np.eye(form.r)).max(axis=1)
    coordinates = np.zeros((1000, form.r))
    coordinates[:, 0] = 1e-6 / unit[0]
    event = 2e-6 / unit[-1] * np.sin(np.pi * np.arange(9) / 8)
    coordinates[505:514, -1] = event
    everywhere = von_mises_history(form, model, coordinates)
    assert everywhere[:505].max() < 0.6 * everywhere.max()
    assert largest_stress(form, model, coordinates).value == pytest.approx(everywhere.max(), rel=1e-9)
