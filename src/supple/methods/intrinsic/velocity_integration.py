"""Places of the stations from their velocities: an independent check of those from the strains."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion

__all__ = ["integrated_places"]

Array = NDArray[np.float64]


def integrated_places(body: IntrinsicBody, motion: IntrinsicMotion, times: Array) -> tuple[Array, Array]:
    """Rotations (t, n, 3, 3) and positions (t, n, 3) of stations from their first ones, by velocities.

    From one output time to the next a station turns by the mean of its angular velocities, and moves with the
    mean of its velocities in space: second order in the output step. The difference from `body.places`, which
    goes out from the root by strains, falls with the square of the segments' length.

    times : (t,) of the motion
    Source: [Wang2015] (4)-(6), at every station.
    """
    modes = body.modes
    rates = np.einsum("nik,tk->tni", modes.velocities, motion.rates)
    first_rotations, first_positions = (each[0] for each in body.places(motion))
    n = body.line.n
    rotations = np.empty((len(times), n, 3, 3))
    rotations[0] = first_rotations
    steps = np.diff(times)
    for number, h in enumerate(steps):
        turn = Rotation.from_rotvec(0.5 * h * (rates[number, :, 3:] + rates[number + 1, :, 3:]))
        rotations[number + 1] = rotations[number] @ turn.as_matrix()
    velocity = np.einsum("tnij,tnj->tni", rotations, rates[..., :3])
    moved = 0.5 * steps[:, None, None] * (velocity[1:] + velocity[:-1])
    positions = first_positions + np.concatenate([np.zeros((1, n, 3)), np.cumsum(moved, axis=0)])
    return rotations, positions
