"""State space and responses: against small motions of the nonlinear machine, and against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.signal
from fixtures.beam_bodies import beam_body

from supple.body import NodalFixedFrame, RayleighDamping, RigidBody, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.linearization import (
    Acceleration,
    RotationPort,
    TranslationPort,
    Velocity,
    frequency_response,
    linearize,
    machine_modes,
    random_response,
    state_space,
)
from supple.machine import (
    GROUND,
    At,
    Constant,
    DeadForce,
    Fixed,
    Placed,
    Revolute,
    Scaled,
    SpringDamper,
    System,
    TorsionSpringDamper,
)
from supple.mesh import strip
from supple.quantities import tracked_motion
from supple.reduction import CraigBampton, NoLoads, reduce
from supple.simulation import equilibrium, simulate

MASS, STIFFNESS, DAMPING = 3.0, 400.0, 8.0


@pytest.fixture(scope="module")
def oscillator():
    """A mass that slides along x, held by a spring and a damper."""
    stone = RigidBody(
        name="stone", mass=MASS, inertia=np.eye(3), centre=np.zeros(3), points={"top": (0, 0, 0)}
    )
    spring = SpringDamper(
        first=GROUND, second=At("stone", "top"), anchor=(5.0, 0, 0),
        stiffness=STIFFNESS, damping=DAMPING, rest_length=5.0,
    )  # fmt: skip
    return linearize(System((Placed(stone),), (), (spring,)))


PUSH = TranslationPort("stone.top", (1, 0, 0))


def test_the_response_of_an_oscillator_is_its_formula(oscillator):
    space = state_space(oscillator, inputs=[PUSH], outputs=[PUSH, Velocity(PUSH), Acceleration(PUSH)])
    w = np.linspace(1.0, 30.0, 7)
    exact = 1 / (STIFFNESS - MASS * w**2 + 1j * w * DAMPING)
    found = frequency_response(space, w).transfer[:, :, 0]
    assert found == pytest.approx(np.stack([exact, 1j * w * exact, -(w**2) * exact], axis=1), rel=1e-9)


def test_white_noise_shakes_an_oscillator_by_its_formula(oscillator):
    """One-sided density S per rad/s: `rms^2 = pi S / (2 k c)`."""
    space = state_space(oscillator, inputs=[PUSH], outputs=[PUSH])
    w = np.linspace(0.01, 400.0, 40001)
    density = 0.3
    response = random_response(frequency_response(space, w), np.full(len(w), density))
    assert response.rms[0] ** 2 == pytest.approx(np.pi * density / (2 * STIFFNESS * DAMPING), rel=1e-3)


def test_matlab_reads_the_matrices(oscillator, tmp_path):
    space = state_space(oscillator, inputs=[PUSH], outputs=[PUSH])
    kept = scipy.io.loadmat(space.write_matlab(tmp_path / "stone.mat"))
    for name, matrix in zip("ABCD", space.matrices, strict=True):
        assert np.array_equal(kept[name], matrix)
    assert str(kept["inputs"].ravel()[0][0]) == "stone.top along x"


def crane(force=0.0):
    """A strip on a hinge with a spring, deflected by gravity by a seventh of its length."""
    model = shell_model(
        strip(length=1.0, width=0.1, n_length=6, n_width=2),
        HomogeneousSection(Isotropic(2.1e11, 0.0, 7850.0), 3e-3),
    )
    body = flexible_body("boom", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))
    boom = reduce(
        body, NodalFixedFrame("root"), CraigBampton(4), damping=RayleighDamping(0.0, 2e-4), loads=NoLoads
    )
    pedestal = RigidBody(
        name="pedestal",
        mass=5.0,
        inertia=np.eye(3),
        centre=np.zeros(3),
        points={"foot": (0, 0, 0), "top": (0, 0, 0), "lug": (0.2, 0, 0)},
    )
    joints = (
        Revolute(name="hinge", first=GROUND, second=At("pedestal", "foot"), axis=(0, 1, 0)),
        Fixed(name="weld", first=At("pedestal", "top"), second=At("boom", "root")),
    )
    loads = [
        SpringDamper(
            first=GROUND, second=At("pedestal", "lug"), anchor=(0.2, 0, -1.0), stiffness=5e3, damping=20.0,
            rest_length=1.0,
        )
    ]  # fmt: skip
    if force:
        loads.append(DeadForce(body="boom", at="tip", force=Scaled((0.0, 0.0, force), Constant(1.0))))
    return System((Placed(pedestal), Placed(boom)), joints, loads, gravity=(0, 0, -9.81))


@pytest.mark.slow
def test_a_small_push_moves_the_machine_as_its_linear_equations_say():
    """A step of force at the tip, 0.05 s after it: equal to 1e-7 as the time step shrinks."""
    resting = equilibrium(crane()).system
    port = TranslationPort("boom.tip", (0, 0, 1))
    space = state_space(linearize(crane()), inputs=[port], outputs=[port])
    time, push = 0.05, 1e-4
    grown = scipy.linalg.expm(time * np.block([[space.a, space.b], [np.zeros((1, len(space.a) + 1))]]))
    linear = float((space.c @ grown[:-1, -1:])[0, 0]) * push

    def tip(force, step):
        machine = crane(force)
        start = System(resting.bodies, machine.joints, machine.loads, gravity=machine.gravity)
        run = Run(time, output_step=time, step=FixedStep(step), method=GeneralizedAlpha(0.9),
                  tolerances=Tolerances(residual=1e-12))  # fmt: skip
        motion = simulate(start, run).bodies["boom"]
        return tracked_motion(start.bodies[1].body, motion, "tip").position[-1, 2]

    moved = [tip(push, step) - tip(0.0, step) for step in (1e-4, 5e-5)]
    extrapolated = moved[1] + (moved[1] - moved[0]) / 3
    assert extrapolated == pytest.approx(linear, rel=1e-7)


def test_a_motor_between_two_bodies_acts_on_both():
    """Two wheels on one axle, with a spring between them: the motor turns the reduced inertia."""
    wheels = {name: RigidBody(name, 1.0, np.zeros(3), each * np.eye(3), {"hub": np.zeros(3)})
              for name, each in (("one", 0.02), ("two", 0.5))}  # fmt: skip
    hinges = [Revolute(first=GROUND, second=f"{name}.hub", axis=(0, 0, 1), name=name) for name in wheels]
    spring = TorsionSpringDamper(
        first="one.hub", second="two.hub", axis=(0, 0, 1), stiffness=200.0, damping=0.4
    )
    machine = linearize(System(list(wheels.values()), hinges, [spring]))
    motor = RotationPort("two.hub", (0, 0, 1), against="one.hub")
    space = state_space(machine, inputs=[motor], outputs=[motor, RotationPort("one.hub", (0, 0, 1))])
    s, reduced = 30j, 0.02 * 0.5 / 0.52
    expected = [
        [1 / (reduced * s**2 + 0.4 * s + 200.0)],
        [-reduced / 0.02 / (reduced * s**2 + 0.4 * s + 200.0)],
    ]
    np.testing.assert_allclose(frequency_response(space, [30.0]).transfer[0], expected, rtol=1e-12)
    assert space.inputs == ("two.hub about z against one.hub",)


@pytest.mark.slow
def test_a_turn_is_the_slope_of_the_deflection():
    """At the hinge's own body: displacement of the lug = arm times rotation."""
    machine = linearize(crane())
    turn = RotationPort("pedestal.top", (0, 1, 0)).row(machine)
    lug = TranslationPort("pedestal.lug", (0, 0, 1)).row(machine)
    placed = machine.system.bodies[0]
    arm = (placed.rotation @ [0.2, 0, 0])[0]
    assert lug == pytest.approx(-arm * turn, abs=1e-12 * abs(turn).max())
    assert machine_modes(machine).damping_ratios.min() > 0


def test_what_cannot_be_asked_is_refused(oscillator):
    with pytest.raises(ModelError, match="ground does not move"):
        TranslationPort("ground", (1, 0, 0))
    with pytest.raises(ModelError, match="not all zero"):
        RotationPort("stone.top", (0, 0, 0))
    with pytest.raises(ModelError, match="at least one port"):
        state_space(oscillator, inputs=[], outputs=[PUSH])
    space = state_space(oscillator, inputs=[PUSH], outputs=[PUSH])
    with pytest.raises(ModelError, match="finite angular frequencies"):
        frequency_response(space, [np.nan])
    # Across the spring the stone is free; along it the response at rest is that of the spring.
    free = TranslationPort("stone.top", (0, 1, 0))
    for ports in ({"inputs": [free], "outputs": [PUSH]}, {"inputs": [free], "outputs": [free]}):
        with pytest.raises(ModelError, match=r"pole at 0 rad/s|moves .* without end"):
            frequency_response(state_space(oscillator, **ports), [0.0])
    assert frequency_response(space, [0.0]).transfer[0, 0, 0] == pytest.approx(1 / STIFFNESS, rel=1e-9)
    response = frequency_response(space, [1.0, 2.0])
    with pytest.raises(ModelError, match="shape"):
        random_response(response, [1.0])
    with pytest.raises(ModelError, match="negative"):
        random_response(response, [1.0, -1.0])
    with pytest.raises(ModelError, match="ascending order"):
        random_response(frequency_response(space, [2.0, 1.0]), [1.0, 1.0])
    two = frequency_response(state_space(oscillator, inputs=[PUSH, PUSH], outputs=[PUSH]), [1.0, 2.0])
    with pytest.raises(ModelError, match="must be Hermitian"):
        random_response(two, np.tile([[1.0, 0.5], [0.0, 1.0]], (2, 1, 1)))


def test_a_constant_force_on_a_free_beam_has_no_static_response():
    """Its poles at zero are rounding errors; at a low frequency w the response is -1 / (m w^2)."""
    body = reduce(beam_body("root", "tip"), NodalFixedFrame("root"), CraigBampton(4), loads=NoLoads)
    root, tip = (TranslationPort(f"beams.{end}", (0, 0, 1)) for end in ("root", "tip"))
    space = state_space(linearize(System([body]), fulls=()), inputs=[root], outputs=[root, Velocity(tip)])
    assert space.drifts.tolist() == [[True], [True]]
    with pytest.raises(ModelError, match=r"a constant 'beams.root along z' moves .* without end"):
        frequency_response(space, [0.0, 1.0])
    lever = 1 + 12 / 4 * (1 - 1e-3)  # of a slender beam pushed at its end, about
    response = frequency_response(space, [0.1]).transfer[0, 0, 0]
    assert response == pytest.approx(-lever / (body.mass * 0.01), rel=0.01)
    held = System([body], [Fixed(first=GROUND, second=At("beams", "root"))])
    space = state_space(linearize(held, fulls=()), inputs=[tip], outputs=[tip])
    assert not space.drifts.any()
    assert frequency_response(space, [0.0]).transfer[0, 0, 0] > 0
