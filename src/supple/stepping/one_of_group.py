"""One element of a group of equal ones, and where its ends are."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from supple.equations.configuration import Configuration, SystemMotion
from supple.equations.ends import markers
from supple.equations.machine_model import Ends
from supple.equations.marker import Marker, pose
from supple.machine.pose import Pose

__all__ = ["marker_of", "one_of", "pose_of"]


def one_of(arrays: Any, number: int) -> Any:
    """The arrays of one of a group."""
    return jax.tree.map(lambda leaf: jnp.asarray(leaf)[number], arrays)


def marker_of(ends: Ends, configuration: Configuration, velocity: Any) -> Marker:
    """The first of some ends, as it moves."""
    return one_of(markers(ends, configuration, velocity), 0)


def pose_of(ends: Ends, motion: SystemMotion) -> Pose:
    """Point, axes and velocities of the first of some ends."""
    return pose(marker_of(ends, motion.configuration, motion.velocity))
