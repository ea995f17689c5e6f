"""What linear strains lack: the shortening of a beam by its bending, in closed form and beside full runs."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.equations.checks.validity import watch
from supple.error import ErrorStudy, state_errors
from supple.error.model_error import model_errors, model_errors_by_limit
from supple.errors import ValidityError, ValidityWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FloatingMotion, Run, Solution, Statistics, Validity
from supple.machine import GROUND, At, Fixed, Placed, System
from supple.mesh import strip
from supple.quantities import PositionSensor, WholeBody
from supple.quantities.place import Place
from supple.quantities.quantity_of_interest import quantity_distance
from supple.reduction import CraigBampton, NoDerivatives, reduce
from supple.simulation import equilibrium
from supple.simulation.stored_basis import stored_bases

LENGTH = 2.0


@pytest.fixture(scope="module")
def linear():
    """A strip without quadratic strains; its tip holds the static shape of a force."""
    wall = HomogeneousSection(Isotropic(1e9, 0.0, 1000.0), 0.01)
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    body = flexible_body("beam", shell_model(strip(LENGTH, 0.05, 16, 2), wall), ends).linearized()
    return reduce(body, NodalFixedFrame("root"), CraigBampton(1), derivatives=NoDerivatives())


def bent(body, turn):
    """At rest under a force at the tip across the strip, its end turned by so much."""
    tip = body.interface("tip")
    shape = np.linalg.solve(body.stiffness, tip.motion[2])
    shape *= turn / np.linalg.norm(tip.motion[3:] @ shape)
    rest = np.zeros((1, 3)), np.eye(3)[None], shape[None]
    still = np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, body.r))
    return Solution(np.zeros(1), {"beam": FloatingMotion(*rest, *still, *still)}, {}, Statistics())


@pytest.mark.parametrize("known", [True, False], ids=["rotations known", "displacements alone"])
@pytest.mark.parametrize("turn", [0.05, 0.2])
def test_a_linear_body_lacks_its_shortening(linear, turn, known):
    """w' = turn (1 - (1 - x/L)^2), and the tip should have moved by the integral of w'^2 / 2 to the root."""
    body = linear if known else replace(linear, rotation_basis=None)
    stated = model_errors_by_limit(System((Placed(body),)), bent(body, turn))["beam"]
    x = np.linspace(0.0, LENGTH, 2001)
    slope = turn * (1 - (1 - x / LENGTH) ** 2)
    shortening = float(np.trapezoid(slope**2 / 2, x))
    assert shortening < stated < 2 * shortening


@pytest.mark.parametrize(("turn", "warned"), [(0.05, False), (0.5, True)])
def test_a_large_error_of_the_model_is_a_warning(linear, turn, warned):
    """theta^2 / 2 of the length over the displacement 2 theta / 3 of a cantilever: 3/4 theta of it."""
    system, bend = System((Placed(linear),)), bent(linear, turn)
    study = ErrorStudy(basis=False, integration=False)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        (stated,) = state_errors(system, Run(1.0, 1.0), bend, study).errors.values()
    messages = [str(each.message) for each in caught if each.category is ValidityWarning]
    assert [message.startswith("body 'beam': the kinematics") for message in messages] == [True] * warned
    assert ("intrinsic body" in stated.advice) == warned
    assert stated.model.value / stated.size == pytest.approx(0.75 * turn, rel=0.03)
    if warned:
        strict = Run(1.0, 1.0, validity=Validity(strict=True))
        with pytest.raises(ValidityError, match="kinematics of the model"):
            state_errors(system, strict, bend, study)


@pytest.mark.parametrize(("axis", "share"), [((0.0, 0.0, 1.0), 0.16), ((1.0, 0.0, 0.0), 0.0)])
def test_a_linear_body_lacks_its_centrifugal_stiffness(linear, axis, share):
    """At 0.4 of its lowest frequency, about an axis across its root; about its own axis it is a shaft."""
    lowest = 1.875104**2 * np.sqrt(1e9 * 0.01**2 / 12 / (1000.0 * LENGTH**4))
    still = bent(linear, 0.05)
    spin = np.array([axis]) * 0.4 * lowest
    turning = replace(still.motion("beam", FloatingMotion), angular_velocity=spin)
    spun = replace(still, bodies={"beam": turning})
    system, run = System((Placed(linear),)), Run(1.0, 1.0)
    study = ErrorStudy(basis=False, integration=False)
    standing = state_errors(system, run, still, study).errors["beam"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        stated = state_errors(system, run, spun, study).errors["beam"]
    added = (stated.model.value - standing.model.value) / stated.size
    assert added == pytest.approx(share, rel=0.02, abs=1e-12)
    assert "quadratic strains" in stated.model.remedy


def test_a_rigid_body_at_the_end_of_a_beam_has_the_error_of_the_beam(linear):
    """It moves with the tip: its position is as wrong as that of the beam, and has its size."""
    load = RigidBody("load", 1.0, np.zeros(3), np.eye(3), {"lug": np.zeros(3)})
    system, bend = System((Placed(linear), Placed(load, position=(LENGTH, 0.0, 0.0)))), bent(linear, 0.05)
    still, none = np.zeros((1, 3)), np.zeros((1, 0))
    frame = FloatingMotion(still, np.eye(3)[None], none, still, still, none, still, still, none)
    solution = replace(bend, bodies={**bend.bodies, "load": frame})
    study = ErrorStudy(basis=False, integration=False, quantities=(PositionSensor("lug", "load.lug"),))
    stated = state_errors(system, Run(1.0, 1.0), solution, study).errors
    assert stated["lug"].size == stated["beam"].size > 0
    assert stated["lug"].model.value == pytest.approx(stated["beam"].model.value)


def test_a_linear_body_is_held_to_a_tenth_of_a_radian(linear):
    def messages(turn):
        limits = watch(System((Placed(linear),)), Validity())
        return limits.excesses(limits.observe({}, bent(linear, turn)))

    assert messages(0.09) == []
    (message,) = messages(0.2)
    assert message.startswith("body 'beam' is linear and rotates by 0.2")
    assert "lack the shortening by bending, 0.02 of its length" in message


@pytest.mark.parametrize(
    ("clamped", "gravity"),
    [
        pytest.param(("root",), 100.0, id="bent by several thicknesses"),
        pytest.param(("root", "tip"), 2000.0, id="stiffened by its membrane", marks=pytest.mark.slow),
    ],
)
def test_a_linear_plate_states_what_its_quadratic_strains_would_change(clamped, gravity):
    """At rest, beside all coordinates with quadratic strains. Stretch that is not relaxed would be 1000 times
    the error of the first, which is 4 and 400 times above what its second order alone is of the second."""
    wall = HomogeneousSection(Isotropic(70e9, 0.3, 2700.0), 0.004)
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    curved = flexible_body("plate", shell_model(strip(0.4, 0.1, 8, 2), wall), ends)
    full = FullBody(curved.linearized(), NodalFixedFrame("root"))
    small = reduce(full.body, full.frame, CraigBampton(6), derivatives=NoDerivatives())

    def at_rest(body):
        walls = tuple(Fixed(name=end, first=GROUND, second=At("plate", end)) for end in clamped)
        system = System((Placed(body),), walls, gravity=np.array([0.0, 0.0, -gravity]))
        return system, equilibrium(system).solution

    system, solution = at_rest(small)
    whole, fulls = WholeBody("plate"), {"plate": full}
    true = quantity_distance(whole, system, solution, *at_rest(FullBody(curved, full.frame)))
    stated = model_errors(system, fulls, stored_bases(system, fulls), solution, [whole])["plate"]
    assert stated.value == pytest.approx(true, rel=0.03)


@pytest.mark.parametrize("frame", [NodalFixedFrame("root"), MeanAxisFrame()], ids=["root", "mean axes"])
def test_positions_of_places_include_the_motion_of_the_frame(frame):
    """In mean axes the frame of a clamped, bent strip moves with the change; the clamp must not."""
    wall = HomogeneousSection(Isotropic(70e9, 0.3, 2700.0), 0.004)
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    body = flexible_body("strip", shell_model(strip(0.4, 0.1, 8, 2), wall), ends)
    full = FullBody(body, frame)
    small = reduce(body, frame, CraigBampton(6), derivatives=NoDerivatives())
    clamp = Fixed(name="clamp", first=GROUND, second=At("strip", "root"))
    system = System((Placed(small),), (clamp,), gravity=np.array([0.0, 0.0, -400.0]))
    solution = equilibrium(system).solution
    every = tuple(range(len(body.nodes)))
    asked = [
        WholeBody("strip"),
        PositionSensor("nodes", Place("strip", every)),
        PositionSensor("root", Place("strip", "root")),
        PositionSensor("tip", Place("strip", "tip")),
    ]
    found = model_errors(system, {"strip": full}, stored_bases(system, {"strip": full}), solution, asked)
    assert found["nodes"].value == pytest.approx(found["strip"].value, rel=1e-9)
    assert found["root"].value < 1e-6 * found["tip"].value
    assert found["tip"].value > 1.5 * found["strip"].value
