"""Rigid motion of a line in its bent shape, as velocities of its stations and as modal amplitudes."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.algebra.cross import cross_matrices
from supple.equations.compiler_options import STARTING
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.line_model import LineModel
from supple.methods.intrinsic.strain_integration import station_places
from supple.programs.program_cache import CachedProgram

__all__ = ["amplitudes_of", "rigid_motion"]

Array = NDArray[np.float64]


def rigid_motion(body: IntrinsicBody, q2: Array) -> Array:
    """Velocities (6 n, 6) of the stations, along their own axes, for each unit component of the root's twist.

    With rotation R and position p of a station relative to the root:  v = R^T (v_0 + w_0 x p),  w = R^T w_0
    q2 : (e,)   constant amplitudes of forces and strains
    """
    if not q2.any():
        return body.line.twists
    rotations, positions = (np.asarray(each) for each in _places(body.model, q2))
    motion = np.zeros((len(positions), 6, 6))
    turned = rotations.transpose(0, 2, 1)
    motion[:, :3, :3] = motion[:, 3:, 3:] = turned
    motion[:, :3, 3:] = -turned @ cross_matrices(positions)
    return motion.reshape(-1, 6)


def amplitudes_of(body: IntrinsicBody, velocities: Array) -> Array:
    """Amplitudes q_1 (m, ...) of velocities (6 n, ...): `Phi_1^T M x_1`, nearest in kinetic energy."""
    return body.modes.velocities.reshape(len(velocities), -1).T @ (body.line.mass @ velocities)


def _from_root(model: LineModel, q2: jax.Array) -> tuple[jax.Array, jax.Array]:
    return station_places(model, q2, jnp.eye(3), jnp.zeros(3))


_places = CachedProgram(_from_root, STARTING)
