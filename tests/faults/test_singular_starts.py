"""Mechanisms in a dead point at the start: refused with the cause; beside it, the known motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.equations import joint_residuals
from supple.errors import ModelError, RedundantConstraintWarning
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    Ball,
    ConstantRate,
    Placed,
    PrescribedRotation,
    Prismatic,
    Revolute,
    SpringDamper,
    System,
)
from supple.simulation import simulate

Z = (0.0, 0.0, 1.0)
RUN = Run(1.0, 0.05, step=FixedStep(2e-3), tolerances=Tolerances(1e-10))


def along(tail, head):
    tail, head = np.asarray(tail, float), np.asarray(head, float)
    angle = np.arctan2(*(head - tail)[::-1])
    return {"position": [*(tail + head) / 2, 0.0], "rotation": [0.0, 0.0, angle]}


def parallelogram(rod, angle):
    """Links 1 and 2 m, the crank driven by 1 rad from an angle; flat where the angle is zero."""
    pin = np.array([np.cos(angle), np.sin(angle)])
    base = np.array([2.0, 0.0])
    return System(
        (
            Placed(rod("crank", 1.0), **along([0, 0], pin)),
            Placed(rod("coupler", 2.0), **along(pin, pin + base)),
            Placed(rod("rocker", 1.0), **along(base, pin + base)),
        ),
        (
            PrescribedRotation(
                first=GROUND, second=At("crank", "left"), axis=Z, angle=ConstantRate(1.0), name="motor"
            ),
            Revolute(first=At("crank", "right"), second=At("coupler", "left"), axis=Z, name="pin"),
            Revolute(first=GROUND, second=At("rocker", "left"), axis=Z, name="pivot"),
            Revolute(first=At("coupler", "right"), second=At("rocker", "right"), axis=Z, name="closing"),
        ),
    )


def slider_crank(rod, angle):
    """Crank and rod of 1 m: folded at pi / 2, where the slider stands on the crank's axis."""
    pin = np.array([np.cos(angle), np.sin(angle)])
    end = np.array([2 * np.cos(angle), 0.0])
    return System(
        (
            Placed(rod("crank", 1.0), **along([0, 0], pin)),
            Placed(rod("rod", 1.0), **along(pin, end)),
            Placed(rod("slider", 0.1), position=[end[0] + 0.05, 0, 0]),
        ),
        (
            PrescribedRotation(
                first=GROUND, second=At("crank", "left"), axis=Z, angle=ConstantRate(0.5), name="motor"
            ),
            Revolute(first=At("crank", "right"), second=At("rod", "left"), axis=Z, name="pin"),
            Revolute(first=At("rod", "right"), second=At("slider", "left"), axis=Z, name="wrist"),
            Prismatic(first=GROUND, second=At("slider", "left"), axis=(1.0, 0.0, 0.0), name="guide"),
        ),
    )


def chain(rod, sag):
    """Three rods of 1 m between two pins: taut, or sagging symmetrically."""
    x = np.cos(sag)
    points = [np.array(p) for p in ([0, 0], [x, -np.sin(sag)], [x + 1, -np.sin(sag)], [2 * x + 1, 0.0])]
    bodies = [Placed(rod(name, 1.0), **along(points[i], points[i + 1])) for i, name in enumerate("abc")]
    ends = [GROUND, At("a", "right"), At("b", "right")]
    joints = [Ball(first=end, second=At(name, "left")) for end, name in zip(ends, "abc", strict=True)]
    joints.append(Ball(first=At("c", "right"), second=GROUND, name="last"))
    return System(bodies, joints, gravity=(3.0, -9.81, 0))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")
@pytest.mark.parametrize(
    ("system", "joint"),
    [
        (lambda rod: parallelogram(rod, 0.0), "closing"),
        (lambda rod: slider_crank(rod, np.pi / 2), "guide"),
        (lambda rod: chain(rod, 0.0), "last"),
    ],
    ids=["flat parallelogram", "folded slider-crank", "taut chain"],
)
def test_a_dead_point_is_refused_by_name(rod, system, joint):
    with pytest.raises(ModelError, match=f"starts in a dead point: .*'{joint}'"):
        simulate(system(rod), RUN)


@pytest.mark.slow
def test_beside_it_a_parallelogram_stays_one(rod):
    """The rocker turns as the crank does, and the coupler stays level."""
    system = parallelogram(rod, 0.3)
    with pytest.warns(RedundantConstraintWarning):
        solution = simulate(system, RUN)
    crank, rocker, coupler = (solution.bodies[name].rotation for name in ("crank", "rocker", "coupler"))
    np.testing.assert_allclose(crank, rocker, atol=1e-9)
    np.testing.assert_allclose(coupler, np.broadcast_to(np.eye(3), coupler.shape), atol=1e-9)
    assert abs(joint_residuals(system, solution)).max() < 1e-9


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.StepCutWarning")  # a step ends in the dead point
def test_beside_it_a_slider_crank_follows_its_path(rod):
    """x = 2 cos(angle) for equal links, through the dead point at pi / 2 where inertia carries it on."""
    system = slider_crank(rod, 1.2)
    with pytest.warns(RedundantConstraintWarning):
        solution = simulate(system, RUN)
    angle = 1.2 + 0.5 * solution.times
    x = solution.bodies["slider"].position[:, 0] - 0.05
    np.testing.assert_allclose(x, 2 * np.cos(angle), atol=1e-5)


@pytest.mark.slow
def test_beside_it_a_chain_swings_and_keeps_its_pins(rod):
    system = chain(rod, 0.2)
    solution = simulate(system, RUN)
    assert abs(joint_residuals(system, solution)).max() < 1e-9
    assert np.ptp(solution.bodies["b"].position[:, 0]) > 1e-3


def ends_of(solution, name):
    """Where the left and the right end of a rod of 1 m stand, in the plane, (t, 2) each."""
    motion = solution.bodies[name]
    half = 0.5 * motion.rotation[:, :2, 0]
    return motion.position[:, :2] - half, motion.position[:, :2] + half


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.StepCutWarning")  # a step ends in the dead point
def test_a_parallelogram_is_driven_through_its_dead_point(rod):
    """From 0.52 rad before the flat position to beyond it: it stays a parallelogram."""
    system = parallelogram(rod, -0.52)
    with pytest.warns(RedundantConstraintWarning):
        solution = simulate(system, RUN)
    pin = -0.52 + solution.times
    path = np.stack([np.cos(pin), np.sin(pin)], axis=1)
    np.testing.assert_allclose(ends_of(solution, "crank")[1], path, atol=1e-9)
    np.testing.assert_allclose(ends_of(solution, "rocker")[1], path + np.array([2.0, 0.0]), atol=1e-6)
    np.testing.assert_allclose(
        solution.bodies["coupler"].position[:, :2], path + np.array([1.0, 0.0]), atol=1e-6
    )


@pytest.mark.slow
def test_a_slider_crank_is_driven_through_all_its_dead_points(rod):
    """A whole turn and more: folded at pi / 2 and 3 pi / 2, stretched at pi and 2 pi."""
    system = slider_crank(rod, 1.2)
    run = Run(14.0, 0.1, step=FixedStep(5e-3), tolerances=Tolerances(1e-10))
    with pytest.warns(RedundantConstraintWarning):
        solution = simulate(system, run)
    angle = 1.2 + 0.5 * solution.times
    assert angle[-1] > 2 * np.pi + 1.2
    np.testing.assert_allclose(solution.bodies["slider"].position[:, 0] - 0.05, 2 * np.cos(angle), atol=1e-9)


@pytest.mark.slow
def test_a_chain_slightly_bent_moves_as_a_four_bar_linkage(rod):
    """One freedom: the first rod's angle gives the others by two circles, and the energy gives its speed."""
    gravity = np.array([400.0, -9.81])
    system = replace(chain(rod, 0.05), gravity=(*gravity, 0.0))
    solution = simulate(system, Run(0.2, 0.005, step=FixedStep(2.5e-4), tolerances=Tolerances(1e-10)))
    pins = np.array([0.0, 0.0]), np.array([2 * np.cos(0.05) + 1, 0.0])
    first, second = ends_of(solution, "a")[1], ends_of(solution, "b")[1]
    assert np.ptp(first[:, 1]) > 0.02
    # The second joint lies on circles about the first joint and the last pin, below the line between them.
    apart = pins[1] - first
    half = np.linalg.norm(apart, axis=1, keepdims=True) / 2
    across = np.stack([apart[:, 1], -apart[:, 0]], axis=1) / (2 * half)
    expected = first + apart / 2 + np.sqrt(1 - half**2) * across
    np.testing.assert_allclose(second, expected, atol=1e-9)
    motions = [solution.bodies[name] for name in "abc"]
    kinetic = sum(
        placed.body.mass * np.sum(motion.velocity**2, axis=1) / 2
        + placed.body.inertia[2, 2] * motion.angular_velocity[:, 2] ** 2 / 2
        for placed, motion in zip(system.bodies, motions, strict=True)
    )
    work = sum(
        placed.body.mass * (motion.position[:, :2] - motion.position[0, :2]) @ gravity
        for placed, motion in zip(system.bodies, motions, strict=True)
    )
    assert kinetic.max() > 0.1
    np.testing.assert_allclose(kinetic, work, atol=2e-3 * kinetic.max())


@pytest.mark.slow
def test_joints_that_repeat_others_everywhere_are_left_out(rod):
    """A bar on two hinges of one axis: five equations twice, wherever it turns to."""
    bar = Placed(rod("bar", 1.0), position=[0.5, 0, 0])
    hinges = (
        Revolute(first=GROUND, second=At("bar", "left"), axis=(1, 0, 0), name="left hinge"),
        Revolute(first=GROUND, second=At("bar", "right"), axis=(1, 0, 0), name="right hinge"),
    )
    spring = SpringDamper(first=At("bar", "left"), anchor=(0, 0.3, 0), stiffness=1.0, rest_length=0.1)
    with pytest.warns(RedundantConstraintWarning, match="5 redundant"):
        solution = simulate(System((bar,), hinges, (spring,)), Run(0.1, 0.05, step=FixedStep(0.01)))
    np.testing.assert_allclose(solution.bodies["bar"].position[-1], [0.5, 0, 0], atol=1e-12)
