"""Controllers in runs: a robot arm against SciPy, order of states, sampled laws, exact resume, refusals."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from supple import machine as m
from supple.body import RigidBody
from supple.equations import balances
from supple.equations.checks.step_resolution import warn_of_missed_loads
from supple.equations.stops import stepping_instants
from supple.errors import ConvergenceError, ModelError, ResolutionWarning
from supple.integrate import AdaptiveStep, FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.linearization import linearize, machine_modes
from supple.simulation import equilibrium, simulate, simulate_batch

MASS, LENGTH, INERTIA = 3.0, 0.8, 0.2
WHEEL = 0.5
AXIS = (0.0, 0.0, 1.0)
GAINS = np.array([[80.0, 9.0], [40.0, 4.0]])


def options(step):
    return {
        "step": FixedStep(step),
        "method": GeneralizedAlpha(0.9),
        "tolerances": Tolerances(residual=1e-11),
    }


def link(name):
    half = LENGTH / 2
    return RigidBody(
        name, MASS, [half, 0, 0], INERTIA * np.eye(3), {"root": (0, 0, 0), "tip": (LENGTH, 0, 0)}
    )


def target(t):
    """Angles of both joints."""
    return jnp.stack([0.5 * (1 - jnp.cos(3 * t)), 0.3 * (1 - jnp.cos(5 * t))])


def follow(time, reads, _states):
    """Proportional and derivative."""
    wanted = target(time)
    return {
        name: GAINS[i, 0] * (wanted[i] - reads[name].angle) - GAINS[i, 1] * reads[name].rate
        for i, name in enumerate(("shoulder", "elbow"))
    }


def arm(controller):
    joints = [
        m.Revolute(first="ground", second="upper.root", axis=AXIS, name="shoulder"),
        m.Revolute(first="upper.tip", second="fore.root", axis=AXIS, name="elbow"),
    ]
    bodies = [link("upper"), m.Placed(link("fore"), position=[LENGTH, 0, 0])]
    return m.System(bodies, joints, gravity=(0, -9.81, 0), controllers=[controller])


DRIVES = {
    "shoulder": m.TorqueBetween(first="ground", second="upper.root", axis=AXIS),
    "elbow": m.TorqueBetween(first="upper.tip", second="fore.root", axis=AXIS),
}
READS = {name: m.JointReading(name) for name in DRIVES}
FOLLOWING = m.Controller(reads=READS, drives=DRIVES, outputs=follow)


def arm_equations(state, torques):
    """Two links by Lagrange, of absolute angles a, b; torques at shoulder and elbow."""
    a, b, da, db = state
    half = LENGTH / 2
    mixed = MASS * LENGTH * half * np.cos(a - b)
    mass = np.array([[INERTIA + MASS * half**2 + MASS * LENGTH**2, mixed], [mixed, INERTIA + MASS * half**2]])
    swing = MASS * LENGTH * half * np.sin(a - b)
    load = [
        torques[0] - torques[1] - swing * db**2 - 9.81 * MASS * (half + LENGTH) * np.cos(a),
        torques[1] + swing * da**2 - 9.81 * MASS * half * np.cos(b),
    ]
    return np.concatenate([[da, db], np.linalg.solve(mass, load)])


def pd_torques(t, state):
    a, b, da, db = state
    wanted = np.array([0.5 * (1 - np.cos(3 * t)), 0.3 * (1 - np.cos(5 * t))])
    return GAINS[:, 0] * (wanted - [a, b - a]) - GAINS[:, 1] * np.array([da, db - da])


def angles(solution):
    axes = [solution.bodies[name].rotation for name in ("upper", "fore")]
    return np.unwrap(np.stack([np.arctan2(own[:, 1, 0], own[:, 0, 0]) for own in axes], axis=1), axis=0)


def extrapolated(run_with, step):
    """From two steps: their errors are of second order, that of the result is of fourth or third."""
    return (4 * run_with(step / 2) - run_with(step)) / 3


@pytest.mark.slow
def test_the_arm_moves_as_an_independent_integration_says():
    system = arm(FOLLOWING)

    def moved(step):
        return angles(simulate(system, Run(duration=0.4, output_step=0.1, **options(step))))

    exact = solve_ivp(
        lambda t, y: arm_equations(y, pd_torques(t, y)), (0, 0.4), np.zeros(4), rtol=1e-12, atol=1e-13
    ).y[:2, -1]
    coarse, fine = (abs(moved(step)[-1] - exact).max() for step in (4e-3, 2e-3))
    assert 1.9 < np.log2(coarse / fine) < 2.2
    np.testing.assert_allclose(extrapolated(moved, 4e-4)[-1], exact, atol=1e-8)


@pytest.mark.slow
def test_newton_takes_as_many_iterations_with_a_controller_as_with_springs():
    """The tangent of a controller is exact: the same law by an element costs no fewer iterations."""
    servo = [
        m.AngleServo(first=first, second=second, axis=AXIS, angle=angle, stiffness=float(k), damping=float(c))
        for (first, second), angle, (k, c) in zip(
            (("ground", "upper.root"), ("upper.tip", "fore.root")),
            (0.4, -0.3),
            GAINS,
            strict=True,
        )
    ]

    def hold(_time, reads, _states):
        return {
            name: GAINS[i, 0] * (wanted - reads[name].angle) - GAINS[i, 1] * reads[name].rate
            for i, (name, wanted) in enumerate((("shoulder", 0.4), ("elbow", -0.3)))
        }

    own = arm(replace(FOLLOWING, outputs=hold))
    other = replace(own, loads=servo, controllers=())
    runs = [simulate(each, Run(duration=0.3, output_step=0.1, **options(2e-3))) for each in (own, other)]
    np.testing.assert_allclose(angles(runs[0]), angles(runs[1]), atol=1e-11)
    assert runs[0].statistics.iterations == runs[1].statistics.iterations


def wheel(controllers):
    body = RigidBody("wheel", 2.0, [0, 0, 0], WHEEL * np.eye(3), {"axle": (0, 0, 0), "rim": (0.3, 0, 0)})
    joint = m.Revolute(first="ground", second="wheel.axle", axis=AXIS, name="hinge")
    return m.System([body], [joint], controllers=controllers)


MOTOR = {"motor": m.TorqueBetween(first="ground", second="wheel.axle", axis=AXIS)}
HINGE = {"hinge": m.JointReading("hinge")}


@pytest.mark.slow
def test_states_of_a_controller_are_of_second_order():
    """PI control of the speed through a filter: a linear system with three states, solved exactly."""

    def rates(_t, reads, z):
        return jnp.stack([2.0 - reads["hinge"].rate, (reads["hinge"].rate - z[1]) / 0.05])

    def outputs(_t, _reads, z):
        return {"motor": 6.0 * z[0] + 1.5 * (2.0 - z[1])}

    system = wheel(
        [m.Controller(reads=HINGE, drives=MOTOR, outputs=outputs, rates=rates, initial=[0.1, -0.2])]
    )
    matrix = np.array([[0, 6.0, -1.5], [-1 * WHEEL, 0, 0], [20 * WHEEL, 0, -20 * WHEEL]]) / WHEEL
    constant = np.array([3.0 / WHEEL, 2.0, 0])
    exact = solve_ivp(lambda _, y: matrix @ y + constant, (0, 1), [0, 0.1, -0.2], rtol=1e-12, atol=1e-13).y[
        :, -1
    ]

    def error(step):
        solution = simulate(system, Run(duration=1.0, output_step=1.0, **options(step)))
        states = solution.engine_state["control.states.controller"]
        found = [solution.bodies["wheel"].angular_velocity[-1, 2], *states[:2]]
        return abs(np.array(found) - exact).max()

    errors = [error(step) for step in (0.02, 0.01, 0.005)]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.15)


@pytest.mark.slow
def test_a_batch_marches_the_states_of_its_controllers():
    """Wheels of three inertias, turning and carrying integrators from different starts: each as if alone."""

    def rates(_t, reads, z):
        return jnp.stack([2.0 - reads["hinge"].rate])

    def outputs(_t, reads, z):
        return {"motor": 6.0 * z[0] - 0.3 * reads["hinge"].angle}

    def case(mass, start, spin):
        own = m.Controller(reads=HINGE, drives=MOTOR, outputs=outputs, rates=rates, initial=[start])
        body = RigidBody("wheel", mass, [0, 0, 0], mass * np.eye(3), {"axle": (0, 0, 0)})
        placed = m.Placed(body, angular_velocity=(0, 0, spin))
        joint = m.Revolute(first="ground", second="wheel.axle", axis=AXIS, name="hinge")
        return m.System([placed], [joint], controllers=[own])

    cases = [case(0.5, 0.1, 0.0), case(0.8, -0.3, 1.0), case(1.3, 0.0, 0.0)]
    run = Run(duration=1.0, output_step=0.5, **options(0.02))
    for system, found in zip(cases, simulate_batch(cases, run).check().solutions, strict=True):
        alone = simulate(system, run)
        ours, theirs = (each.engine_state["control.states.controller"] for each in (found, alone))
        np.testing.assert_allclose(ours, theirs, rtol=1e-11, atol=1e-12)
        ours, theirs = (each.bodies["wheel"].angular_velocity for each in (found, alone))
        np.testing.assert_allclose(ours, theirs, rtol=1e-11, atol=1e-12)
    assert abs(theirs).max() > 0.5
    sampled = m.SampledController(
        reads=HINGE, drives=MOTOR, law=integrating, every=0.1, memory={"total": 0.0}
    )
    with pytest.raises(ModelError, match="one by one"):
        simulate_batch([replace(each, controllers=[sampled]) for each in cases], run)


@pytest.mark.slow
def test_angles_that_are_read_count_whole_turns():
    seen = []

    def law(time, reads, memory):
        seen.append((time, float(reads["hinge"].angle)))
        return {"motor": 20.0}, memory

    system = wheel([m.SampledController(reads=HINGE, drives=MOTOR, law=law, every=0.25)])
    simulate(system, Run(duration=1.0, output_step=0.5, **options(0.01)))
    times, turned = np.array(seen).T
    np.testing.assert_allclose(times, [0, 0.25, 0.5, 0.75], atol=1e-15)
    np.testing.assert_allclose(turned, 20.0 / WHEEL * times**2 / 2, rtol=1e-9, atol=1e-12)
    assert turned[-1] > 2 * np.pi


@pytest.mark.parametrize(("ends", "step"), [((0.1, 0.3), 0.1), ((0.3, 0.4), 0.1), ((0.6, 0.7), 0.05)])
def test_a_longer_run_that_goes_on_calls_a_controller_once_at_each_time(ends, step):
    """The times of runs of different durations differ in their last digits."""
    seen = []

    def law(time, _reads, memory):
        seen.append(time)
        return {"motor": 1.0}, memory

    system = wheel([m.SampledController(reads=HINGE, drives=MOTOR, law=law, every=0.1)])
    first, whole = (Run(duration=end, output_step=step, **options(0.05)) for end in ends)
    simulate(system, whole, resume=simulate(system, first))
    assert seen == pytest.approx(np.arange(round(10 * ends[1])) * 0.1, abs=1e-12)


def test_adaptive_steps_stop_once_where_a_load_jumps_at_a_call_time():
    push = m.TorqueBetween(
        first="ground",
        second=m.At("wheel", "axle"),
        axis=(0, 0, 1),
        torque=m.Table([0, 0.35, 0.7], [0, 1, 0]),
    )
    control = m.SampledController(
        reads=HINGE, drives=MOTOR, law=integrating, every=0.01, memory={"total": 0.0}
    )
    system = replace(wheel([control]), loads=(push,))
    run = Run(duration=0.7, output_step=0.7, step=AdaptiveStep())
    assert not stepping_instants([system], run).size
    assert stepping_instants([replace(system, controllers=())], run) == pytest.approx([0.35])


PERIOD = 0.04


def integrating(_time, reads, memory):
    """PI in plain Python."""
    error = np.array([0.4, -0.3]) - [float(reads[name].angle) for name in ("shoulder", "elbow")]
    rates = np.array([float(reads[name].rate) for name in ("shoulder", "elbow")])
    total = memory["total"] + PERIOD * error
    torques = 60 * error + 50 * total - 5 * rates
    return dict(zip(("shoulder", "elbow"), torques, strict=True)), {
        "total": total,
        "calls": memory["calls"] + 1,
    }


SAMPLED = m.SampledController(
    reads=READS, drives=DRIVES, law=integrating, every=PERIOD, memory={"total": np.zeros(2), "calls": 0}
)


def driven_at_rest(torque):
    """The arm with a controller that adds nothing to a torque over time on its shoulder."""
    shoulder = replace(DRIVES["shoulder"], torque=torque)
    return arm(m.Controller(reads={}, drives={"shoulder": shoulder}, outputs=lambda *_: {"shoulder": 0.0}))


def test_the_own_law_of_a_driven_element_covers_the_run_and_stops_its_steps():
    """A controller adds to the law of its element; loads have the same checks."""
    short = m.Table([0.0, 0.3], [0.0, 5.0])
    with pytest.raises(ModelError, match=r"its table ends at t = 0\.3, before the run ends"):
        simulate(driven_at_rest(short), Run(duration=1.0, output_step=0.5))
    with pytest.raises(ModelError, match=r"its value is needed at t = 0\.5"):
        equilibrium(driven_at_rest(short), time=0.5)
    pulse = m.Table([0.0, 0.61, 0.612, 0.614, 1.0], [0.0, 0.0, 9.0, 0.0, 0.0])
    system = driven_at_rest(pulse)
    run = Run(duration=1.0, output_step=0.25, step=AdaptiveStep(1e-3))
    np.testing.assert_allclose(stepping_instants([system], run), [0.61, 0.612, 0.614])
    with pytest.warns(ResolutionWarning, match="TorqueBetween on ground: within a step"):
        warn_of_missed_loads(system, replace(run, step=FixedStep(0.05)))


@pytest.mark.slow
def test_a_sampled_controller_holds_what_it_gave():
    """Against SciPy, instant by instant; output times and instants do not meet."""
    state, total, duration = np.zeros(4), np.zeros(2), 0.4
    for start in np.arange(0, duration - 1e-9, PERIOD):
        error = np.array([0.4, -0.3]) - [state[0], state[1] - state[0]]
        total = total + PERIOD * error
        held = 60 * error + 50 * total - 5 * np.array([state[2], state[3] - state[2]])
        state = solve_ivp(
            lambda _, y, held=held: arm_equations(y, held),
            (start, start + PERIOD),
            state,
            rtol=1e-12,
            atol=1e-13,
        ).y[:, -1]
    system = arm(SAMPLED)

    def moved(step):
        return angles(simulate(system, Run(duration=duration, output_step=0.1, **options(step))))

    coarse, fine = (abs(moved(step)[-1] - state[:2]).max() for step in (4e-3, 2e-3))
    assert np.log2(coarse / fine) > 1.8
    assert fine < 1e-4


class KilledError(Exception):
    """In the middle of a run."""


@pytest.mark.slow
def test_a_run_that_was_killed_goes_on_to_the_last_bit(tmp_path):
    """With a sampled controller and one with states in the same machine."""

    def rates(_t, reads, z):
        return jnp.stack([reads["upper"].velocity[1] - z[0]])

    def outputs(_t, reads, z):
        return {"pull": -2.0 * z[0] - 0.1 * reads["upper"].point[1]}

    pull = {"pull": m.ForceBetween(first="ground", second="upper.tip", axis=(0, 1, 0))}
    filtering = m.Controller(
        reads={"upper": m.EndReading("upper.tip")},
        drives=pull,
        outputs=outputs,
        rates=rates,
        initial=[0.0],
        name="filter",
    )
    system = replace(arm(SAMPLED), controllers=[SAMPLED, filtering])
    run = Run(duration=1.2, output_step=0.01, **options(5e-3))
    whole = simulate(system, run, file=tmp_path / "whole.h5")

    def kill(share):
        if share > 0.4:
            raise KilledError

    with pytest.raises(KilledError):
        simulate(system, run, file=tmp_path / "cut.h5", progress=kill)
    after = simulate(system, run, file=tmp_path / "cut.h5")
    np.testing.assert_array_equal(after.times, whole.times)
    for name in ("upper", "fore"):
        for part, array in whole.bodies[name].arrays().items():
            np.testing.assert_array_equal(after.bodies[name].arrays()[part], array)
    assert after.engine_state.keys() == whole.engine_state.keys()
    for key, value in whole.engine_state.items():
        np.testing.assert_array_equal(after.engine_state[key], value)
    assert whole.engine_state["control.memory.controller.calls"] == 30


@pytest.mark.slow
def test_energy_is_what_the_controller_gave():
    """Work of the torques by the trapezoidal rule over its outputs."""
    system = arm(FOLLOWING)
    solution = simulate(system, Run(duration=0.3, output_step=1e-3, **options(1e-3)))
    turned = angles(solution)
    rate = np.stack([solution.bodies[name].angular_velocity[:, 2] for name in ("upper", "fore")], axis=1)
    power = [
        pd_torques(t, [*a, *w]) @ [w[0], w[1] - w[0]]
        for t, a, w in zip(solution.times, turned, rate, strict=True)
    ]
    work = np.concatenate([[0], np.cumsum(np.add(power[1:], power[:-1]) / 2 * 1e-3)])
    total = balances(system, solution).total
    np.testing.assert_allclose(total - total[0], work, atol=2e-5 * abs(work).max())


def test_what_a_controller_cannot_do_is_refused():
    spring = {"spring": m.SpringDamper(first="upper.tip", anchor=(0, 9, 0), stiffness=1.0)}
    with pytest.raises(ModelError, match=r"cannot drive SpringDamper on upper.tip, which has no law of time"):
        m.Controller(reads={}, drives=spring, outputs=follow)
    with pytest.raises(ModelError, match="drives nothing"):
        m.Controller(reads={}, drives={}, outputs=follow)
    with pytest.raises(
        ModelError, match="states and rates must be given together; it has 1 initial states and no function"
    ):
        m.Controller(reads={}, drives=DRIVES, outputs=follow, initial=[0.0])
    with pytest.raises(ModelError, match="reads the ground, which does not move"):
        m.EndReading("ground")
    with pytest.raises(ModelError, match="every must be a positive time"):
        replace(SAMPLED, every=0.0)
    with pytest.raises(ModelError, match="its memory must contain numbers"):
        replace(SAMPLED, memory={"word": "no"})
    with pytest.raises(ModelError, match=r"there is no joint 'elbo'; did you mean 'elbow'"):
        arm(replace(FOLLOWING, reads={"elbow": m.JointReading("elbo")}))
    with pytest.raises(ModelError, match="controller name 'controller' is used more than once"):
        replace(arm(FOLLOWING), controllers=[FOLLOWING, SAMPLED])
    with pytest.raises(ModelError, match="remove it, replace"):
        equilibrium(replace(arm(FOLLOWING), controllers=[SAMPLED]))


def holding(_time, reads, _states):
    """Proportional and derivative, level."""
    return {
        name: -GAINS[i, 0] * reads[name].angle - GAINS[i, 1] * reads[name].rate
        for i, name in enumerate(("shoulder", "elbow"))
    }


@pytest.mark.slow
def test_an_arm_that_its_controller_holds_rests_and_vibrates_as_its_equations_say():
    """Weights against gains at rest; eigenvalues of the closed loop from the same independent equations."""
    weight = 9.81
    system = arm(replace(FOLLOWING, outputs=holding))
    found = equilibrium(system)
    upper, fore = found.system.bodies
    first, second = (np.arctan2(each.rotation[1, 0], each.rotation[0, 0]) for each in (upper, fore))
    elbow = MASS * weight * LENGTH / 2 * np.cos(second)
    shoulder = elbow + 1.5 * MASS * weight * LENGTH * np.cos(first)
    np.testing.assert_allclose(-GAINS[:, 0] * [first, second - first], [shoulder, elbow], rtol=1e-8)

    def rates(state):
        relative, speeds = (np.array([one, other - one]) for one, other in (state[:2], state[2:]))
        return arm_equations(state, -GAINS[:, 0] * relative - GAINS[:, 1] * speeds)

    at, step = np.array([first, second, 0.0, 0.0]), 1e-6
    state = np.array([(rates(at + step * e) - rates(at - step * e)) / (2 * step) for e in np.eye(4)]).T
    expected = np.linalg.eigvals(state)
    modes = machine_modes(linearize(system))
    ours = np.sort_complex(modes.eigenvalues)
    np.testing.assert_allclose(ours, np.sort_complex(expected[expected.imag >= 0]), rtol=1e-6)


def test_the_scripts_of_the_page_run():
    page = (Path(__file__).parents[4] / "docs" / "how-to" / "control_and_elements.md").read_text("utf-8")
    names: dict[str, object] = {}
    for script in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(compile(script, "control_and_elements.md", "exec"), names)
    assert isinstance(names["controller"], m.Controller)
    assert isinstance(names["sampled"], m.SampledController)


@pytest.mark.parametrize(
    ("outputs", "message"),
    [
        (lambda _t, reads, _z: {"motor": reads["hing"].angle}, r"uses 'hing'; available are \['hinge'\]"),
        (
            lambda _t, reads, _z: {"motor": 1.0 if reads["hinge"].angle > 0 else 2.0},
            "write jnp.where instead of",
        ),
        (lambda _t, reads, _z: {"motor": np.sin(float(reads["hinge"].angle))}, "jax.numpy instead of math"),
        (lambda *_: {"motor": jnp.ones(2)}, r"output 'motor' must have the shape \(\), got \(2,\)"),
        (lambda *_: {"motor": 1.0 + 2.0j}, "output 'motor' must be real numbers"),
        (lambda *_: {"moter": 1.0}, r"must be a dictionary for \['motor'\], got \['moter'\]"),
    ],
)
def test_what_a_traced_law_must_give(outputs, message):
    system = wheel([m.Controller(reads=HINGE, drives=MOTOR, outputs=outputs)])
    with pytest.raises(ModelError, match=message):
        simulate(system, Run(duration=0.1, output_step=0.1, **options(0.1)))


@pytest.mark.slow
def test_a_law_that_gives_no_number_ends_the_run_in_words():
    def broken(time, _reads, _states):
        return {"motor": jnp.where(time > 0.05, jnp.nan, 1.0)}

    system = wheel([m.Controller(reads=HINGE, drives=MOTOR, outputs=broken)])
    with pytest.raises(ConvergenceError, match=r"at t = 0.05 .* A user-defined controller, law or load"):
        simulate(system, Run(duration=0.1, output_step=0.1, **options(0.01)))


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (lambda *_: {"motor": 1.0}, r"must return \(outputs, memory\)"),
        (lambda *_: ({"moter": 1.0}, {}), "must return outputs for .'motor'."),
        (lambda *_: ({"motor": np.nan}, {}), "output 'motor' must be finite"),
        (lambda *_: ({"motor": 1.0}, {"new": 1.0}), "its memory must keep its names and shapes"),
        (
            lambda time, readings, memory: ({"motor": 1.0}, memory.update(new=1.0) or memory),
            "its memory must keep its names and shapes",
        ),
    ],
)
def test_what_a_sampled_law_must_give(law, message):
    system = wheel([m.SampledController(reads=HINGE, drives=MOTOR, law=law, every=0.1)])
    with pytest.raises(ModelError, match=message):
        simulate(system, Run(duration=0.1, output_step=0.1, **options(0.1)))
