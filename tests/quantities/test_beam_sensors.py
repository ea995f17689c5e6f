"""Sensors of beams: section forces and stress of full and reduced bodies, beside one another and a plane."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from fixtures.beam_bodies import rectangle

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import CoupledBeamSection, beam_forces, shell_model, stress_recovery, von_mises
from supple.integrate import FloatingMotion, Solution, Statistics
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, System
from supple.mesh import CellType, Mesh, rectangular_section
from supple.methods.intrinsic import LoadPath, condense
from supple.quantities import (
    BeamForceSensor,
    Component,
    Maximum,
    Mean,
    Place,
    SectionForceSensor,
    StressSensor,
    read_sensors,
    stress_modes,
    von_mises_history,
)
from supple.reduction import CraigBampton, NoLoads, reduce
from supple.simulation import equilibrium

N, LENGTH, WIDTH, HEIGHT = 6, 3.0, 0.1, 0.3
SECTION = replace(rectangle(WIDTH, HEIGHT), geometry=rectangular_section(HEIGHT, WIDTH))


@pytest.fixture(scope="module")
def model():
    """Beams along x; the two nodes at the tip are tied as one."""
    mesh = Mesh(
        np.linspace(0, LENGTH, N + 1)[:, None] * np.eye(3)[0],
        {CellType.LINE2: np.column_stack([np.arange(N), np.arange(1, N + 1)])},
        node_sets={"root": [0], "tip": [N - 1, N]},
        cell_ids={CellType.LINE2: 10 * np.arange(1, N + 1)},
    )
    return shell_model(mesh, SECTION)


def body_of(model):
    return flexible_body("beam", model, [RigidInterface("root", "root"), RigidInterface("tip", "tip")])


@pytest.fixture(scope="module")
def forms(model):
    """The body in full and reduced, without what the reduced one condenses: it moves in the columns alone."""
    full = FullBody(body_of(model), MeanAxisFrame())
    reduced = reduce(full.body, full.frame, CraigBampton(3), loads=NoLoads)
    return full, replace(reduced, condensed=None)


@pytest.fixture(scope="module")
def amplitudes(forms):
    gamma = np.random.default_rng(0).normal(size=(3, forms[1].r))
    return 0.1 * gamma / np.abs(forms[1].expand(gamma)).max()


def machine(form, coordinates):
    t, r = coordinates.shape
    shapes = {"position": (3,), "rotation": (3, 3), "velocity": (3,), "angular_velocity": (3,)}
    shapes |= {"acceleration": (3,), "angular_acceleration": (3,)}
    arrays = {each.name: np.zeros((t, *shapes.get(each.name, (r,)))) for each in fields(FloatingMotion)}
    motion = FloatingMotion(**arrays | {"coordinates": coordinates})
    return System((Placed(form),)), Solution(
        np.arange(t), {"beam": motion}, {}, Statistics(0, 0, 0, 0.0, 0.0)
    )


def clamped(form, force):
    clamp = Fixed(first=GROUND, second=At("beam", "root"))
    return System((Placed(form),), (clamp,), (DeadForce(at="beam.tip", force=force),))


def test_reduced_and_full_bodies_show_the_same_stress(forms, model, amplitudes):
    """Also beside the tied tip, with the quadratic strains."""
    full, reduced = forms
    q = np.linalg.lstsq(full.body.expansion.toarray(), reduced.nodal_basis, rcond=None)[0]
    np.testing.assert_allclose(full.body.expansion @ q, reduced.nodal_basis, atol=1e-9)
    expected = von_mises_history(full, model, amplitudes @ q.T)
    found = von_mises_history(reduced, model, amplitudes)
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8 * expected.max())
    at_once = stress_modes(reduced, model).at(amplitudes)
    assert at_once.shape[2] == stress_recovery(model).layers.count == 16
    np.testing.assert_allclose(von_mises(at_once).max(axis=2), found, rtol=1e-9, atol=1e-14 * found.max())


def test_second_differences_are_the_quadratic_part(forms, model, amplitudes):
    reduced = forms[1]
    modes, gamma = stress_modes(reduced, model), amplitudes[0]
    plus, minus = modes.at(gamma), modes.at(-gamma)
    recovery = stress_recovery(model)
    u = reduced.nodal_basis @ gamma
    inner = [0, 1, 2, 3]  # without the tie
    second = recovery.at_nodes(u) + recovery.at_nodes(-u)
    np.testing.assert_allclose((plus + minus)[inner], second[inner], atol=1e-9 * np.abs(plus).max())
    assert np.abs(second).max() > 1e-3 * np.abs(plus).max()


def test_forces_of_a_beam_are_those_of_the_recovered_field(forms, model, amplitudes):
    """Reduced: of V gamma. The channels are forces, then moments, in the axes of the section."""
    reduced = forms[1]
    system, solution = machine(reduced, amplitudes)
    expected = np.array([beam_forces(model, reduced.nodal_basis @ gamma) for gamma in amplitudes])
    for end in (1, 2):
        sensor = BeamForceSensor("strut", "beam", model, 20, end)
        found = read_sensors([sensor], system, solution)[0]
        np.testing.assert_allclose(found.values, expected[:, 1, end - 1], atol=1e-9 * np.abs(expected).max())
    assert [channel.name for channel in found.channels] == ["N", "Vy", "Vz", "T", "My", "Mz"]
    assert found.channels[0].axes == "section of beam 20 of beam"


def test_what_a_beam_force_sensor_cannot_read(forms, model, amplitudes):
    system, solution = machine(forms[1], amplitudes)
    with pytest.raises(ModelError, match=r"there is no beam 21; the body has ids 10 to 60"):
        BeamForceSensor("strut", "beam", model, 21).values(system, solution)
    with pytest.raises(ModelError, match="a beam has ends 1 and 2, not 0"):
        BeamForceSensor("strut", "beam", model, 20, 0)


def test_stress_sensors_on_beams(forms, model, amplitudes):
    """One channel a point and end that any of the nodes has; a mean needs as many beams at every node."""
    system, solution = machine(forms[1], amplitudes)
    largest = StressSensor("middle", "beam", model, [0, 1, 2])
    assert len(largest.channels(system)) == 16
    root = StressSensor("root", "beam", model, [0], Component("xx"))
    assert [channel.name for channel in root.channels(system)] == [
        f"beam 1 point {p} xx" for p in range(1, 9)
    ]
    found = read_sensors([largest, root], system, solution)
    history = von_mises_history(forms[1], model, amplitudes)
    np.testing.assert_allclose(found[0].values.max(axis=1), history[:, :3].max(axis=1), rtol=1e-9)
    with pytest.raises(ModelError, match="no common mean"):
        read_sensors([replace(largest, over=Mean())], system, solution)
    read_sensors([StressSensor("inside", "beam", model, [1, 2], over=Mean())], system, solution)
    bare = shell_model(model.mesh, rectangle(WIDTH, HEIGHT))
    with pytest.raises(ModelError, match="have no recovery points"):
        read_sensors([StressSensor("none", "beam", bare, [1], over=Maximum())], system, solution)


@pytest.mark.slow
def test_a_clamped_beam_under_a_tip_force(model):
    """N, V and M along the bent axes; their mean over both beams at a node is the force across the plane."""
    force = np.array([30.0, 200.0, -100.0])
    system = clamped(FullBody(body_of(model), NodalFixedFrame("root")), force)
    solution = equilibrium(system).solution
    node, x = 2, LENGTH * 2 / N
    sensors = [BeamForceSensor("left", "beam", model, 20, 2), BeamForceSensor("right", "beam", model, 30, 1)]
    plane = SectionForceSensor("plane", Place("beam", (node,)), (1.0, 0, 0), model)
    stress = StressSensor("fibre", "beam", model, [node], Component("xx"))
    left, right, cut, fibre = (
        found.values[0] for found in read_sensors([*sensors, plane, stress], system, solution)
    )
    tip = LENGTH * (N - 1) / N
    exact = np.concatenate([force, np.cross([tip + LENGTH / N / 2 - x, 0, 0], force)])
    np.testing.assert_allclose(left, right, atol=1e-4 * np.abs(exact).max())
    np.testing.assert_allclose((left + right) / 2, cut, atol=1e-3 * np.abs(exact).max())
    np.testing.assert_allclose(left, exact, atol=1e-3 * np.abs(exact).max())
    N_, _, _, _, My, Mz = left
    y, z = np.array(SECTION.geometry.points).T
    expected = N_ / SECTION.area - Mz * y / SECTION.I1 + My * z / SECTION.I2
    np.testing.assert_allclose(fibre[:8], expected, rtol=1e-3)


@pytest.mark.slow
def test_a_chain_of_coupled_beams_has_forces_and_no_stress(model):
    """As blade tables give them; full and condensed to a line, at small deflection."""
    stiffness = np.linalg.inv(SECTION.flexibility(np.zeros(1))[0])
    mesh = Mesh(model.mesh.nodes, model.mesh.cells, {"root": [0], "tip": [N]})
    coupled = shell_model(mesh, CoupledBeamSection(stiffness, SECTION.inertia(np.zeros(1))[0], (0, 1, 0)))
    body = flexible_body("beam", coupled, [RigidInterface("root", "root"), RigidInterface("tip", "tip")])
    force = np.array([0.0, 20.0, -10.0])
    read = []
    for form in (
        FullBody(body, NodalFixedFrame("root")),
        condense(body, LoadPath("root", "tip", n_stations=4)),
    ):
        system = System(
            (Placed(form),),
            (Fixed(first=GROUND, second=At("beam", "root")),),
            (DeadForce(at="beam.tip", force=force),),
        )
        solution = equilibrium(system).solution
        read.append(
            read_sensors([BeamForceSensor("b", "beam", coupled, 1, 2)], system, solution)[0].values[0]
        )
    exact = np.concatenate([force, np.cross([LENGTH * (1 - 2 / N), 0, 0], force)])
    np.testing.assert_allclose(read[0], exact, atol=1e-4 * np.abs(exact).max())
    np.testing.assert_allclose(read[1], exact, atol=2e-2 * np.abs(exact).max())
