"""Prediction of the residual after a correction of Newton's iteration from an earlier, measured correction.

Near a solution Newton's iteration squares its residual. With the residuals `s_0` before and `s_1` after a
correction in an earlier step of the same run, relative to the tolerance,

    s_1' <= s_1 max(1, s_0' / s_0)^2

is predicted for a later step. This requires that a single correction solved the measured step, that the later
step is not longer, and that its residual is not much larger. If the prediction is far below the tolerance,
the corrected iterate is accepted without another evaluation. The residual is measured again at regular
intervals, and always in a step with several corrections.

The prediction requires smooth terms, such as inertia, elastic forces, joints and nodal loads. Laws of force
elements and controllers may have kinks within a step. For machines with such parts the residual is always
evaluated.
Source: [HairerWanner1996], section IV.8, also uses the contraction of an earlier step.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.machine_model import Model

MARGIN = 100.0
"""The prediction must be below the tolerance by this factor."""
LIKE = 2.0
"""Largest ratio of a residual to the measured one for a prediction; it is exceeded where a load jumps."""
MEASURED_EVERY = 8
"""Steps between two measurements."""


class Contraction(NamedTuple):
    """The last measured correction, stored as numbers in a recorded run."""

    before: AnyArray
    """Residual before the correction, relative to the tolerance; 0 before the first measurement"""
    after: AnyArray
    step: AnyArray
    """Size of the step, s"""
    phase: AnyArray
    """Accepted steps since the last regular measurement"""


def no_contraction() -> Contraction:
    """The initial state of a run, without a measurement."""
    return Contraction(*np.zeros(4))


def is_predictable(model: Model) -> bool:
    """Whether all terms of the equations are smooth within a step."""
    return not model.forces and not model.controllers


def predicted_to_converge(known: Contraction, size: jax.Array, step: jax.Array) -> jax.Array:
    """Whether a correction from a residual of this size is predicted to end below the tolerance."""
    ratio = jnp.maximum(1.0, size / jnp.where(known.before > 0, known.before, 1.0))
    # The tangent of a step that is no longer than the measured one varies no more.
    comparable = (known.phase > 0) & (step <= known.step * (1 + 1e-6)) & (size <= LIKE * known.before)
    return comparable & (MARGIN * known.after * ratio**2 <= 1.0)


def new_contraction(
    known: Contraction, sizes: jax.Array, step: jax.Array, corrections: jax.Array, evaluated: jax.Array
) -> Contraction:
    """The contraction after an accepted step.

    sizes : (2,)    residuals before and after the last correction of the step
    corrections : number of corrections in the step; after more than one there is no prediction
    evaluated : whether the residual at the end of the step was evaluated
    """
    anew = Contraction(sizes[0], sizes[1], step, known.phase)
    kept = jax.tree.map(
        lambda own, old: jnp.where(evaluated & (corrections == 1), own, old), anew, Contraction(*known)
    )
    return kept._replace(
        before=jnp.where(corrections > 1, 0.0, kept.before), phase=(known.phase + 1) % MEASURED_EVERY
    )
