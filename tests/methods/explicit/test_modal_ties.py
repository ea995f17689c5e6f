"""Modal sub-domains tied to each other: continuity, momenta, balance, accuracy, step limit, refusals."""

from functools import cache, partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, stepped
from fixtures.frame_momentum import nodal_momentum
from jax import lax
from scipy import linalg

from supple.body import AveragingInterface, flexible_body
from supple.errors import ModelError
from supple.fem import solid_model
from supple.integrate import Run, run
from supple.machine import (
    At,
    DeadForce,
    EveryNode,
    MeanMotion,
    Placed,
    System,
    Tie,
)
from supple.mesh import CellType, Mesh, block
from supple.methods.explicit import (
    ENERGIES,
    ExplicitEngine,
    ModalSubdomain,
    ProjectedDifference,
    PublishedScheme,
    explicit_subdomain,
    modal_subdomain,
)
from supple.methods.explicit.frame_model import Generalized, StepLengths
from supple.methods.explicit.march.frame_step import joining_rows
from supple.methods.explicit.modal_tie import tied_gap
from supple.reduction import NormalModes, Rubin

SPIN = (0.05, 0.02, 0.2)


def _model(start, length, cells):
    mesh = block(length, 1, 1, *cells, CellType.TETRA4)
    return solid_model(Mesh(mesh.nodes + np.array([start, 0, 0]), mesh.cells, mesh.node_sets), SOFT)


@cache
def half(name, start, cells=(4, 2, 2), shift=0.0):
    """A half of a bar of 8 x 1 x 1 with the static answers at its ends."""
    ends = [AveragingInterface(end, end) for end in ("root", "tip")]
    return modal_subdomain(flexible_body(name, _model(start + shift, 4, cells), ends), Rubin(4))


LEFT, RIGHT = ("left", 0), ("right", 4)


@cache
def whole_basis(name, start, length, cells):
    """All modes of a coarse bar."""
    model = _model(start, length, cells)
    return modal_subdomain(flexible_body(name, model), NormalModes(model.n_dofs - 6))


def pair(
    first, second, continuity=None, spin=SPIN, velocity=(0.1, 0, 0), parts=(), ties=(), push=(0.0, 0.0, 0.0)
):
    """Two halves that fly as one; the push is there always, so that all marches are one program."""
    flight = {"angular_velocity": spin, "velocity": velocity}
    tie = Tie(At("left", "tip"), "right", continuity=continuity or MeanMotion())
    return System(
        [Placed(first, **flight), Placed(second, **flight), *parts],
        ties=[tie, *ties],
        loads=[DeadForce(at="right.tip", force=push)],
    )


def marched(system, span, n=8, **options):
    own = Run(span, span / n)
    engine = ExplicitEngine(system, stepped(own, **options))
    return engine, run(engine, own.times)


def balance(solution):
    e = solution.series[ENERGIES]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    return np.abs(total - total[0]).max() / np.abs(e).max()


def modal_momenta(engine, solution, name):
    """Linear and angular momentum (t, 6) over the step before each output time, from the nodes."""
    old, push = nodal_momentum(engine, solution.times, name)
    return np.column_stack([push.sum(axis=1), np.cross(old, push).sum(axis=1)])[1:]


def interface(system, solution):
    """Positions (t, n, 3) of the joint's nodes, as each half places them; the same mesh on both sides."""
    sides = []
    for name, nodes in (("left", "tip"), ("right", "root")):
        part = system.placed(name).body
        numbers = part.mesh.node_sets[nodes]
        order = np.lexsort(part.mesh.nodes[numbers].T)
        sides.append(part.positions(solution.bodies[name], numbers[order]))
    return sides


@pytest.fixture(scope="module")
def flight():
    system = pair(half(*LEFT), half(*RIGHT))
    return system, *marched(system, 40.0)


@pytest.mark.slow
def test_halves_that_fly_and_spin_keep_both_momenta_and_the_balance(flight):
    _, engine, solution = flight
    p = sum(modal_momenta(engine, solution, name) for name in ("left", "right"))
    assert np.abs(p - p[0]).max() < 1e-12 * np.abs(p).max()
    assert balance(solution) < 1e-12
    # They stretch and bend as they spin: the test is one of deformed parts.
    assert np.abs(solution.bodies["left"].coordinates[1:]).max() > 1e-3


@pytest.mark.slow
def test_mean_displacement_and_mean_turn_of_the_joint_are_equal(flight):
    system, _, solution = flight
    left, right = interface(system, solution)
    gap, size = left - right, np.abs(left).max()
    local = gap @ solution.bodies["right"].rotation
    X = left[0]
    turn = np.cross(X - X.mean(axis=0), local).mean(axis=1)
    assert np.abs(gap.mean(axis=1)).max() < 1e-13 * size
    assert np.abs(turn).max() < 1e-13 * size
    assert 1e-6 < np.abs(gap).max() < 5e-3  # of a side of 1: sections may warp apart


@pytest.mark.slow
def test_meshes_that_do_not_match_keep_momenta_and_balance():
    system = pair(half(*LEFT), half(*RIGHT, cells=(3, 3, 3)))
    engine, solution = marched(system, 10.0)
    p = sum(modal_momenta(engine, solution, name) for name in ("left", "right"))
    assert np.abs(p - p[0]).max() < 1e-12 * np.abs(p).max()
    assert balance(solution) < 1e-12


def bent(system, name, **options):
    """Mean displacement (t, 3) of the tip of a part over 1.5 periods of the first bending mode of the bar."""
    solution = marched(system, 1.5 * PERIOD, **options)[1]
    part = system.placed(name).body
    tip = part.mesh.node_sets["tip"]
    return (part.positions(solution.bodies[name], tip) - part.nodes[tip]).mean(axis=1)


PUSH = (0.0, 2e-3, 1e-3)
PERIOD = 5.0
"""Of the first bending mode, about: omega_1 = 1.25."""


@pytest.mark.slow
def test_a_bar_cut_in_two_moves_like_one_modal_part_and_like_explicit_elements():
    """A pushed free bar. A mean joint lets its sections warp; nodal mass is lumped in explicit elements."""
    model = _model(0, 8, (8, 2, 2))
    ends = [AveragingInterface("tip", "tip")]
    whole = modal_subdomain(flexible_body("one", model, ends), Rubin(10))
    two = bent(pair(half(*LEFT), half(*RIGHT), spin=(0, 0, 0), velocity=(0, 0, 0), push=PUSH), "right")
    one = bent(System([whole], loads=[DeadForce(at="one.tip", force=PUSH)]), "one")
    fe = explicit_subdomain(model, name="fe")
    nodal = bent(System([fe], loads=[DeadForce(at="fe.tip", force=PUSH)]), "fe")
    size = np.abs(one).max()
    assert np.abs(two - one).max() < 0.01 * size
    assert np.abs(two - nodal).max() < 0.04 * size


@partial(jax.jit, static_argnums=0)
def _flown(pairs, model, states, step, n):
    none = tuple(Generalized(jnp.zeros((4, 3)), jnp.zeros_like(at.y)) for at in states)
    models = tuple(arrays.model for arrays in model.frames)

    def gaps(moved):
        found = zip(model.ties, pairs, strict=True)
        return jnp.concatenate([tied_gap(tie, moved[a], moved[b]) for tie, (a, b) in found])

    def one(_, at):
        rows = joining_rows(model, pairs, at, 0.0)
        return ProjectedDifference().step_joined(models, at, none, rows, gaps, StepLengths(step, step))[0]

    return lax.fori_loop(0, n, one, states)


def flown(built, step, n, rates=1e-6):
    """Frames that vibrate from the start, n steps later."""
    states = tuple(at._replace(vy=jnp.full(len(at.y), rates)) for at in built.start.frames)
    return _flown(built.methods.tied, built.model, states, step, n)


@pytest.mark.slow
def test_with_all_modes_and_every_node_the_cut_bar_is_the_bar_itself():
    """Its largest frequency is that of the bar, and all nodes of the joint meet."""
    left, right = whole_basis("left", 0, 4, (2, 1, 1)), whole_basis("right", 4, 4, (2, 1, 1))
    built = ExplicitEngine(pair(left, right, EveryNode()), Run(1.0, 1.0)).built
    assert sum(len(tie.first.weights) for tie in built.model.ties) == 3 * 4
    limit = float(built.model.frames[0].step_limit)
    one = whole_basis("one", 0, 8, (4, 1, 1))
    assert limit == pytest.approx(one.step_limit, rel=1e-9)
    assert limit > 1.001 * min(left.step_limit, right.step_limit)
    after = flown(built, 0.9 * limit, 2000, rates=1e-2)
    sides = []
    for part, frame, nodes in zip((left, right), after, ("tip", "root"), strict=True):
        numbers = part.body.model.mesh.node_sets[nodes]
        local = part.shapes[numbers] @ (built.frames[part.name].turned @ np.asarray(frame.y))
        P = np.asarray(frame.p[1:] - frame.p[0])
        sides.append(part.points.weights(part.body.nodes[numbers]) @ np.asarray(frame.p) + local @ P)
        assert np.abs(local).max() > 1e-4
    order = [
        np.lexsort(part.body.nodes[part.body.model.mesh.node_sets[nodes]].T)
        for part, nodes in ((left, "tip"), (right, "root"))
    ]
    assert np.abs(sides[0][order[0]] - sides[1][order[1]]).max() < 1e-13 * 8


@pytest.mark.slow
def test_the_step_limit_of_tied_parts_is_that_of_their_common_pencil():
    system = pair(half(*LEFT), half(*RIGHT), spin=(0, 0, 0), velocity=(0, 0, 0))
    built = ExplicitEngine(system, Run(1.0, 1.0)).built
    limit = float(built.model.frames[0].step_limit)
    assert limit >= min(frame.step_limit() for frame in built.frames.values())  # a tie raises no frequency

    def reached(step, n):
        return max(float(jnp.abs(at.y).max()) for at in flown(built, step, n))

    assert reached(0.98 * limit, 4000) < 1e-4
    assert not reached(1.02 * limit, 600) < 1e-2


def test_ties_that_close_a_loop_keep_what_is_independent():
    """Rigid parts joined twice: twelve combinations, six of them said before."""
    bases = [whole_basis("left", 0, 4, (2, 1, 1)), whole_basis("right", 4, 4, (2, 1, 1))]
    left, right = (ModalSubdomain(own.body, np.zeros((own.body.n, 0)), np.zeros(0)) for own in bases)
    system = pair(left, right, ties=[Tie(At("left", "tip"), "right", continuity=EveryNode())])
    built = ExplicitEngine(system, stepped(Run(1.0, 1.0), step=0.01)).built
    assert sum(len(tie.first.weights) for tie in built.model.ties) == 6
    after = flown(built, 0.01, 500)
    # Both turn as one body.
    turns = [np.asarray(at.p[1:] - at.p[0]) / part.points.arm for at, part in zip(after, bases, strict=True)]
    assert np.abs(turns[0] - turns[1]).max() < 1e-12
    assert np.abs(turns[0] - np.eye(3)).max() > 0.5


@pytest.mark.slow
def test_an_explicit_end_on_one_of_two_tied_parts_shares_their_momentum():
    end = Placed(
        explicit_subdomain(_model(8, 2, (2, 2, 2)), name="end"), angular_velocity=SPIN, velocity=(0.1, 0, 0)
    )
    system = pair(half(*LEFT), half(*RIGHT), parts=[end], ties=[Tie(At("end", "root"), "right")])
    engine, solution = marched(system, 10.0, 4, largest_ratio=1)
    p = sum(modal_momenta(engine, solution, name) for name in ("left", "right"))
    h = solution.series["steps"][1:, 0, None, None]
    motion = solution.bodies["end"]
    m = np.asarray(engine.built.model.mass)[engine.built.nodes["end"]][:, None]
    push = m * motion.velocities[1:]
    x = motion.nodes[1:] - h * motion.velocities[1:]
    p = p + np.column_stack([push.sum(axis=1), np.cross(x, push).sum(axis=1)])
    assert np.abs(p - p[0]).max() < 1e-11 * np.abs(p).max()
    assert balance(solution) < 1e-10


def test_mean_motion_is_the_rigid_motion_that_fits_best():
    points = np.random.default_rng(0).uniform(size=(7, 3))
    L = MeanMotion().patterns(points, np.zeros((21, 0)))
    assert len(L) == 6
    shift, turn = np.array([0.1, -0.2, 0.3]), np.array([0.3, 0.1, -0.2])
    rigid = (shift + np.cross(turn, points)).ravel()
    rows = L.reshape(6, -1)
    assert rows @ rows.T == pytest.approx(np.eye(6), abs=1e-12)
    assert rows.T @ (rows @ rigid) == pytest.approx(rigid, abs=1e-12)
    assert len(MeanMotion().patterns(np.outer(np.arange(4.0), [1, 2, 3]), np.zeros((12, 0)))) == 5
    assert len(MeanMotion().patterns(points[:1], np.zeros((3, 0)))) == 3


def test_every_node_leaves_out_what_follows_from_the_rest():
    rng = np.random.default_rng(0)
    reach = rng.normal(size=(12, 5))
    L = EveryNode().patterns(np.zeros((4, 3)), reach)
    assert L.shape == (5, 4, 3)
    assert linalg.subspace_angles(L.reshape(5, 12).T, reach).max() < 1e-12


def test_what_cannot_be_tied_is_refused():
    left, right = half(*LEFT), half(*RIGHT)
    with pytest.raises(ModelError, match="need ProjectedDifference"):
        marched(pair(left, right), 1.0, scheme=PublishedScheme())
    with pytest.raises(ModelError, match=r"differ by 1;"):
        marched(
            System([Placed(left, velocity=(1, 0, 0)), right], ties=[Tie(At("left", "tip"), "right")]), 1.0
        )
    fe = explicit_subdomain(_model(8, 2, (2, 2, 2)), name="end")
    with pytest.raises(ModelError, match="'end' is explicit; tie the nodes of 'end'"):
        marched(System([right, fe], ties=[Tie(At("right", "tip"), "end")]), 1.0)
    with pytest.raises(ModelError, match="cannot be tied to itself"):
        marched(System([right], ties=[Tie(At("right", "tip"), "right")]), 1.0)
    with pytest.raises(ModelError, match="does not match the other"):
        marched(pair(left, half(*RIGHT, shift=0.5)), 1.0)
    with pytest.raises(ModelError, match="tolerance of a tie"):
        EveryNode(0.0)


def test_an_explicit_node_hangs_on_one_modal_part():
    """A pin through the joint of two halves, tied on both: its mass would count twice."""
    pin = explicit_subdomain(_model(4, 2, (2, 2, 2)), name="pin")
    ties = [Tie(At("pin", "root"), name) for name in ("left", "right")]
    flying = Placed(pin, angular_velocity=SPIN, velocity=(0.1, 0, 0))
    system = pair(half(*LEFT), half(*RIGHT), parts=[flying], ties=ties)
    with pytest.raises(ModelError, match="is tied to 'left' and 'right'"):
        marched(system, 1.0)
