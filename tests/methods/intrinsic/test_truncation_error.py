"""What all modes would make of a run of few: beside the run of all."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import ModalDamping, RigidBody
from supple.error import ErrorStudy, state_errors
from supple.errors import ModelError, ValidityError, ValidityWarning
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Validity
from supple.machine import (
    Bushing,
    ConstantRate,
    DeadForce,
    Fixed,
    FollowerTorque,
    Placed,
    PrescribedRotation,
    Revolute,
    System,
)
from supple.methods.intrinsic import (
    CLAMPED,
    FREE,
    clamped_line,
    enough_modes,
    intrinsic_body,
    released,
    truncation_error,
)
from supple.methods.intrinsic.complete_motion import with_modes
from supple.methods.intrinsic.expansion import expansion_of_stations
from supple.methods.intrinsic.intrinsic_body import body_of
from supple.methods.intrinsic.truncation_error import TruncationError, centre_drift
from supple.simulation import simulate, simulate_batch
from supple.simulation.description import inputs_of
from supple.simulation.recorded_run import simulate_recorded
from supple.storage import ResultFile

LINE = beam_line(straight(1.0, 8), EA=1e4, EI=1.0, GJ=1.0, mass_per_length=1.0, radius=0.05)
CLAMP = Fixed(first="ground", second="beam.root")
RUN = Run(1.2, 0.3, step=FixedStep(0.02), method=GeneralizedAlpha(0.8))


@pytest.fixture(scope="module")
def whole():
    return intrinsic_body(LINE, CLAMPED, damping=ModalDamping(0.5))


def lowest_alone(whole, n):
    """Without second-order modes."""
    modes = whole.modes.truncated(n + whole.modes.n_rigid)
    expansion = expansion_of_stations(LINE.tree, modes.velocities[..., modes.n_rigid :])
    return replace(whole, modes=modes, expansion=expansion, complete=whole)


def bent(body):
    """By a dead force at its tip, that sets in slowly."""
    return System([body], [CLAMP], [DeadForce(at="beam.tip", force=ConstantRate(np.array([0.0, 0.0, 5.0])))])


def stations(body, solution):
    return body.places(solution.bodies["beam"])[1]


def test_the_estimate_is_the_distance_from_the_run_of_all_modes(whole):
    """The lowest modes alone are off by an eighth of the deflection, and are warned of."""
    exact = stations(whole, simulate(bent(whole), RUN))
    plain = lowest_alone(whole, 8)
    with pytest.warns(
        ValidityWarning, match="8 modes are too few: with all modes its stations would move by"
    ):
        solution = simulate(bent(plain), RUN)
    found = truncation_error(bent(plain), solution)["beam"]
    true = np.sqrt(np.mean(np.sum((stations(plain, solution) - exact) ** 2, axis=2), axis=1))
    assert found.largest > 0.05
    assert found.places[-1] == pytest.approx(true[-1], rel=0.25)


@pytest.mark.slow
def test_few_modes_of_second_order_are_near_the_run_of_all_modes(whole):
    exact = stations(whole, simulate(bent(whole), RUN))
    few = whole.truncated(4)
    solution = simulate(bent(few), RUN)
    found = truncation_error(bent(few), solution)["beam"]
    true = np.sqrt(np.mean(np.sum((stations(few, solution) - exact) ** 2, axis=2), axis=1))
    assert found.largest < 0.01
    assert found.places[-1] == pytest.approx(true[-1], rel=0.5, abs=2e-4)
    with pytest.raises(ValidityError, match="8 modes are too few"):
        simulate(bent(lowest_alone(whole, 8)), replace(RUN, validity=Validity(strict=True)))
    stated = state_errors(bent(few), RUN, solution, ErrorStudy(integration=False, model=False)).errors["beam"]
    assert stated.basis.value == found.places.max()
    assert stated.basis.how == "omitted modes follow the motion statically, at a few instants"


def test_a_body_with_all_its_modes_leaves_nothing_out(whole):
    solution = simulate(bent(whole), Run(0.1, 0.1, step=FixedStep(0.05)))
    with pytest.raises(ModelError, match="give the same body with more modes"):
        truncation_error(bent(whole), solution)
    study = ErrorStudy(integration=False, model=False)
    assert state_errors(bent(whole), RUN, solution, study).errors["beam"].basis.value == 0


@pytest.mark.slow
def test_as_many_modes_are_taken_as_the_tolerance_asks_for(whole):
    found = enough_modes(bent(whole), lambda machine: simulate(machine, RUN), tolerance=1e-3, first=2)
    body = body_of(found.system.bodies[0])
    assert body.complete is not None
    assert found.errors["beam"].largest <= 1e-3
    exact = stations(whole, simulate(bent(whole), RUN))
    assert np.abs(stations(body, found.solution) - exact).max() < 5e-3
    with pytest.raises(ModelError, match="between 0 and 1"):
        enough_modes(bent(whole), lambda _: found.solution, tolerance=2.0)
    with pytest.raises(ModelError, match="starts at 1 or more"):
        enough_modes(bent(whole), lambda _: found.solution, tolerance=0.1, first=0)


def test_all_modes_are_kept_where_no_fewer_are_enough(whole):
    run = Run(0.1, 0.05, step=FixedStep(0.05))
    found = enough_modes(bent(whole), lambda machine: simulate(machine, run), tolerance=1e-12, first=24)
    assert body_of(found.system.bodies[0]) is whole
    assert found.errors == {}


def error_with(**changes):
    """Of a body of length 2 that does not deflect, unless it is given."""
    known = {"places": np.zeros(1), "drift": 0.0, "deflection": 0.0, "length": 2.0} | changes
    return TruncationError(np.zeros(1), forces=np.zeros(1), velocities=np.zeros(1), **known)


def test_round_off_is_no_truncation_error_and_a_failed_estimate_is_not_zero():
    """A body in free fall deflects by round-off; an estimate that fails is infinite at any deflection."""
    assert error_with(places=np.array([1e-17]), deflection=1e-17).largest < 1e-6
    assert error_with(places=np.array([1e-8]), deflection=1e-7).largest == pytest.approx(0.1)
    assert error_with(places=np.array([np.inf])).largest == np.inf


def test_a_search_for_modes_asks_for_a_root_with_mass():
    """A released body whose root has none cannot retain all its modes."""
    inner = slice(6, None)
    whole = clamped_line("beam", LINE.tree.points, LINE.stiffness[inner, inner], LINE.mass[inner, inner])
    few = released(intrinsic_body(whole, CLAMPED, 10))
    assert few.complete is None
    with pytest.raises(ModelError, match="needs a root with mass"):
        enough_modes(bent(few), lambda _: None, tolerance=1e-2)


@pytest.mark.slow
def test_the_load_of_a_damper_at_a_driven_body_is_no_drift():
    """A free body is carried by a damper whose other end a drive turns."""
    free = Placed(intrinsic_body(LINE, FREE), position=[1.0, 0, 0])
    arm = beam_line(straight(1.0, 2), name="arm", EA=1e4, EI=1.0, GJ=1.0, mass_per_length=1.0, radius=0.05)
    drive = PrescribedRotation(first="ground", second="arm.root", axis=(0, 0, 1), angle=ConstantRate(1.0))
    damper = Bushing(first="arm.tip", second="beam.root", stiffness=np.zeros(6), damping=[1.0] * 6)
    system = System(
        [free, Placed(intrinsic_body(arm, CLAMPED, damping=ModalDamping(0.5)))], [drive], [damper]
    )
    run = Run(0.5, 0.05, step=FixedStep(0.01), method=GeneralizedAlpha(0.9))
    solution = simulate(system, run)
    moved = np.abs(solution.bodies["beam"].position[-1] - [1.0, 0, 0]).max()
    assert moved > 0.02
    assert centre_drift(system, solution, "beam") < 0.05 * moved


@pytest.mark.slow
def test_the_drift_of_a_free_body_is_that_of_its_centre_of_mass():
    """A body that bends far while it turns about its centre, without loads: the centre should stay."""
    free = intrinsic_body(LINE, FREE)
    spin = np.array([0.3, 0.5, 2.0])
    drifts = []
    for body in (lowest_alone(free, 4), free.truncated(4)):
        rates = np.zeros(body.n_coordinates)
        rates[:2] = 4.0, 2.0
        placed = Placed(
            body, coordinate_rates=rates, angular_velocity=spin, velocity=-np.cross(spin, [0.5, 0, 0])
        )
        run = Run(1.0, 0.1, step=FixedStep(0.02), method=GeneralizedAlpha(0.9))
        with pytest.warns(ValidityWarning, match="modes are too few"):
            solution = simulate(System([placed]), run)
        masses = LINE.station_masses[:, 0, 0]
        centre = np.einsum("n,tni->ti", masses, stations(body, solution)) / masses.sum()
        found = truncation_error(System([placed]), solution)["beam"]
        assert found.drift == pytest.approx(np.linalg.norm(centre - centre[0], axis=1).max(), rel=0.2)
        drifts.append(found.drift)
    assert drifts[1] < 0.8 * drifts[0]


def line_on(name, make):
    line = beam_line(straight(1.0, 4), name=name, EA=1e4, EI=1.0, GJ=1.0, mass_per_length=1.0, radius=0.05)
    return released(make(intrinsic_body(line, CLAMPED, damping=ModalDamping(0.1))))


def on_a_hub(make):
    """A line on a rigid hub that a torque sets turning."""
    ends = {"axle": np.zeros(3), "flange": [0.2, 0, 0]}
    hub = RigidBody("hub", 2.0, np.zeros(3), 0.1 * np.eye(3), ends)
    joints = [
        Revolute(first="ground", second="hub.axle", axis=(0, 0, 1), name="hinge"),
        Fixed(first="hub.flange", second="blade.root", name="weld"),
    ]
    blade = Placed(line_on("blade", make), position=[0.2, 0, 0])
    return System([hub, blade], joints, [FollowerTorque(first="hub.axle", torque=(0, 0, 1.0))])


def two_on_hinges(make):
    """Two lines in a row that fall from the horizontal."""
    joints = [
        Revolute(first="ground", second="a.root", axis=(0, 1, 0), name="hinge"),
        Revolute(first="a.tip", second="b.root", axis=(0, 1, 0), name="elbow"),
    ]
    placed = [line_on("a", make), Placed(line_on("b", make), position=[1.0, 0, 0])]
    return System(placed, joints, gravity=np.array([0, 0, -9.81]))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.* modes are too few")
@pytest.mark.parametrize("machine", [on_a_hub, two_on_hinges])
def test_joined_lines_are_loaded_by_the_joint_forces_of_the_run(machine):
    """The change of shape, seen from the root, is that of the run with all modes of every line.

    The static responses at the ends are among the modes: most of the error is then the dynamic response of
    the omitted modes, which the estimate does not contain.
    """
    run = Run(0.6, 0.06, step=FixedStep(0.01), method=GeneralizedAlpha(0.8))
    exact = simulate(machine(lambda whole: whole), run)
    solution = simulate(machine(lambda whole: whole.truncated(2)), run)
    lines = [p for p in machine(lambda whole: whole.truncated(2)).bodies if p.body.kind == "intrinsic"]
    assert set(solution.truncation) == {placed.body.name for placed in lines}
    for placed in lines:
        body = body_of(placed)
        shapes = []
        for own, found in ((body, solution), (body.complete, exact)):
            rotations, positions = own.places(found.bodies[body.name])
            shapes.append(np.einsum("tij,tni->tnj", rotations[:, 0], positions - positions[:, :1]))
        true = np.sqrt(np.mean(np.sum((shapes[1] - shapes[0]) ** 2, axis=2), axis=1)).max()
        assert 0.3 < solution.truncation[body.name].value / true < 2.0
        assert true < 7e-3


def test_modes_of_a_released_body_are_those_on_its_support(whole):
    """Strains that few modes can show survive the way to all modes and back."""
    few = released(whole.truncated(4))
    coordinates = 0.01 * np.arange(1.0, few.n_coordinates + 1)
    in_all = with_modes(Placed(few, coordinates=coordinates, coordinate_rates=-coordinates), None)
    assert body_of(in_all).n_coordinates == whole.n_coordinates
    back = with_modes(in_all, 4)
    assert body_of(back).modes.omega == pytest.approx(few.modes.omega)
    assert back.coordinates == pytest.approx(coordinates, abs=1e-9)
    assert back.coordinate_rates == pytest.approx(-coordinates, abs=1e-9)


@pytest.mark.parametrize("kept", [pytest.param(False, marks=pytest.mark.slow), True])
def test_the_part_of_the_modes_is_computed_once_a_run(whole, monkeypatch, tmp_path, kept):
    """The error statement takes what the end of the run found, in memory or in a file."""
    few = whole.truncated(4)
    system = System([few], [CLAMP], [DeadForce(at="beam.tip", force=(0.0, 0.0, 1.0))])
    solution = simulate(system, RUN, file=tmp_path / "run.h5" if kept else None)
    monkeypatch.setattr(import_module("supple.methods.intrinsic.truncation_error"), "truncation_error", None)
    study = ErrorStudy(integration=False, model=False)
    stated = state_errors(system, RUN, solution, study).errors["beam"]
    assert stated.basis == solution.truncation["beam"]
    assert stated.basis.value > 0


def test_a_stored_or_continued_run_states_the_part_of_the_modes(whole, tmp_path):
    """That of the same run in memory."""
    system = System([whole.truncated(4)], [CLAMP], [DeadForce(at="beam.tip", force=(0.0, 0.0, 1.0))])
    path, legs = tmp_path / "run.h5", []
    expected = simulate(system, RUN, record=legs.append)
    with ResultFile.create(path, case="beam", inputs=inputs_of(system, RUN, "beam")) as file:
        for leg in legs[:3]:
            file.append(leg)
    for _ in ("continued", "read"):
        found = simulate_recorded(system, RUN, path, case="beam")
        assert found.truncation["beam"].value == pytest.approx(expected.truncation["beam"].value, rel=1e-9)
    with pytest.raises(ModelError, match=r"cannot continue from this solution: .* `at` omits that state"):
        simulate(system, RUN, resume=expected.at(slice(3)))


@pytest.mark.slow
def test_a_batch_warns_once_of_the_case_that_is_strained_most(whole):
    plain = lowest_alone(whole, 8)
    cases = [
        System([plain], [CLAMP], [DeadForce(at="beam.tip", force=(0.0, 0.0, force))])
        for force in (0.1, 6.0, 1.0)
    ]
    with pytest.warns(ValidityWarning) as warned:
        batch = simulate_batch(cases, RUN)
    (message,) = [str(each.message) for each in warned]
    assert message.startswith("case 1: body 'beam': 8 modes are too few")
    alone = truncation_error(cases[1], batch.solutions[1])["beam"]
    assert f"{alone.largest:.1%}" in message
    with pytest.raises(ValidityError, match="case 1: body 'beam'"):
        simulate_batch(cases, replace(RUN, validity=Validity(strict=True)))
