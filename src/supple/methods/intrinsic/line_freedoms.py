"""Small motions of a line's axes and elastic amplitudes, from integrals of the velocity amplitudes."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from scipy.linalg import block_diag, null_space

from supple.algebra.cross import cross_matrix
from supple.arrays import FloatArray
from supple.equations.compiler_options import STARTING
from supple.methods.intrinsic.line_equations import (
    RootTwist,
    force_rates,
    section_strains,
    station_velocities,
)
from supple.methods.intrinsic.line_model import LineModel
from supple.methods.intrinsic.root_support import RootSupport
from supple.programs.program_cache import CachedProgram


@dataclass(frozen=True, eq=False)
class LineFreedoms:
    """Small motions p = shapes @ (y, h) of a line about its bent shape.

    p (6 + e,) contains the translation and rotation of the body's axes, along these axes, and the changes
    -dq_2 / w of the elastic amplitudes. y (m,) are the integrals of q_1. h are the motions of the root that
    its support fixes.

    m : number of components of y
    shapes : (6 + e, 6 + e)
    held_mass : (6 + e, 6 + e)  mass matrix for (y, h), with zeros in its block (m, m) of y
    """

    m: int
    shapes: FloatArray
    held_mass: FloatArray

    def amplitudes(self, motions: FloatArray) -> FloatArray:
        """Components y (..., m) of motions p (..., 6 + e)."""
        return np.asarray(np.linalg.solve(self.shapes, motions.T).T[..., : self.m], dtype=float)


def line_freedoms(model: LineModel, support: RootSupport, root: FloatArray, q2: FloatArray) -> LineFreedoms:
    """Small motions of a line with strains q_2 (e,); root (3,) is its position in the body's axes."""
    m = np.shape(model.velocities)[1]
    every = np.asarray(block_diag(np.eye(m), null_space(support.free.T)))
    twist, rates = map(np.asarray, _rates(model, q2))
    from_root = np.eye(6)
    from_root[:3, 3:] = cross_matrix(root)
    shapes = np.vstack([from_root @ twist, -rates / np.asarray(model.omega)[:, None]]) @ every
    mass, momenta = np.zeros((m + 6, m + 6)), np.asarray(model.twist_momenta)
    mass[:m, m:] = np.asarray(model.velocities).T @ momenta
    mass[m:, :m] = mass[:m, m:].T
    mass[m:, m:] = np.asarray(model.twists).T @ momenta
    return LineFreedoms(m, shapes, every.T @ mass @ every)


def _rates_by_velocities(model: LineModel, q2: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Derivatives of the root's twist (6, m + 6) and of q_2' (e, m + 6) by q_1 and an added root twist."""
    m, e = model.velocities.shape[1], section_strains(model, q2)

    def rates(both: jax.Array) -> tuple[jax.Array, jax.Array]:
        q1, more = both[:m], both[m:]
        x1 = station_velocities(model, q1, RootTwist(more, jnp.zeros(6)))
        return x1[0], force_rates(model, x1, q1, e)

    return jax.jacfwd(rates)(jnp.zeros(m + 6))


_rates = CachedProgram(_rates_by_velocities, STARTING)
