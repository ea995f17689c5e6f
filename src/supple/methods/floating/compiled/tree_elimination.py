"""Elimination of the linear equations of a step along a tree, one body after another.

Each body has a front: the part of the matrix with its own unknowns (velocities and the multipliers of its
joint), the velocities of its parent, and the border. After the elimination of its children, with `o` for the
unknowns of the body and `q` for those of parent and border,

    F = [ F_oo  F_oq ]      F_oo^-1,   up = F_oo^-1 F_oq,   down = F_qo F_oo^-1
        [ F_qo  0    ]      remainder for its parent:  - F_qo F_oo^-1 F_oq

All fronts have one size, with decoupled unknowns at unused places, so that one loop eliminates all bodies.
The work is proportional to the number of bodies; the size of the program does not depend on it. `F_oo` is
inverted with row exchanges. `F_oo` is regular, because a body on its joint with a fixed parent has inertia in
every remaining direction. Source: multifrontal elimination [DuffReid1983].
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.elimination_tree import EliminationTree, elimination_tree
from supple.equations.machine_model import Model
from supple.equations.places import MatrixBlock
from supple.methods.floating.compiled.elimination import DenseElimination


class TreeFactor(NamedTuple):
    """Factors of one matrix, for any load; N and Q are the numbers of unknowns `o` and `q` of a front."""

    inverses: jax.Array
    """(nb, N, N)"""
    ups: jax.Array
    """(nb, N, Q)"""
    downs: jax.Array
    """(nb, Q, N)"""
    border: jax.Array
    """Inverse of the remainder for the border, (b, b)"""


@dataclass(frozen=True)
class TreeLayout:
    """Position of a machine's unknowns in the fronts: velocities, then all constraint equations."""

    tree: EliminationTree
    sizes: tuple[int, ...]
    n_equations: int
    active: tuple[int, ...]

    @classmethod
    def of(cls, model: Model) -> TreeLayout:
        """Layout of a machine, from the part of the model that is constant in a compiled program."""
        return cls(elimination_tree(model), model.sizes, model.n_equations, model.active)

    @property
    def n_bodies(self) -> int:
        """Number of bodies in the trees."""
        return len(self.tree.bodies)

    @cached_property
    def n_velocities(self) -> int:
        """Number of velocities of all bodies."""
        return sum(6 + r for r in self.sizes)

    @cached_property
    def own(self) -> int:
        """Largest number `N` of unknowns of a body and its joint."""
        joints = [sum(rows.size for rows in own) for own in self.tree.rows]
        return max(6 + self.sizes[body] + m for body, m in zip(self.tree.bodies, joints, strict=True))

    @cached_property
    def parent(self) -> int:
        """Largest number of velocities of a parent, 0 where no body has one."""
        inner = [place for place in self.tree.parents if place < self.n_bodies]
        return max((6 + self.sizes[self.tree.bodies[place]] for place in inner), default=0)

    @cached_property
    def border(self) -> int:
        """Number `b` of the border's unknowns."""
        bodies = sum(6 + self.sizes[body] for body in self.tree.border_bodies)
        return bodies + sum(rows.size for rows in self.tree.border_rows)

    @property
    def operations(self) -> float:
        """Approximate number of multiplications of one factorisation."""
        others = self.parent + self.border
        each = self.own * (self.own**2 + 2 * self.own * others + others**2)
        return self.n_bodies * each + self.border**3

    @cached_property
    def _pieces(self) -> dict[int, tuple[int, int, int]]:
        """Front, offset and size of each piece of unknowns, by its start; front nb is the border."""
        starts = np.cumsum([0, *(6 + r for r in self.sizes)])
        found = {}
        holders = [
            (front, [body], rows)
            for front, (body, rows) in enumerate(zip(self.tree.bodies, self.tree.rows, strict=True))
        ]
        for front, bodies, rows in [
            *holders,
            (self.n_bodies, self.tree.border_bodies, self.tree.border_rows),
        ]:
            pieces = [(int(starts[body]), 6 + self.sizes[body]) for body in bodies]
            pieces += [(self.n_velocities + own.starts[0], own.size) for own in rows]
            offset = 0
            for start, size in pieces:
                found[start] = front, offset, size
                offset += size
        return found

    @cached_property
    def _index(self) -> tuple[np.ndarray, np.ndarray]:
        """Number of the unknown at each place of a front (nb, N) and of the border (b,); -1 for none."""
        own = np.full((self.n_bodies, self.own), -1)
        border = np.full(self.border, -1)
        for start, (front, offset, size) in self._pieces.items():
            target = border if front == self.n_bodies else own[front]
            target[offset : offset + size] = np.arange(start, start + size)
        return own, border

    @cached_property
    def _place(self) -> np.ndarray:
        """Places of the unknowns (velocities, active multipliers) in the concatenated fronts."""
        own, border = self._index
        everything = np.concatenate([own.reshape(-1), border])
        place = np.zeros(self.n_velocities + self.n_equations, dtype=int)
        place[everything[everything >= 0]] = np.flatnonzero(everything >= 0)
        active = self.n_velocities + np.array(self.active, dtype=int)
        return place[np.concatenate([np.arange(self.n_velocities), active])]

    @cached_property
    def _source(self) -> np.ndarray:
        """Number of the unknown at each place of the fronts and the border; one past the last for none."""
        source = np.full(self.n_bodies * self.own + self.border, len(self._place))
        source[self._place] = np.arange(len(self._place))
        return source

    @cached_property
    def _decoupled(self) -> tuple[np.ndarray, np.ndarray]:
        """1 for places of the fronts (nb, N) and the border (b,) with no unknown or a redundant one."""
        idle = np.ones(self.n_velocities + self.n_equations + 1)
        idle[: self.n_velocities] = 0
        idle[self.n_velocities + np.array(self.active, dtype=int)] = 0
        own, border = self._index
        return idle[own], idle[border]

    def fronts(self, blocks: Iterable[MatrixBlock]) -> jax.Array:
        """The matrix as fronts (nb + 1, T, T), T = N + Q; the last one contains the border alone.

        Rows and columns of constraint equations in the blocks are counted from the number of velocities on.
        """
        size = self.own + self.parent + self.border
        own, border = self._decoupled
        diagonal = np.zeros((self.n_bodies + 1, size))
        diagonal[:-1, : self.own] = own
        diagonal[-1, : self.own], diagonal[-1, size - self.border :] = 1.0, border
        total = jnp.asarray(diagonal[:, :, None] * np.eye(size))
        dimensions = jax.lax.ScatterDimensionNumbers(
            update_window_dims=(1, 2), inserted_window_dims=(0,), scatter_dims_to_operand_dims=(0, 1, 2)
        )
        for block in blocks:
            if block.rows.size and block.columns.size:
                starts = np.array(
                    [
                        self._window(*pair)
                        for pair in zip(block.rows.starts, block.columns.starts, strict=True)
                    ]
                )
                total = jax.lax.scatter_add(
                    total,
                    starts.astype(np.int32),
                    block.values,
                    dimensions,
                    mode=jax.lax.GatherScatterMode.PROMISE_IN_BOUNDS,
                )
        return total

    def _window(self, row: int, column: int) -> tuple[int, int, int]:
        """Front of the block of two pieces, and its first row and column there."""
        front = min(self._pieces[row][0], self._pieces[column][0])
        return front, self._offset(front, row), self._offset(front, column)

    def _offset(self, front: int, start: int) -> int:
        holder, offset, _ = self._pieces[start]
        if holder == self.n_bodies:
            return self.own + self.parent + offset
        if holder == front:
            return offset
        assert holder == self.tree.parents[front]
        return self.own + offset

    def _spread(self, left: jax.Array, axis: int) -> jax.Array:
        """Remainder of a child, (.., Q, ..), at the places of the parent's front, (.., T, ..)."""
        parent, border = jnp.split(left, [self.parent], axis=axis)
        shape = list(left.shape)
        shape[axis] = self.own
        between = jnp.zeros(shape)
        return jnp.concatenate([parent, between, border], axis=axis)

    def factored(self, fronts: jax.Array, elimination: DenseElimination) -> TreeFactor:
        """Factors of all fronts, children before parents."""
        n, parents = self.own, np.array(self.tree.parents)
        others = fronts.shape[1] - n

        def eliminate(left: jax.Array, of_body: tuple[AnyArray, ...]):
            index, parent, front = of_body
            whole = front + self._spread(self._spread(left[index], 0), 1)
            inverse = elimination.inverse(whole[:n, :n])
            up, down = inverse @ whole[:n, n:], whole[n:, :n] @ inverse
            return left.at[parent].add(whole[n:, n:] - down @ whole[:n, n:]), (inverse, up, down)

        left = jnp.zeros((self.n_bodies + 1, others, others))
        left, done = jax.lax.scan(eliminate, left, (np.arange(self.n_bodies), parents, fronts[:-1]))
        last = (fronts[-1, n:, n:] + left[-1])[self.parent :, self.parent :]
        return TreeFactor(*done, border=elimination.inverse(last) if self.border else last)

    def solved(self, factor: TreeFactor, load: jax.Array) -> jax.Array:
        """Solution for a load (n + m,): velocities, then active multipliers."""
        parents = np.array(self.tree.parents)
        own_load, border_load = self._distributed(load)

        def forward(left: jax.Array, of_body: tuple[AnyArray, ...]):
            index, parent, down, own = of_body
            received = left[index]
            whole = own + self._spread(received, 0)[: self.own]
            passed = jnp.concatenate([jnp.zeros(self.parent), received[self.parent :]])
            return left.at[parent].add(passed - down @ whole), whole

        left = jnp.zeros((self.n_bodies + 1, self.parent + self.border))
        numbers = np.arange(self.n_bodies)
        left, wholes = jax.lax.scan(forward, left, (numbers, parents, factor.downs, own_load))
        border = factor.border @ (border_load + left[-1, self.parent :])
        alone = jnp.einsum("bij,bj->bi", factor.inverses, wholes)

        def backward(known: jax.Array, of_body: tuple[AnyArray, ...]):
            index, parent, up, own = of_body
            others = jnp.concatenate([known[parent], border])
            solution = own - up @ others
            return known.at[index].set(solution[: self.parent]), solution

        known = jnp.zeros((self.n_bodies + 1, self.parent))
        _, solutions = jax.lax.scan(backward, known, (numbers, parents, factor.ups, alone), reverse=True)
        return jnp.concatenate([solutions.reshape(-1), border])[self._place]

    def product(self, fronts: jax.Array, unknowns: jax.Array) -> jax.Array:
        """Product of the matrix in fronts and a vector of unknowns, (n + m,)."""
        own, border = self._distributed(unknowns)
        parents = np.array(self.tree.parents)
        of_parents = jnp.pad(own, ((0, 1), (0, 0)))[parents, : self.parent]
        of_border = jnp.broadcast_to(border, (self.n_bodies, self.border))
        both = jnp.einsum("bij,bj->bi", fronts[:-1], jnp.concatenate([own, of_parents, of_border], axis=1))
        n = self.own
        total = jnp.pad(both[:, :n], ((0, 1), (0, 0)))
        total = total.at[parents, : self.parent].add(both[:, n : n + self.parent])[:-1]
        corner = fronts[-1, n + self.parent :, n + self.parent :]
        last = corner @ border + both[:, n + self.parent :].sum(axis=0)
        return jnp.concatenate([total.reshape(-1), last])[self._place]

    def dense(self, fronts: jax.Array) -> jax.Array:
        """The matrix in fronts as one dense matrix, (n + m, n + m)."""
        n = len(self._place)
        own, border = np.split(self._source, [self.n_bodies * self.own])
        own = np.vstack([own.reshape(self.n_bodies, self.own), np.full(self.own, n)])
        of_parents = own[np.array([*self.tree.parents, self.n_bodies]), : self.parent]
        index = np.hstack([own, of_parents, np.broadcast_to(border, (self.n_bodies + 1, self.border))])
        total = jnp.zeros((n + 1, n + 1)).at[index[:, :, None], index[:, None, :]].add(fronts)
        return total[:n, :n]

    def _distributed(self, vector: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Parts of a vector of unknowns in the fronts (nb, N) and the border (b,)."""
        everywhere = jnp.append(vector, 0.0)[self._source]
        own, border = jnp.split(everywhere, [self.n_bodies * self.own])
        return own.reshape(self.n_bodies, self.own), border
