"""Intrinsic bodies that are driven start with the velocity of their drive, whatever holds their root."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import RigidBody
from supple.equations.checks.start_report import report_start
from supple.errors import ModelError, StartWarning
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Validity
from supple.machine import (
    Ball,
    ConstantRate,
    DeadForce,
    Fixed,
    Placed,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    System,
)
from supple.methods.intrinsic import CLAMPED, intrinsic_body, released
from supple.methods.intrinsic.joined_engine import JoinedEngine
from supple.methods.intrinsic.joined_machine import joined_machine
from supple.methods.intrinsic.joined_start import joined_start
from supple.methods.intrinsic.line_equations import force_rates, section_strains, station_velocities
from supple.methods.intrinsic.machine_of_lines import machine_of_lines
from supple.simulation import equilibrium

SOFT = {"EA": 1e4, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.05}
SPIN = 2.0
DRIVE = PrescribedRotation(
    name="drive", first="ground", second="beam.root", axis=(0, 0, 1), angle=ConstantRate(SPIN)
)


def beam(name="beam", *, support=CLAMPED, n_modes=None):
    return intrinsic_body(beam_line(straight(1.0, 4), name=name, **SOFT), support, n_modes)


def bent():
    """A clamped beam at rest under a force at its tip."""
    clamp = Fixed(name="clamp", first="ground", second="beam.root")
    system = System([beam()], [clamp], [DeadForce(at="beam.tip", force=[0, 0.8, 0.3])])
    return equilibrium(system).solution.bodies["beam"].coordinates[0]


def strain_rates(model, state, drive=None):
    """Rates of the force amplitudes."""
    root = None if drive is None else drive.twist(0.0)
    x1 = station_velocities(model, state.q1, root)
    return np.asarray(force_rates(model, x1, state.q1, section_strains(model, state.q2)))


def joined(system):
    return joined_start(joined_machine(system, 0.0), 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("is_bent", [False, True])
def test_a_turned_beam_does_not_deform(is_bent):
    """On the clamped modes, and joined to its drive as a body with a free root."""
    coordinates = bent() if is_bent else np.zeros(beam().n_coordinates)
    assert bool(np.abs(coordinates).max() > 1e-3) is is_bent
    held = machine_of_lines(System([Placed(beam(), coordinates=coordinates)], [DRIVE]), 0.0)
    model, drive, state = held.lines.lines[0], held.lines.drives[0], held.start[0]
    rates = strain_rates(model, state, drive)
    # Rigid motion of a bent beam is exact as its stations grow many; modes at rest would deform it.
    unfit = strain_rates(model, replace(state, q1=0 * state.q1), drive)
    assert np.abs(rates).max() <= 1e-8 + 2e-3 * np.abs(unfit).max()
    free = released(beam())
    # The same strains in the modes of the free body.
    strains = beam().modes.strains.reshape(-1, beam().n_coordinates) @ beam().forces_of(coordinates)
    q2 = np.linalg.lstsq(free.modes.strains.reshape(len(strains), -1), strains, rcond=None)[0]
    arrays, now, change = joined(System([Placed(free, coordinates=-q2 / free.modes.omega[6:])], [DRIVE]))
    assert np.abs(strain_rates(arrays.lines[0], now.lines[0])).max() <= 1e-8 + 2e-3 * np.abs(unfit).max()
    (taken,) = change.taken
    assert (taken.body, taken.spin) == ("beam", pytest.approx(SPIN))
    assert not change.deforming


def test_a_shaken_beam_moves_with_its_table():
    table = PrescribedTranslation(
        name="table", first="ground", second="beam.root", axis=(0, 1, 0), displacement=ConstantRate(0.3)
    )
    arrays, now, _ = joined(System([released(beam())], [table]))
    assert np.abs(now.lines[0].q1[6:]).max() < 1e-9
    x1 = np.asarray(station_velocities(arrays.lines[0], now.lines[0].q1))
    np.testing.assert_allclose(x1, np.tile([0, 0.3, 0, 0, 0, 0], (5, 1)), atol=1e-9)


@pytest.mark.slow
def test_a_hub_carries_its_beam_and_a_crank_its_rod():
    hub = RigidBody("hub", 2.0, [0, 0, 0], np.eye(3), {"middle": [0, 0, 0], "rim": [0.2, 0, 0]})
    motor = PrescribedRotation(
        name="motor", first="ground", second="hub.middle", axis=(0, 0, 1), angle=ConstantRate(SPIN)
    )
    weld = Fixed(name="weld", first="hub.rim", second="beam.root")
    system = System([Placed(released(beam()), position=[0.2, 0, 0]), hub], [motor, weld])
    arrays, now, change = joined(system)
    assert np.abs(strain_rates(arrays.lines[0], now.lines[0])).max() < 1e-9
    np.testing.assert_allclose(now.velocity, [0, 0, 0, 0, 0, SPIN], atol=1e-9)
    assert {each.body for each in change.taken} == {"hub", "beam"}

    slider = RigidBody("slider", 0.5, [0, 0, 0], np.eye(3), {"pin": [0, 0, 0]})
    joints = [
        motor,
        Ball(name="big end", first="hub.rim", second="beam.root"),
        Revolute(name="small end", first="slider.pin", second="beam.tip", axis=(0, 0, 1)),
        Prismatic(name="way", first="ground", second="slider.pin", axis=(1, 0, 0)),
    ]
    along = np.sqrt(1 - 0.2**2)
    upright = Placed(hub, rotation=[0, 0, np.pi / 2])
    rod = Placed(released(beam()), position=[0, 0.2, 0], rotation=[0, 0, -np.arcsin(0.2)])
    chain = System([upright, rod, Placed(slider, position=[along, 0, 0])], joints)
    arrays, now, _ = joined(chain)
    assert np.abs(strain_rates(arrays.lines[0], now.lines[0])).max() < 1e-9
    np.testing.assert_allclose(now.velocity[6:9], [-0.2 * SPIN, 0, 0], atol=1e-9)


def test_the_rest_of_a_rate_that_no_rigid_motion_meets_deforms_and_warns():
    pull = PrescribedTranslation(
        name="pull", first="ground", second="beam.tip", axis=(1, 0, 0), displacement=ConstantRate(0.01)
    )
    clamp = Fixed(name="clamp", first="ground", second="beam.root")
    system = System([released(beam())], [clamp, pull])
    change = joined(system)[2]
    with pytest.warns(StartWarning, match="body 'beam' deforms at a rate of kinetic energy .*'pull'"):
        report_start(change, Validity())


@pytest.mark.slow
def test_given_velocities_that_joints_do_not_allow_are_said_alike():
    given = Placed(released(beam()), velocity=[0, 0, 0], angular_velocity=[0, 0, 0])
    run = Run(0.002, 0.001, step=FixedStep(1e-3), method=GeneralizedAlpha(1.0))
    with pytest.warns(StartWarning, match="body 'beam' starts with an angular velocity of 2 instead of 0"):
        JoinedEngine(System([given], [DRIVE]), run).start(0.0)
    with pytest.raises(ModelError, match=r"its root cannot have: .* Give the velocity of its joint, or none"):
        machine_of_lines(System([Placed(beam(), angular_velocity=[0, 0, 0])], [DRIVE]), 0.0)


def test_what_is_left_out_of_a_velocity_follows_the_drive():
    """A root off the origin of its body: of the spin alone the velocity of the origin follows."""
    line = beam_line(straight(1.0, 4) + np.array([0.5, 0, 0]), name="beam", **SOFT)
    placed = Placed(intrinsic_body(line, CLAMPED), angular_velocity=[0, 0, SPIN])
    held = machine_of_lines(System([placed], [DRIVE]), 0.0)
    assert np.abs(held.start[0].q1).max() == 0
    arrays, now, change = joined(
        System([Placed(released(placed.body), angular_velocity=[0, 0, SPIN])], [DRIVE])
    )
    assert np.abs(strain_rates(arrays.lines[0], now.lines[0])).max() < 1e-9
    assert not change.slowed
