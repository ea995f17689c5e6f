"""The linear equations of Newton's iteration within a step, and their solution.

Unknown are the changes of accelerations and multipliers. With `k = beta h^2 kappa` the constraint equations
are divided by `k`, so that every row of

    [ S    G^T ] [ d vdot   ]     [ residual ]
    [ G_T  0   ] [ d lambda ] = - [ g / k    ]

has the size of a force or an acceleration whatever the step: the index-3 equations stay as well conditioned
for h to 0 as the mass matrix (Bottasso, Bauchau & Cardona 2007). Small machines are solved as one dense
matrix, others along their tree; where that leaves more than rounding, as one dense matrix after all.
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

__all__ = [
    "LinearizedStep",
    "correction",
    "step_fronts",
    "step_inverse",
    "step_matrix",
    "tree_layout",
    "tree_solution",
]

_LEAST = 4
"""Bodies below which a dense matrix is always solved faster."""
_LOOP = 1e4
"""Multiplications that take as long as what else the elimination of a body does: four rigid rods on balls are
faster as one matrix (32 us a step, 42 along the tree), eight along the tree (70 us, 107)."""


_ROUNDING = 1e-13
"""What a solution leaves, in parts of the terms in its equations by kind of row, where rounding alone is at
work; a solution along the tree is refined where it leaves more [ArioliDemmelDuff1989], and then until it
has left no more twice: small multipliers beside large ones are right one pass after the residual is small."""
_REFINEMENTS = 4
_INEXACT = 1e-11
"""What refinement may leave before the whole matrix is eliminated with row exchanges instead."""


class LinearizedStep(NamedTuple):
    """Where the equations are linearised."""

    motion: SystemMotion
    linearization: Linearization
    increments: jax.Array
    """(n,), those that led to the configuration"""
    factors: StepFactors


def tree_layout(model: Model) -> TreeLayout | None:
    """The layout by which a machine is eliminated; None where one dense matrix costs less."""
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
    """Changes of accelerations and multipliers (n + m,) that take away the residuals (n,) and (m,)."""
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
    """What `correction` gives for residuals (n,) and (m,), eliminated once for many of them, not refined."""
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
    """A solution and what it leaves."""

    solution: jax.Array
    rest: jax.Array
    part: jax.Array
    """Of the terms in the equations, the rest"""
    part_before: jax.Array
    passes: jax.Array


def tree_solution(
    elimination: DenseElimination, model: Model, layout: TreeLayout, fronts: jax.Array, load: jax.Array
) -> jax.Array:
    """Solution along the tree, refined; with row exchanges across the whole matrix where that is inexact.

    Loops where branches would do: of a batch, all cases take a branch that one of them takes, and always.
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
    # Asked this way round, what is not a number is inexact.
    _, solution = jax.lax.while_loop(
        lambda known: known[0],
        lambda _: (jnp.zeros((), dtype=bool), _dense_solution(elimination, layout.dense(fronts), load)),
        (~(along_tree.part <= _INEXACT), along_tree.solution),
    )
    return solution


def step_matrix(model: Model, step: LinearizedStep) -> jax.Array:
    """The matrix of the equations, (n + m, n + m), multipliers in parts of the machine's mass."""
    matrix = tangent(model, *step)
    rows = constraint_rows(model, step.linearization.joints)
    by_increment = constraint_rows(model, step.linearization.joints, step.increments)
    m = len(model.active)
    return jnp.block([[matrix, model.mass * rows.T], [model.mass * by_increment, jnp.zeros((m, m))]])


def step_fronts(layout: TreeLayout, model: Model, step: LinearizedStep) -> jax.Array:
    """The same matrix as fronts, (nb + 1, T, T)."""
    blocks = tangent_blocks(model, *step)
    joints = step.linearization.joints
    for block in constraint_blocks(model, joints):
        own = _kept(model, block)
        blocks.append(MatrixBlock(own.columns, own.rows, jnp.swapaxes(own.values, 1, 2)))
    blocks += [_kept(model, block) for block in constraint_blocks(model, joints, step.increments)]
    return layout.fronts(blocks)


def _kept(model: Model, block: MatrixBlock) -> MatrixBlock:
    """Constraint equations in parts of the mass, behind the velocities; zero where they are redundant."""
    values = model.mass * block.values
    if len(model.active) < model.n_equations:
        kept = np.zeros(model.n_equations)
        kept[np.array(model.active, dtype=int)] = 1.0
        values = values * kept[block.rows.index][:, :, None]
    starts = tuple(model.n_velocities + start for start in block.rows.starts)
    return MatrixBlock(Places(starts, block.rows.size), block.columns, values)
