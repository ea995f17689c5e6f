"""Single elements of a group, and the pose of their ends."""

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
    """The arrays of element `number` of a group."""
    return jax.tree.map(lambda leaf: jnp.asarray(leaf)[number], arrays)


def marker_of(ends: Ends, configuration: Configuration, velocity: Any) -> Marker:
    """The marker of the first of some ends."""
    return one_of(markers(ends, configuration, velocity), 0)


def pose_of(ends: Ends, motion: SystemMotion) -> Pose:
    """Position, axes and velocities of the first of some ends."""
    return pose(marker_of(ends, motion.configuration, motion.velocity))
