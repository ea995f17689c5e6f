"""How runs go: output times, records, progress, resumption, failure, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import RigidBody
from supple.errors import ConvergenceError, ModelError
from supple.integrate import AdaptiveStep, FixedStep, Run, Tolerances, concatenate
from supple.machine import GROUND, At, DeadForce, Placed, Revolute, System, Table
from supple.simulation import simulate
from supple.simulation.watched_run import check_laws_cover


@pytest.fixture(scope="module")
def pendulum(turned):
    """Released at 2 rad from hanging."""
    bob = RigidBody("bob", 2.0, [0, 0, 0], np.diag([0.15, 0.2, 0.25]), {"hinge": [0, 0, 0.8]})
    rotation = turned(0, 2.0)
    hinge = Revolute(first=GROUND, second=At("bob", "hinge"), axis=(1, 0, 0), name="hinge")
    placed = Placed(bob, position=-rotation @ [0, 0, 0.8], rotation=rotation)
    return System((placed,), (hinge,), gravity=(0, 0, -9.81))


def test_output_at_the_times_asked_for(pendulum):
    solution = simulate(pendulum, Run(duration=1.0, output_step=0.1, step=FixedStep(0.03)))
    np.testing.assert_allclose(solution.times, np.arange(11) * 0.1, rtol=1e-15)
    assert solution.statistics.steps == 40  # four steps of 0.025 to each output
    motion = solution.bodies["bob"]
    assert motion.rotation.shape == (11, 3, 3)
    assert motion.coordinates.shape == (11, 0)
    assert solution.multipliers["hinge"].shape == (11, 5)
    assert solution.joint_forces["hinge"].shape == (11, 6)


def test_steps_default_to_the_output_step(pendulum):
    assert simulate(pendulum, Run(duration=1.0, output_step=0.02)).statistics.steps == 50


def test_velocities_are_the_rates_of_positions(pendulum):
    """Central differences of the output, of second order in its step."""
    solution = simulate(pendulum, Run(duration=0.05, output_step=1e-3))
    motion, h = solution.bodies["bob"], 1e-3
    rate = (motion.position[2:] - motion.position[:-2]) / (2 * h)
    np.testing.assert_allclose(motion.velocity[1:-1], rate, atol=1e-5)
    change = (motion.rotation[2:] - motion.rotation[:-2]) / (2 * h)
    spin = np.einsum("tji,tjk->tik", motion.rotation[1:-1], change)
    np.testing.assert_allclose(motion.angular_velocity[1:-1, 0], spin[:, 2, 1], atol=1e-4)
    np.testing.assert_allclose(
        motion.acceleration[1:-1], (motion.velocity[2:] - motion.velocity[:-2]) / (2 * h), atol=2e-3
    )


def test_chunks_are_recorded_in_order_and_make_the_solution(pendulum):
    chunks = []
    solution = simulate(pendulum, Run(duration=5.0, output_step=0.05), record=chunks.append)
    assert len(chunks) == 9  # the initial state, and the fewest legs, for the steps take a moment
    np.testing.assert_array_equal(chunks[0].times, [0.0])
    joined = concatenate(chunks)
    np.testing.assert_array_equal(joined.times, solution.times)
    np.testing.assert_array_equal(joined.bodies["bob"].position, solution.bodies["bob"].position)
    assert joined.statistics == solution.statistics


@pytest.mark.slow
def test_last_chunk_may_be_shorter(pendulum):
    """101 outputs in chunks of three."""
    solution = simulate(pendulum, Run(duration=1.01, output_step=0.01))
    assert solution.times.size == 102
    longer = simulate(pendulum, Run(duration=5.0, output_step=0.05, step=FixedStep(0.01)))
    np.testing.assert_allclose(
        solution.bodies["bob"].position[100], longer.bodies["bob"].position[20], atol=1e-9
    )


def test_progress_rises_to_one(pendulum):
    seen = []
    simulate(pendulum, Run(duration=1.0, output_step=0.02), progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert len(seen) == 8


@pytest.mark.parametrize("step", [FixedStep(0.01), AdaptiveStep(first=1e-3, largest=0.05)])
def test_a_resumed_run_is_the_uninterrupted_one(pendulum, step):
    """Bit by bit: the engine's state is kept with the motion."""
    whole = simulate(pendulum, Run(duration=1.0, output_step=0.05, step=step))
    half = simulate(pendulum, Run(duration=0.5, output_step=0.05, step=step))
    rest = simulate(pendulum, Run(duration=1.0, output_step=0.05, step=step), resume=half)
    np.testing.assert_array_equal(rest.times, whole.times[11:])
    for name, array in rest.bodies["bob"].arrays().items():
        np.testing.assert_array_equal(array, whole.bodies["bob"].arrays()[name][11:])
    np.testing.assert_array_equal(rest.joint_forces["hinge"], whole.joint_forces["hinge"][11:])


@pytest.mark.slow
def test_a_run_can_be_resumed_from_its_motion_alone(pendulum):
    """The auxiliary acceleration starts anew, which costs an error of the integrator's own order."""

    def difference(h):
        whole = simulate(pendulum, Run(duration=1.0, output_step=0.05, step=FixedStep(h)))
        half = simulate(pendulum, Run(duration=0.5, output_step=0.05, step=FixedStep(h)))
        bare = replace(half, engine_state={})
        rest = simulate(pendulum, Run(duration=1.0, output_step=0.05, step=FixedStep(h)), resume=bare)
        np.testing.assert_allclose(rest.times, whole.times[11:])
        return np.abs(rest.bodies["bob"].position - whole.bodies["bob"].position[11:]).max()

    coarse, fine = difference(0.01), difference(0.005)
    assert coarse < 1e-4
    assert coarse / fine > 3.5  # order two or better


def test_nothing_left_to_resume(pendulum):
    done = simulate(pendulum, Run(duration=0.5, output_step=0.05))
    with pytest.raises(ValueError, match=r"nothing is left to simulate: the recorded part ends at t = 0.5"):
        simulate(pendulum, Run(duration=0.5, output_step=0.05), resume=done)


def test_another_system_cannot_be_resumed(pendulum):
    done = simulate(pendulum, Run(duration=0.5, output_step=0.05))
    renamed = replace(done, bodies={"weight": done.bodies["bob"]})
    with pytest.raises(ModelError, match="the recorded part has other bodies or joints than this system"):
        simulate(pendulum, Run(duration=1.0, output_step=0.05), resume=renamed)


def test_failure_names_time_and_residual_and_keeps_what_was_recorded(pendulum):
    """One iteration a step is enough at first, but not when the pendulum is fast."""
    recorded = []
    with pytest.raises(
        ConvergenceError,
        match=r"no convergence at t = 0\.\d+ with the smallest step allowed: relative residual "
        r"0\.0\d+ in the moments",
    ):
        simulate(
            pendulum,
            Run(
                duration=1.0,
                output_step=0.1,
                step=FixedStep(0.02, smallest=0.015),
                tolerances=Tolerances(residual=1e-4, max_iterations=1),
            ),
            record=recorded.append,
        )
    kept = concatenate(recorded)
    assert kept.times[-1] > 0.1
    whole = simulate(pendulum, Run(duration=1.0, output_step=0.1, step=FixedStep(0.02)))
    n = kept.times.size
    np.testing.assert_allclose(kept.bodies["bob"].position, whole.bodies["bob"].position[:n], atol=1e-4)


def test_adaptive_step_reports_no_cuts(pendulum):
    """Rejected steps are how it works; only a fixed step that had to be cut earns the warning."""
    solution = simulate(
        pendulum,
        Run(duration=1.0, output_step=0.1, step=AdaptiveStep(first=0.05, largest=0.1, tolerance=1e-6)),
    )
    assert solution.statistics.rejected_steps > 0


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
@pytest.mark.parametrize("name", ["duration", "output_step"])
def test_times_must_be_positive(pendulum, name, value):
    with pytest.raises(ValueError, match=f"{name} must be a positive, finite number, got"):
        simulate(pendulum, Run(**({"duration": 1.0, "output_step": 0.1} | {name: value})))


def test_duration_must_be_a_multiple_of_the_output_step(pendulum):
    with pytest.raises(
        ValueError,
        match=r"the duration \(1.0\) is not a multiple of the output step \(0.3\): "
        r"try an output step of 0.333333",
    ):
        simulate(pendulum, Run(duration=1.0, output_step=0.3))


def test_table_that_ends_before_the_run(pendulum):
    force = Table([0.0, 0.8], np.zeros((2, 3)))
    loaded = replace(pendulum, loads=(DeadForce(body="bob", at="hinge", force=force),))
    with pytest.raises(
        ModelError,
        match=r"DeadForce on 'hinge' of 'bob': its table ends at t = 0.8, before the run ends \(t = 1\)",
    ):
        simulate(loaded, Run(duration=1.0, output_step=0.1))


def test_table_that_begins_after_the_run(pendulum):
    loaded = replace(
        pendulum, loads=(DeadForce(body="bob", at="hinge", force=Table([0.2, 2.0], np.zeros((2, 3)))),)
    )
    with pytest.raises(ModelError, match=r"its table begins at t = 0.2, after the run begins \(t = 0\)"):
        simulate(loaded, Run(duration=1.0, output_step=0.1))


@pytest.mark.parametrize(("begin", "end"), [(0.1 + 0.2, 1.0), (-2.0, -1.0), (-0.7, -0.1 - 0.2)])
def test_a_table_may_begin_and_end_with_the_run_up_to_rounding(pendulum, begin, end):
    force = Table([begin, end], np.zeros((2, 3)))
    loaded = replace(pendulum, loads=(DeadForce(body="bob", at="hinge", force=force),))
    check_laws_cover(loaded, round(begin, 9), round(end, 9))
