"""An error asked for is that of the sum: steps are cut and tolerances tightened, or the model is named."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from supple.body import (
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RayleighDamping,
    RigidInterface,
    flexible_body,
)
from supple.error import (
    ErrorStudy,
    ReductionStart,
    SelfCorrection,
    SelfCorrectionError,
    self_correct,
    state_errors,
)
from supple.error.integration_error import TIGHTEST, with_shorter_steps, with_tolerance
from supple.error.model_error import model_errors_by_limit
from supple.error.round_archive import InMemoryArchive
from supple.error.system_correction import Problem
from supple.error.whole_correction import _announce_steps, _needed
from supple.errors import LockingWarning, StepCutWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import ErrorPart, ErrorStatement, FixedStep, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    Controller,
    DeadForce,
    Fixed,
    JointReading,
    Placed,
    Ramp,
    Revolute,
    System,
    TorqueBetween,
)
from supple.mesh import strip
from supple.quantities import JointForceSensor, PositionSensor, StressSensor, WholeBody
from supple.quantities.quantity_of_interest import quantity_distance
from supple.reduction import (
    CompressedDerivatives,
    CondensedQuartic,
    CraigBampton,
    NoDerivatives,
    NoLoads,
    NormalModes,
    PlainQuartic,
    project,
    reduce,
    reduction_basis,
)
from supple.simulation import simulate

DAMPING = RayleighDamping(alpha=0.5, beta=1e-3)
WALL = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
MODEL = shell_model(strip(1.0, 0.1, 4, 2), WALL)
MIDDLE = np.flatnonzero(MODEL.mesh.nodes[:, 0] == 0.5)
STRESS = StressSensor("stress at middle", "beam", MODEL, MIDDLE)
TIP, FORCE = PositionSensor("beam.tip", "beam.tip"), JointForceSensor("force of wall", "wall")
STUDY = ErrorStudy(quantities=(TIP, FORCE, STRESS))


@pytest.fixture(scope="module")
def beam():
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    return flexible_body("beam", MODEL, ends)


def pushed(body, size=2.0, rise=0.3):
    wall = Fixed(name="wall", first=GROUND, second=At("beam", "root"))
    force = DeadForce(body="beam", at="tip", force=Ramp(np.array([0.0, 0.0, size]), rise))
    return System((Placed(body),), (wall,), loads=(force,))


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(PlainQuartic(), id="plain"),
        pytest.param(CondensedQuartic(), id="condensed", marks=pytest.mark.slow),
    ],
)
def plain(beam, request):
    """A body of a fixed size, its run with a long step, and what is said of it.

    The tolerance is so tight that the error of the joint's force is the basis's, not Newton's.
    """
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        small = reduce(
            beam,
            full.frame,
            CraigBampton(n_modes=4),
            derivatives=CompressedDerivatives(10),
            damping=DAMPING,
            quartic=request.param,
            loads=NoLoads,
        )
    system = pushed(small, 0.5)
    run = Run(0.6, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-9))
    solution = simulate(system, run)
    return full, system, run, state_errors(system, run, solution, STUDY, fulls=[full])


@pytest.mark.slow
def test_every_part_of_a_plain_run_is_the_truth(plain):
    """Basis against the full run with the same steps, step against a sixteenth of it, in four quantities."""
    full, system, run, solution = plain
    whole = pushed(full, 0.5)
    same, fine = simulate(whole, run), simulate(system, with_shorter_steps(run, 1 / 16))
    assert set(solution.errors) == {"beam", "beam.tip", "force of wall", "stress at middle"}
    for quantity in (WholeBody("beam"), *STUDY.quantities):
        stated = solution.errors[quantity.name]
        basis = quantity_distance(quantity, system, solution, whole, same)
        step = quantity_distance(quantity, system, solution, system, fine)
        assert 0.7 < stated.basis.value / basis < 1.4
        assert 0.7 < stated.step.value / step < 1.4
    assert solution.bodies["beam"].error is solution.errors["beam"]


@pytest.mark.slow
def test_the_sum_of_a_plain_run_holds_against_a_full_run_with_an_eighth_of_the_step(plain):
    full, system, run, solution = plain
    whole = pushed(full, 0.5)
    exact = simulate(whole, with_shorter_steps(with_tolerance(run, 1e-9), 1 / 8))
    true = quantity_distance(WholeBody("beam"), system, solution, whole, exact)
    stated = solution.errors["beam"]
    assert 0.5 < (stated.total - stated.model.value) / true < 2.0


@pytest.mark.slow
def test_an_accuracy_is_that_of_the_sum(beam):
    """The step of 20 ms costs ten times what is allowed: it is cut, and the truth keeps to the limit."""
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    run = Run(0.6, 0.02, step=FixedStep(0.02))
    corrected = self_correct(pushed(full), run, SelfCorrection(relative=2e-3), study=ErrorStudy())
    stated = corrected.solution.errors["beam"]
    assert corrected.run.step_control.size < 0.02
    assert stated.total <= stated.allowed
    exact = simulate(pushed(full), with_shorter_steps(with_tolerance(corrected.run, 1e-8), 1 / 8))
    true = quantity_distance(WholeBody("beam"), corrected.system, corrected.solution, pushed(full), exact)
    assert true <= 1.1 * stated.allowed
    rounds = corrected.bodies["beam"].rounds
    assert rounds[-1].solution is corrected.solution
    assert len({each.number for each in rounds}) == len(rounds)


@pytest.mark.slow
def test_an_accuracy_of_a_quantity(beam):
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    run = Run(0.6, 0.02, step=FixedStep(0.01))
    target = SelfCorrection(relative=0.02, of=FORCE)
    corrected = self_correct(pushed(full), run, target, study=ErrorStudy())
    stated = corrected.solution.errors["force of wall"]
    assert stated.total <= stated.allowed == pytest.approx(0.02 * stated.size)
    beside = corrected.solution.errors["beam"]
    assert beside.allowed is None
    assert beside.total == beside.at_least


@pytest.mark.slow
def test_a_body_that_corrects_itself_states_the_basis_part_of_every_quantity(beam):
    """Against the full run with the same steps; parts that nobody looked at leave no total."""
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    run = Run(0.4, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-9))
    start = ReductionStart(SelfCorrection(relative=0.05), CraigBampton(1), CompressedDerivatives(2))
    study = ErrorStudy(integration=False, model=False, quantities=STUDY.quantities)
    corrected = self_correct(pushed(full, 3.0), run, start, study=study)
    reference = simulate(pushed(full, 3.0), run)
    for quantity in (WholeBody("beam"), *STUDY.quantities):
        stated = corrected.solution.errors[quantity.name]
        true = quantity_distance(quantity, corrected.system, corrected.solution, pushed(full, 3.0), reference)
        assert 0.7 < stated.basis.value / true < 1.4
        assert stated.missing == ("step", "model")
        assert stated.total is None
        assert stated.at_least == stated.basis.value + stated.newton.value


@pytest.mark.slow
def test_an_accuracy_of_a_stress_is_met_and_true(beam):
    """A strip bent by 0.4 rad: without the quadratic strain of the corrected motion, none is ever met."""
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    run = Run(0.6, 0.02, step=FixedStep(0.02), tolerances=Tolerances(1e-9))
    corrected = self_correct(pushed(full, 4.0), run, SelfCorrection(relative=0.01, of=STRESS))
    last = corrected.bodies["beam"].rounds[-1]
    true = quantity_distance(
        STRESS, corrected.system, corrected.solution, pushed(full, 4.0), simulate(pushed(full, 4.0), run)
    )
    assert last.estimated_error <= last.allowed
    assert 0.7 < last.estimated_error / true < 1.4


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")
def test_kinematics_that_exceed_the_target_end_the_first_round(beam):
    """No motion outside the basis is computed for a target that no basis can meet."""
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    announced = []
    with pytest.raises(SelfCorrectionError, match="error of its kinematics alone") as raised:
        self_correct(
            pushed(full, 8.0),
            Run(0.3, 0.02, step=FixedStep(0.01)),
            SelfCorrection(relative=1e-5),
            study=ErrorStudy(),
            announce=announced.append,
        )
    assert raised.value.rounds == ()
    assert not announced


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # which is what it is about
def test_a_model_that_costs_more_than_is_allowed_is_named(beam):
    """Bent to where its elements turn by a radian, a strip seen from its root is off by 1e-3."""
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    start = ReductionStart(
        SelfCorrection(relative=3e-4, directions=5, max_rounds=10), CraigBampton(5), CompressedDerivatives(5)
    )
    run = Run(0.8, 0.02, step=FixedStep(0.01))
    with pytest.raises(SelfCorrectionError, match="error of its kinematics alone"):
        self_correct(pushed(full, 15.0, 0.6), run, start, study=ErrorStudy())


def needed(**values):
    parts = {name: ErrorPart(value, "") for name, value in values.items()}
    return _needed(ErrorStatement("", 1.0, allowed=1.0, **parts))


def test_the_cheapest_part_is_mended_first_and_alone_where_that_suffices():
    tolerance = needed(basis=0.3, step=0.3, newton=0.6, model=0.0)
    assert tolerance.tolerance < 1
    assert tolerance.step == 1.0
    assert tolerance.basis is None
    step = needed(basis=0.3, step=4.0, newton=0.01, model=0.0)
    assert step.tolerance == pytest.approx(1.0)
    assert step.step == pytest.approx(np.sqrt(0.49 / 4.0))
    assert step.basis is None
    both = needed(basis=0.9, step=0.9, newton=0.01, model=0.0)
    assert both.step < 1
    assert 1 - both.basis < 0.9


@pytest.mark.parametrize("model", [0.0, 0.2, 0.5, 0.79])
@pytest.mark.parametrize(
    ("basis", "step", "newton"), [(0.5, 0.49, 0.1), (0.4, 0.6, 0.01), (0.9, 0.01, 0.01), (0.05, 0.2, 2.0)]
)
def test_what_a_pass_mends_would_keep_to_what_is_allowed(model, basis, step, newton):
    """Whatever the model leaves of it: basis as asked for, the step by its square, the tolerance as it is."""
    mended = needed(basis=basis, step=step, newton=newton, model=model)
    after = (
        (basis if mended.basis is None else 1.0 - mended.basis)
        + mended.step**2 * step
        + mended.tolerance * newton
    )
    if basis + step + newton + model > 1.0:
        assert after + model <= 1.0


def test_a_pass_is_not_made_twice(beam, monkeypatch):
    """What the tightest tolerance leaves cannot be less: it is said after one pass."""
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    run = Run(0.04, 0.02, step=FixedStep(0.02), tolerances=Tolerances(TIGHTEST))
    passes = []

    def told(_problem, corrected, _study):
        passes.append(corrected)
        parts = {"basis": 0.0, "newton": 2.0}
        return {
            "beam": ErrorStatement("", 1.0, allowed=1.0, **{k: ErrorPart(v, "") for k, v in parts.items()})
        }

    monkeypatch.setattr("supple.error.whole_correction._stated", told)
    start = ReductionStart(SelfCorrection(absolute=1.0), CraigBampton(1), NoDerivatives())
    with pytest.raises(SelfCorrectionError, match="in 1 passes"):
        self_correct(pushed(full, 0.1), run, start, study=ErrorStudy())
    assert len(passes) == 1


def test_many_more_steps_are_announced_before_they_are_taken(beam):
    """In words of the progress whenever steps change, and by a warning from ten times those asked for."""
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    system, run = pushed(full), Run(0.6, 0.02, step=FixedStep(0.02))
    words = []
    problem = Problem(
        system, {"beam": full}, {}, run, None, lambda step, _: words.append(step), InMemoryArchive()
    )
    eight, eleven = (replace(problem, run=with_shorter_steps(run, 1 / n)) for n in (8, 11))
    _announce_steps(run, problem, eight)
    assert words == ["the error of the time step is too large: 240 steps of at most 0.0025 instead of 30"]
    with pytest.warns(StepCutWarning, match="needs 330 steps .* instead of 30"):
        _announce_steps(run, eight, eleven)
    _announce_steps(run, eleven, eleven)
    assert len(words) == 2


def test_a_part_that_is_unknown_is_mended_as_far_as_goes_at_once():
    assert needed(basis=0.1, step=np.inf, newton=0.01, model=0.0).step == 1 / 8


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")
def test_the_model_costs_what_the_mean_axes_save(beam):
    """Full runs in both frames differ by what the kinematics cost in the worse one, that of the root.

    Damped by the strain rate alone: a drag on the motion in the frame is another one in another frame.
    """
    run = Run(1.0, 0.02, step=FixedStep(0.02))
    frames = {"root": NodalFixedFrame("root"), "mean": MeanAxisFrame()}
    damping = RayleighDamping(alpha=0.0, beta=1e-3)
    fulls = {name: FullBody(beam, frame, damping) for name, frame in frames.items()}
    motions = {name: simulate(pushed(full, 6.0, 0.8), run) for name, full in fulls.items()}
    true = quantity_distance(
        WholeBody("beam"),
        pushed(fulls["root"], 6.0),
        motions["root"],
        pushed(fulls["mean"], 6.0),
        motions["mean"],
    )
    start = ReductionStart(
        SelfCorrection(absolute=true / 30, directions=5, max_rounds=12),
        CraigBampton(5),
        CompressedDerivatives(5),
    )
    parts = {}
    for name, full in fulls.items():
        corrected = self_correct(pushed(full, 6.0, 0.8), run, start)
        told = state_errors(
            corrected.system,
            run,
            corrected.solution,
            ErrorStudy(basis=False, integration=False),
            fulls=[full],
        )
        parts[name] = told.errors["beam"].model.value
    assert 0.6 < parts["root"] / true < 1.6
    assert parts["mean"] < 0.2 * parts["root"]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.SuppleWarning")
def test_the_model_costs_the_same_in_a_basis_that_locks(beam):
    """The kinematics are those of the elements: how well a basis follows them is another part.

    Few columns with plain tensors cannot relax what bending stretches. Tangents at that run would answer the
    same forces with more than twice the motion.
    """
    run = Run(0.9, 0.02, step=FixedStep(0.02))
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    study = ErrorStudy(basis=False, integration=False)
    parts = []
    for modes, derivatives in ((5, 25), (3, 4)):
        body = reduce(
            beam,
            full.frame,
            CraigBampton(modes),
            derivatives=CompressedDerivatives(derivatives),
            damping=DAMPING,
            quartic=PlainQuartic(),
            loads=NoLoads,
        )
        system = pushed(body, 4.0, 0.8)
        told = state_errors(system, run, simulate(system, run), study, fulls=[full])
        parts.append(told.errors["beam"].model.value)
    assert parts[1] == pytest.approx(parts[0], rel=0.1)


@pytest.mark.slow
def test_beside_controllers_the_basis_is_compared_with_a_richer_one(beam):
    """Controllers have no part in equations at an instant: the model is told by its limit."""
    full = FullBody(beam, NodalFixedFrame("root"), DAMPING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        body = reduce(
            beam, full.frame, NormalModes(1), derivatives=NoDerivatives(), damping=DAMPING, loads=NoLoads
        )
    hinge = Revolute(name="hinge", first=GROUND, second=At("beam", "root"), axis=(0, 1, 0))
    motor = TorqueBetween(first=GROUND, second=At("beam", "root"), axis=(0, 1, 0), torque=0.0)
    controller = Controller(
        reads={"hinge": JointReading("hinge")},
        drives={"motor": motor},
        outputs=lambda time, reads, _states: {"motor": 4 * time * (0.2 - reads["hinge"].angle)},
    )
    system = System((Placed(body),), (hinge,), controllers=[controller])
    run = Run(0.2, 0.01, step=FixedStep(0.005))
    solution = simulate(system, run)
    told = state_errors(system, run, solution, ErrorStudy(integration=False), fulls=[full]).errors["beam"]
    assert told.model.value == model_errors_by_limit(system, solution)["beam"]
    basis = reduction_basis(beam, full.frame, CraigBampton(4), derivatives=CompressedDerivatives(6))
    fine = replace(system, bodies=(Placed(project(beam, basis, damping=DAMPING)),))
    true = quantity_distance(WholeBody("beam"), system, solution, fine, simulate(fine, run))
    assert 0.7 < told.basis.value / true < 1.4
