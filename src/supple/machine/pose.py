"""Pose of a marker and wrench on a marker: data that joints and forces exchange with bodies of any type."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax

__all__ = ["Parameters", "Pose", "Wrench", "Wrenches"]

Parameters = Sequence[jax.Array]
"""Numbers and arrays in the equations of a force element."""


class Pose(NamedTuple):
    """Position and motion of one end of a joint or force, global components."""

    point: jax.Array
    """(3,)"""
    axes: jax.Array
    """(3, 3), as columns: the axes of the joint or force, which rotate with the interface"""
    velocity: jax.Array
    """(3,) of the point; zero for joints, whose equations depend only on positions"""
    angular_velocity: jax.Array
    """(3,) of the axes; zero for joints"""


class Wrench(NamedTuple):
    """Force (3,) at the point of one end, and moment (3,), global components."""

    force: jax.Array
    moment: jax.Array


Wrenches = tuple[Wrench, Wrench]
"""Wrenches on the first and on the second end."""
