"""What joints and forces see of a body, whatever its form: where a marker is, and how it moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax

__all__ = ["Parameters", "Pose", "Wrench", "Wrenches"]

Parameters = Sequence[jax.Array]
"""Numbers of a force element, and arrays of them, as its equations see them."""


class Pose(NamedTuple):
    """Place and motion of one end of a joint or force, global components."""

    point: jax.Array
    """(3,)"""
    axes: jax.Array
    """(3, 3), as columns: the axes of the joint or force, which turn with the interface"""
    velocity: jax.Array
    """(3,) of the point; zero for joints, whose equations see positions alone"""
    angular_velocity: jax.Array
    """(3,) of the axes; likewise"""


class Wrench(NamedTuple):
    """Force and moment on one end, global components, the force acting at its point."""

    force: jax.Array
    moment: jax.Array


Wrenches = tuple[Wrench, Wrench]
"""On the first end and on the second."""
