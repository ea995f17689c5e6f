"""Blocks of solids and of shell triangles in the model: force, step limit, recorded results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.elements import (
    ShellBlock,
    SolidBlock,
    block_force,
    element_von_mises,
    layered_force,
    layered_von_mises,
    rest_layers,
    shell_force,
    shell_von_mises,
    smallest_stretch,
    triangle_stretch,
)
from supple.methods.explicit.elements.bulk_viscosity import bulk_share
from supple.methods.explicit.elements.solid_block import deformation
from supple.methods.explicit.materials import J2Plasticity, Law

__all__ = [
    "BlockRule",
    "BlockState",
    "ElementInstant",
    "Forces",
    "SolidArrays",
    "Solids",
    "TriangleArrays",
    "Triangles",
    "with_contact",
]


_COLLAPSED = 0.05
"""Smallest stretch that shortens the step: a collapsed triangle would need endless steps."""


class ElementInstant(NamedTuple):
    """Positions x (3, N), reached by the increment dx in a step h; triads (3, 3, r) at nodes of shells."""

    x: Array
    dx: Array
    h: Array
    triads: Array


class BlockState(NamedTuple):
    """State of a block of E elements.

    material : state of the law, or of the layers of shells;   ratios : (g, E) det F of solids, else None
    alive : (E,) 1, or 0 once an element is deleted
    """

    material: Any
    ratios: Any
    alive: Array


class Forces(NamedTuple):
    """Forces of a block at an instant.

    force, hourglass : (3, N);   moment : (3, r) on the triads, None for solids
    plastic, viscous : work of the step that led here, J
    smallest : smallest det F of remaining elements, or None
    """

    force: Array
    hourglass: Array | None
    moment: Array | None
    state: BlockState
    plastic: Array | None
    viscous: Array | None
    smallest: Array | None


class SolidArrays(NamedTuple):
    """Solids, their stable steps (E,) at rest, s, and their stiffness damping, s, or None."""

    block: SolidBlock
    limit: Array
    beta: Array | None

    def longest_step(self, x: Array, v: Array, alive: Array, contact_rate: Array) -> Array:
        """Step limit of the remaining elements in their present state, s, with all contacts closed.

        It includes the bulk viscosity, but not the stiffness damping.
        """
        stretch = smallest_stretch(self.block, x)
        longest = with_contact(self.limit * stretch, contact_rate)
        if self.block.bulk is not None:
            F, rate = (deformation(self.block, each[:, self.block.nodes]) for each in (x, v))
            xi = bulk_share(self.block.bulk, F, rate) / stretch
            longest = longest * (jnp.sqrt(1 + xi**2) - xi)
        return jnp.min(jnp.where(alive > 0, longest, jnp.inf))


class TriangleArrays(NamedTuple):
    """Triangles of a shell, and their step limits (E,) at rest, s."""

    block: ShellBlock
    limit: Array
    beta: None = None

    def longest_step(self, x: Array, _v: Array, alive: Array, contact_rate: Array) -> Array:
        """Step limit of the remaining triangles in their present state, s, with all contacts closed.

        Bending stiffness acts through the rotation of a triangle by the motion of its corners, which is
        inversely proportional to its height.
        """
        stretch = jnp.clip(triangle_stretch(self.block, x), _COLLAPSED, 1.0)
        longest = with_contact(self.limit * stretch, contact_rate)
        return jnp.min(jnp.where(alive > 0, longest, jnp.inf))


def with_contact(limit: Array, rate: Array) -> Array:
    """A step limit with all contacts closed, s; rate : largest stiffness over mass, 1/s^2."""
    return 2 / jnp.sqrt((2 / limit) ** 2 + rate)


class BlockRule(Protocol):
    """Static arguments of a block of elements in compiled code; `own` denotes the arrays of the block."""

    def start(self, own: Any) -> BlockState:
        """Undeformed state."""
        ...

    def force(self, own: Any, at: ElementInstant, state: BlockState) -> Forces:
        """Forces at an instant, and the new state."""
        ...

    def recorded(self, own: Any, x: Array, triads: Array, state: BlockState, /) -> tuple[Array, Array]:
        """Plastic strain and von Mises stress (E,) at the worst point of each element."""
        ...


@dataclass(frozen=True)
class Solids:
    """Static arguments of a block of solids."""

    law: Law
    deletion: float

    def start(self, own: SolidArrays) -> BlockState:
        """Undeformed state."""
        shape = own.block.volumes.shape
        return BlockState(self.law.initial(shape), jnp.ones(shape), jnp.ones(shape[1]))

    def force(self, own: SolidArrays, at: ElementInstant, state: BlockState) -> Forces:
        """Stress, damping and hourglass forces; elements that reach the deletion strain are then deleted."""
        out = block_force(
            self.law, own.block, at.x, at.dx, state.material, state.ratios, state.alive, own.beta, at.h
        )
        strain, alive = self.law.plastic_strain(out.state), state.alive
        if strain is not None and self.deletion != float("inf"):
            alive = alive * (strain.max(axis=0) < self.deletion)
        reached = BlockState(out.state, out.ratios, alive)
        return Forces(out.force, out.hourglass, None, reached, out.plastic, out.viscous, out.smallest)

    def recorded(self, own: SolidArrays, x: Array, _triads: Array, state: BlockState) -> tuple[Array, Array]:
        """Plastic strain and von Mises stress (E,) at the worst point of each element."""
        strain = self.law.plastic_strain(state.material)
        stress = element_von_mises(self.law, own.block, x, state.material).max(axis=0)
        return jnp.zeros_like(state.alive) if strain is None else strain.max(axis=0), state.alive * stress


@dataclass(frozen=True)
class Triangles:
    """Static arguments of a block of shells; law None: elastic."""

    law: J2Plasticity | None
    deletion: float

    def start(self, own: TriangleArrays) -> BlockState:
        """Undeformed state."""
        layers = None if own.block.layers is None else rest_layers(own.block)
        return BlockState(layers, None, jnp.ones(own.block.nodes.shape[1]))

    def force(self, own: TriangleArrays, at: ElementInstant, state: BlockState) -> Forces:
        """Force and moment; elements that reach the deletion strain are then deleted."""
        if self.law is None:
            pull = shell_force(own.block, at.x, at.triads)
            return Forces(pull.force, None, pull.moment, state, None, None, None)
        out = layered_force(self.law, own.block, at.x, at.triads, state.material, state.alive)
        alive = state.alive
        if self.deletion != float("inf"):
            alive = alive * (out.state.strain.max(axis=(0, 1)) < self.deletion)
        return Forces(
            out.force, None, out.moment, BlockState(out.state, None, alive), out.plastic, None, None
        )

    def recorded(
        self, own: TriangleArrays, x: Array, triads: Array, state: BlockState
    ) -> tuple[Array, Array]:
        """Plastic strain and von Mises stress (E,) at the worst point of each element."""
        if self.law is None:
            return jnp.zeros_like(state.alive), shell_von_mises(own.block, x, triads)
        stress = layered_von_mises(self.law, own.block, x, triads, state.material)
        return state.material.strain.max(axis=(0, 1)), state.alive * stress
