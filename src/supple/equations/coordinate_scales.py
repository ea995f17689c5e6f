"""Translations, rotations and deformations among the coordinates, and the scale of each."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.compiler_options import STARTING
from supple.equations.machine_model import BodyGroup, Model
from supple.equations.places import Places, assembled_vector
from supple.programs.program_cache import CachedProgram


def position_scale(model: Model) -> jax.Array:
    """Size of a large change of each freedom, (n,).

    It is the system's length for translations, 1 rad for rotations, and `coordinate_scale` for deformations.
    """

    def of_group(group: BodyGroup) -> tuple[Places, jax.Array]:
        k = len(group.members)
        deformation = jnp.broadcast_to(jnp.asarray(group.coordinate_scale)[:, None], (k, group.r))
        frames = (jnp.full((k, 3), model.length), jnp.ones((k, 3)))
        return group.velocities, jnp.concatenate([*frames, deformation], axis=1)

    return assembled_vector(model.n_velocities, [of_group(group) for group in model.groups])


known_position_scale = CachedProgram(position_scale, STARTING)
"""`position_scale` as one compiled program with concrete values."""


def kinds_of_rows(model: Model) -> np.ndarray:
    """Three rows (3, n) with ones at the translations, rotations and deformations of the velocity vector."""
    kinds = np.zeros((3, model.n_velocities))
    for part in model.slices:
        kinds[0, part.start : part.start + 3] = 1
        kinds[1, part.start + 3 : part.start + 6] = 1
        kinds[2, part.start + 6 : part.stop] = 1
    return kinds
