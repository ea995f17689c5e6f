"""Modes of a four-bar linkage with a flexible coupler against its constrained eigenproblem, made by hand."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.beam_bodies import rectangle
from scipy.linalg import block_diag, eigh, null_space

from supple.body import FullBody, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.fem import shell_model
from supple.linearization import linearize, machine_modes
from supple.machine import GROUND, At, Placed, Revolute, System, TorsionSpringDamper
from supple.mesh import CellType, Mesh
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce

N = 10
PIVOT, CRANK_PIN, ROCKER_PIN, FOOT = np.array(
    [[0.0, 0.0, 0.0], [0.15, 0.0, 0.26], [1.1, 0.0, 0.59], [1.0, 0.0, 0.0]]
)
LINKS = {"crank": (2.0, PIVOT, CRANK_PIN), "rocker": (3.0, FOOT, ROCKER_PIN)}
INERTIA = np.diag([0.02, 0.05, 0.03])
HOLD = 400.0
"""N m/rad, of the spring at the crank: without it the linkage turns freely."""


@pytest.fixture(scope="module")
def coupler():
    mesh = Mesh(
        np.linspace(CRANK_PIN, ROCKER_PIN, N + 1),
        {CellType.LINE2: np.column_stack([np.arange(N), np.arange(1, N + 1)])},
        node_sets={"left": [0], "right": [N]},
    )
    return shell_model(mesh, rectangle(0.02, 0.03))


def linkage(coupler, form):
    body = flexible_body("coupler", coupler, [RigidInterface(side, side) for side in ("left", "right")])
    frame = NodalFixedFrame("left")
    middle = (
        FullBody(body, frame)
        if form == "full"
        else reduce(body.linearized(), frame, CraigBampton(form), derivatives=NoDerivatives(), loads=NoLoads)
    )
    rigid = []
    for name, (mass, held, pin) in LINKS.items():
        centre = (held + pin) / 2
        points = {"held": held - centre, "pin": pin - centre}
        rigid.append(Placed(RigidBody(name, mass, np.zeros(3), INERTIA, points), position=tuple(centre)))
    ends = [
        (GROUND, At("crank", "held")),
        (At("crank", "pin"), At("coupler", "left")),
        (At("coupler", "right"), At("rocker", "pin")),
        (At("rocker", "held"), GROUND),
    ]
    joints = [Revolute(first=first, second=second, axis=(0, 1, 0)) for first, second in ends]
    spring = TorsionSpringDamper(
        first=GROUND, second=At("crank", "held"), axis=(0, 1, 0), stiffness=HOLD, damping=0.0
    )
    return System((*rigid, Placed(middle)), joints, (spring,))


def frequencies_by_hand(coupler):
    """`K v = w^2 M v` of two rigid links and the beams, on the null space of the joints' rows; rad/s."""
    size = 12 + coupler.n_dofs

    def motion(first, arm):
        """(6, size) of a point: u + theta x arm, and theta."""
        rows = np.zeros((6, size))
        rows[:, first : first + 6] = np.eye(6)
        rows[:3, first + 3 : first + 6] = np.cross(np.eye(3), arm).T
        return rows

    link = {name: (6 * i, (held - pin) / 2) for i, (name, (_, held, pin)) in enumerate(LINKS.items())}
    left, right = motion(12, np.zeros(3)), motion(12 + 6 * N, np.zeros(3))
    (crank, arm), (rocker, other) = link.values()
    hinges = [
        motion(crank, arm),
        motion(crank, -arm) - left,
        motion(rocker, -other) - right,
        motion(rocker, other),
    ]
    held = [0, 1, 2, 3, 5]  # all but the turn about y
    free = null_space(np.vstack([hinge[held] for hinge in hinges]))
    bodies = [block_diag(mass * np.eye(3), INERTIA) for mass, _, _ in LINKS.values()]
    mass = block_diag(*bodies, coupler.mass.toarray())
    stiffness = block_diag(np.zeros((12, 12)), coupler.stiffness.toarray())
    stiffness[4, 4] += HOLD
    squares = eigh(free.T @ stiffness @ free, free.T @ mass @ free, eigvals_only=True)
    assert squares[0] > 0
    return np.sqrt(squares)


@pytest.mark.slow
@pytest.mark.parametrize(("form", "tolerance"), [("full", 1e-7), (6 * N - 6, 1e-7), (8, 2e-3)])
def test_a_four_bar_with_a_flexible_coupler_has_the_modes_of_its_equations(coupler, form, tolerance):
    """In full and by all modes the same numbers; by eight modes from above."""
    exact = frequencies_by_hand(coupler)[:5]
    found = machine_modes(linearize(linkage(coupler, form)), 5 if form == "full" else None).frequencies[:5]
    assert found == pytest.approx(exact, rel=tolerance)
    assert (found > exact * (1 - 1e-7)).all()
