"""Loads on nodes: pressure that follows, an accelerating base; the same in both engines."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame, RigidBody, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    BaseAcceleration,
    Fixed,
    FollowerPressure,
    Placed,
    Revolute,
    Sine,
    System,
)
from supple.mesh import CellType, block
from supple.quantities import node_positions
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate

TIGHT = Tolerances(1e-10)


@pytest.fixture(scope="module")
def bar():
    """A soft bar of twenty-node hexahedra, 1 m long, and the quadrilaterals of its upper face."""
    mesh = block(1.0, 0.1, 0.1, 10, 1, 1, CellType.HEXA20)
    x, _, z = mesh.nodes.T
    body = flexible_body(
        "bar",
        solid_model(mesh, Isotropic(1e8, 0.3, 1000.0)),
        [RigidInterface("root", np.flatnonzero(x < 1e-9))],
    )
    top = np.flatnonzero((z > 0.05 - 1e-9) & (np.abs(np.round(10 * x) - 10 * x) < 1e-9))
    corners = {}
    for node in top:
        corners[round(10 * x[node]), mesh.nodes[node, 1] > 0] = int(node)
    faces = [
        [corners[i, False], corners[i + 1, False], corners[i + 1, True], corners[i, True]] for i in range(10)
    ]
    return body, np.array(faces)


def test_pressure_on_a_closed_surface_leaves_no_force(bar):
    """Whatever the places of the nodes: the area vectors of a closed surface sum to zero."""
    places = jnp.asarray(np.random.default_rng(2).standard_normal((4, 3)))
    tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    total = sum(
        FollowerPressure.facet_forces(places[jnp.array(face)], jnp.eye(3), 7.0).sum(axis=0)
        for face in tetrahedron
    )
    np.testing.assert_allclose(total, 0, atol=1e-14)


def test_pressure_on_a_flat_face_is_area_times_normal():
    square = jnp.array([[0, 0, 1], [2, 0, 1], [2, 3, 1], [0, 3, 1.0]])
    forces = FollowerPressure.facet_forces(square, jnp.eye(3), 5.0)
    np.testing.assert_allclose(forces, np.tile([0, 0, -5.0 * 6 / 4], (4, 1)), atol=1e-14)
    triangle = FollowerPressure.facet_forces(square[:3], jnp.eye(3), 5.0)
    np.testing.assert_allclose(triangle.sum(axis=0), [0, 0, -5.0 * 3], atol=1e-14)


@pytest.mark.slow
def test_both_engines_agree_under_pressure(bar):
    """A turning bar pressed on one side: reduced by a rich basis and in full."""
    body, faces = bar
    frame = MeanAxisFrame()
    small = reduce(
        body.linearized(), frame, CraigBampton(n_modes=40), derivatives=NoDerivatives(), loads=NoLoads
    )
    load = FollowerPressure(body="bar", faces=faces, pressure=Sine(3e3, 5.0))
    run = Run(0.1, 0.02, step=FixedStep(2e-3), tolerances=TIGHT)
    tips = []
    for own in (small, FullBody(body.linearized(), frame)):
        hinge = Revolute(first=GROUND, second=At("bar", "root"), axis=(0, 1, 0))
        solution = simulate(System([Placed(own)], [hinge], [load]), run)
        tips.append(node_positions(own, solution.bodies["bar"], [int(faces[-1, 1])])[:, 0])
    assert np.ptp(tips[1][:, 2]) > 0.02
    np.testing.assert_allclose(tips[0], tips[1], atol=2e-3 * np.ptp(tips[1][:, 2]))


@pytest.mark.slow
@pytest.mark.parametrize("form", ["reduced", "full"])
def test_an_accelerating_base_is_gravity_the_other_way(bar, form):
    body, _ = bar
    body, frame = body.linearized(), MeanAxisFrame()
    own = FullBody(body, frame)
    if form == "reduced":
        own = reduce(body, frame, CraigBampton(n_modes=5), derivatives=NoDerivatives(), loads=NoLoads)
    clamp = Fixed(first=GROUND, second=At("bar", "root"))
    run = Run(0.02, 0.01, step=FixedStep(1e-3), tolerances=TIGHT)
    acceleration = np.array([1.0, -3.0, 20.0])
    shaken = simulate(System([own], [clamp], [BaseAcceleration(acceleration=acceleration)]), run)
    hung = simulate(System([own], [clamp], gravity=-acceleration), run)
    q, expected = shaken.bodies["bar"].coordinates, hung.bodies["bar"].coordinates
    assert np.abs(expected).max() > 0
    np.testing.assert_allclose(q, expected, atol=1e-9 * np.abs(expected).max())


def test_the_motion_is_that_seen_from_the_base():
    """A free ball on a shaking table stays where it was in space: it moves against the table."""
    ball = RigidBody("ball", 2.0, [0, 0, 0], np.eye(3))
    shaken = BaseAcceleration(acceleration=lambda t: jnp.array([jnp.cos(t), 0.0, 0.0]))
    solution = simulate(System([ball], loads=[shaken]), Run(1.0, 0.1, step=FixedStep(1e-3)))
    table = 1 - np.cos(solution.times)  # its displacement, from rest
    np.testing.assert_allclose(solution.bodies["ball"].position[:, 0], -table, atol=1e-6)


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([[0, 1]], r"must be node indices \(e, 3\) or \(e, 4\), got shape \(1, 2\)"),
        ([[0, 1, 1]], "a face has one node twice"),
        ([[0.0, 1.0, 2.0]], "node indices of faces must be integers"),
        (np.zeros((0, 3), int), r"got shape \(0, 3\)"),
    ],
)
def test_faces_must_be_faces(faces, message):
    with pytest.raises(ModelError, match=message):
        FollowerPressure(body="bar", faces=faces, pressure=1.0)


def test_loads_need_nodes_and_numbers(bar):
    body, faces = bar
    full = FullBody(body, MeanAxisFrame())
    with pytest.raises(ModelError, match="node indices run from 0 to 99999"):
        System([full], loads=[FollowerPressure(body="bar", faces=[[0, 1, 99999]], pressure=1.0)])
    ball = RigidBody("ball", 2.0, [0, 0, 0], np.eye(3))
    with pytest.raises(ModelError, match="a rigid body has no nodes"):
        System([ball], loads=[FollowerPressure(body="ball", faces=[[0, 1, 2]], pressure=1.0)])
    with pytest.raises(ModelError, match="its values over time have shape"):
        System([full], loads=[FollowerPressure(body="bar", faces=faces, pressure=[1.0, 2.0])])
    with pytest.raises(ModelError, match=r"BaseAcceleration: its values over time have shape \(\)"):
        System([full], loads=[BaseAcceleration(acceleration=1.0)])
