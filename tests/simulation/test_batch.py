"""Many load cases at once are the same cases one by one."""

from __future__ import annotations

import io
import pickle
import threading
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.algebra import available_memory
from supple.algebra.jax_settings import release_programs
from supple.body import FullBody, NodalFixedFrame, RigidBody
from supple.equations.build_model import build_model
from supple.equations.compiler_options import STARTING
from supple.errors import ConvergenceError, MemoryShortageError, ModelError, ValidityWarning
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    DeadTorque,
    FollowerForce,
    FollowerTorque,
    Placed,
    PrescribedRotation,
    Ramp,
    Revolute,
    Scaled,
    Sine,
    SpinUp,
    Spline,
    System,
    Table,
)
from supple.methods.floating.compiled import frozen_tangent
from supple.programs import worker_processes
from supple.programs.program_cache import CachedProgram
from supple.programs.program_worker import answer_questions
from supple.simulation import case_worker, shares_of_cases, simulate, simulate_batch
from supple.simulation.case_worker import CaseWork


def pendulum(turned, angle=2.0, gravity=9.81, rows=2):
    """Released from an angle, with a side force from a table."""
    bob = RigidBody("bob", 2.0, [0, 0, 0], np.diag([0.15, 0.2, 0.25]), {"hinge": [0, 0, 0.8]})
    rotation = turned(0, angle)
    hinge = Revolute(first=GROUND, second=At("bob", "hinge"), axis=(1, 0, 0), name="hinge")
    force = np.outer(np.linspace(0, angle, rows), [0.0, 1.0, 0.0])
    load = DeadForce(body="bob", at="hinge", force=Table(np.linspace(0, 1, rows), force))
    placed = Placed(bob, position=-rotation @ [0, 0, 0.8], rotation=rotation)
    return System((placed,), (hinge,), (load,), gravity=(0, 0, -gravity))


@pytest.fixture(scope="module")
def cases(turned):
    return [pendulum(turned, angle, gravity) for angle, gravity in ((2.0, 9.81), (1.0, 9.81), (0.5, 1.62))]


RUN = Run(1.0, 0.1, step=FixedStep(0.02))


@pytest.mark.slow
def test_batch_is_the_same_as_one_by_one(cases):
    together = simulate_batch(cases, RUN).check()
    for system, own in zip(cases, together.solutions, strict=True):
        alone = simulate(system, RUN)
        np.testing.assert_array_equal(own.times, alone.times)
        np.testing.assert_allclose(own.bodies["bob"].position, alone.bodies["bob"].position, atol=1e-12)
        np.testing.assert_allclose(own.joint_forces["hinge"], alone.joint_forces["hinge"], atol=1e-8)
        assert own.statistics.steps == alone.statistics.steps == 50


def test_cases_may_go_in_chunks(cases):
    seen = []
    together = simulate_batch([*cases, *reversed(cases)], RUN, chunk=3, progress=seen.append)
    assert seen == [0.5, 1.0]
    for own, other in zip(together.solutions, reversed(together.solutions), strict=True):
        np.testing.assert_allclose(own.bodies["bob"].position, other.bodies["bob"].position, atol=1e-12)


def test_failing_case_does_not_stop_the_others(cases):
    """Too few iterations for wide swings, enough for the smallest."""
    hasty = replace(
        RUN, step=FixedStep(0.02, smallest=0.015), tolerances=Tolerances(residual=1e-4, max_iterations=1)
    )
    together = simulate_batch(cases, hasty)
    assert list(together.failures) == [0, 1]
    assert together.solutions[0].times[-1] < 1.0
    assert together.solutions[2].times[-1] == 1.0
    with pytest.raises(
        ConvergenceError, match=r"2 of 3 cases failed \(0, 1\); case 0: no convergence at t = 0"
    ):
        together.check()


def test_joint_forces_of_cases_found_together_are_those_of_each_alone(cases):
    """Of cases that share bodies and joints, one of which ends early; one has a joint of another name."""
    (hinge,) = cases[2].joints
    systems = [replace(cases[2], gravity=(0.0, 0.0, -g)) for g in (1.62, 100.0, 1.2)]
    systems.append(replace(systems[2], joints=(replace(hinge, name="pivot"),)))
    hasty = replace(RUN, step=FixedStep(0.02, smallest=0.015), tolerances=Tolerances(1e-4, max_iterations=1))
    together = simulate_batch(systems, hasty)
    assert list(together.failures) == [1]
    for system, own in zip(systems, together.solutions, strict=True):
        (name,) = own.joint_forces
        assert name == system.joints[0].name
        if len(own.times) == len(RUN.times):
            alone = simulate(system, hasty)
            np.testing.assert_allclose(own.joint_forces[name], alone.joint_forces[name], atol=1e-8)
            np.testing.assert_allclose(
                own.engine_state["auxiliary"], alone.engine_state["auxiliary"], atol=1e-8
            )


def test_a_batch_needs_a_case():
    with pytest.raises(ModelError, match="a batch needs at least one case"):
        simulate_batch([], Run(duration=1.0, output_step=0.1))


def swinging(body, rate):
    hinge = Revolute(first="ground", second="blade.root", axis=(0, 1, 0), name="hinge")
    return System((Placed(body, angular_velocity=[0, rate, 0]),), (hinge,))


@pytest.mark.slow
@pytest.mark.parametrize("processes", [0, 1])
def test_full_bodies_go_one_after_another(blade, monkeypatch, processes):
    """Each in the bits of its own run, also where another process shares the work."""
    monkeypatch.setattr(worker_processes, "_number_worth", lambda *_: processes)
    body = FullBody(blade, NodalFixedFrame("root"))
    cases = [swinging(body, rate) for rate in (0.1, 0.2, 0.3)]
    run = Run(duration=0.01, output_step=0.005)
    done = []
    batch = simulate_batch(cases, run, progress=done.append).check()
    assert done == pytest.approx([1 / 3, 2 / 3, 1.0])
    alone = simulate(cases[2], run)
    own = batch.solutions[2]
    assert np.array_equal(own.bodies["blade"].coordinates, alone.bodies["blade"].coordinates)
    assert np.array_equal(own.joint_forces["hinge"], alone.joint_forces["hinge"])
    assert own.bodies["blade"].angular_velocity[0, 1] == pytest.approx(0.3)


@pytest.mark.slow
def test_another_process_answers_with_the_same_bits_and_what_it_warns_of(blade):
    run = Run(duration=0.01, output_step=0.005)
    case = swinging(FullBody(blade, NodalFixedFrame("root")), 3.0)
    work, answers = CaseWork(run), io.BytesIO()
    sent = [work.greeting(), work.question((case,))]
    answer_questions(io.BytesIO(b"".join(map(pickle.dumps, sent))), answers, case_worker.marcher_of)
    answers.seek(0)
    assert pickle.load(answers) == "ready"
    seconds, (parts, warned) = pickle.load(answers)
    assert seconds > 0
    own, alone = work.result((parts, warned)), simulate(case, run)
    assert np.array_equal(own.bodies["blade"].coordinates, alone.bodies["blade"].coordinates)
    with pytest.warns(ValidityWarning, match="too far"):
        work.result((parts, [ValidityWarning("too far")]))


def test_chunks_hold_a_case(cases):
    with pytest.raises(ValueError, match="chunk must be at least 1, got 0"):
        simulate_batch(cases, RUN, chunk=0)


def test_cases_differ_in_numbers_only(cases):
    with pytest.raises(ModelError, match="the cases of a batch must differ in numbers only"):
        simulate_batch([cases[0], replace(cases[0], loads=())], RUN)


def test_tables_have_one_size(cases, turned):
    with pytest.raises(
        ModelError, match="the cases of a batch must have tables and bodies of the same sizes"
    ):
        simulate_batch([cases[0], pendulum(turned, rows=3)], RUN)


def driven(amplitude, frequency, height, speed, last):
    """A bob turned by a spin-up, with a law of every other kind acting on it."""
    bob = RigidBody("bob", 2.0, [0, 0, 0], np.diag([0.15, 0.2, 0.25]), {"hinge": [0, 0, 0.8]})
    hinge = At("bob", "hinge")
    rows = np.outer([0.0, 1.0, last], [0.0, 1.0, 0.0])
    drive = PrescribedRotation(
        first=GROUND, second=hinge, axis=(1, 0, 0), angle=SpinUp(speed, 0.7), name="drive"
    )
    loads = (
        DeadForce(body="bob", at="hinge", force=Table([0.0, 0.4, 1.0], rows)),
        FollowerForce(first=hinge, force=Scaled([0.0, 0.0, 1.0], Sine(amplitude, frequency))),
        FollowerTorque(first=hinge, torque=Ramp([height, 0.0, 0.0], 0.5)),
        DeadTorque(first=hinge, torque=Scaled([0.0, 1.0, 0.0], Spline([0.0, 0.5, 1.0], [0.0, last, 1.0]))),
    )
    return System((Placed(bob, position=[0, 0, -0.8]),), (drive,), loads)


@pytest.fixture
def traced(monkeypatch):
    """Marches that were traced: a Python function runs only while JAX makes a new program of it."""
    seen = []

    def counted(*arguments):
        seen.append(arguments)
        return shares_of_cases._march_of_cases(*arguments)

    # Of a function from elsewhere no program is kept between processes.
    monkeypatch.setattr(shares_of_cases, "_MAPPED_MARCH", CachedProgram(counted, STARTING))
    release_programs()  # now, not between two of the batches
    return seen


@pytest.mark.slow
def test_cases_that_differ_in_the_numbers_of_their_laws_compile_once(traced):
    first = [driven(1.0, 2.0, 3.0, 4.0, 5.0), driven(-2.0, 1.0, 0.5, 3.0, 2.0)]
    second = [driven(7.0, 0.3, 1.0, 2.0, -5.0), driven(1.5, 2.5, -1.0, 6.0, 0.0)]
    simulate_batch(first, RUN)
    assert len(traced) == 1
    for system, own in zip(second, simulate_batch(second, RUN).solutions, strict=True):
        alone = simulate(system, RUN)
        np.testing.assert_allclose(own.joint_forces["drive"], alone.joint_forces["drive"], atol=1e-8)
        np.testing.assert_allclose(own.bodies["bob"].position, alone.bodies["bob"].position, atol=1e-12)
    assert len(traced) == 1
    simulate_batch([replace(system, loads=system.loads[:2]) for system in first], RUN)
    assert len(traced) == 2, "another machine is another program, and this test sees it"


@pytest.mark.slow
def test_a_last_chunk_of_fewer_cases_and_another_duration_share_the_program(traced):
    """A single case is left over: what differs between the others is stacked of it, too."""
    cases = [driven(1.0 + i, 2.0, 3.0 - i, 4.0, 5.0) for i in range(3)]
    found = simulate_batch(cases, RUN, chunk=2).check()
    assert len(found.solutions) == 3
    shorter = simulate_batch(cases, replace(RUN, duration=0.9 * RUN.duration), chunk=2).check()
    assert len(traced) == 1
    for run, solutions in ((RUN, found), (replace(RUN, duration=0.9 * RUN.duration), shorter)):
        alone = simulate(cases[2], run)
        assert len(solutions.solutions[2].times) == len(alone.times)
        own = solutions.solutions[2].bodies["bob"].position
        np.testing.assert_allclose(own, alone.bodies["bob"].position, atol=1e-12)


@pytest.mark.slow
def test_functions_of_time_differ_in_more_than_numbers():
    swings = [
        FollowerTorque(first=At("bob", "hinge"), torque=lambda t, size=size: size * jnp.array([t, 0.0, 0.0]))
        for size in (1.0, 2.0)
    ]
    system = driven(1.0, 2.0, 3.0, 4.0, 5.0)
    with pytest.raises(ModelError, match="the same function objects for quantities over time"):
        simulate_batch([replace(system, loads=(load,)) for load in swings], RUN)


def pushed(body, force):
    """A reduced blade on a turning hub, its tip pushed by a table of its own."""
    hub = PrescribedRotation(
        first=GROUND, second=At("blade", "root"), axis=(0, 0, 1), angle=SpinUp(0.5, 0.2), name="hub"
    )
    load = DeadForce(body="blade", at="tip", force=Table([0.0, 0.1, 0.2], np.outer([1.0, 2.0, 0.0], force)))
    return System((Placed(body),), (hub,), (load,), gravity=(0, 0, -9.81))


@pytest.fixture
def pushes(clamped_blade):
    directions = np.random.default_rng(3).standard_normal((5, 3))
    return [pushed(clamped_blade, 0.2 * direction) for direction in directions]


FLEXIBLE_RUN = Run(0.1, 0.02, step=FixedStep(0.005))


@pytest.mark.slow
def test_flexible_cases_that_differ_in_loads_start_and_go_on_as_alone(pushes):
    """Their starts are mapped: they have accelerations and hub forces of their own from the first instant."""
    together = simulate_batch(pushes, FLEXIBLE_RUN, chunk=2).check()
    for system, own in zip(pushes, together.solutions, strict=True):
        alone = simulate(system, FLEXIBLE_RUN)
        for name in ("coordinates", "coordinate_rates", "coordinate_accelerations"):
            mine, expected = getattr(own.bodies["blade"], name), getattr(alone.bodies["blade"], name)
            np.testing.assert_allclose(mine, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
        wrench = alone.joint_forces["hub"]
        np.testing.assert_allclose(own.joint_forces["hub"], wrench, rtol=0, atol=1e-9 * np.abs(wrench).max())
        assert own.statistics.iterations == alone.statistics.iterations


@pytest.mark.slow
def test_cases_that_take_turns_carry_no_tables(turned):
    """A case whose turn it is copies its numbers: with the wind of 100 s among them a batch crawled."""
    models = [build_model(pendulum(turned, rows=rows), ()) for rows in (3, 3000)]
    held = [model.loads_at(0.3) for model in models]
    sizes = [sum(np.size(leaf) for leaf in jax.tree.leaves(model)) for model in held]
    assert sizes[0] == sizes[1] < 500
    for model, still in zip(models, held, strict=True):
        for load, same in zip(model.nodal_loads, still.nodal_loads, strict=True):
            np.testing.assert_array_equal(same.load.law(0.7), load.load.law(0.3))


def test_a_chunk_that_would_not_fit_in_memory_is_refused(pushes, monkeypatch):
    monkeypatch.setattr(available_memory, "available_memory", lambda: 100_000)
    with pytest.raises(MemoryShortageError, match=r"a chunk of 5 cases with 6 output times .*`chunk`"):
        simulate_batch(pushes, FLEXIBLE_RUN)


@pytest.mark.slow
@pytest.mark.parametrize("fewest", [1, 1000], ids=["each by itself", "mapped"])
def test_cases_of_another_core_are_the_same_to_the_last_digit(pushes, fewest, monkeypatch):
    """By the number of coordinates from which tangents are kept; what is left after the first share waits for
    the other process."""
    monkeypatch.setattr(frozen_tangent, "_FEWEST", fewest)
    here = simulate_batch(pushes, FLEXIBLE_RUN, chunk=2).check()
    other_has_begun = threading.Event()
    next_of = worker_processes._next

    def in_turn(waiting):
        if threading.current_thread() is not threading.main_thread():
            other_has_begun.set()
        elif len(waiting) < len(range(0, len(pushes), 1 if fewest == 1 else 2)):
            assert other_has_begun.wait(120)
        return next_of(waiting)

    monkeypatch.setattr(worker_processes, "_next", in_turn)
    monkeypatch.setattr(worker_processes, "available_cores", lambda: 2)
    monkeypatch.setattr(worker_processes, "_WORTH", 1e-9)
    together = simulate_batch(pushes, FLEXIBLE_RUN, chunk=2).check()
    assert other_has_begun.is_set()
    for own, other in zip(here.solutions, together.solutions, strict=True):
        for name in ("coordinates", "coordinate_rates", "position"):
            mine, expected = getattr(own.bodies["blade"], name), getattr(other.bodies["blade"], name)
            np.testing.assert_array_equal(mine, expected)
        assert own.statistics.factorizations == other.statistics.factorizations
