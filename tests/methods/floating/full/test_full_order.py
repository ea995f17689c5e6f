"""All freedoms in the sparse engine against the same body in a complete basis, frame by frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import (
    AveragingInterface,
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RayleighDamping,
    RigidBody,
    RigidInterface,
    flexible_body,
)
from supple.errors import ConvergenceError, ModelError
from supple.fem import Isotropic, solid_model
from supple.integrate import AdaptiveStep, FixedStep, Run, Tolerances
from supple.machine import GROUND, At, Ball, DeadForce, FollowerForce, Placed, Revolute, System
from supple.mesh import CellType, block
from supple.reduction import CompleteBasis, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate

# The beam is set in motion, and the joints take the lump along.
pytestmark = pytest.mark.filterwarnings("ignore::supple.errors.StartWarning")

FRAMES = {"nodal-fixed": NodalFixedFrame("root"), "mean-axis": MeanAxisFrame()}
DAMPING = RayleighDamping(alpha=0.2, beta=2e-4)
TIGHT = Tolerances(residual=1e-11)
LENGTH = 1.0


@pytest.fixture(scope="module")
def beam():
    """A soft solid beam along x, Green-Lagrange."""
    model = solid_model(block(LENGTH, 0.2, 0.2, 3, 1, 1, CellType.TETRA4), Isotropic(5e5, 0.3, 1000.0))
    return flexible_body("beam", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


def hanging(body, nodes):
    """The beam on a ball joint, a lump hinged to its tip; gravity, and forces of every kind."""
    lump = RigidBody("lump", 10.0, [0, 0, 0], 0.2 * np.eye(3), {"eye": [-0.2, 0, 0]})
    return System(
        bodies=(
            Placed(body, angular_velocity=[1.2, -2.5, 5.0]),
            Placed(lump, position=[LENGTH + 0.2, 0, 0]),
        ),
        joints=(
            Ball(first=GROUND, second=At("beam", "root"), name="shoulder"),
            Revolute(first=At("beam", "tip"), second=At("lump", "eye"), axis=(0, 1, 0), name="elbow"),
        ),
        loads=(
            DeadForce(body="beam", at=nodes, force=[0.0, 20.0, 5.0]),
            FollowerForce(first=At("beam", "tip"), force=[0.0, 0.0, 30.0]),
        ),
        gravity=(0, 0, -9.81),
    )


def run(body, h=5e-3, duration=0.4, step=None, tolerances=TIGHT, **how):
    options = Run(duration, 0.02, step=step or FixedStep(h), tolerances=tolerances)
    return simulate(hanging(body, [7, 9]), options, **how)


def tip_positions(body, solution):
    """Mean of the tip's nodes, global, (t, 3)."""
    motion = solution.bodies["beam"]
    tip = np.isclose(body.nodes[:, 0], LENGTH)
    local = (body.nodes + body.expand(motion.coordinates))[:, tip].mean(axis=1)
    return motion.position + np.einsum("tij,tj->ti", motion.rotation, local)


@pytest.fixture(scope="module")
def complete(beam):
    """The beam in all of its modes, in both frames."""
    return {
        name: reduce(
            beam, frame, CompleteBasis(), derivatives=NoDerivatives(), damping=DAMPING, loads=NoLoads
        )
        for name, frame in FRAMES.items()
    }


@pytest.fixture(scope="module")
def full(beam):
    return {name: FullBody(beam, frame, DAMPING) for name, frame in FRAMES.items()}


@pytest.fixture(scope="module")
def full_runs(full):
    return {name: run(body) for name, body in full.items()}


@pytest.mark.slow
def test_the_beam_bends(full, full_runs):
    """Guards the comparisons below: rotations of the tip against the root are not small."""
    motion = full_runs["nodal-fixed"].bodies["beam"]
    tip = full["nodal-fixed"].expand(motion.coordinates)[
        :, np.isclose(full["nodal-fixed"].nodes[:, 0], LENGTH)
    ]
    assert np.abs(tip).max() > 0.05 * LENGTH


@pytest.mark.slow
@pytest.mark.parametrize("name", FRAMES)
def test_full_order_is_the_complete_basis_in_other_coordinates(name, full, full_runs, complete):
    """The same discrete equations: equal to what Newton's method leaves."""
    reduced = run(complete[name])
    own = full_runs[name]
    np.testing.assert_allclose(
        tip_positions(full[name], own), tip_positions(complete[name], reduced), atol=1e-9
    )
    for joint in ("shoulder", "elbow"):
        scale = np.abs(reduced.multipliers[joint]).max()
        np.testing.assert_allclose(own.multipliers[joint], reduced.multipliers[joint], atol=1e-6 * scale)
    np.testing.assert_allclose(own.bodies["lump"].rotation, reduced.bodies["lump"].rotation, atol=1e-8)


@pytest.fixture(scope="module")
def loose_ends():
    """The beam with averaging interfaces, which hold nothing rigid; in all of its modes, in both frames."""
    model = solid_model(block(LENGTH, 0.2, 0.2, 3, 1, 1, CellType.TETRA4), Isotropic(5e5, 0.3, 1000.0))
    ends = (AveragingInterface("root", "root"), AveragingInterface("tip", "tip"))
    body = flexible_body("beam", model, ends)
    return [
        reduce(body, frame, CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads)
        for frame in FRAMES.values()
    ]


@pytest.mark.slow
def test_frames_agree_at_order_two(loose_ends):
    """With Green-Lagrange strains the frame is a matter of description; the step's error is all there is.

    (Rigid interfaces turn by linearised rotations, joints see averaged ones: either depends on the frame. A
    ball joint at an averaged point does not.)
    """

    def path(body, h):
        pivot = Ball(first=GROUND, second=At("beam", "root"))
        push = DeadForce(body="beam", at=[7, 9], force=[0.0, 20.0, 5.0])
        system = System((Placed(body, angular_velocity=[0.5, -1.0, 2.0]),), (pivot,), (push,), (0, 0, -9.81))
        solution = simulate(system, Run(duration=0.4, output_step=0.02, step=FixedStep(h), tolerances=TIGHT))
        return tip_positions(body, solution)

    coarse, fine = (np.abs(path(loose_ends[0], h) - path(loose_ends[1], h)).max() for h in (2e-3, 1e-3))
    assert fine < 1e-4
    assert 3.5 < coarse / fine < 4.5


@pytest.mark.slow
def test_linear_full_body_is_the_linear_complete_basis(beam):
    """A body without quadratic strains, gently moved: f = K q."""
    linear, frame = beam.linearized(), FRAMES["mean-axis"]
    full = FullBody(linear, frame, DAMPING)
    complete = reduce(
        linear, frame, CompleteBasis(), derivatives=NoDerivatives(), damping=DAMPING, loads=NoLoads
    )
    system = hanging(full, [7, 9])
    calm = replace(system, bodies=(Placed(full), *system.bodies[1:]))
    same = replace(calm, bodies=(Placed(complete), *system.bodies[1:]))
    paths = [
        tip_positions(
            body, simulate(item, Run(duration=0.1, output_step=0.01, step=FixedStep(5e-3), tolerances=TIGHT))
        )
        for body, item in ((full, calm), (complete, same))
    ]
    np.testing.assert_allclose(paths[0], paths[1], atol=1e-9)


@pytest.mark.slow
def test_adaptive_step_of_the_full_model(full, full_runs):
    """Stays close to the fixed steps, whose own error is of order h^2."""
    body = full["mean-axis"]
    solution = run(body, step=AdaptiveStep(first=1e-3, largest=0.01, tolerance=1e-4))
    path = tip_positions(body, solution)
    np.testing.assert_allclose(path, tip_positions(body, full_runs["mean-axis"]), atol=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("linear", [False, True])
def test_a_resumed_full_run_is_the_uninterrupted_one(full, linear):
    """Bit by bit, also where a linear body's kept factor decides on the iterations."""
    system = hanging(full["nodal-fixed"], [7, 9])
    if linear:  # lightly loaded, for it has no geometric stiffness
        body = full["nodal-fixed"]
        shoulder = Revolute(first=GROUND, second=At("beam", "root"), axis=(0, 1, 0), name="shoulder")
        system = System([replace(body, body=body.body.linearized())], [shoulder], gravity=(0, 0, -1))

    def until(duration, **how):
        options = Run(duration, 0.02, step=FixedStep(5e-3), tolerances=TIGHT)
        return simulate(system, options, **how)

    whole, half = until(0.2), until(0.1)
    rest = until(0.2, resume=half)
    np.testing.assert_array_equal(rest.times, whole.times[6:])
    for name, array in rest.bodies["beam"].arrays().items():
        np.testing.assert_array_equal(array, whole.bodies["beam"].arrays()[name][6:])


@pytest.mark.slow
def test_full_run_can_be_resumed_from_its_motion_alone(full):
    """Same steps but for the auxiliary acceleration, which starts anew: a difference of the step's order."""
    body = full["nodal-fixed"]

    def difference(h):
        whole, half = run(body, h, duration=0.2), run(body, h, duration=0.1)
        rest = run(body, h, duration=0.2, resume=replace(half, engine_state={}))
        np.testing.assert_allclose(rest.times, whole.times[6:])
        return np.abs(tip_positions(body, rest) - tip_positions(body, whole)[6:]).max()

    coarse, fine = difference(5e-3), difference(2.5e-3)
    assert coarse < 1e-4
    assert coarse / fine > 3.0


@pytest.mark.slow
def test_full_run_that_fails_keeps_what_was_recorded(full):
    recorded = []
    with pytest.raises(ConvergenceError, match=r"no convergence at t = 0.* relative residual"):
        run(
            full["nodal-fixed"],
            step=FixedStep(5e-3, smallest=4e-3),
            tolerances=Tolerances(residual=1e-12, max_iterations=1),
            record=recorded.append,
        )
    assert recorded[0].times[0] == 0.0


def test_initial_deformation_must_not_move_the_frame(full):
    body = full["mean-axis"]
    rigid = body.body.rigid_modes[:, 0]
    system = System((Placed(body, coordinates=0.01 * rigid),))
    with pytest.raises(ModelError, match="the initial deformation of body 'beam' moves its frame by"):
        simulate(system, Run(duration=0.1, output_step=0.1))
