"""Velocities, accelerations, energies and momenta of intrinsic bodies, by the sensors of all forms."""

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import AveragingInterface, ModalDamping, RigidBody, RigidInterface, flexible_body
from supple.equations import balances
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, RungeKutta4
from supple.machine import GROUND, At, Fixed, Placed, PrescribedRotation, Revolute, SpringDamper, System
from supple.mesh import strip
from supple.methods.intrinsic import BALL, FREE, LoadPath, condense, intrinsic_body, released
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.quantities import (
    AccelerationSensor,
    AngularVelocitySensor,
    EnergySensor,
    JointMotionSensor,
    Place,
    SpringForceSensor,
    VelocitySensor,
    read_sensors,
)
from supple.simulation import simulate

SOFT = {"EA": 1e3, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.05}
GRAVITY = np.array([0.0, 0.0, -9.81])


def free_line(n=4):
    return intrinsic_body(beam_line(straight(1.0, n), name="a", **SOFT), FREE)


def thrown(body, gravity=GRAVITY):
    """Bent and spinning when it is let go."""
    bent = np.zeros(body.n_coordinates)
    bent[:3] = 0.05, 0.03, -0.01
    placed = Placed(body, velocity=[1.0, -2.0, 0.5], angular_velocity=[1.0, 2.0, -3.0], coordinates=bent)
    return System([placed], gravity=gravity)


def assert_derivatives(body, motion, nodes, name, h):
    """Velocities and accelerations are those of the positions, by differences of second order."""
    places, nodal = body.positions(motion, nodes), body.node_motion(motion, nodes)
    end = body.interface_motion(motion, name)
    for position, velocity, acceleration in (
        (places, nodal.velocity, nodal.acceleration),
        (end.position, end.velocity, end.acceleration),
    ):
        first = (position[2:] - position[:-2]) / (2 * h)
        second = (position[2:] - 2 * position[1:-1] + position[:-2]) / h**2
        assert velocity[1:-1] == pytest.approx(first, abs=1e-4 * np.abs(first).max())
        assert acceleration[1:-1] == pytest.approx(second, abs=1e-4 * np.abs(second).max())
    spin = (end.rotation[2:] - end.rotation[:-2]) @ end.rotation[1:-1].transpose(0, 2, 1) / (2 * h)
    turning = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    assert end.angular_velocity[1:-1] == pytest.approx(turning, abs=1e-4 * np.abs(turning).max())


def test_rates_are_those_of_the_positions_in_free_flight():
    body, h = free_line(), 1e-4
    run = Run(8 * h, h, step=FixedStep(h), method=RungeKutta4())
    motion = simulate(thrown(body), run).bodies["a"]
    assert_derivatives(body, motion, [0, 3, 4], "tip", h)


@pytest.mark.slow
def test_rates_are_those_of_the_positions_where_the_root_is_driven():
    """Sections that warp: the nodes of a condensed strip follow its strains."""
    steel = Isotropic(2.1e9, 0.3, 7850.0)
    model = shell_model(strip(1.0, 0.1, 8, 2), HomogeneousSection(steel, 0.01))
    ends = [RigidInterface("root", "root"), AveragingInterface("tip", "tip")]
    body = condense(
        flexible_body("a", model, ends), LoadPath("root", "tip", 5), n_modes=6, damping=ModalDamping(0.2)
    )
    assert np.abs(body.expansion.warping).max() > 1e-3 * np.abs(body.expansion.modes).max()
    h = 1e-4
    drive = PrescribedRotation(
        first=GROUND, second=At("a", "root"), axis=(0, 1, 0), angle=lambda t: 3 * t**2 + 2 * t
    )
    run = Run(0.2 + 8 * h, h, step=FixedStep(h), method=GeneralizedAlpha(1.0))
    motion = simulate(System([Placed(body)], [drive], gravity=GRAVITY), run).bodies["a"].at(slice(-9, None))
    assert_derivatives(body, motion, [2, 13, 22], "tip", h)


RUN = Run(0.1, 0.01, step=FixedStep(2e-4), method=RungeKutta4())


@pytest.mark.slow
def test_a_free_line_keeps_its_energy():
    system = thrown(free_line(), 0 * GRAVITY)
    (energies,) = read_sensors([EnergySensor("energy")], system, simulate(system, RUN))
    kinetic, strain, _, total = energies.values.T
    assert total == pytest.approx(total[0], rel=1e-10)
    assert np.ptp(strain) > 0.05 * total[0]
    assert kinetic + strain == pytest.approx(total, rel=1e-12)


@pytest.mark.slow
def test_momentum_follows_the_weight_to_second_order_in_the_segments():
    missed = []
    for n in (4, 8):
        body = free_line(n)
        system = thrown(body)
        solution = simulate(system, RUN)
        found, t, weight = balances(system, solution), solution.times[:, None], body.mass * GRAVITY
        gained = found.momentum - found.momentum[0] - weight * t
        risen = found.potential - found.potential[0] + (t * found.momentum[0] + weight * t**2 / 2) @ GRAVITY
        calm = thrown(body, 0 * GRAVITY)
        turning = balances(calm, simulate(calm, RUN)).angular_momentum
        sizes = (np.abs(found.momentum).max(), found.total[0], np.abs(turning).max())
        drift = (gained, risen, turning - turning[0])
        missed.append([np.abs(each).max() / size for each, size in zip(drift, sizes, strict=True)])
    assert np.max(missed) < 4e-3
    assert np.all(np.log2(np.divide(*missed)) > 1.2)


def test_a_line_that_turns_as_a_rigid_body_has_its_energy_and_momentum():
    body, spin = free_line(), np.array([0.3, 0.0, 2.0])
    motion = IntrinsicMotion(
        position=np.array([[0.0, 0.2, 0.0]]),
        rotation=np.eye(3)[None],
        coordinates=np.zeros((1, body.n_coordinates)),
        velocity=np.zeros((1, 3)),
        angular_velocity=spin[None],
        rates=np.zeros((1, body.modes.n_modes)),
    )
    system = System([Placed(body)])
    still = simulate(System([Placed(body, angular_velocity=spin)]), Run(1e-3, 1e-3, step=FixedStep(1e-4)))
    found = balances(system, still)
    inertia = body.line.twists.T @ body.line.mass @ body.line.twists
    assert found.kinetic[0] == pytest.approx(0.5 * spin @ inertia[3:, 3:] @ spin, rel=1e-9)
    assert found.angular_momentum[0] == pytest.approx(inertia[3:, 3:] @ spin, rel=1e-9)
    assert body.interface_motion(motion, "tip").velocity[0] == pytest.approx(np.cross(spin, [1.0, 0, 0]))
    with pytest.raises(ModelError, match="recorded by an earlier version"):
        AccelerationSensor("a", Place("a", "tip")).values(
            system, still.__class__(**{**still.__dict__, "times": np.zeros(1), "bodies": {"a": motion}})
        )


@pytest.mark.slow
def test_sensors_of_a_machine_of_a_line_and_a_rigid_body_agree():
    """A line on a hinge carries a mass at its tip: both bodies say the same of where they meet."""
    line = released(intrinsic_body(beam_line(straight(1.0, 4), name="a", **SOFT), BALL, 6))
    weight = RigidBody("b", 0.3, np.zeros(3), 1e-3 * np.eye(3), {"here": np.zeros(3)})
    hinge = Revolute(first=GROUND, second=At("a", "root"), axis=(0, 1, 0), name="hinge")
    spring = SpringDamper(
        first=GROUND,
        second=At("a", "tip"),
        stiffness=5.0,
        rest_length=float(np.sqrt(2)),
        damping=0.1,
        anchor=(0.0, 0.0, 1.0),
    )
    joints = [hinge, Fixed(first=At("a", "tip"), second=At("b", "here"), name="held")]
    system = System([Placed(line), Placed(weight, position=[1.0, 0, 0])], joints, [spring], gravity=GRAVITY)
    run = Run(0.3, 0.01, step=FixedStep(1e-3), method=GeneralizedAlpha(1.0))
    solution = simulate(system, run)
    tip, mass = Place("a", "tip"), Place("b", "here")
    found = {
        reading.name: reading.values
        for reading in read_sensors(
            [
                VelocitySensor("v line", tip),
                VelocitySensor("v mass", mass),
                AccelerationSensor("a line", tip),
                AccelerationSensor("a mass", mass),
                AngularVelocitySensor("w line", "a.tip"),
                AngularVelocitySensor("w mass", "b.here"),
                AngularVelocitySensor("w root", "a.root"),
                JointMotionSensor("hinge", "hinge"),
                SpringForceSensor("spring", spring),
            ],
            system,
            solution,
        )
    }
    for what, size in (("v", 1e-7), ("w", 1e-7), ("a", 1e-5)):
        one, other = found[f"{what} line"], found[f"{what} mass"]
        assert one == pytest.approx(other, abs=size * np.abs(other).max())
    angle, rate = found["hinge"][:, 0], found["hinge"][:, 1]
    assert rate == pytest.approx(found["w root"][:, 1], abs=1e-10)
    # The trapezoidal rule of 30 outputs.
    turned = np.concatenate([[0], np.cumsum(0.005 * (rate[1:] + rate[:-1]))])
    assert angle == pytest.approx(turned, abs=2e-3 * np.abs(angle).max())
    # Stretched by what its ends are apart beyond the first distance, less what it damps.
    ends = solution.bodies["b"].position - np.array([0.0, 0.0, 1.0])
    length = np.linalg.norm(ends, axis=1)
    along = np.sum(found["v mass"] * ends, axis=1) / length
    pull = 5.0 * (length - length[0]) + 0.1 * along
    assert found["spring"][:, :3] == pytest.approx(-(pull / length)[:, None] * ends, abs=1e-6)
