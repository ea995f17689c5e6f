"""Common records of blocks of solids and of shell triangles."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.materials.law import LawState

__all__ = ["BlockState", "ElementInstant", "Forces", "with_contact"]


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

    material: LawState
    ratios: Array | None
    alive: Array


class Forces(NamedTuple):
    """Forces of a block at an instant, and its state then.

    force : (3, N) negative internal force on the nodes;   hourglass : (3, N), None for shells
    moment : (3, r) on the triads, None for solids
    plastic, viscous : work of the step that led here, J
    smallest : smallest det F of remaining elements, or None
    """

    force: Array
    state: BlockState
    hourglass: Array | None = None
    moment: Array | None = None
    plastic: Array | None = None
    viscous: Array | None = None
    smallest: Array | None = None


def with_contact(limit: Array, rate: Array) -> Array:
    """A step limit with all contacts closed, s; rate : largest stiffness over mass, 1/s^2."""
    return 2 / jnp.sqrt((2 / limit) ** 2 + rate)
