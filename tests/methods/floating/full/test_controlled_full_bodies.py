"""Controllers beside full bodies: against complete bases, which have the same motions."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg

from supple import machine as m
from supple.body import FullBody, MeanAxisFrame, RigidInterface, flexible_body
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.linearization import linearize, machine_modes
from supple.mesh import strip
from supple.methods.floating import FullEngine
from supple.reduction import CraigBampton, NoLoads, reduce
from supple.simulation import equilibrium, simulate

AXIS = (0, 1, 0)
GOAL = -0.02
RUN = Run(
    duration=0.02,
    output_step=0.01,
    step=FixedStep(5e-4),
    method=GeneralizedAlpha(0.8),
    tolerances=Tolerances(residual=1e-11),
)


@pytest.fixture(scope="module")
def body():
    model = shell_model(strip(1.0, 0.1, 2, 2), HomogeneousSection(Isotropic(2.1e11, 0.3, 7850.0), 5e-3))
    return flexible_body("strip", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


def rates(_t, reads, z):
    """The integral of the error, and the tip's speed through a filter."""
    return jnp.stack([GOAL - reads["hinge"].angle, (reads["tip"].velocity[2] - z[1]) / 0.02])


def outputs(_t, reads, z):
    hinge = reads["hinge"]
    return {
        "motor": 6 * (GOAL - hinge.angle) - 0.6 * hinge.rate + 20 * z[0],
        "brake": -3 * z[1],
    }


CONTROLLER = m.Controller(
    reads={"hinge": m.JointReading("hinge"), "tip": m.EndReading("strip.tip")},
    drives={
        "motor": m.TorqueBetween(first="ground", second="strip.root", axis=AXIS),
        "brake": m.ForceBetween(first="ground", second="strip.tip", axis=(0, 0, 1)),
    },
    outputs=outputs,
    rates=rates,
    initial=[0.0, 0.0],
)


def hinged(form, controllers=(CONTROLLER,)):
    joint = m.Revolute(first="ground", second="strip.root", axis=AXIS, name="hinge")
    return m.System([form], [joint], gravity=(0, 0, -9.81), controllers=controllers)


def full(body):
    return FullBody(body, MeanAxisFrame())


def complete(body):
    return reduce(body, MeanAxisFrame(), CraigBampton(body.n - 12), loads=NoLoads)


def places(system, solution):
    """Of all nodes, from the origin of the frame."""
    form, motion = system.bodies[0].body, solution.bodies["strip"]
    local = form.nodes + np.array([form.expand(each) for each in motion.coordinates])
    return motion.position[:, None] + np.einsum("tij,tnj->tni", motion.rotation, local)


@pytest.mark.slow
def test_a_full_body_moves_as_its_complete_basis(body):
    """With an integrator and a filter in the loop: places and states alike, in as many steps."""
    systems = [hinged(form(body)) for form in (full, complete)]
    runs = [simulate(system, RUN) for system in systems]
    ours, theirs = (places(*pair) for pair in zip(systems, runs, strict=True))
    assert abs(theirs[-1] - theirs[0]).max() > 1e-3
    np.testing.assert_allclose(ours, theirs, atol=1e-9)
    ours, theirs = (run.engine_state["control.states.controller"] for run in runs)
    np.testing.assert_allclose(ours, theirs, atol=1e-9)


@pytest.mark.slow
def test_a_run_in_two_parts_is_one_run(body, tmp_path):
    system, half = hinged(full(body)), tmp_path / "half.h5"

    class CutError(Exception):
        pass

    def cut(share):
        if share > 0.4:
            raise CutError

    with pytest.raises(CutError):
        simulate(system, RUN, file=half, progress=cut)
    after, whole = simulate(system, RUN, file=half), simulate(system, RUN)
    np.testing.assert_array_equal(
        after.engine_state["control.states.controller"], whole.engine_state["control.states.controller"]
    )
    np.testing.assert_array_equal(after.bodies["strip"].coordinates, whole.bodies["strip"].coordinates)


@pytest.mark.slow
def test_a_full_body_rests_where_its_complete_basis_does(body):
    """Held by the integrator; states, and the modes of the closed loop, alike."""
    systems = [equilibrium(hinged(form(body))).system for form in (full, complete)]
    ours, theirs = (system.controllers[0].initial for system in systems)
    np.testing.assert_allclose(ours, theirs, rtol=1e-8, atol=1e-10)
    ours = machine_modes(linearize(systems[0]), 6).eigenvalues
    dense = linearize(systems[1])
    theirs = slowest(dense, 6)
    # All motions at once are known to rounding in parts of the fastest, as squares.
    fastest = abs(np.linalg.eigvals(np.linalg.solve(dense.mass, dense.stiffness))).max()
    rounding = np.finfo(float).eps * fastest / abs(theirs) ** 2
    assert (abs(ours - theirs) <= (1e-8 + rounding) * abs(theirs)).all()
    np.testing.assert_allclose(ours, theirs, rtol=2e-6)
    assert (theirs.imag == 0).any()


def slowest(machine, number):
    """Eigenvalues of a dense machine with its controllers, by the inverse: exact where they are small."""
    k, control = machine.size, machine.control
    none = np.zeros((k, control.size))
    moving = np.block(
        [
            [np.zeros((k, k)), np.eye(k), none],
            [-machine.stiffness, -machine.damping, control.forces],
            [control.by_position, control.by_velocity, control.by_state],
        ]
    )
    held = scipy.linalg.block_diag(np.eye(k), machine.mass, np.eye(control.size))
    values = 1 / np.linalg.eigvals(np.linalg.solve(moving, held))
    values = values[values.imag >= 0]
    return values[np.argsort(abs(values))[:number]]


EVERY = 7e-3
"""s, of the sampled controller: its instants lie between the output times."""


def sampled(calls):
    """Proportional, with a sum of the errors so far; notes when it is called."""

    def law(time, reads, memory):
        calls.append(time)
        error = GOAL - reads["hinge"].angle
        total = memory["total"] + EVERY * error
        return {"motor": 6 * error + 200 * total}, {"total": total}

    motor = m.TorqueBetween(first="ground", second="strip.root", axis=AXIS)
    reads = {"hinge": m.JointReading("hinge")}
    memory = {"total": np.zeros(())}
    return m.SampledController(
        reads=reads, drives={"motor": motor}, law=law, every=EVERY, memory=memory, name="clock"
    )


def test_accelerations_are_found_whatever_they_were(body):
    """As after a sample, when those of the step before are there."""
    engine = FullEngine(hinged(full(body), ()), RUN)
    state = engine.start(0.0).state
    again = engine.machine.accelerated(state)
    assert abs(state.acceleration).max() > 1
    np.testing.assert_allclose(again.acceleration, state.acceleration, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(again.multipliers, state.multipliers, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_sampled_controllers_drive_a_full_body_as_its_complete_basis(body):
    calls, theirs = [], []
    systems = [hinged(full(body), [sampled(calls)]), hinged(complete(body), [sampled(theirs)])]
    runs = [simulate(system, RUN) for system in systems]
    ours, other = (places(*pair) for pair in zip(systems, runs, strict=True))
    free = places(systems[1], simulate(hinged(complete(body), ()), RUN))
    assert abs(free[-1] - other[-1]).max() > 1e-5
    np.testing.assert_allclose(ours, other, atol=1e-9)
    np.testing.assert_allclose(calls, [0, EVERY, 2 * EVERY], atol=1e-15)
    assert calls == theirs


@pytest.mark.slow
def test_a_sampled_run_in_two_parts_is_one_run(body):
    calls = []
    system = hinged(full(body), [sampled(calls)])
    whole = simulate(system, RUN)
    first = simulate(system, replace(RUN, duration=0.01))
    calls.clear()
    rest = simulate(system, RUN, resume=first)
    np.testing.assert_array_equal(rest.bodies["strip"].coordinates[-1], whole.bodies["strip"].coordinates[-1])
    assert calls == [2 * EVERY]
