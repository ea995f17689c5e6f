"""Force elements that do not count revolutions: a warning where an angle leaves their range."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple import machine as m
from supple.body import RigidBody
from supple.errors import ValidityError, ValidityWarning
from supple.integrate import FloatingMotion, Run, Solution, Statistics, Validity
from supple.simulation.half_revolutions import report_half_revolutions

AXIS = np.array([2.0, -1.0, 2.0]) / 3
ENDS = {"first": "ground", "second": "rotor.hub"}
ALONG = {**ENDS, "axis": tuple(AXIS)}
TIMES = np.linspace(0.0, 1.0, 101)


def turned(load, revolutions, validity=None):
    """Check a machine with one load whose rotor turns at a constant rate for one unit of time."""
    rotor = RigidBody("rotor", 1.0, np.zeros(3), np.eye(3), {"hub": np.zeros(3)})
    rate = 2 * np.pi * revolutions * AXIS
    rotation = Rotation.from_rotvec(np.outer(TIMES, rate)).as_matrix()
    none, still = np.zeros((len(TIMES), 0)), np.zeros((len(TIMES), 3))
    spin = np.tile(rate, (len(TIMES), 1))
    motion = FloatingMotion(still, rotation, none, still, spin, none, still, still, none)
    system = m.System([rotor], loads=[load])
    run = Run(1.0, 0.01, validity=validity or Validity())
    report_half_revolutions(system, run, Solution(TIMES, {"rotor": motion}, {}, Statistics()))


TORSION = m.TorsionSpringDamper(**ALONG, stiffness=3.0)
TABLE = m.TabledTorque(**ALONG, torque=m.Surface([-2, 2], [0, 1], [[1, 1], [-1, -1]]))
BUSHING = m.Bushing(**ENDS, axis=tuple(AXIS), stiffness=[9, 9, 9, 5, 5, 0])
SERVO = m.AngleServo(**ALONG, angle=m.ConstantRate(2 * np.pi), stiffness=3.0)


@pytest.mark.parametrize("load", [TORSION, TABLE, BUSHING])
def test_an_angle_that_passes_half_a_revolution_is_reported(load):
    with pytest.warns(ValidityWarning, match=r"by t = 0\.84 its .* passes half a revolution"):
        turned(load, -0.6)  # half a revolution at 0.8333
    with pytest.raises(ValidityError, match="passes half a revolution"):
        turned(load, 0.6, Validity(strict=True))
    turned(load, 0.49)
    with pytest.warns(ValidityWarning, match="passes half a revolution"):
        turned(load, 60.0)  # more than half a revolution between output times


def test_a_servo_is_reported_where_it_is_half_a_revolution_late():
    with pytest.warns(ValidityWarning, match=r"by t = 0\.56 the difference from its set-point"):
        turned(SERVO, 0.1)
    turned(SERVO, 1.4)


@pytest.mark.parametrize(
    "load",
    [
        m.TorsionSpringDamper(**ALONG, damping=3.0),
        m.Bushing(**ENDS, stiffness=[9, 9, 9, 0, 0, 0]),
        m.TabledTorque(**ALONG, torque=m.Surface([-2, 2], [0, 1], [[1, 2], [1, 2]])),
        m.TabledTorque(**ALONG, torque=m.Surface([0, np.pi, 6.28], [0, 1], [[0, 0], [1, 1], [0, 0]])),
        m.RevoluteFriction(**ALONG, moment=1.0, width=0.1),
    ],
)
def test_what_turns_without_a_limit_is_not_reported(load):
    turned(load, 3.0)
    turned(load, 60.0)
