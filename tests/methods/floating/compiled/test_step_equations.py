"""Elimination along trees against one dense matrix: machines with branches, loops and extreme numbers."""

from __future__ import annotations

import warnings
from functools import lru_cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import RigidBody
from supple.equations.balance import balance
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import SystemMotion, advance
from supple.errors import RedundantConstraintWarning
from supple.integrate import FixedStep, GeneralizedAlpha, Run, StepRule, Tolerances
from supple.machine import (
    GROUND,
    At,
    Ball,
    Fixed,
    Placed,
    PrescribedRotation,
    Revolute,
    SpringDamper,
    System,
    TorsionSpringDamper,
)
from supple.methods.floating.compiled import step_equations
from supple.methods.floating.compiled.elimination import ByLapack, ByLoops, solve_bordering_column
from supple.methods.floating.compiled.engine import controls, initial_state
from supple.methods.floating.compiled.step_equations import (
    LinearizedStep,
    step_fronts,
    step_matrix,
    tree_layout,
    tree_solution,
)
from supple.methods.floating.compiled.time_step import march
from supple.methods.floating.compiled.tree_elimination import TreeLayout

STEP = 0.01
Z = (0.0, 0.0, 1.0)


def placed(name, start, end, mass=1.0, spin=0.0):
    """A rigid rod from point to point, with interfaces at both ends and beside its middle."""
    start, along = np.asarray(start, dtype=float), np.subtract(end, start)
    inertia = mass * (np.eye(3) * (along @ along + 0.01) - np.outer(along, along)) / 12
    points = {"a": np.zeros(3), "b": along, "beside": along / 2 + [0.0, 0.1, 0.05]}
    rod = RigidBody(name, mass, along / 2, inertia, points)
    return Placed(rod, position=start, angular_velocity=[0, 0, spin], velocity=np.cross([0, 0, spin], start))


def rods(points, masses=None):
    masses = masses or [1.0] * (len(points) - 1)
    return [placed(f"r{i}", *points[i : i + 2], mass) for i, mass in enumerate(masses)]


def balls(n):
    return [Ball(first=At(f"r{i}", "b"), second=At(f"r{i + 1}", "a"), name=f"ball {i}") for i in range(n - 1)]


def on_ground(body, end="a", kind=Ball, **more):
    return kind(first=GROUND, second=At(body, end), name=f"ground {body} {end}", **more)


ZIGZAG = [[i, 0.4 * (i % 2), 0.3 * (i % 3)] for i in range(7)]


def hanging_chain(masses=None):
    return System(rods(ZIGZAG, masses), [on_ground("r0"), *balls(6)], gravity=(0, 0, -9.81))


def held_at_both_ends():
    return System(rods(ZIGZAG), [on_ground("r0"), *balls(6), on_ground("r5", "b")], gravity=(0, 0, -9.81))


def flying_star():
    arms = [
        placed(f"arm {i}", [0, 0, 0.5 * (i > 2)], [np.cos(i), np.sin(i), 0.2 * i], spin=30.0)
        for i in range(5)
    ]
    hub = placed("hub", [0, 0, 0], [0, 0, 0.5], mass=3.0, spin=30.0)
    joints = [
        Revolute(first=At("hub", "a"), second=At(arm.body.name, "a"), axis=(0.1, 1, 0.2), name=arm.body.name)
        for arm in arms[:3]
    ] + [Fixed(first=At(arm.body.name, "a"), second=At("hub", "b"), name=arm.body.name) for arm in arms[3:]]
    return System([arms[0], hub, *arms[1:]], joints)


def ring():
    points = [[np.cos(a), np.sin(a), 0.2 * (i % 2)] for i, a in enumerate(np.linspace(0, 2 * np.pi, 7)[:-1])]
    closing = Ball(first=At("r5", "b"), second=At("r0", "a"), name="closing")
    return System(rods([*points, points[0]]), [*balls(6), closing], gravity=(0, 1, -9.81))


def two_rings_on_the_ground():
    one = ring()
    ring_middle = one.bodies[2].position + one.bodies[2].body.interface("beside").position
    more = [placed("x", [0, 0, 0], [1, 0, 0.0]), placed("y", [0, 0, 0], ring_middle)]
    joints = [
        *one.joints,
        on_ground("x"),
        Ball(first=At("x", "b"), second=At("r0", "a"), name="x r0"),
        Ball(first=At("x", "a"), second=At("y", "a"), name="x y"),
        Ball(first=At("y", "b"), second=At("r2", "beside"), name="y r2"),
    ]
    return System([*one.bodies, *more], joints)


def four_bar():
    """Three of its closing hinge's equations are redundant."""
    points = [[0, 0, 0], [1, 0, 0], [3, 2, 0], [4, 0, 0]]
    joints = [
        on_ground("r0", kind=PrescribedRotation, axis=Z, angle=lambda t: t**2),
        *(
            Revolute(first=At(f"r{i}", "b"), second=At(f"r{i + 1}", "a"), axis=Z, name=f"hinge {i}")
            for i in range(2)
        ),
        on_ground("r2", "b", Revolute, axis=Z),
    ]
    return System(rods(points), joints)


def springs_across():
    base = hanging_chain()
    springs = [
        SpringDamper(first=At("r1", "beside"), second=At("r4", "beside"), stiffness=1e9, damping=10.0),
        SpringDamper(first=At("r0", "beside"), second=At("r2", "beside"), stiffness=10.0),
        TorsionSpringDamper(first=At("r2", "b"), second=At("r3", "a"), axis=Z, stiffness=50.0),
    ]
    return System(base.bodies, base.joints, springs, gravity=base.gravity)


def held_by_springs_alone():
    springs = [
        SpringDamper(first=At(f"r{i}", "beside"), second=At(f"r{i + 1}", "beside"), stiffness=1e4)
        for i in range(5)
    ]
    return System(rods(ZIGZAG), loads=springs)


def two_joints_with_one_parent():
    bodies = [placed(name, [0, 0, 0], [1.0, 0.5, 0.2]) for name in "pqst"]
    pairs = [("p", "q"), ("q", "s"), ("s", "t")]
    joints = [
        Ball(first=At(one, end), second=At(other, end), name=f"{one} {other} {end}")
        for one, other in pairs
        for end in "ab"
    ]
    return System(bodies, [on_ground("p", kind=Fixed), *joints])


def heavy_and_light():
    return hanging_chain([1.0, 1e-6, 1e6, 1e-6, 1.0, 1e6])


def heavy_end():
    return hanging_chain([1e-6] * 5 + [1e3])


MACHINES = [ring]
MORE_MACHINES = [
    hanging_chain,
    four_bar,
    springs_across,
    held_at_both_ends,
    flying_star,
    two_rings_on_the_ground,
    held_by_springs_alone,
    two_joints_with_one_parent,
]
EXTREME = [heavy_and_light, heavy_end]
LOOPS_FIRST = pytest.mark.parametrize(
    "elimination",
    [
        pytest.param(ByLoops(), id="by loops"),
        pytest.param(ByLapack(), id="by LAPACK", marks=pytest.mark.slow),
    ],
)
BOTH = pytest.mark.parametrize("elimination", [ByLapack(), ByLoops()], ids=["by LAPACK", "by loops"])


class Equations(NamedTuple):
    """A model, its layout, and the equations of a step in the midst of its iteration."""

    model: Any
    layout: TreeLayout
    matrix: Any
    fronts: Any
    load: Any


def model_of(system):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RedundantConstraintWarning)
        return initial_state(system, 0.0, STEP)


@lru_cache
def equations(machine):
    """Of a machine by the function that makes it: once for all tests."""
    model, state = model_of(machine())
    increments = 0.05 * np.random.default_rng(5).standard_normal(model.n_velocities)
    found = evaluated(model, state, increments)
    return Equations(model, TreeLayout.of(model), *(np.asarray(item) for item in found))


@partial(jax.jit, compiler_options=STARTING)
def evaluated(model, state, increments):
    """The dense matrix, the fronts and the load: one program for machines that differ in masses."""
    configuration = advance(model, state.configuration, increments)
    velocity = state.velocity + 10 * increments
    motion = SystemMotion(STEP, configuration, velocity, state.acceleration, state.multipliers)
    terms = balance(model, motion)
    factors = StepRule(GeneralizedAlpha(0.8).coefficients, STEP).factors
    step = LinearizedStep(motion, terms.linearization, increments, factors)
    load = jnp.concatenate([terms.residual, terms.constraint_residual])
    return step_matrix(model, step), step_fronts(TreeLayout.of(model), model, step), load


@pytest.fixture
def machine(request):
    return equations(request.param)


def named(machine):
    return machine.__name__


def refined(matrix, load):
    """Solution with residuals in extended precision, (n,)."""
    solution = np.zeros(len(load), dtype=np.longdouble)
    for _ in range(10):
        solution += np.linalg.solve(matrix, (load - matrix.astype(np.longdouble) @ solution).astype(float))
    return solution.astype(float)


def errors(machine, solution):
    """Relative errors of accelerations and of multipliers."""
    exact, n = refined(machine.matrix, machine.load), machine.model.n_velocities
    parts = [(abs(solution - exact)[part], abs(exact)[part]) for part in (slice(0, n), slice(n, None))]
    return np.array([np.max(wrong) / np.max(size) if size.size else 0.0 for wrong, size in parts])


@partial(jax.jit, static_argnums=0, compiler_options=STARTING)
def solved(elimination, model, fronts, load):
    """The dense matrix of fronts, its product with a load, and the solution along the tree."""
    layout = TreeLayout.of(model)
    along_tree = tree_solution(elimination, model, layout, fronts, load)
    return layout.dense(fronts), layout.product(fronts, load), along_tree


@LOOPS_FIRST
@pytest.mark.parametrize(
    "machine",
    [*MACHINES, *(pytest.param(each, marks=pytest.mark.slow) for each in MORE_MACHINES)],
    indirect=True,
    ids=named,
)
def test_solution_is_as_good_as_that_of_the_dense_matrix(machine, elimination):
    model, _, matrix, fronts, load = machine
    size = abs(matrix).max()
    assembled, product, along_tree = map(np.asarray, solved(elimination, model, fronts, load))
    np.testing.assert_allclose(assembled, matrix, rtol=0, atol=1e-15 * size)
    np.testing.assert_allclose(product, matrix @ load, rtol=0, atol=1e-13 * size * abs(load).max())
    along_tree = errors(machine, along_tree)
    dense = errors(machine, solve_bordering_column(np.column_stack([matrix, load])))
    assert np.all(along_tree <= 10 * dense + 1e-11)


@BOTH
@pytest.mark.parametrize("machine", EXTREME, indirect=True, ids=named)
def test_extreme_masses_cost_newton_no_iteration(machine, elimination):
    """Light bodies know their accelerations to eight digits: Newton's iteration gains so many at a time."""
    model, _, _, fronts, load = machine
    assert np.all(errors(machine, np.asarray(solved(elimination, model, fronts, load)[2])) <= 1e-7)


@LOOPS_FIRST
@pytest.mark.parametrize("machine", [hanging_chain, ring], indirect=True)
def test_elimination_leaves_rounding_alone(machine, elimination):
    """Row exchanges within a body and its joint are enough, unless masses differ by many powers of ten."""
    _, layout, matrix, fronts, load = machine
    solution = layout.solved(layout.factored(fronts, elimination), load)
    terms = abs(matrix) @ abs(solution) + abs(load)
    assert np.max(abs(matrix @ solution - load)) <= 1e-12 * np.max(terms)


@pytest.mark.parametrize(
    ("machine", "unknowns"),
    [(hanging_chain, 0), (flying_star, 0), (held_at_both_ends, 3), (ring, 6 + 2 * 3), (four_bar, 5)],
)
def test_loops_alone_make_a_border(machine, unknowns):
    """The equations of a second joint with the ground, or a body with all of its joints."""
    assert TreeLayout.of(model_of(machine())[0]).border == unknowns


@BOTH
def test_a_singular_body_is_left_to_the_dense_matrix(elimination):
    """A first front without inertia, which regular machines may have by chance: elimination divides by 0."""
    model, layout, _, fronts, load = equations(hanging_chain)
    n, fronts = layout.own, fronts.copy()
    fronts[0, :6, :6] = 0.0
    fronts[0, :6, n : n + 6] = fronts[0, n : n + 6, :6] = np.eye(6)
    matrix, _, solution = solved(elimination, model, fronts, load)
    np.testing.assert_allclose(solution, np.linalg.solve(matrix, load))


@LOOPS_FIRST
def test_cases_can_be_mapped_over(elimination):
    """One regular, one left to the dense matrix."""
    model, layout, _, fronts, load = equations(ring)
    singular = fronts.copy()
    singular[0, :6, :6] = 0.0
    both = np.stack([fronts, singular])
    found = jax.jit(jax.vmap(lambda own: tree_solution(elimination, model, layout, own, load)))(both)
    for own, solution in zip(both, found, strict=True):
        expected = np.linalg.solve(layout.dense(own), load)
        np.testing.assert_allclose(solution, expected, rtol=0, atol=1e-9 * abs(expected).max())


def test_small_machines_stay_dense():
    assert tree_layout(model_of(four_bar())[0]) is None


@pytest.mark.slow
def test_motion_is_that_of_the_dense_matrix(monkeypatch):
    settings = controls(Run(0.05, 0.01, step=FixedStep(1e-3), tolerances=Tolerances(1e-10)))
    model, state = model_of(hanging_chain())
    stops = np.linspace(0.01, 0.05, 5)

    def marched():
        end, _ = jax.jit(partial(march, ByLapack()), compiler_options=STARTING)(model, settings, state, stops)
        return end

    monkeypatch.setattr(step_equations, "tree_layout", TreeLayout.of)
    along_tree = marched()
    monkeypatch.setattr(step_equations, "tree_layout", lambda _: None)
    dense = marched()
    origins = dense.configuration.origins
    assert dense.time == stops[-1]
    np.testing.assert_allclose(along_tree.configuration.origins, origins, rtol=0, atol=1e-12)
