"""The linear equations of Newton's iteration within a step, and their solution.

The unknowns are the changes of accelerations and multipliers. With `k = beta h^2 kappa` the constraint
equations are divided by `k`, so that every row of

    [ S    G^T ] [ d vdot   ]     [ residual ]
    [ G_T  0   ] [ d lambda ] = - [ g / k    ]

has the size of a force or an acceleration for every step: for h to 0 the index-3 equations stay as well
conditioned as the mass matrix (Bottasso, Bauchau & Cardona 2007). Small machines are solved as one dense
matrix, others along their tree; a tree solution that refinement leaves inexact is replaced by a dense one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.balance import Linearization, tangent, tangent_blocks
from supple.equations.configuration import SystemMotion
from supple.equations.coordinate_scales import kinds_of_rows
from supple.equations.joint_force import constraint_blocks, constraint_rows
from supple.equations.machine_model import Model
from supple.equations.places import MatrixBlock, Places
from supple.integrate import StepFactors
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.tree_elimination import TreeLayout

_LEAST = 4
"""Number of bodies below which a dense matrix is always faster."""
_LOOP = 1e4
"""Overhead of the elimination of one body, as a number of multiplications: four rigid rods on ball joints are
faster as one matrix (32 us a step, 42 along the tree), eight along the tree (70 us, 107)."""


_ROUNDING = 1e-13
"""Residual due to rounding alone, relative to the terms of the equations, by kind of row. A tree solution
with a larger residual is refined [ArioliDemmelDuff1989] until two passes stay below this limit: small
multipliers beside large ones are accurate one pass after the residual is small."""
_REFINEMENTS = 4
"""Largest number of refinements of a tree solution."""
_INEXACT = 1e-11
"""Residual after refinement above which the whole matrix is eliminated with row exchanges instead."""


class LinearizedStep(NamedTuple):
    """Point of linearisation of the equations of a step."""

    motion: SystemMotion
    linearization: Linearization
    increments: jax.Array
    """(n,) increments that led to the configuration"""
    factors: StepFactors


def tree_layout(model: Model) -> TreeLayout | None:
    """Layout for the elimination along the tree; None where one dense matrix costs less."""
    if len(model.sizes) < _LEAST:
        return None
    layout = TreeLayout.of(model)
    n = model.n_velocities + len(model.active)
    along_tree = layout.operations + _LOOP * layout.n_bodies
    return layout if along_tree < n**3 / 3 + 10 * n**2 else None


def correction(
    elimination: DenseElimination,
    model: Model,
    step: LinearizedStep,
    residual: jax.Array,
    constraint_residual: jax.Array,
) -> jax.Array:
    """Changes of accelerations and multipliers (n + m,) that cancel the residuals (n,) and (m,)."""
    load = _load(model, step, residual, constraint_residual)
    layout = tree_layout(model)
    if layout is None:
        change = _dense_solution(elimination, step_matrix(model, step), load)
    else:
        change = tree_solution(elimination, model, layout, step_fronts(layout, model, step), load)
    n = model.n_velocities
    return change.at[n:].multiply(model.mass)


def _load(
    model: Model, step: LinearizedStep, residual: jax.Array, constraint_residual: jax.Array
) -> jax.Array:
    """The right-hand side (n + m,)."""
    return -jnp.concatenate([residual, model.mass / step.factors.by_position * constraint_residual])


def step_inverse(
    elimination: DenseElimination, model: Model, step: LinearizedStep
) -> Callable[[jax.Array, jax.Array], jax.Array]:
    """A function equal to `correction`, factored once for many residuals (n,) and (m,); no refinement."""
    layout, n = tree_layout(model), model.n_velocities
    if layout is None:
        inverse = elimination.inverse(step_matrix(model, step))
        solved = partial(jnp.matmul, inverse)
    else:
        solved = partial(layout.solved, layout.factored(step_fronts(layout, model, step), elimination))

    def corrected(residual: jax.Array, constraint_residual: jax.Array) -> jax.Array:
        return solved(_load(model, step, residual, constraint_residual)).at[n:].multiply(model.mass)

    return corrected


def _dense_solution(elimination: DenseElimination, matrix: jax.Array, load: jax.Array) -> jax.Array:
    return elimination.solution(jnp.concatenate([matrix, load[:, None]], axis=1))


class _Refined(NamedTuple):
    """A solution and its residual."""

    solution: jax.Array
    rest: jax.Array
    part: jax.Array
    """Residual relative to the terms of the equations"""
    part_before: jax.Array
    passes: jax.Array


def tree_solution(
    elimination: DenseElimination, model: Model, layout: TreeLayout, fronts: jax.Array, load: jax.Array
) -> jax.Array:
    """Solution along the tree, refined; by elimination of the whole matrix where it stays inexact.

    Loops instead of branches: in a batch, all cases would compute a branch that one case takes.
    """
    factor = layout.factored(fronts, elimination)
    sizes = jnp.abs(fronts)
    m = len(model.active)
    kinds = np.block([[kinds_of_rows(model), np.zeros((3, m))], [np.zeros(model.n_velocities), np.ones(m)]])

    def refined(old: _Refined) -> _Refined:
        solution = old.solution + layout.solved(factor, old.rest)
        rest = load - layout.product(fronts, solution)
        terms = layout.product(sizes, jnp.abs(solution)) + jnp.abs(load)
        left, there = (jnp.max(kinds * jnp.abs(vector), axis=1) for vector in (rest, terms))
        part = jnp.max(left / jnp.where(there > 0, there, 1.0))
        return _Refined(solution, rest, part, old.part, old.passes + 1)

    def unfinished(old: _Refined) -> jax.Array:
        refined_once = (old.passes > 1) & (old.part_before > _ROUNDING)
        return ((old.part > _ROUNDING) | refined_once) & (old.passes <= _REFINEMENTS)

    infinite = jnp.asarray(jnp.inf)
    none = _Refined(jnp.zeros_like(load), load, infinite, infinite, jnp.asarray(0))
    along_tree = jax.lax.while_loop(unfinished, refined, none)
    # With this comparison NaN counts as inexact.
    _, solution = jax.lax.while_loop(
        lambda known: known[0],
        lambda _: (jnp.zeros((), dtype=bool), _dense_solution(elimination, layout.dense(fronts), load)),
        (~(along_tree.part <= _INEXACT), along_tree.solution),
    )
    return solution


def step_matrix(model: Model, step: LinearizedStep) -> jax.Array:
    """Matrix of the equations, (n + m, n + m), with multipliers relative to the machine's mass."""
    matrix = tangent(model, *step)
    rows = constraint_rows(model, step.linearization.joints)
    by_increment = constraint_rows(model, step.linearization.joints, step.increments)
    m = len(model.active)
    return jnp.block([[matrix, model.mass * rows.T], [model.mass * by_increment, jnp.zeros((m, m))]])


def step_fronts(layout: TreeLayout, model: Model, step: LinearizedStep) -> jax.Array:
    """The matrix of `step_matrix` as fronts, (nb + 1, T, T)."""
    blocks = tangent_blocks(model, *step)
    joints = step.linearization.joints
    for block in constraint_blocks(model, joints):
        own = _kept(model, block)
        blocks.append(MatrixBlock(own.columns, own.rows, jnp.swapaxes(own.values, 1, 2)))
    blocks += [_kept(model, block) for block in constraint_blocks(model, joints, step.increments)]
    return layout.fronts(blocks)


def _kept(model: Model, block: MatrixBlock) -> MatrixBlock:
    """Block of constraint equations times the mass, numbered after the velocities; zero where redundant."""
    values = model.mass * block.values
    if len(model.active) < model.n_equations:
        kept = np.zeros(model.n_equations)
        kept[np.array(model.active, dtype=int)] = 1.0
        values = values * kept[block.rows.index][:, :, None]
    starts = tuple(model.n_velocities + start for start in block.rows.starts)
    return MatrixBlock(Places(starts, block.rows.size), block.columns, values)
