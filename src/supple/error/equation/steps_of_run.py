"""The steps of a run in blocks for the linearised march, with the rotations of the frames."""

from __future__ import annotations

from collections.abc import Iterator

import jax
import numpy as np
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray
from supple.equations.configuration import SystemMotion
from supple.error.equation.linearised_march import GainHistory, StepOfRun

STEPS_AT_ONCE = 64


def blocks_of_run(
    motion: SystemMotion, histories: tuple[GainHistory, ...]
) -> Iterator[tuple[StepOfRun, int]]:
    """Blocks of equal numbers of steps, the last padded with its last step; each with its number of steps."""
    frames = motion.configuration.rotations
    # (t, nb, 3): the rotation of every frame in the step that ends at each time.
    turn = rotation_vectors(frames[:-1].swapaxes(-1, -2) @ frames[1:])
    h = np.diff(motion.time)
    for start in range(0, len(h), STEPS_AT_ONCE):
        rows = np.arange(start, start + STEPS_AT_ONCE)
        number = int(np.sum(rows < len(h)))
        rows = np.minimum(rows, len(h) - 1)
        ends, own = jax.tree.map(lambda leaf, at=rows + 1: leaf[at], (motion, histories))
        yield StepOfRun(h[rows], ends, turn[rows], own), number


def rotations(vectors: FloatArray) -> FloatArray:
    """Rotations (t, k, 3, 3) of rotation vectors (t, k, 3); in NumPy, which needs no compilation."""
    turned = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix()
    return turned.reshape(*vectors.shape, 3)


def rotation_vectors(matrices: FloatArray) -> FloatArray:
    """Rotation vectors (t, k, 3) of rotations (t, k, 3, 3)."""
    return Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_rotvec().reshape(matrices.shape[:-1])


def standing(motion: SystemMotion, histories: tuple[GainHistory, ...]) -> StepOfRun:
    """The start of a run as a block of steps of zero length."""
    first, own = jax.tree.map(
        lambda leaf: np.broadcast_to(leaf[0], (STEPS_AT_ONCE, *np.shape(leaf)[1:])), (motion, histories)
    )
    turn = np.zeros((STEPS_AT_ONCE, motion.configuration.origins.shape[1], 3))
    return StepOfRun(np.zeros(STEPS_AT_ONCE), first, turn, own)
